/** An operation: its inputs and parameters, made from its table; it runs as a job and can be undone. */
import { useState } from "preact/hooks";
import { copyText } from "../actions";
import { Properties, sentence, type ParameterStore } from "../inspector/properties";
import type { Json, JsonObject, Operand } from "../protocol";
import { ask } from "../session";
import * as store from "../store";
import { Select } from "../ui/controls";
import { closeDialog, DialogButtons, Modal } from "../ui/dialog";
import { label, titleOf, valueAt } from "../values";

const NONE = "";
const LETTERS = "abcdefghijklmnop";

function datasetOptions(operand: Operand) {
  return store.datasetsFor(operand).map((id) => ({ value: id, text: titleOf(valueAt(store.world.value, `datasets.${id}`), id) }));
}

/** Datasets by operand; of operands that are named, by those names. */
type Inputs = { [name: string]: string };

/** The first input, whose place the result takes, stands above: here are the others. */
function OtherInputs({ operands, inputs, change }: { operands: Operand[]; inputs: Inputs; change: (inputs: Inputs) => void }) {
  return (
    <>
      {operands.map((operand) => {
        const id = `operation-input-${operand.name}`;
        const options = [...(operand.least === 0 ? [{ value: NONE, text: "(none)" }] : []), ...datasetOptions(operand)];
        return (
          <div class="dialog-row" key={operand.name}>
            <label for={id} title={sentence(operand.doc)}>{label(operand.name)}</label>
            <Select id={id} value={inputs[operand.name] ?? NONE} options={options} onChange={(value) => change({ ...inputs, [operand.name]: value })} />
          </div>
        );
      })}
    </>
  );
}

/** Inputs that an expression speaks of: a, b, c ... */
function NamedInputs({ operand, inputs, change }: { operand: Operand; inputs: Inputs; change: (inputs: Inputs) => void }) {
  const names = Object.keys(inputs);
  const next = [...LETTERS].find((letter) => !names.includes(letter));
  const options = datasetOptions(operand);
  return (
    <>
      {names.map((name) => (
        <div class="dialog-row" key={name}>
          <label for={`operation-input-${name}`} title={sentence(operand.doc)}>{name}</label>
          <Select id={`operation-input-${name}`} value={inputs[name] ?? NONE} options={options} onChange={(value) => change({ ...inputs, [name]: value })} />
        </div>
      ))}
      {next && names.length < operand.most ? (
        <button type="button" class="button" onClick={() => change({ ...inputs, [next]: options[0]?.value ?? NONE })}>Add input {next}</button>
      ) : null}
    </>
  );
}

/** What stands beside the first input when the dialog opens: the first dataset that fits, where one is needed. */
function firstInputs(operands: Operand[]): Inputs {
  const inputs: Inputs = {};
  operands.forEach((operand, i) => {
    const fit = store.datasetsFor(operand);
    if (operand.named) inputs.a = fit[0] ?? NONE;
    else if (i > 0 && operand.least > 0) inputs[operand.name] = fit[1] ?? fit[0] ?? NONE;
  });
  return inputs;
}

export function OperationDialog({ name }: { name: string }) {
  const operation = store.welcome.value?.operations.find((row) => row.name === name);
  const operands = operation?.inputs ?? [];
  const first = operands[0];
  const named = operands.find((operand) => operand.named);
  const [chosen, setDataset] = useState(store.datasetsFor(first)[0] ?? NONE);
  const [inputs, setInputs] = useState(() => firstInputs(operands));
  const [parameters, setParameters] = useState<JsonObject>({});
  const [error, setError] = useState("");
  if (!operation || !first) return null;
  const dataset = named ? Object.values(inputs)[0] ?? NONE : chosen;
  const others = Object.fromEntries(Object.entries(inputs).filter(([, id]) => id !== NONE));
  const complete = dataset !== NONE && operands.every((operand, i) => i === 0 || operand.named || operand.least === 0 || others[operand.name]);

  const values: ParameterStore = {
    get: (path) => parameters[path],
    set: (path, value: Json | undefined) => setParameters((now) => {
      const { [path]: _, ...others } = now;
      return value === undefined ? others : { ...others, [path]: value };
    }),
  };
  /** The answer comes when the job is done; what is refused at once keeps the dialog open. */
  const run = () => {
    const asked = ask<{ note?: string }>({ type: "run", operation: name, dataset, inputs: others, parameters });
    const quick = new Promise<"going">((resolve) => setTimeout(() => resolve("going"), 300));
    asked.then(({ note }) => { if (note) store.notify("info", note); }, (e: Error) => { if (store.dialog.value?.name === "operation") setError(e.message); });
    void Promise.race([asked, quick]).then(closeDialog, () => {});
  };
  const copy = () => {
    ask<{ text: string }>({ type: "command", operation: name, dataset, inputs: others, parameters })
      .then((value) => copyText(value.text), (e: Error) => setError(e.message));
  };
  return (
    <Modal title={label(operation.name)}>
      <p class="doc">{sentence(operation.doc)}</p>
      {named
        ? <NamedInputs operand={named} inputs={inputs} change={setInputs} />
        : <div class="dialog-row"><label for="operation-data">Data</label><Select id="operation-data" value={dataset} options={datasetOptions(first)} onChange={setDataset} /></div>}
      <OtherInputs operands={operands.slice(1).filter((operand) => !operand.named)} inputs={inputs} change={setInputs} />
      <div class="operation-parameters">
        <Properties path="" className={operation.class} base={values} />
      </div>
      {error ? <p class="row-error" role="alert">{error}</p> : null}
      <p class="hint">The result replaces the data in the scene. Undo brings them back.</p>
      <DialogButtons>
        <span class="grow" />
        <button type="button" class="button" disabled={!complete} onClick={copy}>Copy command</button>
        <button type="button" class="button" onClick={closeDialog}>Cancel</button>
        <button type="button" class="button button-main" disabled={!complete} onClick={run}>Run</button>
      </DialogButtons>
    </Modal>
  );
}
