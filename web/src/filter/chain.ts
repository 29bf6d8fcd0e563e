/** How a dataset came about, from a file to it, and changes of that as edits of the World. */
import type { Edit, Json, JsonObject, Operation } from "../protocol";
import { isObject, valueAt, type Classes } from "../values";

/** One operation on the way. */
export interface Step {
  id: string;
  operation: string;
  /** Which of its inputs is what the step before makes. */
  input: string;
  parameters: JsonObject;
  on: boolean;
}

export interface Chain {
  /** The dataset that the first step works on; null: there is none. */
  source: string | null;
  steps: Step[];
}

/** What is known of the World, and of what may be in it. */
export interface Tables {
  world: JsonObject;
  operations: Operation[];
  classes: Classes;
}

const LONGEST = 64;

function datasetAt(world: JsonObject, id: string): JsonObject | null {
  const value = valueAt(world, `datasets.${id}`);
  return isObject(value) ? value : null;
}

export function isMade(world: JsonObject, id: string): boolean {
  const data = datasetAt(world, id);
  return data !== null && typeof data["operation"] === "string" && data["path"] === undefined;
}

function inputsOf(data: JsonObject): JsonObject {
  return isObject(data["inputs"]) ? data["inputs"] : {};
}

/** The name of the input that the chain goes on by: the first one. */
function firstInput(data: JsonObject, operation: Operation | undefined): string | null {
  const first = operation?.inputs[0];
  if (!first) return null;
  return first.named ? (Object.keys(inputsOf(data))[0] ?? null) : first.name;
}

export function chainOf({ world, operations }: Tables, dataset: string): Chain {
  const steps: Step[] = [];
  const seen = new Set<string>();
  let at: string | null = dataset;
  while (at !== null && isMade(world, at) && !seen.has(at) && steps.length < LONGEST) {
    const data: JsonObject = datasetAt(world, at)!;
    const operation = operations.find((row) => row.name === data["operation"]);
    const input = firstInput(data, operation);
    seen.add(at);
    steps.unshift({
      id: at, operation: String(data["operation"]), input: input ?? "", on: data["on"] !== false,
      parameters: isObject(data["parameters"]) ? data["parameters"] : {},
    });
    const next: Json | undefined = input === null ? undefined : inputsOf(data)[input];
    at = typeof next === "string" && datasetAt(world, next) ? next : null;
  }
  return { source: at !== null && isMade(world, at) ? null : at, steps }; // made: a ring
}

function kindOf({ world, operations }: Tables, id: string): "volume" | "mesh" {
  const data = datasetAt(world, id);
  if (isMade(world, id)) return operations.find((row) => row.name === data!["operation"])?.gives ?? "volume";
  return data?.["kind"] === "mesh" ? "mesh" : "volume";
}

function operandOf({ world, operations }: Tables, dataset: string, input: string) {
  const row = operations.find((one) => one.name === datasetAt(world, dataset)?.["operation"]);
  return row?.inputs.find((operand) => operand.name === input) ?? row?.inputs.find((operand) => operand.named);
}

/** Every property that names a dataset: inputs of others, what volumes show, ... */
export function refersTo(tables: Tables, id: string): string[] {
  const found: string[] = [];
  const walk = (value: Json | undefined, className: string, path: string) => {
    for (const row of tables.classes[className]?.properties ?? []) {
      const inside = isObject(value) ? value[row.name] : undefined;
      const where = path ? `${path}.${row.name}` : row.name;
      if (inside === undefined) continue;
      if (row.kind === "reference" && row.ref_to === "datasets" && inside === id) found.push(where);
      else if (row.kind === "members" && row.name === "inputs" && isObject(inside))
        found.push(...Object.keys(inside).filter((name) => inside[name] === id).map((name) => `${where}.${name}`));
      else if (row.kind === "object" && row.class) walk(inside, row.class, where);
      else if ((row.kind === "map" || row.kind === "list") && row.class)
        for (const [name, entry] of Object.entries(inside as JsonObject)) walk(entry, row.class, `${where}.${name}`);
    }
  };
  walk(tables.world, "world", "");
  return found;
}

/** What takes the result of `from` shall take that of `to`; or why it cannot. */
function hand(tables: Tables, paths: string[], to: string): Edit[] | string {
  const kind = kindOf(tables, to);
  for (const path of paths) {
    const [, dataset, input] = /^datasets\.(.+)\.inputs\.([^.]+)$/.exec(path) ?? [];
    if (dataset && input && !operandOf(tables, dataset, input)?.[kind]) return `${dataset} does not work on a ${kind}, as ${to} is one.`;
  }
  return paths.map((path) => ({ op: "set", path, value: to }));
}

/** The step goes, and what stood on it stands on what it was made of. */
export function removeStep(tables: Tables, chain: Chain, id: string): Edit[] | string {
  const at = chain.steps.findIndex((step) => step.id === id);
  const before = at > 0 ? chain.steps[at - 1]!.id : chain.source;
  if (at < 0 || before === null) return "What it is made of is not there.";
  const edits = hand(tables, refersTo(tables, id), before);
  return typeof edits === "string" ? edits : [...edits, { op: "remove", path: `datasets.${id}` }];
}

/** What stands on a step, and would stand on another behind it. */
export function takersOf(tables: Tables, after: string): string[] {
  return refersTo(tables, after).filter((path) => path.startsWith("datasets.") || path.startsWith("volumes."));
}

/** A step behind another one, or (null) behind the source; what stood on that stands on the new one. */
export function insertStep(tables: Tables, after: string, id: string, recipe: JsonObject): Edit[] | string {
  const inputs = isObject(recipe["inputs"]) ? recipe["inputs"] : {};
  const others = Object.values(inputs);
  const next = { ...tables, world: { ...tables.world, datasets: { ...(tables.world["datasets"] as JsonObject), [id]: recipe } } };
  const taken = takersOf(tables, after);
  if (taken.some((path) => others.some((other) => path.startsWith(`datasets.${String(other)}.`) && other !== after)))
    return "One of its other inputs stands on this step: that would be a ring.";
  const edits = hand(next, taken, id);
  return typeof edits === "string" ? edits : [{ op: "add", path: "datasets", id, value: recipe }, ...edits, ...forgotten(tables, recipe, taken)];
}

/** New labels have neither the names nor the colours of those that they are made of. */
function forgotten({ world, operations }: Tables, recipe: JsonObject, takers: string[]): Edit[] {
  if (!operations.find((row) => row.name === recipe["operation"])?.new_values) return [];
  const shown = takers.flatMap((path) => /^(volumes\.[^.]+)\.data$/.exec(path)?.[1] ?? []);
  return shown.flatMap((volume) => ["table", "names"].map((name) => `${volume}.segmentation.labels.${name}`))
    .filter((path) => valueAt(world, path) !== undefined).map((path) => ({ op: "unset", path }));
}

/** One step to another place; what stood on the last one stands on the one that is last then. */
export function moveStep(tables: Tables, chain: Chain, from: number, to: number): Edit[] | string {
  const order = [...chain.steps];
  const [moved] = order.splice(from, 1);
  if (!moved || to < 0 || to > order.length || chain.source === null) return "There is no such place.";
  order.splice(to, 0, moved);
  const edits: Edit[] = [];
  let before = chain.source;
  for (const [i, step] of order.entries()) {
    const operand = operandOf(tables, step.id, step.input);
    const kind = kindOf(tables, before);
    if (!operand?.[kind]) return `${step.id} does not work on a ${kind}, as ${before} is one.`;
    const others = Object.entries(inputsOf(datasetAt(tables.world, step.id)!)).filter(([name]) => name !== step.input).map(([, id]) => id);
    const later = order.slice(i).find((other) => others.includes(other.id));
    if (later) return `${step.id} also works on ${later.id}, which must come before it.`;
    if (chain.steps[i]?.id !== step.id || (i > 0 && chain.steps[i - 1]?.id !== order[i - 1]!.id))
      edits.push({ op: "set", path: `datasets.${step.id}.inputs.${step.input}`, value: before });
    before = step.id;
  }
  const last = chain.steps.at(-1)!.id;
  const inside = new Set(order.map((step) => `datasets.${step.id}.inputs.${step.input}`));
  const outside = last === before ? [] : hand(tables, refersTo(tables, last).filter((path) => !inside.has(path)), before);
  return typeof outside === "string" ? outside : [...edits, ...outside];
}

/** Its parameters in a few words: "sigma 1mm, border wrap". */
export function summaryOf(step: Step): string {
  const words = Object.entries(step.parameters).map(([name, value]) => {
    const word = name.replace(/_/g, " ");
    return typeof value === "boolean" ? (value ? word : `no ${word}`) : `${word} ${Array.isArray(value) ? value.join(", ") : String(value)}`;
  });
  return words.join(", ") || "defaults";
}
