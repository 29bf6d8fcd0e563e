// Pure modules of the page against formulas and examples of docs/protocol.md.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeSrgb, encodeSrgb, hexOf, hexOfLinear, linearOfHex } from "../src/colors";
import { applyChanges, KnownWorld } from "../src/changes";
import { backOff, Connection } from "../src/connection";
import { datasetOf as failedDataset, reasonOf } from "../src/failure";
import { otsu, startOf } from "../src/filter/start";
import { inPanel } from "../src/filter/words";
import type { Operation, Property } from "../src/protocol";
import { Finality, isWhole, parseFrame } from "../src/frames";
import { addEvent, keyName, placeIn, printEvent, wheelNotches, type TimedEvent } from "../src/input/events";
import { axesOf, fromCamera, fromDisc, onDisc, placedAt, seenAt, toCamera, unit } from "../src/view/light_geometry";
import { nextDirection } from "../src/directions";
import { rangeOf, windowEdits } from "../src/transfer/window";
import { inOrder, keycaps, keysOfActions } from "../src/keys";
import { findBest } from "../src/search";
import { toBeOpened, whyNot } from "../src/uploads_order";
import { draggedWindow, panned, placeOf, runAlong, sliceAt, toPicture, toWorld, zoomed } from "../src/slices/geometry";
import { columns, fullAxis, heightOpacity, insertNode, moveNode, opacityHeight, removeNode, sampleNodes, ticks, zoomAxis, type OpacityNode, isMap, moveEnd, thin } from "../src/transfer/curve";
import { acts, classAt, flawOf, hasEntry, formatBytes, formatNumber, freeName, label, labelOf, parseEntry, parseLabel, parseRow, sliderScale, tipOf, unitOf, valueAt, type Classes } from "../src/values";
import { axisEnds, cameraFrom } from "../src/view/axes_geometry";

function frameBytes(): ArrayBuffer {
  const bytes = new Uint8Array(36);
  const view = new DataView(bytes.buffer);
  bytes.set([0x56, 0x56, 0x46, 0x31]);
  view.setUint16(4, 2, true);
  view.setUint16(6, 3, true);
  view.setUint32(8, 70000, true);
  [640, 360, 1280, 720, 2, 9].forEach((v, i) => view.setUint16(12 + 2 * i, v, true));
  view.setUint32(24, 12, true);
  view.setFloat32(28, 16.5, true);
  bytes.set([1, 2, 3, 4], 32);
  return bytes.buffer;
}

test("the head of a frame is read as the protocol says", () => {
  const frame = parseFrame(frameBytes())!;
  assert.deepEqual({ ...frame, picture: [...frame.picture] }, {
    type: "image/png", final: true, moving: true, compressed: false, number: 70000, width: 640, height: 360, fullWidth: 1280, fullHeight: 720,
    level: 2, passes: 9, commit: 12, latency: 16.5, picture: [1, 2, 3, 4],
  });
});

test("a picture that was broken off is known by its end", () => {
  const end = { "image/png": [0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82], "image/jpeg": [0xff, 0xd9] };
  for (const type of ["image/png", "image/jpeg"] as const) {
    const whole = new Uint8Array([1, 2, 3, ...end[type]]);
    assert.equal(isWhole({ type, picture: whole }), true);
    for (let n = 0; n < whole.length; n++) assert.equal(isWhole({ type, picture: whole.subarray(0, n) }), false);
  }
});

test("what is no frame is refused: too short, another magic, another kind", () => {
  const kind = new Uint8Array(frameBytes());
  kind[4] = 7;
  const magic = new Uint8Array(frameBytes());
  magic[0] = 0;
  for (const bytes of [new ArrayBuffer(0), frameBytes().slice(0, 32), kind.buffer, magic.buffer]) assert.equal(parseFrame(bytes), null);
});

test("frames that came before the server took its word back are final no more, on the screen or on their way there", () => {
  const finality = new Finality();
  assert.equal(finality.isOutdated(1), false);
  for (const frame of [1, 2]) finality.take(frame);
  finality.outdate();
  assert.deepEqual([1, 2, 3].map((frame) => finality.isOutdated(frame)), [true, true, false]);
  finality.begin();
  assert.equal(finality.isOutdated(1), false);
});

test("the value that parts a histogram is between its two humps", () => {
  const counts = Array.from({ length: 100 }, (_, i) => Math.exp(-(((i - 20) / 5) ** 2)) + 0.5 * Math.exp(-(((i - 70) / 5) ** 2)));
  const histogram = { lo: -100, hi: 100, counts, unit: null, mean: 0, deviation: 1, n: 1, percentiles: { 1: -80.25, 99: 60 } };
  const at = otsu(histogram);
  assert.ok(at > -50 && at < 30, String(at));
  const known = { histogram, crossHair: null, orientation: "RAS" };
  assert.deepEqual(startOf("clamp", known), { range: "-80.25..60" });
  assert.deepEqual([startOf("clamp", { ...known, histogram: null }), startOf("grow", known), startOf("gaussian", known), startOf("reorient", known)], [{}, {}, {}, {}]);
});

test("sentences of operations are about the fields of the panel", () => {
  const operation = { name: "threshold" } as Operation;
  const rows = [{ name: "method" }, { name: "min_size" }] as Property[];
  assert.equal(inPanel("threshold: range is needed; or --method otsu, --min-size, --other", operation, rows), "Range is needed; or Method otsu, Min size, --other.");
  assert.equal(inPanel('parameters.min_size: expected a length, found "x"', operation, rows), 'Min size: expected a length, found "x".');
  const all = [operation, { ...operation, name: "distance" }];
  assert.equal(inPanel("no basins; a `volvis distance --side inside` has, `volvis convert --type u8` keeps", operation, rows, all), "No basins; a Distance (Side inside) has, `volvis convert --type u8` keeps.");
  assert.equal(inPanel("see 'volvis distance', or `distance`", operation, rows, all), "See Distance, or Distance.");
  assert.equal(inPanel("on the grid of another volume (onto=FILE)", operation, []), "On the grid of another volume.");
});

test("why there is no picture is said until it is tried again or a newer frame is there", () => {
  const finality = new Finality();
  const failure = { text: "datasets.body.parameters: expected a range", where: "datasets.body.parameters", frame: 7 };
  const kept = (frame: number) => { finality.fail(failure); finality.show(frame); return finality.failure !== null; };
  assert.deepEqual([6, 7, 8].map(kept), [true, true, false]);
  finality.fail(failure);
  finality.outdate();
  assert.equal(finality.failure, null);
  assert.deepEqual([failedDataset(failure), failedDataset({ ...failure, where: null }), failedDataset({ ...failure, where: "volumes.ring" })], ["body", null, null]);
  assert.deepEqual([reasonOf(failure), reasonOf({ ...failure, where: null })], ["expected a range", failure.text]);
});

test("places are from the middle in half of the smaller side, y up", () => {
  const rect = { left: 100, top: 50, width: 400, height: 200 };
  assert.deepEqual(placeIn(rect, 300, 150), [0, 0]);
  assert.deepEqual(placeIn(rect, 500, 50), [2, 1]);
  assert.deepEqual(placeIn(rect, 100, 250), [-2, -1]);
});

test("lines of events are those of the protocol", () => {
  const lines = (event: TimedEvent) => printEvent(event);
  assert.deepEqual(lines({ t: 1.25, kind: "place", x: -0.25, y: 0.5 }), ["1250000 mouse axis x -0.25", "1250000 mouse axis y 0.5"]);
  assert.deepEqual(lines({ t: 1.25, kind: "button", button: "left", down: true }), ["1250000 mouse button left down"]);
  assert.deepEqual(lines({ t: 2, kind: "key", key: "ArrowLeft", down: true }), ["2000000 keyboard key ArrowLeft down"]);
  assert.deepEqual(lines({ t: 2.1, kind: "touch", id: 3, phase: "move", x: 0.5, y: -0.125 }), ["2100000 touch touch 3 move 0.5 -0.125"]);
  assert.deepEqual(lines({ t: 2.2, kind: "lost", device: "mouse" }), ["2200000 mouse lost"]);
  assert.deepEqual(lines({ t: 1, kind: "wheel", axis: "wheel-y", notches: 1 }), ["1000000 mouse axis wheel-y 1"]);
});

test("moves are joined, buttons between them are not passed", () => {
  const waiting: TimedEvent[] = [];
  const add = (event: TimedEvent) => addEvent(waiting, event);
  add({ t: 1, kind: "place", x: 0, y: 0 });
  add({ t: 2, kind: "place", x: 1, y: 1 });
  add({ t: 3, kind: "button", button: "left", down: true });
  add({ t: 4, kind: "place", x: 2, y: 2 });
  add({ t: 5, kind: "wheel", axis: "wheel-y", notches: 1 });
  add({ t: 6, kind: "wheel", axis: "wheel-y", notches: 0.5 });
  assert.deepEqual(waiting.map((e) => e.t), [2, 3, 4, 6]);
  assert.equal((waiting[3] as { notches: number }).notches, 1.5);
});

test("of two fingers each keeps its last move", () => {
  const waiting: TimedEvent[] = [];
  for (const [t, id] of [[1, 1], [2, 2], [3, 1], [4, 2]] as const) addEvent(waiting, { t, kind: "touch", id, phase: "move", x: t, y: 0 });
  assert.deepEqual(waiting.map((e) => e.t), [3, 4]);
});

test("wheels in pixels, lines and pages give the same notches", () => {
  assert.equal(wheelNotches(100, 0), 1);
  assert.equal(wheelNotches(3, 1), 1);
  assert.equal(wheelNotches(1, 2), 1);
  assert.equal(wheelNotches(1e9, 0), 10);
});

test("keys have the names of bindings", () => {
  assert.equal(keyName({ key: "a", code: "KeyA" }), "A");
  assert.equal(keyName({ key: "!", code: "Digit1" }), "Digit1");
  assert.equal(keyName({ key: "7", code: "Numpad7" }), "Digit7");
  assert.equal(keyName({ key: "+", code: "Equal" }), "+");
  assert.equal(keyName({ key: " ", code: "Space" }), "Space");
  assert.deepEqual(keycaps("Control+Shift+Z"), ["Ctrl", "Shift", "Z"]);
  assert.deepEqual(keycaps("+"), ["+"]);
});

test("nodes: a jump holds from its value on, beyond the ends the last value holds", () => {
  const nodes = [[0, 0], [10, 1], [10, 0.5], [20, 0.5]];
  assert.deepEqual(sampleNodes(nodes, -5), [0]);
  assert.deepEqual(sampleNodes(nodes, 5), [0.5]);
  assert.deepEqual(sampleNodes(nodes, 10), [0.5]);
  assert.deepEqual(sampleNodes(nodes, 99), [0.5]);
  assert.deepEqual(sampleNodes([], 1), []);
});

test("a node does not pass its neighbours, and opacity stays in 0 to 1", () => {
  const nodes: OpacityNode[] = [[0, 0], [10, 0.5], [20, 1]];
  assert.deepEqual(moveNode(nodes, 1, 99, 7), [[0, 0], [20, 1], [20, 1]]);
  assert.deepEqual(moveNode(nodes, 1, -99, -7), [[0, 0], [0, 0], [20, 1]]);
  assert.equal(insertNode<OpacityNode>(nodes, [10, 0.7]).index, 2);
  assert.equal(insertNode<OpacityNode>(nodes, [-1, 0]).index, 0);
  assert.deepEqual(removeNode(nodes, 1), [[0, 0], [20, 1]]);
});

test("zooming keeps the value under the pointer and never leaves the whole", () => {
  const full = { lo: -1000, hi: 3000 };
  const near = zoomAxis(full, full, 0, 0.5);
  assert.equal(near.hi - near.lo, 2000);
  assert.ok(Math.abs((0 - near.lo) / 2000 - 0.25) < 1e-12);
  assert.deepEqual(zoomAxis(near, full, 0, 100), full);
  assert.deepEqual(fullAxis(5, 5, []), { lo: 4.5, hi: 5.5 });
});

test("the axis of opacity is one to one", () => {
  for (let i = 0; i <= 100; i++) assert.ok(Math.abs(heightOpacity(opacityHeight(i / 100)) - i / 100) < 1e-12);
});

test("columns of a histogram: none is lost when there are fewer than bins, and air does not flatten the rest", () => {
  const counts = [100000, 5, 7, 0, 3];
  assert.deepEqual(columns(counts, 0, 5, { lo: 0, hi: 5 }, 5, false).map((h) => h > 0), [true, true, true, false, true]);
  assert.equal(columns(counts, 0, 5, { lo: 0, hi: 5 }, 2, true)[0], 1);
  assert.ok(columns(counts, 0, 5, { lo: 0, hi: 5 }, 5, false)[1]! >= 0.5);
  assert.deepEqual(columns([], 0, 1, { lo: 0, hi: 1 }, 3, true), [0, 0, 0]);
});

test("ticks are round and inside", () => {
  assert.deepEqual(ticks({ lo: 0, hi: 255 }, 5), [0, 100, 200]);
  for (const t of ticks({ lo: -3.2, hi: 7.9 }, 6)) assert.ok(t >= -3.2 && t <= 7.9);
});

test("sRGB there and back", () => {
  for (let i = 0; i <= 255; i++) assert.ok(Math.abs(encodeSrgb(decodeSrgb(i / 255)) - i / 255) < 1e-12);
  assert.equal(hexOfLinear(linearOfHex("#5eb0ee")), "#5eb0ee");
  assert.equal(hexOf("#E6DCC8ff"), "#e6dcc8");
  assert.equal(hexOf([1, 0, 0]), "#ff0000");
});

test("all names of colours that the program knows are those of the browser, and no other text is one", () => {
  const source = readFileSync("../src/core/color_names.c", "utf-8");
  const names = new Map([...source.matchAll(/\{"(\w+)", 0x([0-9a-f]{6})([0-9a-f]{2})\}/g)].map((m) => [m[1]!, m[3] === "ff" ? `#${m[2]}` : "rgba(0, 0, 0, 0)"]));
  const canvas = { // as the HTML standard has it: what is no colour changes nothing
    is: "#000000",
    get fillStyle() { return this.is; },
    set fillStyle(typed: string) { this.is = typed.startsWith("#") ? typed : names.get(typed.toLowerCase()) ?? this.is; },
  };
  Object.assign(globalThis, { document: { createElement: () => ({ getContext: () => canvas }) } });
  assert.equal(names.size, 149);
  for (const [name, hex] of names) assert.equal(hexOf(name), name === "transparent" ? "#000000" : hex, name);
  assert.equal(hexOf("RebeccaPurple"), "#663399");
  for (const text of ["nonsense", "", "url(x)", "#12", "rgb(1, 2, 3)"]) assert.equal(hexOf(text), null, text);
  Reflect.deleteProperty(globalThis, "document");
});

test("numbers are short and lose no digit before the point", () => {
  for (const [value, text] of [[0, "0"], [0.1234567, "0.1235"], [143, "143"], [12345.678, "12346"], [1e-9, "1e-9"], [2.5e12, "2.5e12"], [-31.25, "-31.25"]] as const)
    assert.equal(formatNumber(value), text);
  assert.equal(formatBytes(1536), "1.5 KiB");
  assert.equal(formatBytes(0), "0 B");
});

test("entries: numbers become numbers, units stay text, nothing is nothing", () => {
  assert.equal(parseEntry(" 1,5 "), 1.5);
  assert.equal(parseEntry("\u22122"), -2);
  assert.equal(parseEntry("1.5mm"), "1.5mm");
  assert.equal(parseEntry("  "), undefined);
});

test("whole numbers that are not what was typed are refused", () => {
  assert.match(flawOf(parseEntry("1e20"), "integer"), /beyond 9007199254740991/);
  assert.match(flawOf(parseEntry("-9007199254740993"), "integer"), /beyond/);
  assert.deepEqual([flawOf(2 ** 53 - 1, "integer"), flawOf(1e20, "number"), flawOf(1.5, "integer"), flawOf("1e20", "string")], ["", "", "", ""]);
});

test("ids of labels keep all of their digits", () => {
  assert.deepEqual(["7", " 864691135000000001 ", "-864691135000000002", "\u2212864691135000000002", "7.5", ""].map(parseLabel),
    [7, "864691135000000001", "-864691135000000002", "-864691135000000002", 7.5, undefined]);
  assert.deepEqual(parseRow("864691135000000001, 1 0; 0.5, 1", 5), ["864691135000000001", 1, 0, 0.5, 1]);
  assert.deepEqual(parseRow("3, 0.5", 0), [3, 0.5]);
});

test("an entry is there or not", () => {
  const world = { volumes: { a: {} }, cut_planes: [{}] };
  for (const path of ["", "volumes", "volumes.a", "volumes.a.place", "cut_planes.0"]) assert.ok(hasEntry(world, path), path);
  for (const path of ["volumes.b", "volumes.constructor", "cut_planes.1", "lights.key"]) assert.ok(!hasEntry(world, path), path);
});

test("changes make one World of another, in the order of its maps, and leave the old one as it is", () => {
  const world = JSON.parse('{"title": "a", "lights": {"key": {"on": true, "color": "#fff"}, "fill": {}}, "cut_planes": [{"offset": 1}, {"offset": 2}], "views": {"main": {"width": 3}}}');
  const before = structuredClone(world);
  const now = applyChanges(world, [
    { op: "set", path: "title", value: "b" }, { op: "unset", path: "lights.key.color" }, { op: "set", path: "lights.key.intensity", value: 2 },
    { op: "add", path: "lights", id: "back", after: "key", value: { on: false } }, { op: "add", path: "lights", id: "first", after: null, value: {} },
    { op: "remove", path: "lights.fill" }, { op: "add", path: "lights", id: "__proto__", after: "back", value: { on: true } },
    { op: "set", path: "cut_planes.1.offset", value: 5 }, { op: "set", path: "datasets", value: { a: {} } }, { op: "set", path: "views.left.camera.zoom", value: 2 },
  ]);
  assert.deepEqual(world, before);
  assert.deepEqual(Object.keys(now.lights as object), ["first", "key", "back", "__proto__"]);
  assert.equal(valueAt(now, "lights.__proto__.on"), true);
  assert.equal(({} as { on?: boolean }).on, undefined);
  assert.deepEqual(valueAt(now, "lights.key"), { on: true, intensity: 2 });
  assert.deepEqual(now.cut_planes, [{ offset: 1 }, { offset: 5 }]);
  assert.deepEqual([now.title, now.datasets, now.views], ["b", { a: {} }, { main: { width: 3 }, left: { camera: { zoom: 2 } } }]);
  assert.equal(valueAt(now, "views.main"), valueAt(world, "views.main"), "what did not change is the same");
  assert.deepEqual(applyChanges(world, [{ op: "set", path: "", value: { title: "c" } }]), { title: "c" });
});

test("a page that missed a message about the World knows that it did, until it is told all of it", () => {
  const known = new KnownWorld();
  const rest = { type: "world" as const, who: "", paths: [], undo: false, redo: false, title: null };
  const title = (since: number, number: number) => known.take({ ...rest, number, since, changes: [{ op: "set", path: "title", value: `${number}` }] });
  assert.equal(title(0, 1), null);
  assert.deepEqual(known.take({ ...rest, number: 4, world: { unit: "mm" } }), { unit: "mm" });
  assert.deepEqual(title(4, 6), { unit: "mm", title: "6" });
  assert.equal(title(7, 8), null);
  assert.deepEqual(title(6, 9), { unit: "mm", title: "9" });
});

test("paths lead to values and classes, prototypes are no values", () => {
  const world = { volumes: { a: { cut_planes: [{ offset: 3 }] } } };
  const classes: Classes = {
    world: { doc: "", properties: [{ name: "volumes", kind: "map", doc: "", class: "volume" }] },
    volume: { doc: "", properties: [{ name: "cut_planes", kind: "list", doc: "", class: "cut_plane" }, { name: "place", kind: "object", doc: "", class: "frame" }] },
    cut_plane: { doc: "", properties: [] }, frame: { doc: "", properties: [] },
  };
  assert.equal(valueAt(world, "volumes.a.cut_planes.0.offset"), 3);
  assert.equal(valueAt(world, "volumes.b"), undefined);
  assert.equal(valueAt(world, "constructor"), undefined);
  assert.equal(classAt(classes, "volumes.a.cut_planes.0"), "cut_plane");
  assert.equal(classAt(classes, "volumes.a.place"), "frame");
  assert.equal(classAt(classes, "nothing"), null);
  assert.equal(label("range_lo"), "Range lo");
  assert.equal(label("fill-holes"), "Fill holes");
  assert.equal(freeName(["light", "light2"], "light"), "light3");
});

test("what a property is called, and what its tool tip says", () => {
  const row = { name: "range_lo", kind: "number" as const, doc: "the lower end" };
  assert.equal(labelOf(row), "Range lo");
  assert.equal(tipOf(row), "The lower end.");
  const named = { name: "parc", label: "skip empty ends", kind: "bool" as const, doc: "follow rays between boxes", automatic: "on" };
  assert.equal(labelOf(named), "Skip empty ends");
  assert.equal(tipOf(named), "Follow rays between boxes. Automatic: on. In scenes and lines: parc.");
});

test("sliders: linear, logarithmic over three decades, none where the range has no end", () => {
  const row = { name: "x", kind: "number" as const, doc: "" };
  assert.equal(sliderScale({ ...row, min: 0, max: 1e9 }), null);
  assert.equal(sliderScale(row), null);
  assert.equal(sliderScale({ ...row, min: 0, max: 10 })!.toValue(0.5), 5);
  assert.equal(sliderScale({ ...row, min: 1, max: 10000 })!.toValue(0.5), 100);
  assert.equal(sliderScale({ ...row, kind: "integer", min: 0, max: 65535 }), null);
  assert.equal(unitOf({ ...row, unit: "value per length" }, "mm", "HU"), "HU/mm");
  assert.equal(unitOf({ ...row, quantity: "angle" }, "mm", ""), "\u00b0");
});

test("search: all words must be there, titles count more than what is said of them", () => {
  const rows = [["Ramp", "opacity rises evenly"], ["Opacity length", "of a transfer"], ["Shadows", ""]];
  assert.deepEqual(findBest("opac", rows, (r) => r, 9).map((r) => r[0]), ["Opacity length", "Ramp"]);
  assert.deepEqual(findBest("opacity rises", rows, (r) => r, 9).map((r) => r[0]), ["Ramp"]);
  assert.equal(findBest("zebra", rows, (r) => r, 9).length, 0);
  assert.equal(findBest(" ", rows, (r) => r, 2).length, 2);
});

test("axes: from the front x points left, z up, and y to the viewer", () => {
  const ends = axisEnds({ eye: [0, 10, 0], at: [0, 0, 0], up: [0, 0, 1] });
  const end = (axis: string) => ends.find((e) => e.axis === axis && e.positive)!;
  assert.ok(Math.abs(end("x").x + 1) < 1e-12);
  assert.ok(Math.abs(end("z").y + 1) < 1e-12);
  assert.ok(Math.abs(end("y").depth - 1) < 1e-12);
});

test("from an end of an axis the distance stays, and up is z or an axis of the horizon", () => {
  const pose = { eye: [3, 4, 0] as [number, number, number], at: [0, 0, 0] as [number, number, number], up: [0, 0, 1] as [number, number, number], parallel: false, fov: 20 };
  assert.deepEqual(cameraFrom(pose, { axis: "x", positive: false }), { eye: [-5, 0, 0], at: [0, 0, 0], up: [0, 0, 1], fov: 20 });
  assert.deepEqual(cameraFrom(pose, { axis: "z", positive: true }).up, [-0, -1, -0]);
  assert.deepEqual(cameraFrom(pose, { axis: "z", positive: false }).up, [0, 1, 0]);
});

test("tries come back slower and slower, up to eight seconds", () => {
  assert.deepEqual([0, 1, 2, 3, 4, 5, 6, 60].map(backOff), [250, 500, 1000, 2000, 4000, 8000, 8000, 8000]);
});

// Slices -----------------------------------------------------------------------------------------------------------

const axial = { type: "pose" as const, eye: [5, -7, -500] as [number, number, number], at: [5, -7, 20] as [number, number, number], up: [0, 1, 0] as [number, number, number], parallel: true, height: 200, moving: false };

test("from the feet the patient's right is on the left, and the front at the top", () => {
  const [x, y] = toPicture(axial, 2, [5 + 40, -7 + 30, 20]);
  assert.ok(Math.abs(x - (0.5 - 40 / 400)) < 1e-12 && Math.abs(y - (0.5 - 30 / 200)) < 1e-12, `${x} ${y}`);
});

test("a point of the picture is the point of the plane through the cross-hair that is seen there", () => {
  for (const p of [[5, -7, 33], [80, 12, 33], [-31, 44.5, 33]] as [number, number, number][]) {
    const back = toWorld(axial, 1.25, ...toPicture(axial, 1.25, p), [1, 2, 33]);
    assert.ok(back.every((v, i) => Math.abs(v - p[i]!) < 1e-9), `${back} ${p}`);
  }
});

test("what is under the pointer stays there when the picture is moved or comes nearer", () => {
  const p = toWorld(axial, 1.5, 0.3, 0.8, [0, 0, 20]);
  const moved = toPicture(panned(axial, 1.5, 0.1, -0.2), 1.5, p);
  assert.ok(Math.abs(moved[0] - 0.4) < 1e-12 && Math.abs(moved[1] - 0.6) < 1e-12, `${moved}`);
  const nearer = zoomed(axial, 1.5, 0.5, 0.3, 0.8);
  const [x, y] = toPicture(nearer, 1.5, p);
  assert.ok(nearer.height === 100 && Math.abs(x - 0.3) < 1e-12 && Math.abs(y - 0.8) < 1e-12, `${x} ${y}`);
});

test("slices are counted from the first sample, whichever way the samples run", () => {
  const info = { dims: [5, 7, 9], spacing: [2, 1, 3], origin: [8, 0, 24], directions: [[-1, 0, 0], [0, 1, 0], [0, 0, -1]] };
  assert.deepEqual([0, 1, 2].map((axis) => runAlong(info, axis as 0 | 1 | 2)), [
    { lo: 0, hi: 8, step: 2, n: 5 }, { lo: 0, hi: 6, step: 1, n: 7 }, { lo: 0, hi: 24, step: 3, n: 9 },
  ]);
  const run = runAlong(info, 2)!;
  assert.deepEqual([-5, 0, 1.4, 1.6, 24, 99].map((place) => sliceAt(run, place)), [0, 0, 0, 1, 8, 8]);
  assert.deepEqual([-1, 0, 4, 8, 12].map((slice) => placeOf(run, slice)), [0, 0, 12, 24, 24]);
  assert.equal(runAlong({ dims: [1, 1, 1], spacing: [1, 1, 1] }, 0)!.n, 1);
  assert.equal(runAlong({}, 0), null);
});

test("dragged to the right a window is wider, upwards it is higher", () => {
  assert.deepEqual(draggedWindow([0, 100], 0, 0), [0, 100]);
  const [lo, hi] = draggedWindow([0, 100], 150 * Math.log(2), 0);
  assert.ok(Math.abs(lo + 50) < 1e-3 && Math.abs(hi - 150) < 1e-3, `${lo} ${hi}`);
  assert.deepEqual(draggedWindow([0, 100], 0, -30), [10, 110]);
});

test("keys of bindings are found whatever the order of their modifiers", () => {
  assert.equal(inOrder("Shift+Control+Z"), "Control+Shift+Z");
  assert.equal(inOrder("Shift++"), "Shift++");
  assert.equal(inOrder("left"), "left");
  const row = { device: "keyboard", method: "action", action: "undo" };
  assert.deepEqual([...keysOfActions([{ ...row, when: "Control+Z" }, { ...row, when: "Q" }, { ...row, device: "mouse", when: "left" }])], [["undo", ["Control+Z", "Q"]]]);
});

test("a window moves and stretches values, colours of a map by its range", () => {
  const transfer = { opacity: [[10, 0], [30, 1]], color: [[0, 1, 0, 0], [20, 0, 1, 0]], opacity_length: 1 };
  assert.deepEqual(rangeOf(transfer), [0, 30]);
  assert.equal(rangeOf({ ...transfer, opacity: [[5, 1]], color: [] }), null);
  const moved = windowEdits("t", transfer, [0, 30], [100, 160], true);
  assert.deepEqual(moved.map((edit) => edit.op === "set" && edit.value), [[[120, 0], [160, 1]], [[100, 1, 0, 0], [140, 0, 1, 0]]]);
  const mapped = windowEdits("t", transfer, [0, 30], [100, 160], false);
  assert.deepEqual(mapped.slice(1), [{ op: "set", path: "t.range_lo", value: 100 }, { op: "set", path: "t.range_hi", value: 140 }]);
});

test("a cut goes round the six sides", () => {
  let normal: readonly number[] = [0, 0.1, -0.9];
  const seen = new Set<string>();
  for (let i = 0; i < 6; i++) seen.add(String(normal = nextDirection(normal)));
  assert.equal(seen.size, 6);
  assert.deepEqual(nextDirection([-1, 0, 0]), [1, 0, 0]);
});

test("a colour map is moved by its ends, and thinned to what it cannot do without", () => {
  const map = Array.from({ length: 33 }, (_, i): [number, number, number, number] => [i, i / 32, (i / 32) ** 3, i === 20 ? 1 : 0]);
  assert.ok(isMap(map) && !isMap(map.slice(0, 16)));
  const moved = moveEnd(map, 0, -32);
  assert.deepEqual([moved[0]![0], moved[16]![0], moved[32]![0]], [-32, 0, 32]);
  assert.deepEqual(moveEnd(map, 32, 64)[16]!.slice(0, 2), [32, 0.5]);
  assert.ok(moveEnd(map, 0, 99)[0]![0] < 32, "the ends do not pass each other");
  const few = thin(map, 12);
  assert.ok(few.length <= 12 && few.includes(map[0]!) && few.includes(map[20]!) && few.includes(map[32]!));
  const off = map.map((node) => Math.abs(sampleNodes(few, node[0])[1]! - node[2]));
  assert.ok(Math.max(...off) < 0.06, String(Math.max(...off)));
  assert.deepEqual(thin(map.slice(0, 2), 12), map.slice(0, 2));
});

test("every direction of a light has a place on the disc, and comes back from it", () => {
  const close = (a: readonly number[], b: readonly number[]) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) < 1e-12, `${a} is not ${b}`));
  close(onDisc([0, 0, -1]), [0, 0]);
  close(onDisc([-1, 0, 0]), [0.5, 0]); // it travels to the left: it comes from the right
  close(onDisc([0, -1, 0]), [0, 0.5]);
  assert.ok(Math.abs(Math.hypot(...onDisc([0, 0, 1])) - 1) < 1e-12);
  for (let i = 0; i < 50; i++) {
    const v = unit([Math.sin(7 * i), Math.cos(5 * i), Math.sin(3 * i + 1)]);
    close(fromDisc(...onDisc(v)), v);
  }
  close(fromDisc(0, 3), fromDisc(0, 1));
  const camera = { eye: [0, -10, 0], at: [0, 0, 0], up: [0, 0, 1], parallel: false, fov: 90 } as const;
  const axes = axesOf(camera as never);
  close(axes.flat(), [1, 0, 0, 0, 0, 1, 0, -1, 0]);
  const v = toCamera([5, 10, -2], axes); // of (5, 0, -2) from the eye
  close(seenAt(v, camera as never)!, [0.5, -0.2]);
  close(fromCamera(placedAt(0.5, 0.4, v, camera as never), axes), [5, 10, 4]);
  assert.equal(seenAt([0, 0, 1], camera as never), null);
});

test("of files that are dropped headers are opened first, and not the samples that they read", () => {
  const named = (...names: string[]) => names.map((name) => ({ name, size: 1 }));
  const opened = (...names: string[]) => toBeOpened(named(...names)).map(({ name }) => name);
  assert.deepEqual(opened("a.raw", "a.nhdr"), ["a.nhdr"]);
  assert.deepEqual(opened("b.nii.gz", "a.zraw", "a.mhd", "c.stl"), ["a.mhd", "b.nii.gz", "c.stl"]);
  assert.deepEqual(opened("a.img", "b.nrrd"), ["a.img", "b.nrrd"]);
  assert.equal(whyNot(named("a.raw", "a.nhdr")), "");
  assert.match(whyNot([{ name: "a.nrrd", size: 0 }]), /a\.nrrd is empty/);
  assert.match(whyNot(named("1.dcm", "2.dcm")), /as a folder/);
  assert.match(whyNot(named(...Array.from({ length: 17 }, (_, i) => `${i}.nrrd`))), /as a folder/);
});

test("the link is shown once, the cookie afterwards, and the link again where the cookie is not taken", async () => {
  const asked: string[] = [], later: (() => void)[] = [], sockets: { onopen(): void; onclose(event: object): void }[] = [];
  const step = () => new Promise((resolve) => setImmediate(resolve));
  class Socket {
    static OPEN = 1;
    onopen = () => {};
    onclose = () => {};
    constructor() {
      sockets.push(this);
    }
  }
  const before = ["location", "window", "fetch", "WebSocket"].map((name) => [name, Object.getOwnPropertyDescriptor(globalThis, name)] as const);
  const put = (name: string, value: unknown) => Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
  put("location", { protocol: "http:", host: "localhost:1" });
  put("window", { setTimeout: (next: () => void) => later.push(next) });
  put("fetch", async (path: string) => (asked.push(path), { ok: true, status: 204 }));
  put("WebSocket", Socket);
  try {
    await new Connection({ state() {}, message() {}, binary() {} }, "token").start();
    sockets[0]!.onopen();
    sockets[0]!.onclose({ reason: "" });
    later.pop()!();
    await step();
    assert.deepEqual([asked, sockets.length], [["/session"], 2]);
    sockets[1]!.onclose({ reason: "" });
    await step();
    later.pop()!();
    await step();
    assert.deepEqual([asked, sockets.length], [["/session", "/icon.svg", "/session"], 3]);
  } finally {
    for (const [name, descriptor] of before) descriptor ? Object.defineProperty(globalThis, name, descriptor) : Reflect.deleteProperty(globalThis, name);
  }
});

test("a property acts while another has one of some values, or while one of others is set", () => {
  const of = (values: Record<string, string | number>) => (name: string) => values[name];
  assert.equal(acts("method=otsu|hysteresis", of({ method: "otsu" })), true);
  assert.equal(acts("method=otsu|hysteresis", of({ method: "range" })), false);
  assert.equal(acts("data=labels", of({})), true); // what the data are is not known here
  assert.equal(acts("pieces|least", of({})), false);
  assert.equal(acts("pieces|least", of({ least: 3 })), true);
  assert.equal(acts(null, of({})), true);
});
