/** Cut planes by commands: a first one, on and off, and the next of the six directions. */
import { nextDirection, type Vec } from "./directions";
import type { Json } from "./protocol";
import { addSelected, tryEdit } from "./session";
import * as store from "./store";
import { tidy } from "./transfer/curve";
import { isObject } from "./values";

function planes(): Json[] {
  const all = store.world.value["cut_planes"];
  return Array.isArray(all) ? all : [];
}

/** The one that is selected, else the last; -1: there is none. */
function current(): number {
  const [map, index] = store.selection.value.split(".");
  const n = planes().length;
  return map === "cut_planes" && Number(index) < n ? Number(index) : n - 1;
}

/** Through the middle of what is seen. */
function through(normal: Vec): { normal: number[]; offset: number } {
  const at = store.pose.value?.at ?? [0, 0, 0];
  return { normal: [...normal], offset: tidy(at.reduce((sum, v, i) => sum + v * normal[i]!, 0)) };
}

/** The half in front goes, so that the cut shows at once. */
export function addCutPlane(): void {
  const { eye, at } = store.pose.value ?? { eye: [1, 0, 0], at: [0, 0, 0] };
  const towards = eye.map((v, i) => v - at[i]!);
  const axis = towards.reduce((best, v, i) => (Math.abs(v) > Math.abs(towards[best]!) ? i : best), 0);
  const normal = towards.map((v, i) => (i === axis ? -Math.sign(v) || 1 : 0));
  addSelected(`cut_planes.${planes().length}`, "cut_planes", null, through(normal));
}

export function toggleCutPlane(): void {
  const index = current();
  if (index < 0) addCutPlane();
  else tryEdit({ op: "set", path: `cut_planes.${index}.on`, value: store.valueOf(`cut_planes.${index}.on`) === false });
}

export function turnCutPlane(): void {
  const index = current();
  const plane = planes()[index];
  if (index < 0) return addCutPlane();
  const normal = isObject(plane) && Array.isArray(plane["normal"]) ? (plane["normal"] as number[]) : [0, 0, 1];
  const { normal: next, offset } = through(nextDirection(normal));
  tryEdit({ op: "set", path: `cut_planes.${index}.normal`, value: next }, { op: "set", path: `cut_planes.${index}.offset`, value: offset },
    { op: "set", path: `cut_planes.${index}.on`, value: true });
}
