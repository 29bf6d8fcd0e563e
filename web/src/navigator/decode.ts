/** Files of surfaces to triangles. */
import { decodeRecords } from "./records";
import { decodeBoxes } from "./boxes";
import { KIND_BOXES, KIND_RECORDS, KIND_TRIANGLES, readHead, refuse, type Surface } from "./surface";
import { decodeTriangles } from "./triangles";

/** Throws an Error with one sentence where the file is none. */
export function decodeSurface(buffer: ArrayBuffer): Surface {
  const view = new DataView(buffer);
  const head = readHead(view);
  if (head.kind === KIND_RECORDS) return decodeRecords(buffer, view, head);
  if (head.kind === KIND_TRIANGLES) return decodeTriangles(buffer, view, head);
  if (head.kind === KIND_BOXES) return decodeBoxes(buffer, view, head);
  return refuse("it is of a kind that this page does not know");
}
