/** Where the ends of the World's axes are in the picture, and the camera that looks from one of them. */
import type { Pose } from "../protocol";

type Vector = [number, number, number];

export interface AxisEnd {
  axis: "x" | "y" | "z";
  positive: boolean;
  x: number;
  y: number;
  depth: number;
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(v: Vector): Vector {
  const length = Math.hypot(...v) || 1;
  return [v[0] / length, v[1] / length, v[2] / length];
}

/** The six ends of the axes as the camera sees them: x right, y down, depth towards the viewer; back ones first. */
export function axisEnds(pose: { eye: Vector; at: Vector; up: Vector }): AxisEnd[] {
  const towards = unit([pose.eye[0] - pose.at[0], pose.eye[1] - pose.at[1], pose.eye[2] - pose.at[2]]);
  const right = unit(cross(pose.up, towards));
  const up = cross(towards, right);
  const ends = (["x", "y", "z"] as const).flatMap((axis, i) =>
    [1, -1].map((sign) => ({ axis, positive: sign > 0, x: sign * right[i]!, y: -sign * up[i]!, depth: sign * towards[i]! })),
  );
  return ends.sort((a, b) => a.depth - b.depth);
}

const AXES: Vector[] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** From the same distance along one axis; up is z, or, from above and below, the axis that is nearest to what was up. */
export function cameraFrom(pose: Omit<Pose, "type" | "moving">, end: { axis: "x" | "y" | "z"; positive: boolean }) {
  const index = "xyz".indexOf(end.axis);
  const distance = Math.hypot(...pose.eye.map((v, i) => v - pose.at[i]!)) * (end.positive ? 1 : -1);
  const eye = pose.at.map((v, i) => v + (i === index ? distance : 0)) as Vector;
  const away = [pose.at[0] - pose.eye[0], pose.at[1] - pose.eye[1], 0] as Vector; // what lay behind goes up
  const wish: Vector = Math.hypot(...away) > 1e-9 * Math.abs(distance) ? away : pose.up;
  const candidates = AXES.slice(0, 2).flatMap((a) => [a, a.map((v) => -v) as Vector]);
  const sign = end.positive ? 1 : -1;
  const up = index === 2 ? candidates.reduce((best, a) => (sign * dot(a, wish) > sign * dot(best, wish) ? a : best)) : AXES[2]!;
  return { eye, at: pose.at, up, ...(pose.parallel ? { parallel: true, height: pose.height } : { fov: pose.fov }) };
}
