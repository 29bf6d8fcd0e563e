/** Where slices are: from points of the World to points of a picture, and from one sample to the next. */
import type { JsonObject, Pose } from "../protocol";

export type Vec3 = [number, number, number];
export type Plane = "axial" | "coronal" | "sagittal";
export const PLANES: Plane[] = ["axial", "coronal", "sagittal"];
/** Number of the world axis that a plane lies across. */
export const AXIS: { [plane in Plane]: 0 | 1 | 2 } = { axial: 2, coronal: 1, sagittal: 0 };

const add = (a: Vec3, b: Vec3, by = 1): Vec3 => [a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2]];
const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a: Vec3): Vec3 => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** Unit vectors of a picture: right, up, and where one looks. */
export function frameOf(pose: Pick<Pose, "eye" | "at" | "up">): { right: Vec3; up: Vec3; forward: Vec3 } {
  const forward = unit(add(pose.at, pose.eye, -1));
  const right = unit(cross(forward, pose.up));
  return { right, up: cross(right, forward), forward };
}

/** From 0 to 1 from the top left, where it is inside. */
export function toPicture(pose: Pose, aspect: number, p: Vec3): [number, number] {
  const { right, up } = frameOf(pose);
  const height = pose.height ?? 1;
  const from = add(p, pose.at, -1);
  return [0.5 + dot(from, right) / (height * aspect), 0.5 - dot(from, up) / height];
}

/** The point of the plane through `through` that is seen there. */
export function toWorld(pose: Pose, aspect: number, x: number, y: number, through: Vec3): Vec3 {
  const { right, up, forward } = frameOf(pose);
  const height = pose.height ?? 1;
  const p = add(add(pose.at, right, (x - 0.5) * height * aspect), up, (0.5 - y) * height);
  return add(p, forward, dot(add(through, p, -1), forward));
}

/** The camera of a picture that was moved by parts of its size, and made `by` times as high about a point of it. */
export function panned(pose: Pose, aspect: number, dx: number, dy: number): Pose {
  const { right, up } = frameOf(pose);
  const height = pose.height ?? 1;
  const move = add(add([0, 0, 0], right, -dx * height * aspect), up, dy * height);
  return { ...pose, eye: add(pose.eye, move), at: add(pose.at, move) };
}

export function zoomed(pose: Pose, aspect: number, by: number, x: number, y: number): Pose {
  const moved = panned(pose, aspect, (0.5 - x) * (1 - by), (0.5 - y) * (1 - by));
  return { ...moved, height: (pose.height ?? 1) * by };
}

/** The slices across an axis of the World. */
export interface Run {
  lo: number;
  hi: number;
  step: number;
  n: number;
}

/** Of the data of a volume as `info` tells them; null where it does not say enough. */
export function runAlong(info: JsonObject, axis: 0 | 1 | 2): Run | null {
  const dims = info["dims"] as number[] | undefined;
  const spacing = info["spacing"] as number[] | undefined;
  if (!Array.isArray(dims) || !Array.isArray(spacing)) return null;
  const directions = (info["directions"] as number[][] | undefined) ?? [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const origin = (info["origin"] as number[] | undefined) ?? [0, 0, 0];
  let lo = origin[axis]!;
  let hi = lo;
  let nearest = 0;
  for (let i = 0; i < 3; i++) {
    const reach = directions[i]![axis]! * spacing[i]! * (dims[i]! - 1);
    if (reach < 0) lo += reach;
    else hi += reach;
    if (Math.abs(directions[i]![axis]!) > Math.abs(directions[nearest]![axis]!)) nearest = i;
  }
  const step = spacing[nearest]!;
  return { lo, hi, step, n: Math.max(1, Math.round((hi - lo) / step) + 1) };
}

/** Number of the slice at a place, from 0, and where the slice of a number is. */
export function sliceAt(run: Run, place: number): number {
  return Math.max(0, Math.min(run.n - 1, Math.round((place - run.lo) / run.step)));
}

export function placeOf(run: Run, slice: number): number {
  return Math.min(run.hi, run.lo + Math.max(0, Math.min(run.n - 1, slice)) * run.step);
}

/** A window that a hand has moved by pixels: to the right it is wider, upwards its middle is higher. */
export function draggedWindow([lo, hi]: [number, number], dx: number, dy: number): [number, number] {
  const width = (hi - lo) * Math.exp(dx / 150);
  const level = (lo + hi) / 2 - (dy * (hi - lo)) / 300;
  const tidy = (value: number) => Number(value.toPrecision(6));
  return [tidy(level - width / 2), tidy(level + width / 2)];
}
