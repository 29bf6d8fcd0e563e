/** The operation that is being set up beside the picture, and what is seen of it before it is applied. */
import { effect, signal } from "@preact/signals";
import type { Json, JsonObject, Operation } from "../protocol";
import * as store from "../store";
import { flawOf } from "../values";
import type { Tables } from "./chain";

/** Datasets by the names of inputs. */
export type Inputs = { [name: string]: string };

export interface Plan {
  operation: Operation;
  /** What stands for the first input. */
  dataset: string;
  inputs: Inputs;
  parameters: JsonObject;
  /** It goes behind this step of a chain, before what stands on it. */
  inserts: boolean;
  /** All of the data are worked on for the preview, however large they are. */
  whole: boolean;
}

/** What the server says of a part that is seen. */
export interface Preview {
  whole: boolean;
  full: boolean;
  bytes: number;
  /** That the whole takes about, where that is known. */
  seconds?: number;
  picture?: string;
  /** What it is made of, where the view shows something else. */
  input?: string;
  lo?: number[];
  n?: number[];
  dims?: number[];
  window?: number[];
  before?: number;
  after?: number;
  /** Of a step between others: what is made of it is what is seen, or it is seen by itself. */
  end?: boolean;
}

export const tables = (): Tables => ({ world: store.world.value, operations: store.welcome.value?.operations ?? [], classes: store.classes.value });

export const plan = signal<Plan | null>(null);
/** The plan as it was when hands had been still for a moment: that is what is asked for. */
export const asked = signal<Plan | null>(null);
/** By viewport: what came, or the sentence of a refusal. */
export const previews = signal<{ [viewport: string]: Preview | string }>({});
export const waiting = signal(0);
/** The part of a picture that is shown as it is: what is right of it is the preview. */
export const wipe = signal(0.4); // beside the cross-hair, which is in the middle at first
export const previewOn = signal(true);
/** The dataset of a step that has just been made: the pipeline opens it. */
export const freshStep = signal<string | null>(null);

/** What inputs are called that people may name as they like. */
export const LETTERS = "abcdefghijklmnopqrstuvwxyz";

const STILL_MS = 120;

let timer = 0;
effect(() => {
  const now = plan.value;
  clearTimeout(timer);
  if (!now) {
    asked.value = null;
    previews.value = {};
  } else if (!asked.peek()) asked.value = now;
  else timer = window.setTimeout(() => { asked.value = now; }, STILL_MS);
});

/** What went away takes the plan with it. */
effect(() => {
  const now = plan.value;
  if (now && !store.idsOf("datasets").includes(now.dataset)) plan.value = null;
});

/** What stands beside the first input when the panel opens: the first other dataset that fits, where one is needed. */
function firstInputs(operation: Operation, dataset: string): Inputs {
  const inputs: Inputs = {};
  operation.inputs.forEach((operand, i) => {
    const fit = store.datasetsFor(operand);
    if (operand.named) for (let n = 0; n < Math.max(1, operand.least); n++) inputs[LETTERS[n]!] = n === 0 ? dataset : (fit.find((id) => id !== dataset) ?? dataset);
    else if (i > 0 && operand.least > 0) inputs[operand.name] = fit.find((id) => id !== dataset) ?? dataset;
  });
  return inputs;
}

/** Opens the panel; the page's room is the inspector's. */
export function begin(name: string, dataset?: string): void {
  const operation = store.welcome.value?.operations.find((row) => row.name === name);
  const of = dataset ?? store.datasetsFor(operation?.inputs[0])[0];
  if (!operation || !of) return;
  store.rightOpen.value = true;
  plan.value = { operation, dataset: of, inputs: firstInputs(operation, of), parameters: {}, inserts: dataset !== undefined, whole: false };
}

export function change(by: Partial<Plan>): void {
  if (plan.value) plan.value = { ...plan.value, whole: false, ...by };
}

export function setParameter(name: string, value: Json | undefined): void {
  const now = plan.value;
  if (!now || flawOf(value, "") !== "") return;
  const { [name]: _, ...others } = now.parameters;
  change({ parameters: value === undefined ? others : { ...others, [name]: value } });
}

/** The message's members that say what is done to what. */
export function request(of: Plan): { operation: string; dataset: string; inputs: Inputs; parameters: JsonObject } {
  const named = of.operation.inputs.some((operand) => operand.named);
  const inputs = Object.fromEntries(Object.entries(of.inputs).filter(([, id]) => id !== ""));
  return { operation: of.operation.name, dataset: named ? (Object.values(inputs)[0] ?? of.dataset) : of.dataset, inputs, parameters: of.parameters };
}

/** The dataset that it makes. */
export function recipe(of: Plan): JsonObject {
  const { operation, dataset, inputs, parameters } = request(of);
  const first = of.operation.inputs[0]!;
  return { operation, inputs: first.named ? inputs : { [first.name]: dataset, ...inputs }, ...(Object.keys(parameters).length ? { parameters } : {}) };
}

export function isComplete(of: Plan): boolean {
  return of.operation.inputs.every((operand, i) => i === 0 || operand.named || operand.least === 0 || !!of.inputs[operand.name]);
}

/** Why an operation cannot be done to a dataset, or (undefined) to what is shown; "": it can. */
export function hindrance(operation: Operation, dataset?: string): string {
  if (store.readOnly.value) return "this session is read-only";
  const first = operation.inputs[0];
  const shown = dataset ?? (store.currentVolume.value ? store.datasetOf(store.currentVolume.value) : null);
  if (!first || !shown) return "nothing is open";
  const mesh = store.isMeshData(shown);
  return (mesh ? first.mesh : first.volume) ? "" : `works on a ${first.mesh ? "mesh" : "volume"}; ${shown} is a ${mesh ? "mesh" : "volume"}`;
}
