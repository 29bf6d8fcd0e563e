/** Places of measurements: from the World to a picture, lengths and angles while a hand draws, and boxes of samples. */
import type { JsonObject, Pose } from "../protocol";
import { AXIS, runAlong, toPicture, type Plane, type Vec3 } from "../slices/geometry";
import { axesOf, fromCamera, halfHeight, seenAt, toCamera } from "../view/light_geometry";

const EDGE_ON = 1e-3; // sine of the angle between a ray and a plane

export const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Of the way from each to the next. */
export function lengthOf(points: Vec3[]): number {
  return points.slice(1).reduce((sum, p, i) => sum + Math.hypot(...minus(p, points[i]!)), 0);
}

/** At the second of three, in degrees. */
export function angleOf([a, b, c]: [Vec3, Vec3, Vec3]): number {
  const [u, v] = [minus(a, b), minus(c, b)];
  return (Math.atan2(Math.hypot(...cross(u, v)), dot(u, v)) * 180) / Math.PI;
}

/** Where a point of the World is seen in a picture, from 0 to 1 from the top left; null: behind the eye. */
export function project(pose: Pose, aspect: number, p: Vec3): [number, number] | null {
  if (pose.parallel) return toPicture(pose, aspect, p);
  const at = seenAt(toCamera(minus(p, pose.eye), axesOf(pose)), pose);
  return at && [0.5 + at[0] / (2 * aspect), 0.5 - at[1] / 2];
}

/** The point of the plane through `through` that is seen at a place of a picture; null: the plane is seen edge on there, or is behind the eye. */
export function onPlane(pose: Pose, aspect: number, [x, y]: [number, number], through: Vec3, normal: Vec3): Vec3 | null {
  const axes = axesOf(pose);
  const half = halfHeight(pose, 1);
  const aside: Vec3 = [(2 * x - 1) * aspect * half, (1 - 2 * y) * half, 0];
  const from = pose.parallel ? (fromCamera(aside, axes).map((v, i) => v + pose.eye[i]!) as Vec3) : pose.eye;
  const way = fromCamera(pose.parallel ? [0, 0, -1] : [aside[0], aside[1], -1], axes);
  const [off, down] = [dot(minus(through, from), normal), dot(way, normal)];
  if (Math.abs(down) < EDGE_ON * Math.hypot(...way) || (!pose.parallel && off / down <= 0)) return null;
  return from.map((v, i) => v + (way[i]! * off) / down) as Vec3;
}

/** Whether a place belongs to the slice through the cross-hair: it is no farther than half a step from it. */
export function isInSlice(info: JsonObject | null, plane: Plane, hair: Vec3, p: Vec3): boolean {
  const run = info && runAlong(info, AXIS[plane]);
  const off = Math.abs(p[AXIS[plane]] - hair[AXIS[plane]]);
  return off <= (run ? run.step : 1) * (0.5 + 1e-6);
}

/** From the World to the numbers of samples, of data that nothing moves; null where they do not say where they lie. */
export function toIndex(info: JsonObject, p: Vec3): Vec3 | null {
  const spacing = info["spacing"] as number[] | undefined;
  if (!Array.isArray(spacing)) return null;
  const directions = (info["directions"] as Vec3[] | undefined) ?? [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const origin = (info["origin"] as Vec3 | undefined) ?? [0, 0, 0];
  const [a, b, c] = directions.map((d, i) => d.map((v) => v * spacing[i]!)) as [Vec3, Vec3, Vec3];
  const volume = dot(a, cross(b, c));
  const q = minus(p, origin);
  return volume ? [dot(q, cross(b, c)) / volume, dot(q, cross(c, a)) / volume, dot(q, cross(a, b)) / volume] : null;
}

/** The samples between two corners, as the property `box` has them: the first and the last along each axis. Null: none. */
export function boxBetween(a: Vec3, b: Vec3, dims: number[]): string | null {
  const ends = [0, 1, 2].map((i) => {
    const [from, to] = [a[i]!, b[i]!].sort((x, y) => x - y);
    let [lo, hi] = [Math.ceil(from! - 1e-6), Math.floor(to! + 1e-6)];
    if (hi < lo) lo = hi = Math.round((from! + to!) / 2); // both between two samples
    return [Math.max(0, lo), Math.min(dims[i]! - 1, hi)] as const;
  });
  return ends.every(([lo, hi]) => lo <= hi) ? ends.map(([lo, hi]) => `${lo}..${hi}`).join(",") : null;
}
