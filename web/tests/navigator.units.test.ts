// What the page draws by itself, against numbers worked out by hand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeSurface } from "../src/navigator/decode";
import { composed, covectors, depthsOf, isMirrored, lensOf, projection, seenFrom, seenPlane, toEye } from "../src/navigator/lens";
import type { Surface } from "../src/navigator/surface";
import { normalOf } from "../src/navigator/triangles";

const UNIT = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
const ENDS = 1 << 8;

function head(bytes: number, kind: number, flags: number, place = UNIT): DataView {
  const view = new DataView(new ArrayBuffer(bytes));
  [0x56, 0x56, 0x53, 0x31].forEach((c, i) => view.setUint8(i, c));
  view.setUint16(4, kind, true);
  view.setUint16(6, flags, true);
  place.forEach((v, i) => view.setFloat64(8 + 8 * i, v, true));
  return view;
}

/** One brick at the origin, and the triangles of one pattern. */
function records(dims: number[], flags: number, cells: number, pattern: number, edges: number[], bits: bigint, nBits: number): ArrayBuffer {
  const table = 392 + ((edges.length + 3) & ~3);
  const nBytes = Math.ceil(nBits / 8);
  const view = head(table + 12 + nBytes, 1, flags);
  [...dims, 1, cells, (cells * edges.length) / 3, nBytes].forEach((v, i) => view.setUint32(104 + 4 * i, v, true));
  view.setUint8(132 + pattern, edges.length / 3);
  view.setUint32(388, edges.length, true);
  edges.forEach((e, i) => view.setUint8(392 + i, e));
  view.setUint16(table + 6, cells, true);
  for (let i = 0; i < nBytes; i++) view.setUint8(table + 12 + i, Number((bits >> BigInt(8 * i)) & 255n));
  return view.buffer as ArrayBuffer;
}

/** Of what is closed; above 0 where triangles are counter-clockwise from outside. */
function volumeOf({ positions, indices }: Surface): number {
  let sum = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => [0, 1, 2].map((axis) => positions[3 * indices[i + k]! + axis]!)) as [number[], number[], number[]];
    sum += a[0]! * (b[1]! * c[2]! - b[2]! * c[1]!) + a[1]! * (b[2]! * c[0]! - b[0]! * c[2]!) + a[2]! * (b[0]! * c[1]! - b[1]! * c[0]!);
  }
  return sum / 6;
}

/** Corner 0 is inside; the edges along x, y and z are crossed at 1/8, 7/8 and 3/8. */
const corner = (flags: number) => records([2, 2, 2], flags, 1, 1, [0, 4, 8], 1n << 12n | 3n << 22n | 1n << 24n, 26);

test("a cell becomes a triangle at the eighths that its record says", () => {
  const { positions, normals, indices: all, nShown } = decodeSurface(corner(1));
  const indices = all.slice(0, nShown);
  assert.deepEqual([...positions.slice(0, 9)], [1 / 8, 0, 0, 0, 7 / 8, 0, 0, 0, 3 / 8]);
  assert.deepEqual([...indices], [0, 1, 2]);
  const n = [21 / 64, 3 / 64, 7 / 64].map((v) => Math.round((32767 * v * 64) / Math.hypot(21, 3, 7)));
  assert.deepEqual([...normals.slice(0, 3)], n);
});

test("a solid is closed where its samples end: a corner of 1/8 x 7/8 x 3/8", () => {
  const closed = decodeSurface(corner(1 | ENDS));
  assert.equal(closed.indices.length, 12);
  assert.equal(closed.nShown, 12);
  assert.equal(volumeOf(closed), (1 * 7 * 3) / 512 / 6);
});

test("cells share vertices, and what has no record is as its neighbours are", () => {
  // x = 0 is inside, in two cells beside each other along y; the surface lies at 3/8 of them
  const quad = [0, 1, 3, 0, 3, 2];
  const cell = (y: bigint) => y << 4n | 0x55n << 12n | 0x55n << 20n;
  const file = records([2, 3, 2], 0x55 | ENDS, 2, 0x55, quad, cell(0n) | cell(1n) << 28n, 56);
  const open = decodeSurface(records([2, 3, 2], 0x55, 2, 0x55, quad, cell(0n) | cell(1n) << 28n, 56));
  assert.equal(open.nShown, 3 * 4);
  assert.deepEqual([...open.positions.slice(0, 18)].filter((_, i) => i % 3 === 0), Array(6).fill(3 / 8));
  assert.deepEqual([open.lo, open.hi], [[0, 0, 0], [3 / 8, 2, 1]]);
  for (let i = 0; i < 6; i++) assert.deepEqual([...open.normals.slice(4 * i, 4 * i + 3)], [32767, 0, 0]);
  assert.equal(volumeOf(decodeSurface(file)), (3 / 8) * 2);
  const full = records([3, 2, 2], 0x55 | ENDS, 1, 0x55, quad, 1n | cell(0n), 28); // the second along x; the first is full
  assert.equal(volumeOf(decodeSurface(full)), 1 + 3 / 8);
});

test("boxes are closed, end with the samples, and share no faces", () => {
  const view = head(137, 3, 0);
  // 6 x 3 x 3 samples in boxes of 2: 3 x 1 x 1 of them, the last one cell long; the first two are solid, or the last
  [6, 3, 3, 2, 3, 1, 1, 20].forEach((v, i) => view.setUint32(104 + 4 * i, v, true));
  view.setUint8(136, 0b011);
  const two = decodeSurface(view.buffer as ArrayBuffer);
  assert.equal(two.indices.length, 3 * 20);
  assert.equal(volumeOf(two), 4 * 2 * 2);
  assert.deepEqual([two.lo, two.hi], [[0, 0, 0], [4, 2, 2]]);
  view.setUint8(136, 0b100);
  assert.equal(volumeOf(decodeSurface(view.buffer as ArrayBuffer)), 1 * 2 * 2);
});

test("normals are octahedral", () => {
  assert.deepEqual(normalOf(0, 0), [0, 0, 32767]);
  assert.deepEqual(normalOf(32767, 0), [32767, 0, 0]);
  assert.deepEqual(normalOf(-32768, -32768), [0, 0, 0]);
  assert.deepEqual(normalOf(32767, 32767).map((v) => v + 0), [0, 0, -32767]);
  assert.deepEqual(normalOf(-10922, 10922).map((v) => Math.round(v / 100)), [-189, 189, 189]); // a third each
});

test("triangles keep their places, normals and colours", () => {
  const view = head(104 + 8 + 12 + 3 * 14, 2, 1, [0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 1, 2, 3]);
  view.setUint32(104, 3, true);
  view.setUint32(108, 1, true);
  [0, 2, 1].forEach((v, i) => view.setUint32(112 + 4 * i, v, true));
  [255, 0, 0, 255].forEach((v, i) => view.setUint8(124 + i, v));
  [65535, 2, 3, 0, 0].forEach((v, i) => view.setUint16(136 + i * 2, v, true));
  const { positions, indices, colors, place, normals } = decodeSurface(view.buffer as ArrayBuffer);
  assert.deepEqual([...positions.slice(0, 3)], [65535, 2, 3]);
  assert.deepEqual([...indices], [0, 2, 1]);
  assert.deepEqual([...colors!.slice(0, 4)], [255, 0, 0, 255]);
  assert.deepEqual([...normals.slice(0, 3)], [0, 0, 32767]);
  assert.deepEqual(place.slice(9), [1, 2, 3]);
});

test("what is no file of a surface is refused in a sentence", () => {
  const good = corner(1);
  const broken: [ArrayBuffer, RegExp][] = [
    [new ArrayBuffer(0), /begin/], [good.slice(0, 120), /short|length/], [good.slice(0, good.byteLength - 1), /length/],
    [head(200, 7, 0).buffer as ArrayBuffer, /kind/], [head(124, 2, 0).buffer.slice(0, 118) as ArrayBuffer, /length/],
  ];
  for (const [buffer, sentence] of broken) assert.throws(() => decodeSurface(buffer), sentence);
  const edges = new Uint8Array(good.slice(0));
  edges[393] = 12;
  assert.throws(() => decodeSurface(edges.buffer), /twelve edges/);
});

const onScreen = (clip: number[], p: number[]) => {
  const [x, y, , w] = [0, 1, 2, 3].map((row) => clip[row]! * p[0]! + clip[4 + row]! * p[1]! + clip[8 + row]! * p[2]! + clip[12 + row]!);
  return [x! / w!, y! / w!].map((v) => Number(v.toFixed(9)));
};

test("the lens is the server's: perspective and parallel, wide and high", () => {
  const pose = { eye: [0, -10, 0], at: [0, 0, 0], up: [0, 0, 1], parallel: false, fov: 90 } as const;
  const wide = lensOf(structuredClone(pose) as never, 200, 100);
  assert.deepEqual([wide.right, wide.up, wide.back].map((v) => v.map((c) => c + 0)), [[1, 0, 0], [0, 0, 1], [0, -1, 0]]);
  assert.deepEqual(seenFrom(wide, [5, 0, 2.5]).map((v) => v + 0), [5, 2.5, -10]);
  assert.deepEqual(onScreen(projection(wide, 5, 20), [5, 2.5, -10]), [0.25, 0.25]); // tangents 0.5 of 2, 0.25 of 1
  const high = lensOf({ ...structuredClone(pose), parallel: true, height: 8 } as never, 100, 200);
  assert.deepEqual(onScreen(projection(high, 0, 20), [1, 2, -10]), [0.5, 0.5]); // 1 of 2, 2 of 4
});

test("depth goes from the nearest to the farthest place", () => {
  const lens = lensOf({ eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], parallel: false, fov: 60 }, 100, 100);
  const [near, far] = depthsOf(toEye(lens, UNIT), [-1, -1, -2], [1, 1, 3]);
  assert.deepEqual([near, far], [7, 12]);
  const clip = projection(lens, near, far);
  const depth = (z: number) => (clip[10]! * z + clip[14]!) / -z;
  assert.ok(depth(-7) > -1 && depth(-7) < -0.95 && depth(-12) < 1 && depth(-12) > 0.95);
});

test("maps are put together, planes are seen from the eye, covectors stay at right angles", () => {
  const scaled = [2, 0, 0, 0, 3, 0, 0, 0, 4, 1, 1, 1];
  assert.deepEqual(composed([0, 1, 0, -1, 0, 0, 0, 0, 1, 10, 0, 0], scaled), [0, 2, 0, -3, 0, 0, 0, 0, 4, 9, 1, 1]);
  const lens = lensOf({ eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], parallel: false, fov: 60 }, 100, 100);
  assert.deepEqual(seenPlane(lens, [0, 0, 1, 4]).map((v) => v + 0), [0, 0, 1, -6]);
  const sheared = [1, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0]; // y leans over x: the plane x = 0 has (1, -1, 0) for its normal
  const turn = covectors(sheared);
  assert.deepEqual(turn.slice(0, 3).map((v) => v + 0), [1, -1, 0]);
  assert.deepEqual([isMirrored(sheared), isMirrored([-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])], [false, true]);
  const mirrored = covectors([-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
  assert.deepEqual(mirrored.map((v) => v + 0), [-1, 0, 0, 0, 1, 0, 0, 0, 1]);
});
