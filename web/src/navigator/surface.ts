/** Triangles as the page draws them: what the decoders of docs/protocol.md, "Shapes", make of a file. */

export interface Surface {
  /** Three numbers a vertex, in the numbers of the file. */
  positions: Float32Array;
  /** Four a vertex, of which three count: 32767 times a normal of length 1, as covectors of the file's numbers; zeros: none. */
  normals: Int16Array;
  indices: Uint32Array;
  /** How many of the indices, from the first, are seen; the rest closes the surface where the samples end. */
  nShown: number;
  /** Red, green, blue, alpha of each vertex, sRGB. */
  colors: Uint8Array | null;
  /** Three axes and the origin of the map from numbers of the file to its space. */
  place: number[];
  lo: [number, number, number];
  hi: [number, number, number];
}

export const KIND_RECORDS = 1;
export const KIND_TRIANGLES = 2;
export const KIND_BOXES = 3;
const MAGIC = 0x31535656; // "VVS1", little-endian
export const HEAD_BYTES = 104;

export interface Head {
  kind: number;
  flags: number;
  place: number[];
}

export function refuse(what: string): never {
  throw new Error(`A surface that the server sent cannot be drawn: ${what}.`);
}

export function readHead(view: DataView): Head {
  if (view.byteLength < HEAD_BYTES + 8 || view.getUint32(0, true) !== MAGIC) refuse("it does not begin as one");
  const place = Array.from({ length: 12 }, (_, i) => view.getFloat64(8 + 8 * i, true));
  return { kind: view.getUint16(4, true), flags: view.getUint16(6, true), place };
}

/** Sets lo and hi of the positions. */
export function boundsOf(positions: Float32Array): Pick<Surface, "lo" | "hi"> {
  const lo: Surface["lo"] = [Infinity, Infinity, Infinity];
  const hi: Surface["hi"] = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    const axis = i % 3;
    if (positions[i]! < lo[axis]!) lo[axis] = positions[i]!;
    if (positions[i]! > hi[axis]!) hi[axis] = positions[i]!;
  }
  return { lo, hi };
}
