/** How a dataset came about, as a list that can be edited: steps are switched off, moved, put between others and removed. */
import { useEffect, useRef, useState } from "preact/hooks";
import { copyText } from "../clipboard";
import { datasetOf, reasonOf } from "../failure";
import { Icon } from "../icons";
import { Properties } from "../inspector/properties";
import { tryAsk, tryEdit } from "../session";
import * as store from "../store";
import { IconButton, Switch } from "../ui/controls";
import { label, sentence, titleOf, valueAt } from "../values";
import type { Edit } from "../protocol";
import { freshStep, tables } from "./state";
import { chainOf, moveStep, removeStep, summaryOf, type Chain, type Step } from "./chain";

/** Edits, or why there are none. */
function take(edits: Edit[] | string): boolean {
  if (typeof edits === "string") store.notify("warning", edits);
  else if (edits.length) tryEdit(...edits);
  return typeof edits !== "string";
}

/** As `volvis pipe` reads it: the whole line, or what stands between its quotation marks. */
async function copy(form: "pipe" | "chain", dataset: string): Promise<void> {
  const value = await tryAsk<{ text: string }>({ type: "command", form, dataset });
  if (value) await copyText(value.text, form === "pipe" ? undefined : "The chain is copied.");
}

function shownName(id: string): string {
  return titleOf(valueAt(store.world.value, `datasets.${id}`), id);
}

/** The step that has the focus when the list is there again: one that was moved, or that stands beside one that is gone. */
let next: string | null = null;

function StepRow({ chain, step, at, open, toggle }: { chain: Chain; step: Step; at: number; open: boolean; toggle: () => void }) {
  const [over, setOver] = useState(false);
  const operation = tables().operations.find((row) => row.name === step.operation);
  const name = label(step.operation);
  const failure = store.failed.value;
  const why = failure && datasetOf(failure) === step.id ? reasonOf(failure) : "";
  const fixed = store.readOnly.value;
  const button = useRef<HTMLButtonElement>(null);
  const move = (to: number) => { if (take(moveStep(tables(), chain, at, to))) next = step.id; };
  useEffect(() => {
    if (next !== step.id) return;
    next = null;
    button.current?.focus();
  });
  const remove = () => {
    next = chain.steps[at > 0 ? at - 1 : 1]?.id ?? null;
    if (!take(removeStep(tables(), chain, step.id))) return;
    const before = at > 0 ? chain.steps[at - 1]!.id : chain.source;
    if (store.selection.value === `datasets.${step.id}` && before) store.selection.value = `datasets.${before}`;
  };
  return (
    <li
      class={`step ${step.on ? "" : "step-off"} ${why ? "step-failed" : ""} ${over ? "step-over" : ""}`} draggable={!fixed && chain.steps.length > 1}
      onDragStart={(event) => event.dataTransfer?.setData("text/x-volvis-step", String(at))}
      onDragOver={(event) => { if (event.dataTransfer?.types.includes("text/x-volvis-step")) { event.preventDefault(); event.stopPropagation(); setOver(true); } }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        setOver(false);
        const from = event.dataTransfer?.getData("text/x-volvis-step");
        if (!from) return;
        event.preventDefault();
        event.stopPropagation();
        if (Number(from) !== at) take(moveStep(tables(), chain, Number(from), at));
      }}
      onKeyDown={(event) => {
        if (!event.altKey || fixed || (event.key !== "ArrowUp" && event.key !== "ArrowDown")) return;
        event.preventDefault();
        event.stopPropagation();
        const to = at + (event.key === "ArrowUp" ? -1 : 1);
        if (to >= 0 && to < chain.steps.length) move(to);
      }}
    >
      <div class="step-head">
        <button ref={button} type="button" class="step-name" aria-expanded={open} title={operation ? sentence(operation.doc) : undefined} onClick={toggle}>
          <Icon name={open ? "down" : "right"} />
          <span class="step-words"><span class="step-title">{name}</span><span class="step-summary">{step.on ? summaryOf(step) : "switched off"}</span></span>
        </button>
        <span class="hidden" id={`step-${step.id}-label`}>{name} is applied</span>
        <Switch id={`step-${step.id}`} on={step.on} disabled={fixed} onChange={(on) => tryEdit(on ? { op: "unset", path: `datasets.${step.id}.on` } : { op: "set", path: `datasets.${step.id}.on`, value: false })} />
      </div>
      {why ? <p class="row-error">Cannot be made: {why}</p> : null}
      {open ? (
        <div class="step-body">
          {operation ? <Properties path={`datasets.${step.id}.parameters`} className={operation.class} /> : null}
          <div class="step-tools">
            <IconButton icon="up" label={`Move ${name} up`} disabled={fixed || at === 0} onClick={() => move(at - 1)} />
            <IconButton icon="down" label={`Move ${name} down`} disabled={fixed || at === chain.steps.length - 1} onClick={() => move(at + 1)} />
            <button type="button" class="button button-small" disabled={fixed} onClick={() => { store.dialog.value = { name: "filters", after: step.id }; }}>Insert after</button>
            <span class="grow" />
            <IconButton icon="remove" label={`Remove ${name}`} disabled={fixed} onClick={remove} />
          </div>
        </div>
      ) : null}
    </li>
  );
}

/** Which step is open: a new one, else the one that is looked at, until another is chosen. */
export function Pipeline({ dataset }: { dataset: string }) {
  const chain = chainOf(tables(), dataset);
  const [opened, setOpened] = useState<string | null>(dataset);
  const fresh = freshStep.value;
  useEffect(() => {
    if (!fresh || !chain.steps.some((step) => step.id === fresh)) return;
    setOpened(fresh);
    freshStep.value = null;
  }, [fresh]);
  if (!chain.steps.length) return null;
  return (
    <section class="pipeline" aria-label="Pipeline">
      <h3>Pipeline</h3>
      <ol class="steps">
        {chain.source !== null ? <li class="step step-source"><Icon name="file" /><span class="step-title">{shownName(chain.source)}</span></li> : null}
        {chain.steps.map((step, at) => (
          <StepRow key={step.id} chain={chain} step={step} at={at} open={opened === step.id} toggle={() => setOpened(opened === step.id ? null : step.id)} />
        ))}
      </ol>
      <div class="pipeline-tools">
        <button type="button" class="button button-small" disabled={store.readOnly.value} onClick={() => { store.dialog.value = { name: "filters", after: chain.steps.at(-1)!.id }; }}>Add a step</button>
        <button type="button" class="button button-small" disabled={store.readOnly.value} onClick={() => { store.dialog.value = { name: "write", dataset }; }}>Save data as…</button>
        <button type="button" class="button button-small" onClick={() => void copy("pipe", dataset)}>Copy as command</button>
        <button type="button" class="button button-small" onClick={() => void copy("chain", dataset)}>Copy chain</button>
      </div>
    </section>
  );
}
