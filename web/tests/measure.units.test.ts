// Pure modules of the Measurement room against formulas and examples.
import assert from "node:assert/strict";
import { test } from "node:test";
import { angleOf, boxBetween, cross, dot, isInSlice, lengthOf, minus, onPlane, project, toIndex } from "../src/measure/geometry";
import { csvOfAnswer, labelRows, plotOf, type Curve } from "../src/measure/plots";
import { curvePath, rangeOf, readout } from "../src/measure/plot_geometry";
import { extentOf, handlesOf, movedRegion, regionOf } from "../src/measure/regions";
import { csvOfRows, rowOf, sorted, type Order, type Row } from "../src/measure/rows";
import { hintOf, kindsOnMeshes, toolsOf } from "../src/measure/tools";
import type { JsonObject, Measure, MeasureForm, Pose } from "../src/protocol";
import type { Vec3 } from "../src/slices/geometry";

test("tools of the Measurement room come from the table of kinds", () => {
  const form = (uses: string[], more: object = {}) => ({ of: ["volume" as const], other: false, points: 0, uses, ...more });
  const row = (name: string, least_points: number, any_points: boolean, forms: MeasureForm[]): Measure => ({ name, doc: "", plot: false, least_points, any_points, forms });
  const tools = toolsOf([
    row("statistics", 0, false, [form(["iso", "seed", "box", "label", "region"])]), row("angle", 3, false, [form(["points"])]), row("distance", 2, true, [form(["points"])]),
    row("labels", 0, false, [form(["box"])]), row("summary", 0, false, [form(["seed", "box", "label"])]), row("area", 0, false, [form(["box"], { other: true }), form(["box"], { of: ["mesh"] })]),
  ]);
  assert.deepEqual(tools.map(({ name, least, most }) => [name, least, most]), [
    ["distance", 2, 2], ["polyline", 2, Infinity], ["angle", 3, 3], ["rectangle", 2, 2], ["ellipse", 2, 2], ["polygon", 3, Infinity], ["sphere", 2, 2], ["box", 2, 2], ["seed", 1, 1], ["label", 1, 1], ["nothing", 0, 0],
  ]);
  assert.deepEqual(tools.find((tool) => tool.takes === "box")!.kinds, ["statistics", "labels", "summary"]);
  assert.deepEqual(tools.find((tool) => tool.takes === "seed")!.kinds, ["summary", "statistics"]);
  assert.match(hintOf(tools[1]!, 2), /Enter or a double click ends/);
  assert.doesNotMatch(hintOf(tools[0]!, 1), /Enter/);
  const polygon = tools.find((tool) => tool.takes === "polygon")!;
  assert.match(hintOf(polygon, 0), /Click the first corner in a slice/);
  assert.match(hintOf(polygon, 3), /Enter or a double click closes the outline/);
});

test("on meshes there are tools for places, regions and the whole, with what can be measured so", () => {
  const form = (of: MeshForm[], uses: string[]) => ({ of, other: false, points: 0, uses });
  type MeshForm = "volume" | "mesh" | "shown";
  const row = (name: string, least_points: number, forms: MeasureForm[]): Measure => ({ name, doc: "", plot: false, least_points, any_points: false, forms });
  const measures = [
    row("distance", 2, [form(["volume"], ["points", "iso"]), form(["shown"], ["points"])]), row("profile", 2, [form(["volume"], ["points"])]),
    row("area", 0, [form(["volume"], ["seed", "label", "region"]), form(["shown"], ["closed", "region"])]), row("histogram", 0, [form(["volume"], ["seed"])]),
  ];
  const kinds = Object.fromEntries(toolsOf(measures).map((tool) => [tool.name, kindsOnMeshes(tool, measures)]));
  assert.deepEqual(kinds, { distance: ["distance"], profile: [], rectangle: ["area"], ellipse: [], polygon: ["area"], sphere: ["area"], seed: [], label: [], nothing: ["area"] });
  const rectangle = toolsOf(measures).find((tool) => tool.name === "rectangle")!;
  assert.match(hintOf(rectangle, 0, true), /on the mesh: what lies behind the outline/);
});

test("regions are what is drawn, in the plane that it is drawn in, and their handles keep the rest where it is", () => {
  const s = Math.SQRT1_2;
  const frame = { right: [s, s, 0] as Vec3, up: [0, 0, 1] as Vec3 }; // a coronal slice that is turned by 45 degrees
  const at = (x: number, y: number): Vec3 => [3 + x * s, 4 + x * s, 5 + y];
  const near = (a: unknown, b: number[]) => b.forEach((v, i) => assert.ok(Math.abs((a as number[])[i]! - v) < 1e-7, `${String(a)} is not ${String(b)}`));
  const box = regionOf("rectangle", [at(6, 1), at(-2, 4)], frame) as JsonObject;
  assert.equal(box["kind"], "box");
  near(box["center"], at(2, 2.5));
  near(box["size"], [8, 3, 0]);
  near(box["normal"], [s, -s, 0]);
  near((regionOf("rectangle", [at(6, 1), at(-2, 4)], frame, 30) as JsonObject)["size"], [8, 3, 30]);
  assert.equal((regionOf("polygon", [at(0, 0), at(4, 0), at(4, 4)], frame, 30) as JsonObject)["thickness"], 30);
  assert.equal((regionOf("polygon", [at(0, 0), at(4, 0), at(4, 4)], frame) as JsonObject)["thickness"], undefined);
  const moved = movedRegion(box, 2, at(9, 9));
  near(handlesOf(moved)[0], at(-2, 1));
  near(handlesOf(moved)[2], at(9, 9));
  near(moved["size"], [11, 8, 0]);
  assert.ok(Math.abs(extentOf("ellipse", [at(0, 0), at(8, 3)], frame).area! - 6 * Math.PI) < 1e-9);
  const corners = [at(0, 0), at(4, 0), at(4, 4), at(2, 1), at(0, 4)];
  assert.ok(Math.abs(extentOf("polygon", corners, frame).area! - 10) < 1e-9);
  near(handlesOf(movedRegion(regionOf("polygon", corners, frame) as JsonObject, 3, at(2, 2)))[3], at(2, 2));
  const ball = regionOf("sphere", [[1, 2, 3], [1, 5, 7]], null) as JsonObject;
  assert.deepEqual(ball, { kind: "ellipsoid", center: [1, 2, 3], size: [10, 10, 10] });
  assert.deepEqual(movedRegion({ ...ball, size: [10, 8, 6] }, 1, [1, 2, 8])["size"], [10, 8, 6]);
  assert.deepEqual(movedRegion(ball, 0, [0, 0, 1])["center"], [0, 0, 1]);
  assert.equal(typeof regionOf("rectangle", [at(1, 1), at(5, 1)], frame), "string");
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

test("a length along several points is listed as what it is", () => {
  const kindOf = (points: number[][]) => row("a", 3, { points }).kind;
  assert.deepEqual([kindOf([[0, 0, 0], [1, 1, 1]]), kindOf([[0, 0, 0], [1, 1, 1], [2, 0, 0]])], ["distance", "polyline"]);
});

test("what comes out now is compared with what the scene keeps, to rounding", () => {
  const series = (step: number, kept: object[] = []) => rowOf("a", { figures: kept as never }, { figures: [{ name: "mean", value: 3 }, { name: "time_step", value: step }], error: "", busy: false }, "heart", () => "mean");
  assert.equal(series(4).step, 4);
  assert.match(csvOfRows([series(4)]), /a,summary,"heart, step 4",mean,3/);
  assert.equal(series(4, [{ name: "mean", value: 3 }, { name: "time_step", value: 4 }]).changed, false);
  assert.equal(series(4, [{ name: "mean", value: 3 }, { name: "time_step", value: 5 }]).changed, true);
  assert.equal(series(4, [{ name: "mean", value: 3 }]).changed, false); // of a version that did not say it
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
  assert.equal(csvOfAnswer({ profile: [[0.5, -1.25]], profile_error: [null], unit: "mm", value_unit: "HU" }), "distance [mm],value [HU],error [HU]\r\n0.5,-1.25,\r\n");
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

test("what is seen at a place of the picture is on the plane that one draws in", () => {
  for (const parallel of [false, true]) {
    const pose = { type: "pose", eye: [3, -200, 40], at: [5, 4, 10], up: [0.1, 0, 1], parallel, fov: 30, height: 80, moving: false } as Pose;
    const [through, normal]: Vec3[] = [[10, 2, 12], [0.2, -0.9, 0.3]];
    for (const place of [[0.5, 0.5], [0.1, 0.8], [0.9, 0.3]] as [number, number][]) {
      const p = onPlane(pose, 1.6, place, through!, normal!)!;
      assert.ok(Math.abs(dot(minus(p, through!), normal!)) < 1e-9, String(p));
      project(pose, 1.6, p)!.forEach((v, i) => assert.ok(Math.abs(v - place[i]!) < 1e-9, `${parallel} ${v}`));
    }
    assert.equal(onPlane(pose, 1, [0.5, 0.5], through!, cross(minus(pose.eye, pose.at), pose.up)), null); // edge on
    if (!parallel) assert.equal(onPlane(pose, 1, [0.5, 0.5], [3, -300, 40], normal!), null); // behind the eye
  }
});
