/**
 * Faces that a solid shows where its samples end. Cells with records tell which samples on the border are inside; where
 * there is no record all corners of a cell are the same, so that the rest follows from one corner of the grid.
 */
import type { Growing } from "./growing";

/** Of a cell at the border: which of its four corners there are inside, where its four edges there are crossed. */
const PRESENT = 1 << 15;

/** One side of the grid: across(i, j, k) of its cells; u and v are the other two axes, in rising order. */
interface Side {
  axis: number;
  upper: boolean;
  u: number;
  v: number;
  cells: Uint16Array;
}

/** Corners of a face in order around it, as u + 2 v, and the edge from each to the next one. */
const AROUND = [0, 1, 3, 2];

/** Number of the edge along an axis whose lower end is at this corner (x + 2 y + 4 z) of the cell. */
function edgeAt(axis: number, corner: number): number {
  const [first, second] = [[1, 2], [0, 2], [0, 1]][axis]!;
  return 4 * axis + ((corner >> first!) & 1) + 2 * ((corner >> second!) & 1);
}

export class EndFaces {
  readonly sides: Side[];

  constructor(readonly dims: [number, number, number]) {
    this.sides = [0, 1, 2, 3, 4, 5].map((i) => {
      const axis = i >> 1;
      const [u, v] = [[1, 2], [0, 2], [0, 1]][axis] as [number, number];
      return { axis, upper: (i & 1) === 1, u, v, cells: new Uint16Array((dims[u]! - 1) * (dims[v]! - 1)) };
    });
  }

  /** A cell with a record; most are nowhere near. */
  add(x: number, y: number, z: number, pattern: number, q: Int32Array): void {
    const { dims } = this;
    if (x > 0 && y > 0 && z > 0 && x < dims[0] - 2 && y < dims[1] - 2 && z < dims[2] - 2) return;
    const at = [x, y, z];
    for (const side of this.sides) {
      if (at[side.axis] !== (side.upper ? dims[side.axis]! - 2 : 0)) continue;
      side.cells[at[side.v]! * (dims[side.u]! - 1) + at[side.u]!] = PRESENT | bitsOf(side, pattern, q);
    }
  }
}

/** Corner of the cell that corner c (u + 2 v) of its face is. */
function cornerOf(side: Side, c: number): number {
  return (side.upper ? 1 << side.axis : 0) | ((c & 1) << side.u) | ((c >> 1) << side.v);
}

function bitsOf(side: Side, pattern: number, q: Int32Array): number {
  let bits = 0;
  for (let i = 0; i < 4; i++) {
    const here = cornerOf(side, AROUND[i]!);
    const next = cornerOf(side, AROUND[(i + 1) % 4]!);
    bits |= ((pattern >> here) & 1) << AROUND[i]!;
    const axis = i % 2 === 0 ? side.u : side.v;
    bits |= q[edgeAt(axis, Math.min(here, next))]! << (4 + 2 * i);
  }
  return bits;
}

/** Which samples of a side are inside. */
function samplesOf(side: Side, dims: readonly number[], corners: number): Uint8Array {
  const n = dims[side.u]!;
  const m = dims[side.v]!;
  const inside = new Uint8Array(n * m);
  const cell = (i: number, j: number, corner: number, without: number) => {
    const bits = side.cells[j * (n - 1) + i]!;
    return bits & PRESENT ? (bits >> corner) & 1 : without;
  };
  inside[0] = (corners >> cornerOf(side, 0)) & 1;
  for (let i = 1; i < n; i++) inside[i] = cell(i - 1, 0, 1, inside[i - 1]!);
  for (let j = 1; j < m; j++) {
    inside[j * n] = cell(0, j - 1, 2, inside[(j - 1) * n]!);
    for (let i = 1; i < n; i++) inside[j * n + i] = cell(i - 1, j - 1, 3, inside[(j - 1) * n + i - 1]!);
  }
  return inside;
}

class Closing {
  private numbers: Int32Array; // of the vertices that samples are

  constructor(private to: Growing, private side: Side, private dims: readonly number[]) {
    this.numbers = new Int32Array(dims[side.u]! * dims[side.v]!).fill(-1);
  }

  private vertex(u: number, v: number): number {
    const { side, to, dims } = this;
    const p = [0, 0, 0];
    p[side.axis] = side.upper ? dims[side.axis]! - 1 : 0;
    p[side.u] = u;
    p[side.v] = v;
    const number = to.vertex(p[0]!, p[1]!, p[2]!);
    const out = side.upper ? 1 : -1;
    to.turn(number, side.axis === 0 ? out : 0, side.axis === 1 ? out : 0, side.axis === 2 ? out : 0);
    return number;
  }

  private sample(i: number, j: number): number {
    const at = j * this.dims[this.side.u]! + i;
    if (this.numbers[at]! < 0) this.numbers[at] = this.vertex(i, j);
    return this.numbers[at]!;
  }

  /** Edge i goes from corner AROUND[i] to the next; q counts from the lower end. */
  private crossing(i: number, j: number, edge: number, bits: number): number {
    const share = (2 * ((bits >> (4 + 2 * edge)) & 3) + 1) / 8;
    const places: [number, number][] = [[i + share, j], [i + 1, j + share], [i + share, j + 1], [i, j + share]];
    return this.vertex(...places[edge]!);
  }

  private fan(polygon: number[]): void {
    const turned = this.side.upper === (this.side.axis !== 1); // u, v and the axis are right-handed but for y
    for (let k = 2; k < polygon.length; k++) {
      const [a, b, c] = [polygon[0]!, polygon[k - 1]!, polygon[k]!];
      if (turned) this.to.triangle(a, b, c);
      else this.to.triangle(a, c, b);
    }
  }

  /** Where two corners that are inside lie across from each other, they are apart. */
  cell(i: number, j: number, inside: number, bits: number): void {
    const is = AROUND.map((c) => (inside >> c) & 1);
    const corner = (k: number) => this.sample(i + (AROUND[k]! & 1), j + (AROUND[k]! >> 1));
    if (is[0] === is[2] && is[1] === is[3] && is[0] !== is[1]) {
      for (const k of is[0] ? [0, 2] : [1, 3])
        this.fan([this.crossing(i, j, (k + 3) % 4, bits), corner(k), this.crossing(i, j, k, bits)]);
      return;
    }
    const polygon: number[] = [];
    for (let k = 0; k < 4; k++) {
      if (is[k]) polygon.push(corner(k));
      if (is[k] !== is[(k + 1) % 4]) polygon.push(this.crossing(i, j, k, bits));
    }
    this.fan(polygon);
  }
}

/** corners: bit x + 2 y + 4 z of the grid's own corners that are inside. */
export function closeEnds(to: Growing, ends: EndFaces, corners: number): void {
  for (const side of ends.sides) {
    const inside = samplesOf(side, ends.dims, corners);
    const closing = new Closing(to, side, ends.dims);
    const n = ends.dims[side.u]!;
    for (let j = 0; j + 1 < ends.dims[side.v]!; j++)
      for (let i = 0; i + 1 < n; i++) {
        const at = j * n + i;
        const four = inside[at]! | (inside[at + 1]! << 1) | (inside[at + n]! << 2) | (inside[at + n + 1]! << 3);
        if (four) closing.cell(i, j, four, side.cells[j * (n - 1) + i]!);
      }
  }
}
