/** The panel of an operation, in the inspector's place: its inputs and parameters, and what the preview shows. */
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { copyText } from "../clipboard";
import { Properties } from "../inspector/properties";
import type { Operand } from "../protocol";
import { ask, edit, fetchHistogram, fetchInfo, tryAsk } from "../session";
import * as store from "../store";
import { IconButton, Select, Switch } from "../ui/controls";
import { formatBytes, formatNumber, formatSeconds, freeName, label, sentence, titleOf, valueAt } from "../values";
import { chainOf, insertStep, takersOf } from "./chain";
import { startOf } from "./start";
import { change, hindrance, isComplete, LETTERS, freshStep, plan, previewOn, previews, recipe, request, setParameter, tables, waiting, type Plan, type Preview } from "./state";
import { inPanel } from "./words";

const NONE = "";

function options(operand: Operand) {
  return store.datasetsFor(operand).map((id) => ({ value: id, text: titleOf(valueAt(store.world.value, `datasets.${id}`), id) }));
}

function InputRow({ name, operand, value, optional, onChange }: { name: string; operand: Operand; value: string; optional?: boolean; onChange: (id: string) => void }) {
  const id = `operation-input-${name}`;
  return (
    <div class="row">
      <label class="row-label" for={id} title={sentence(operand.doc)}>{label(name)}</label>
      <div class="row-control"><Select id={id} value={value} options={[...(optional ? [{ value: NONE, text: "(none)" }] : []), ...options(operand)]} onChange={onChange} /></div>
    </div>
  );
}

/** Those that an expression speaks of: a, b, c ... */
function NamedInputs({ of, operand }: { of: Plan; operand: Operand }) {
  const names = Object.keys(of.inputs);
  const next = [...LETTERS].find((letter) => !names.includes(letter));
  const give = (name: string, id: string) => {
    const { [name]: _, ...others } = of.inputs;
    change({ inputs: id === NONE ? others : { ...of.inputs, [name]: id } });
  };
  return (
    <>
      {names.map((name) => (
        <InputRow key={name} name={name} operand={operand} value={of.inputs[name] ?? NONE} optional={names.length > Math.max(1, operand.least)} onChange={(id) => give(name, id)} />
      ))}
      {next && names.length < operand.most ? (
        <button type="button" class="button button-small" onClick={() => give(next, options(operand)[0]?.value ?? NONE)}>Add input {next}</button>
      ) : null}
    </>
  );
}

function InputRows({ of }: { of: Plan }) {
  const [first, ...others] = of.operation.inputs;
  const named = of.operation.inputs.find((operand) => operand.named);
  return (
    <div class="rows">
      {named ? <NamedInputs of={of} operand={named} /> : <InputRow name={first!.name} operand={first!} value={of.dataset} onChange={(dataset) => change({ dataset })} />}
      {others.filter((operand) => !operand.named).map((operand) => (
        <InputRow
          key={operand.name} name={operand.name} operand={operand} value={of.inputs[operand.name] ?? NONE} optional={operand.least === 0}
          onChange={(id) => change({ inputs: { ...of.inputs, [operand.name]: id } })}
        />
      ))}
    </div>
  );
}

const times = (n: number[]) => n.join(" × ");

/** Which samples the previews show. */
function extent(shown: Preview[]): string {
  const one = shown[0]!;
  if (one.whole) return one.n ? `All ${times(one.n)} samples.` : "All of it.";
  const part = shown.find((preview) => !preview.full);
  if (part?.n) return `A box of ${times(part.n)} samples around the cross-hair: more would take too long.`;
  return shown.length > 1 ? "The parts that the slices show." : `What is seen: ${times(one.n ?? [])} of ${times(one.dims ?? [])} samples.`;
}

/** "about 5 s and 4.3 MiB of memory"; of a mesh nobody knows how large it will be. */
function costs(of: Plan, { seconds, bytes }: Preview): string {
  return `${seconds == null ? "" : `about ${formatSeconds(seconds)} and `}${of.operation.gives === "mesh" ? "at least " : ""}${formatBytes(bytes)} of memory`;
}

function PreviewState({ of }: { of: Plan }) {
  const all = Object.values(previews.value);
  const shown = all.filter((value): value is Preview => typeof value !== "string");
  const refusal = all.find((value): value is string => typeof value === "string");
  const pictures = shown.filter((preview) => preview.picture);
  const value = pictures.find((preview) => preview.after !== undefined);
  const large = shown.find((preview) => preview.whole && !preview.picture);
  const alone = pictures.find((preview) => preview.end === false);
  const flawed = refusal !== undefined && pictures.length === 0;
  return (
    <section class="preview-state" aria-label="Preview" aria-busy={waiting.value > 0}>
      <div class="preview-head">
        <span id="preview-on-label">Preview</span>
        <Switch id="preview-on" on={previewOn.value} onChange={(on) => { previewOn.value = on; }} />
      </div>
      {flawed ? <p class="row-error" role="alert">{inPanel(refusal, of.operation, store.classes.value[of.operation.class]?.properties ?? [])}</p> : null}
      {large ? (
        <p class="preview-note">
          {label(of.operation.name)} works on all samples at once. That takes {costs(of, large)}.{" "}
          <button type="button" class="button button-small" onClick={() => change({ whole: true })}>Preview the whole</button>
        </p>
      ) : null}
      {alone ? (
        <p class="preview-note">
          This step by itself: with what follows, the preview takes {alone.seconds == null ? "longer" : `about ${formatSeconds(alone.seconds)}`}.{" "}
          <button type="button" class="button button-small" onClick={() => change({ whole: true })}>Preview the end</button>
        </p>
      ) : null}
      {pictures.some((preview) => preview.end) ? <p class="preview-note">The end of the pipeline, with this step in it.</p> : null}
      {pictures.length ? <p class="preview-note">{extent(pictures)}</p> : null}
      {value ? (
        <dl class="preview-values">
          <div><dt>At the cross-hair</dt><dd>{formatNumber(value.before!)} <span aria-label="becomes">→</span> <strong>{formatNumber(value.after!)}</strong></dd></div>
          {value.window ? <div><dt>Window</dt><dd>{formatNumber(value.window[0]!)} to {formatNumber(value.window[1]!)}</dd></div> : null}
        </dl>
      ) : null}
      {!all.length ? <p class="preview-note">{waiting.value ? "Working…" : "It is made as soon as the picture is at rest."}</p> : null}
    </section>
  );
}

/** As a new step between others, or as a dataset of its own that takes the place of the first one in the picture. */
async function apply(of: Plan): Promise<string> {
  if (!of.inserts) {
    const { dataset, note } = await ask<{ dataset: string; note?: string }>({ type: "run", ...request(of) });
    if (note) store.notify("info", `${label(of.operation.name)}: ${note}`);
    await told(dataset);
    return dataset;
  }
  const id = freeName(store.idsOf("datasets"), of.operation.name);
  const edits = insertStep(tables(), of.dataset, id, recipe(of));
  if (typeof edits === "string") throw new Error(edits);
  await edit(...edits);
  await told(id);
  return id;
}

/** The World is told after the answer. */
function told(dataset: string): Promise<void> {
  return new Promise((resolve) => {
    const stop = effect(() => {
      if (store.idsOf("datasets").includes(dataset)) queueMicrotask(() => { stop(); resolve(); });
    });
  });
}

/** Where people look at a new step: where they looked before, if it is in the pipeline there, else at the volume that shows what is made with it. */
function whereSeen(dataset: string): string {
  const isIn = (id: string | null | undefined) => id != null && chainOf(tables(), id).steps.some((step) => step.id === dataset);
  const [map, id] = store.selection.value.split(".");
  const volumes = store.volumeIds.value.filter((volume) => isIn(store.datasetOf(volume)));
  if ((map === "datasets" && isIn(id)) || (map === "volumes" && volumes.includes(id!))) return store.selection.value;
  return map === "datasets" || !volumes.length ? `datasets.${dataset}` : `volumes.${volumes[0]}`;
}

/** Where nothing would be seen without a parameter, one is there that the data propose. */
function useStart(of: Plan): void {
  const volume = store.currentVolume.value;
  const isShown = volume !== null && store.datasetOf(volume) === of.dataset;
  const histogram = isShown ? store.histograms.value[volume] : undefined;
  useEffect(() => {
    if (isShown) void fetchHistogram(volume);
    void fetchInfo(of.dataset);
  }, [of.dataset]);
  const info = store.dataInfos.value[of.dataset];
  useEffect(() => {
    const now = plan.peek(); // effects come late: somebody may have said something since it was drawn
    if (now?.operation !== of.operation || Object.keys(now.parameters).length || info === undefined) return;
    const start = startOf(of.operation.name, {
      histogram: histogram && typeof histogram !== "string" ? histogram : null, crossHair: store.crossHair.value,
      orientation: typeof info === "string" ? "" : String(info["orientation"] ?? ""),
    });
    if (Object.keys(start).length) change({ parameters: start });
  }, [of.operation.name, histogram === undefined, info === undefined]);
}

/** The focus goes to the first field, and back when the panel is closed. */
function useFocus(name: string) {
  const body = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    body.current?.querySelector<HTMLElement>("input, select, textarea")?.focus();
    return () => { if (!document.activeElement || document.activeElement === document.body) before?.focus?.(); };
  }, [name]);
  return body;
}

export function FilterPanel() {
  const of = plan.value!;
  const body = useFocus(of.operation.name);
  const [error, setError] = useState("");
  const [busy, setBusy] = useState(false);
  const why = hindrance(of.operation, of.dataset);
  const ready = isComplete(of) && !busy && !store.readOnly.value;
  const words = (text: string) => inPanel(text, of.operation, store.classes.value[of.operation.class]?.properties ?? []);
  useStart(of);
  const run = () => {
    setBusy(true);
    setError("");
    apply(plan.peek() ?? of).then((dataset) => {
      if (plan.value?.operation !== of.operation) return; // people have gone on meanwhile
      plan.value = null;
      freshStep.value = dataset;
      store.selection.value = whereSeen(dataset);
    }, (problem: Error) => setError(problem.message)).finally(() => setBusy(false));
  };
  const copy = () => void tryAsk<{ text: string }>({ type: "command", ...request(of) }).then((value) => { if (value) void copyText(value.text); });
  return (
    <aside class="inspector filter-panel" aria-label="Filter" onKeyDown={(event) => { if (event.key === "Escape" && !event.defaultPrevented) plan.value = null; }}>
      <header class="inspector-head">
        <div class="inspector-title"><h2>{label(of.operation.name)}</h2><span class="inspector-kind">{label(of.operation.group)}</span></div>
        <IconButton icon="close" label="Close" onClick={() => { plan.value = null; }} />
      </header>
      <div ref={body} class="inspector-body" key={of.operation.name}>
        <p class="doc filter-panel-doc">{words(of.operation.doc)}</p>
        <InputRows of={of} />
        <Properties path="" className={of.operation.class} base={{ get: (name) => of.parameters[name], set: setParameter }} />
        <PreviewState of={of} />
      </div>
      <footer class="filter-foot">
        {error ? <p class="row-error" role="alert">{words(error)}</p> : null}
        {of.inserts && takersOf(tables(), of.dataset).some((path) => path.startsWith("datasets.")) ? <p class="hint">Goes behind {of.dataset}, before what stands on it.</p> : null}
        <div class="filter-buttons">
          <button type="button" class="button" disabled={!isComplete(of)} onClick={copy}>Copy command</button>
          <span class="grow" />
          <button type="button" class="button" onClick={() => { plan.value = null; }}>Cancel</button>
          <button type="button" class="button button-main" disabled={!ready || why !== ""} onClick={run}>{busy ? "Applying…" : "Apply"}</button>
        </div>
      </footer>
    </aside>
  );
}
