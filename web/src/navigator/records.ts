/**
 * Records of Marching Cubes cells: each says where it is, which of its corners are inside, and where the surface
 * crosses its edges. Vertices are shared between cells, so that their normals are means of the triangles around them.
 */
import { closeEnds, EndFaces } from "./ends";
import { Growing } from "./growing";
import { boundsOf, HEAD_BYTES, refuse, type Head, type Surface } from "./surface";

const SHIFT = 4;
const SIDE = 1 << SHIFT;
const PATTERNS = 256;
const FLAG_ENDS = 1 << 8;
const BRICK_BYTES = 12;
const TABLE = 3 * SIDE * SIDE * SIDE;

/** Edge e runs along axis e >> 2, from the sample at this place in the cell: x + 2 y + 4 z. */
export const EDGE_FROM = Array.from({ length: 12 }, (_, e) => {
  const [first, second] = [[2, 4], [1, 4], [1, 2]][e >> 2]!;
  return (e & 1 ? first! : 0) + (e & 2 ? second! : 0);
});

/** Edges that are crossed where these corners are inside: their ends differ. */
const CROSSED = Array.from({ length: PATTERNS }, (_, pattern) =>
  EDGE_FROM.flatMap((from, e) => (((pattern >> from) ^ (pattern >> (from + (1 << (e >> 2))))) & 1 ? [e] : [])),
);

class Bits {
  private word = 0;
  private n = 0;

  constructor(private bytes: Uint8Array, private at: number) {}

  get(n: number): number {
    while (this.n < n) {
      if (this.at >= this.bytes.length) refuse("its records end too early");
      this.word |= this.bytes[this.at++]! << this.n;
      this.n += 8;
    }
    const value = this.word & ((1 << n) - 1);
    this.word >>>= n;
    this.n -= n;
    return value;
  }
}

/** Which triangles each pattern has: three edges each, from first[pattern]. */
interface Cases {
  first: Uint32Array;
  edges: Uint8Array;
  end: number;
}

function readCases(bytes: Uint8Array, view: DataView, at: number): Cases {
  const first = new Uint32Array(PATTERNS + 1);
  for (let p = 0; p < PATTERNS; p++) first[p + 1] = first[p]! + 3 * bytes[at + p]!;
  const n = view.getUint32(at + PATTERNS, true);
  const begin = at + PATTERNS + 4;
  if (n !== first[PATTERNS] || begin + n > bytes.length) refuse("its table of cases is none");
  const edges = bytes.subarray(begin, begin + n);
  if (edges.some((e) => e >= 12)) refuse("its cells have twelve edges");
  return { first, edges, end: begin + ((n + 3) & ~3) };
}

/** Vertices by edge, of the bricks of samples that cells of one layer touch; those behind are used again. */
class EdgeTables {
  private tables = new Map<number, Int32Array>();
  private free: Int32Array[] = [];
  private layer = -1;

  constructor(private nx: number, private ny: number) {}

  /** Bit 0: one brick further along x, ... */
  near(x: number, y: number, z: number): Int32Array[] {
    if (z !== this.layer) this.forget(z);
    return Array.from({ length: 8 }, (_, i) => this.table(x + (i & 1), y + ((i >> 1) & 1), z + (i >> 2)));
  }

  private table(x: number, y: number, z: number): Int32Array {
    const key = (z * this.ny + y) * this.nx + x;
    let table = this.tables.get(key);
    if (!table) {
      table = this.free.pop() ?? new Int32Array(TABLE);
      table.fill(-1);
      this.tables.set(key, table);
    }
    return table;
  }

  private forget(z: number): void {
    this.layer = z;
    for (const [key, table] of this.tables)
      if (key < z * this.ny * this.nx) {
        this.tables.delete(key);
        this.free.push(table);
      }
  }
}

class Decoding {
  private readonly vertex = new Int32Array(12);
  private readonly q = new Int32Array(12);

  constructor(private cases: Cases, private to: Growing, private ends: EndFaces | null) {}

  brick(bits: Bits, nCells: number, x: number, y: number, z: number, tables: Int32Array[]): void {
    for (let i = 0; i < nCells; i++) {
      const local = bits.get(12);
      const pattern = bits.get(8);
      const cx = local & (SIDE - 1);
      const cy = (local >> SHIFT) & (SIDE - 1);
      const cz = local >> (2 * SHIFT);
      for (const e of CROSSED[pattern]!) {
        this.q[e] = bits.get(2);
        this.vertex[e] = this.find(e, cx, cy, cz, SIDE * x, SIDE * y, SIDE * z, tables);
      }
      this.triangles(pattern);
      this.ends?.add(SIDE * x + cx, SIDE * y + cy, SIDE * z + cz, pattern, this.q);
    }
  }

  private find(e: number, cx: number, cy: number, cz: number, x: number, y: number, z: number, tables: Int32Array[]): number {
    const from = EDGE_FROM[e]!;
    const axis = e >> 2;
    const sx = cx + (from & 1);
    const sy = cy + ((from >> 1) & 1);
    const sz = cz + (from >> 2);
    const table = tables[(sx >> SHIFT) | ((sy >> SHIFT) << 1) | ((sz >> SHIFT) << 2)]!;
    const at = 3 * (((((sz & (SIDE - 1)) << SHIFT) | (sy & (SIDE - 1))) << SHIFT) | (sx & (SIDE - 1))) + axis;
    if (table[at]! >= 0) return table[at]!;
    const share = (2 * this.q[e]! + 1) / 8;
    return (table[at] = this.to.vertex(x + sx + (axis === 0 ? share : 0), y + sy + (axis === 1 ? share : 0), z + sz + (axis === 2 ? share : 0)));
  }

  private triangles(pattern: number): void {
    for (let i = this.cases.first[pattern]!; i < this.cases.first[pattern + 1]!; i += 3) {
      const a = this.vertex[this.cases.edges[i]!]!;
      const b = this.vertex[this.cases.edges[i + 1]!]!;
      const c = this.vertex[this.cases.edges[i + 2]!]!;
      this.to.triangle(a, b, c);
      this.turn(a, b, c);
    }
  }

  /** Twice the area and its direction, to each corner. */
  private turn(a: number, b: number, c: number): void {
    const p = this.to.positions;
    const ux = p[3 * b]! - p[3 * a]!;
    const uy = p[3 * b + 1]! - p[3 * a + 1]!;
    const uz = p[3 * b + 2]! - p[3 * a + 2]!;
    const vx = p[3 * c]! - p[3 * a]!;
    const vy = p[3 * c + 1]! - p[3 * a + 1]!;
    const vz = p[3 * c + 2]! - p[3 * a + 2]!;
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    this.to.turn(a, x, y, z);
    this.to.turn(b, x, y, z);
    this.to.turn(c, x, y, z);
  }
}

export function decodeRecords(buffer: ArrayBuffer, view: DataView, head: Head): Surface {
  const bytes = new Uint8Array(buffer);
  if (bytes.length < HEAD_BYTES + 28 + PATTERNS + 4) refuse("it is too short");
  const word = (i: number) => view.getUint32(HEAD_BYTES + 4 * i, true);
  const dims: [number, number, number] = [word(0), word(1), word(2)];
  const [nBricks, nTriangles, nBytes] = [word(3), word(5), word(6)];
  const cases = readCases(bytes, view, HEAD_BYTES + 28);
  const records = cases.end + BRICK_BYTES * nBricks;
  if (records + nBytes !== bytes.length) refuse("it has another length than it says");
  if (nTriangles > 12 * 8 * nBytes) refuse("it has more triangles than its records can make");
  const to = new Growing(nTriangles);
  const ends = Math.min(...dims) > 1 ? new EndFaces(dims) : null;
  const decoding = new Decoding(cases, to, ends);
  const tables = new EdgeTables((dims[0] >> SHIFT) + 2, (dims[1] >> SHIFT) + 2);
  for (let i = 0; i < nBricks; i++) {
    const at = cases.end + BRICK_BYTES * i;
    const [x, y, z] = [0, 2, 4].map((o) => view.getUint16(at + o, true)) as [number, number, number];
    const bits = new Bits(bytes, records + view.getUint32(at + 8, true));
    decoding.brick(bits, view.getUint16(at + 6, true), x, y, z, tables.near(x, y, z));
  }
  const nOpen = to.nIndices;
  if (ends) closeEnds(to, ends, head.flags & 255);
  const made = to.finish();
  return { ...made, nShown: head.flags & FLAG_ENDS ? made.indices.length : nOpen, colors: null, place: head.place, ...boundsOf(made.positions) };
}
