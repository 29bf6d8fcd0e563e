/** Boxes, a bit each: the faces that no other box is beyond. */
import { Growing } from "./growing";
import { boundsOf, HEAD_BYTES, refuse, type Head, type Surface } from "./surface";

const BITS = HEAD_BYTES + 32;

type Three = [number, number, number];

/** A square of two triangles, counter-clockwise from outside; u, v and the axis are right-handed. */
function addFace(to: Growing, axis: number, upper: boolean, lo: Three, hi: Three): void {
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => {
    const p: Three = [0, 0, 0];
    p[axis] = upper ? hi[axis]! : lo[axis]!;
    p[u] = a ? hi[u]! : lo[u]!;
    p[v] = b ? hi[v]! : lo[v]!;
    const vertex = to.vertex(...p);
    const out = upper ? 1 : -1;
    to.turn(vertex, axis === 0 ? out : 0, axis === 1 ? out : 0, axis === 2 ? out : 0);
    return vertex;
  });
  const [a, b, c, d] = upper ? corners : corners.reverse();
  to.triangle(a!, b!, c!);
  to.triangle(a!, c!, d!);
}

/** Neighbours' faces have the same corners, in whole numbers: nothing shines through between them. */
export function decodeBoxes(buffer: ArrayBuffer, view: DataView, head: Head): Surface {
  if (buffer.byteLength < BITS) refuse("it is too short");
  const word = (i: number) => view.getUint32(HEAD_BYTES + 4 * i, true);
  const dims: Three = [word(0), word(1), word(2)];
  const side = word(3);
  const n: Three = [word(4), word(5), word(6)];
  if (Math.ceil((n[0] * n[1] * n[2]) / 8) !== buffer.byteLength - BITS) refuse("it has another length than it says");
  const bits = new Uint8Array(buffer, BITS);
  const solid = (p: Three) => {
    if (p.some((v, a) => v < 0 || v >= n[a]!)) return false;
    const at = (p[2] * n[1] + p[1]) * n[0] + p[0];
    return ((bits[at >> 3]! >> (at & 7)) & 1) === 1;
  };
  const to = new Growing(word(7));
  for (let z = 0; z < n[2]; z++)
    for (let y = 0; y < n[1]; y++)
      for (let x = 0; x < n[0]; x++) {
        const p: Three = [x, y, z];
        if (!solid(p)) continue;
        const lo = p.map((v) => v * side) as Three;
        const hi = p.map((v, a) => Math.min((v + 1) * side, dims[a]! - 1)) as Three;
        for (let i = 0; i < 6; i++) {
          const beyond: Three = [x, y, z];
          beyond[i >> 1]! += i & 1 ? 1 : -1;
          if (!solid(beyond)) addFace(to, i >> 1, (i & 1) === 1, lo, hi);
        }
      }
  const made = to.finish();
  return { ...made, nShown: made.indices.length, colors: null, place: head.place, ...boundsOf(made.positions) };
}
