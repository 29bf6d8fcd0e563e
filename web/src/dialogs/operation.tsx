/** An operation: its inputs and parameters, made from its table; it runs as a job and can be undone. */
import { useState } from "preact/hooks";
import { copyText } from "../actions";
import { Properties, sentence, type ParameterStore } from "../inspector/properties";
import type { Json, JsonObject } from "../protocol";
import { ask } from "../session";
import * as store from "../store";
import { Select } from "../ui/controls";
import { closeDialog, DialogButtons, Modal } from "../ui/dialog";
import { label, titleOf, valueAt } from "../values";

export function OperationDialog({ name }: { name: string }) {
  const operation = store.welcome.value?.operations.find((row) => row.name === name);
  const fit = operation ? store.datasetsFor(operation) : [];
  const [dataset, setDataset] = useState(fit[0] ?? "");
  const [parameters, setParameters] = useState<JsonObject>({});
  const [error, setError] = useState("");
  if (!operation) return null;

  const values: ParameterStore = {
    get: (path) => parameters[path],
    set: (path, value: Json | undefined) => setParameters((now) => {
      const { [path]: _, ...others } = now;
      return value === undefined ? others : { ...others, [path]: value };
    }),
  };
  /** The answer comes when the job is done; what is refused at once keeps the dialog open. */
  const run = () => {
    const asked = ask<{ note?: string }>({ type: "run", operation: name, dataset, parameters });
    const quick = new Promise<"going">((resolve) => setTimeout(() => resolve("going"), 300));
    asked.then(({ note }) => { if (note) store.notify("info", note); }, (e: Error) => { if (store.dialog.value?.name === "operation") setError(e.message); });
    void Promise.race([asked, quick]).then(closeDialog, () => {});
  };
  const copy = () => {
    ask<{ text: string }>({ type: "command", operation: name, dataset, parameters })
      .then((value) => copyText(value.text), (e: Error) => setError(e.message));
  };
  const options = fit.map((id) => ({ value: id, text: titleOf(valueAt(store.world.value, `datasets.${id}`), id) }));
  return (
    <Modal title={label(operation.name)}>
      <p class="doc">{sentence(operation.doc)}</p>
      <div class="dialog-row"><label for="operation-data">Data</label><Select id="operation-data" value={dataset} options={options} onChange={setDataset} /></div>
      <div class="operation-parameters">
        <Properties path="" className={operation.class} base={values} />
      </div>
      {error ? <p class="row-error" role="alert">{error}</p> : null}
      <p class="hint">The result replaces the data in the scene. Undo brings them back.</p>
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button" disabled={!dataset} onClick={copy}>Copy command</button>
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        <button type="button" class="button button-main" disabled={!dataset} onClick={run}>Run</button>
      </DialogButtons>
    </Modal>
  );
}
