// Pipelines as lists: what is removed, moved and put between others, as edits whose result is looked at.
import assert from "node:assert/strict";
import { describe, test } from "node:test";
import { chainOf, insertStep, moveStep, refersTo, removeStep, summaryOf, type Tables } from "../src/filter/chain";
import type { Edit, JsonObject, Operation, Property } from "../src/protocol";

const one = (name: string, mesh = false) => ({ name, doc: "", volume: !mesh, mesh, least: 1, most: 1, named: false });
const operation = (name: string, inputs = [one("volume")], gives: "volume" | "mesh" = "volume"): Operation =>
  ({ name, component: "filter", group: "smoothing", doc: "", class: `operation.${name}`, inputs, gives });
const operations = [
  operation("gaussian"), operation("median"), operation("threshold"), operation("mask", [one("volume"), one("mask")]),
  operation("isosurface", [one("volume")], "mesh"), operation("smooth", [one("mesh", true)], "mesh"),
  operation("calc", [{ ...one("values"), most: 8, named: true }]),
];
const row = (name: string, kind: Property["kind"], more = {}): Property => ({ name, kind, doc: "", ...more });
const classes = {
  world: { doc: "", properties: [row("datasets", "map", { class: "dataset" }), row("volumes", "map", { class: "volume" })] },
  dataset: { doc: "", properties: [row("path", "path"), row("operation", "string"), row("inputs", "members"), row("parameters", "members"), row("on", "bool")] },
  volume: { doc: "", properties: [row("data", "reference", { ref_to: "datasets" }), row("paint", "object", { class: "paint" })] },
  paint: { doc: "", properties: [row("data", "reference", { ref_to: "datasets" })] },
};
const made = (name: string, of: string, parameters: JsonObject = {}): JsonObject => ({ operation: name, inputs: { volume: of }, parameters });
const world = (): JsonObject => ({
  datasets: {
    head: { path: "scans/my head.nrrd" }, a: made("gaussian", "head", { sigma: "1mm" }), b: made("median", "a", { radius_voxels: [1, 1, 2] }),
    c: made("threshold", "b", { range: "80..", fill: false }), s: { operation: "isosurface", inputs: { volume: "b" } }, t: { operation: "smooth", inputs: { mesh: "s" } },
  },
  volumes: { head: { data: "c" }, other: { data: "t", paint: { data: "b" } } },
});
const tables = (of = world()): Tables => ({ world: of, operations, classes });

/** As the server does them. */
function after(edits: Edit[] | string, of = world()): Tables {
  assert.ok(typeof edits !== "string", String(edits));
  for (const edit of edits) {
    const parts = edit.path.split(".");
    const name = parts.pop()!;
    const at = parts.reduce((value, part) => value[part] as JsonObject, of);
    if (edit.op === "set") at[name] = edit.value;
    else if (edit.op === "add") (at[name] as JsonObject)[edit.id!] = edit.value;
    else delete at[name];
  }
  return tables(of);
}
const ids = (of: Tables, dataset: string) => [chainOf(of, dataset).source, ...chainOf(of, dataset).steps.map((step) => step.id)];
const dataOf = (of: Tables, volume: string) => ((of.world["volumes"] as JsonObject)[volume] as JsonObject)["data"];

describe("a pipeline", () => {
  test("is read from the file to the dataset, and ends where a ring begins", () => {
    assert.deepEqual(ids(tables(), "c"), ["head", "a", "b", "c"]);
    assert.deepEqual(ids(tables(), "t"), ["head", "a", "b", "s", "t"]);
    assert.deepEqual(ids(tables(), "head"), ["head"]);
    const ring = world();
    ((ring["datasets"] as JsonObject)["a"] as JsonObject)["inputs"] = { volume: "c" };
    assert.deepEqual(chainOf(tables(ring), "c").source, null);
  });

  test("finds all that refers to a dataset", () => {
    assert.deepEqual(refersTo(tables(), "b"), ["datasets.c.inputs.volume", "datasets.s.inputs.volume", "volumes.other.paint.data"]);
  });

  test("loses a step, and what stood on it stands on the one before", () => {
    const next = after(removeStep(tables(), chainOf(tables(), "c"), "b"));
    assert.deepEqual(ids(next, "c"), ["head", "a", "c"]);
    assert.deepEqual(ids(next, "t"), ["head", "a", "s", "t"]);
    assert.deepEqual(refersTo(next, "b"), []);
    const first = after(removeStep(tables(), chainOf(tables(), "c"), "c"));
    assert.equal(dataOf(first, "head"), "b");
  });

  test("keeps a step whose input is of another kind than the next one takes", () => {
    assert.match(String(removeStep(tables(), chainOf(tables(), "t"), "s")), /t does not work on a volume/);
  });

  test("has steps in another order, and the volume shows the last one", () => {
    const chain = chainOf(tables(), "c");
    const next = after(moveStep(tables(), chain, 2, 0));
    assert.equal(dataOf(next, "head"), "b");
    assert.deepEqual(ids(next, "b"), ["head", "c", "a", "b"]);
    const swapped = after(moveStep(tables(), chain, 0, 1));
    assert.deepEqual(ids(swapped, "c"), ["head", "b", "a", "c"]);
    assert.match(String(moveStep(tables(), chainOf(tables(), "t"), 2, 1)), /\w/);
    assert.match(String(moveStep(tables(), chainOf(tables(), "t"), 2, 3)), /t does not work on a volume/);
  });

  test("refuses an order in which a step would stand on a later one", () => {
    const of = world();
    (of["datasets"] as JsonObject)["m"] = { operation: "mask", inputs: { volume: "c", mask: "a" } };
    assert.match(String(moveStep(tables(of), chainOf(tables(of), "m"), 3, 0)), /m also works on a/);
  });

  test("has a step put between others: all that stood there stands on it", () => {
    const next = after(insertStep(tables(), "b", "n", made("gaussian", "b")));
    assert.deepEqual(ids(next, "c"), ["head", "a", "b", "n", "c"]);
    assert.deepEqual(ids(next, "t"), ["head", "a", "b", "n", "s", "t"]);
    assert.equal(dataOf(after(insertStep(tables(), "c", "n", made("median", "c"))), "head"), "n");
    assert.match(String(insertStep(tables(), "b", "n", { operation: "isosurface", inputs: { volume: "b" } })), /does not work on a mesh/);
  });

  test("says a step's parameters in a few words", () => {
    assert.equal(summaryOf(chainOf(tables(), "c").steps[2]!), "range 80.., no fill");
  });
});
