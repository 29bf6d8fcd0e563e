// Pure modules of the Measurement room against formulas and examples.
import assert from "node:assert/strict";
import { test } from "node:test";
import { angleOf, boxBetween, isInSlice, lengthOf, project, toIndex } from "../src/measure/geometry";
import { csvOfAnswer, labelRows, plotOf, type Curve } from "../src/measure/plots";
import { curvePath, rangeOf, readout } from "../src/measure/plot_geometry";
import { csvOfRows, rowOf, sorted, type Order, type Row } from "../src/measure/rows";
import { hintOf, toolsOf } from "../src/measure/tools";
import type { Measure, MeasureForm } from "../src/protocol";

test("tools of the Measurement room come from the table of kinds", () => {
  const form = (uses: string[], more: object = {}) => ({ of: ["volume" as const], other: false, points: 0, uses, ...more });
  const row = (name: string, least_points: number, any_points: boolean, forms: MeasureForm[]): Measure => ({ name, doc: "", plot: false, least_points, any_points, forms });
  const tools = toolsOf([
    row("statistics", 0, false, [form(["iso", "seed", "box", "label"])]), row("angle", 3, false, [form(["points"])]), row("distance", 2, true, [form(["points"])]),
    row("labels", 0, false, [form(["box"])]), row("summary", 0, false, [form(["seed", "box", "label"])]), row("area", 0, false, [form(["box"], { other: true }), form(["box"], { of: ["mesh"] })]),
  ]);
  assert.deepEqual(tools.map(({ name, least, most }) => [name, least, most]), [
    ["distance", 2, 2], ["polyline", 2, Infinity], ["angle", 3, 3], ["box", 2, 2], ["seed", 1, 1], ["label", 1, 1], ["nothing", 0, 0],
  ]);
  assert.deepEqual(tools.find((tool) => tool.takes === "box")!.kinds, ["statistics", "labels", "summary"]);
  assert.deepEqual(tools.find((tool) => tool.takes === "seed")!.kinds, ["summary", "statistics"]);
  assert.match(hintOf(tools[1]!, 2), /Enter or a double click ends/);
  assert.doesNotMatch(hintOf(tools[0]!, 1), /Enter/);
});

test("lengths and angles of places are those of formulas", () => {
  assert.equal(lengthOf([[0, 0, 0], [3, 4, 0], [3, 4, 12]]), 17);
  assert.equal(lengthOf([[1, 2, 3]]), 0);
  assert.ok(Math.abs(angleOf([[1, 0, 0], [0, 0, 0], [0, 0, 5]]) - 90) < 1e-12);
  assert.ok(Math.abs(angleOf([[2, 0, 0], [1, 0, 0], [0, 1e-9, 0]]) - 180) < 1e-6);
});

test("a place is seen where the camera has it, in both projections", () => {
  const pose = { type: "pose" as const, eye: [0, -10, 0] as [number, number, number], at: [0, 0, 0] as [number, number, number], up: [0, 0, 1] as [number, number, number], moving: false };
  assert.deepEqual(project({ ...pose, parallel: true, height: 4 }, 2, [2, 3, 1]), [0.75, 0.25]);
  const [x, y] = project({ ...pose, parallel: false, fov: 90 }, 2, [10, 0, 5])!; // half of the height is 10 there
  assert.ok(Math.abs(x - 0.75) < 1e-12 && Math.abs(y - 0.25) < 1e-12);
  assert.equal(project({ ...pose, parallel: false, fov: 90 }, 2, [0, -11, 0]), null);
});

test("a region is the samples between two corners, whichever comes first, of turned and sheared grids too", () => {
  const info = { dims: [10, 20, 30], spacing: [2, 1, 0.5], origin: [-5, 0, 1], directions: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] };
  const p = toIndex(info, [-5 - 3, 8, 1 + 2])!; // four along the first axis, three along the second
  assert.ok([4, 3, 4].every((v, i) => Math.abs(p[i]! - v) < 1e-12));
  assert.equal(boxBetween([7.2, 3, 4.9], [2.6, 40, 4.7], [10, 20, 30]), "3..7,3..19,5..5");
  assert.equal(boxBetween([11, 0, 0], [12, 5, 5], [10, 20, 30]), null);
  assert.equal(isInSlice(info, "axial", [0, 0, 3], [9, 9, 3.25]), true);
  assert.equal(isInSlice(info, "axial", [0, 0, 3], [9, 9, 3.3]), false);
});

const row = (id: string, value?: number, more: object = {}): Row => rowOf(id, { what: "distance", figures: value === undefined ? [] : [{ name: "distance", value, error: 0.1, unit: "mm" }], ...more }, { figures: null, error: "", busy: false }, "head", () => "distance");

test("the table is sorted by numbers as numbers, and what has none comes last", () => {
  const all = [row("b", 9), row("a10", 100), row("none"), row("a2", 20)];
  const ids = (order: Order | null) => sorted(all, order).map(({ id }) => id);
  assert.deepEqual(ids(null), ["b", "a10", "none", "a2"]);
  assert.deepEqual(ids({ by: "value", down: false }), ["b", "a2", "a10", "none"]);
  assert.deepEqual(ids({ by: "value", down: true }), ["a10", "a2", "b", "none"]);
  assert.deepEqual(ids({ by: "title", down: false }), ["a2", "a10", "b", "none"]);
});

test("what comes out now is compared with what the scene keeps, to rounding", () => {
  const with_ = (value: number) => rowOf("a", { figures: [{ name: "distance", value: 3 }] }, { figures: [{ name: "distance", value }], error: "", busy: false }, "", () => "").changed;
  assert.deepEqual([with_(3), with_(3 + 1e-10), with_(3.1)], [false, false, true]);
});

test("CSV has all digits, and quotes what needs it", () => {
  const text = csvOfRows([row("a", 0.1 + 0.2, { title: 'the "left", one' }), row("sum", 1e-7, { title: "=SUM(A1)" })]);
  assert.equal(text, 'name,kind,of,quantity,value,error,unit\r\n"the ""left"", one",distance,head,distance,0.30000000000000004,0.1,mm\r\n\'=SUM(A1),distance,head,distance,1e-7,0.1,mm\r\n');
});

test("answers are plotted as what they are: curves with gaps, steps, counts in a plane", () => {
  const curve = plotOf({ profile: [[0, 1], [1, null], [2, 3]], profile_error: [0, null, 0.5], unit: "mm", value_unit: "HU" })!;
  assert.deepEqual([curve.what, curve.xLabel, curve.yLabel], ["curve", "Distance, mm", "Value, HU"]);
  assert.equal(csvOfAnswer({ profile: [[0, 1], [1, null]], profile_error: [0.5, null] }), "distance,value,error\r\n0,1,0.5\r\n1,,\r\n");
  const answer = { histogram: { lo: 0, hi: 4, counts: [7, 0] } };
  const steps = plotOf(answer)!;
  assert.equal(csvOfAnswer(answer), "from,to,count\r\n0,2,7\r\n2,4,0\r\n");
  const f = { left: 0, right: 100, top: 0, bottom: 50, x: rangeOf(steps)[0], y: rangeOf(steps)[1], toX: (v: number) => v * 25, toY: (v: number) => 50 - v };
  assert.equal(readout(steps, f, 60, 10), "Value 2 to 4 · 0 samples");
  assert.equal(curvePath(curve as Curve, { ...f, toX: (v) => v, toY: (v) => v }), "M0.0 1.0M2.0 3.0");
  const joint = { joint: { values: [0, 2], gradients: [0, 1], n_values: 2, n_gradients: 1, counts: [[3, 0]] } };
  assert.equal(csvOfAnswer(joint), "value_from,value_to,gradient_from,gradient_to,count\r\n0,1,0,1,3\r\n");
  assert.equal(plotOf({ distance: 3 }), null);
  assert.deepEqual(labelRows({ labels: [{ label: 1, centroid: [1, 2, 3] }] }), { head: ["label", "centroid_x", "centroid_y", "centroid_z"], rows: [[1, 1, 2, 3]] });
});
