/** Files of triangles: meshes, and the boxes around a surface. */
import { boundsOf, HEAD_BYTES, refuse, type Head, type Surface } from "./surface";

const FLAG_COLORS = 1;
const VERTEX_NUMBERS = 5; // 16 bits each: place, normal

const NONE = -32768;

/** Octahedral normals (Meyer et al. 2010), as 32767 times a direction of length 1; zeros where there is none. */
export function normalOf(u: number, v: number): [number, number, number] {
  if (u === NONE && v === NONE) return [0, 0, 0];
  let x = u / 32767;
  let y = v / 32767;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
  const scale = 32767 / Math.hypot(x, y, z);
  return [Math.round(scale * x), Math.round(scale * y), Math.round(scale * z)];
}

/** Normals are directions of the mesh's space; its numbers differ from that by one factor alone. */
export function decodeTriangles(buffer: ArrayBuffer, view: DataView, head: Head): Surface {
  const nVertices = view.getUint32(HEAD_BYTES, true);
  const nIndices = 3 * view.getUint32(HEAD_BYTES + 4, true);
  const colored = (head.flags & FLAG_COLORS) !== 0;
  const colorsAt = HEAD_BYTES + 8 + 4 * nIndices;
  const verticesAt = colorsAt + (colored ? 4 * nVertices : 0);
  if (verticesAt + 2 * VERTEX_NUMBERS * nVertices !== buffer.byteLength) refuse("it has another length than it says");
  const indices = new Uint32Array(buffer.slice(HEAD_BYTES + 8, colorsAt));
  if (indices.some((i) => i >= nVertices)) refuse("it has fewer vertices than its triangles want");
  const places = new Uint16Array(buffer, verticesAt, VERTEX_NUMBERS * nVertices);
  const signed = new Int16Array(buffer, verticesAt, VERTEX_NUMBERS * nVertices);
  const positions = new Float32Array(3 * nVertices);
  const normals = new Int16Array(4 * nVertices);
  for (let i = 0; i < nVertices; i++) {
    positions.set(places.subarray(VERTEX_NUMBERS * i, VERTEX_NUMBERS * i + 3), 3 * i);
    normals.set(normalOf(signed[VERTEX_NUMBERS * i + 3]!, signed[VERTEX_NUMBERS * i + 4]!), 4 * i);
  }
  const colors = colored ? new Uint8Array(buffer.slice(colorsAt, verticesAt)) : null;
  return { positions, normals, indices, nShown: nIndices, colors, place: head.place, ...boundsOf(positions) };
}
