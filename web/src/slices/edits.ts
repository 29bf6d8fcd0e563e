/** What hands change of slices: the cross-hair and windows. What belongs together is one step for undo. */
import { Gesture } from "../session";
import * as store from "../store";
import { AXIS, placeOf, runAlong, sliceAt, type Plane, type Run, type Vec3 } from "./geometry";

const PAUSE = 700; // milliseconds: turns of the wheel and keys that follow each other are one step

let gesture: Gesture | null = null;
let about = "";
let timer = 0;

/** The gesture that goes on, or a new one when another thing is moved or the hand has rested. */
function going(what: string): Gesture {
  if (!gesture || about !== what) gesture = new Gesture();
  about = what;
  clearTimeout(timer);
  timer = window.setTimeout(endGesture, PAUSE);
  return gesture;
}

/** The hand lets go. */
export function endGesture(): void {
  clearTimeout(timer);
  gesture = null;
  store.heldCrossHair.value = null;
}

export function moveCrossHair(to: Vec3, what: string): void {
  if (store.readOnly.value) return;
  const value = to.map((v) => Number(v.toPrecision(9))) as Vec3;
  store.heldCrossHair.value = value;
  going(what).change({ op: "set", path: "cross_hair", value });
}

/** The slices of the first volume of samples that is seen. */
export function runOf(plane: Plane): Run | null {
  const volume = store.volumeIds.value.find((id) => !store.isMesh(id) && store.valueOf(`volumes.${id}.visible`) !== false);
  const dataset = volume ? store.datasetOf(volume) : null;
  const info = dataset ? store.dataInfos.value[dataset] : undefined;
  return info && typeof info !== "string" ? runAlong(info, AXIS[plane]) : null;
}

export function datasetOfRuns(): string | null {
  const volume = store.volumeIds.value.find((id) => !store.isMesh(id));
  return volume ? store.datasetOf(volume) : null;
}

export function goToSlice(plane: Plane, slice: number): void {
  const run = runOf(plane);
  const hair = store.crossHair.value;
  if (!run || !hair) return;
  const to: Vec3 = [...hair];
  to[AXIS[plane]] = placeOf(run, slice);
  moveCrossHair(to, `slice ${plane}`);
}

export function stepSlices(plane: Plane, by: number): void {
  const run = runOf(plane);
  const hair = store.crossHair.value;
  if (run && hair) goToSlice(plane, sliceAt(run, hair[AXIS[plane]]) + by);
}

/** Of the volume that is selected. */
export function windowNow(): [number, number] | null {
  const volume = store.currentVolume.value;
  const lo = store.valueOf(`volumes.${volume}.slices.window_lo`);
  const hi = store.valueOf(`volumes.${volume}.slices.window_hi`);
  return typeof lo === "number" && typeof hi === "number" && hi > lo ? [lo, hi] : null;
}

export function setWindow([lo, hi]: [number, number]): void {
  const path = `volumes.${store.currentVolume.value}.slices`;
  if (store.readOnly.value || !(hi > lo)) return;
  going("window").change({ op: "set", path: `${path}.window_lo`, value: lo }, { op: "set", path: `${path}.window_hi`, value: hi });
}
