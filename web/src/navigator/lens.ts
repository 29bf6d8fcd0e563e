/**
 * The server's lens (src/scene/lens.c) in the page: from what a message `pose` says to numbers for the graphics
 * card. Places are counted from the eye, in doubles, before they become floats: a small thing far from the World's
 * origin does not tremble.
 */
import type { Pose } from "../protocol";

export type Vector = [number, number, number];
export type View = Pick<Pose, "eye" | "at" | "up" | "parallel" | "fov" | "height">;

/** Eye space: x right, y up, z towards the viewer. */
export interface Lens {
  eye: Vector;
  right: Vector;
  up: Vector;
  back: Vector;
  parallel: boolean;
  /** Of the picture: tangents, or lengths where it is parallel. */
  halfWidth: number;
  halfHeight: number;
}

export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

function unit(v: Vector): Vector {
  const length = Math.hypot(...v) || 1;
  return [v[0] / length, v[1] / length, v[2] / length];
}

export function lensOf(pose: View, width: number, height: number): Lens {
  const back = unit(minus(pose.eye, pose.at));
  const right = unit(cross(pose.up, back));
  const halfHeight = pose.parallel ? (pose.height ?? 1) / 2 : Math.tan(((pose.fov ?? 30) * Math.PI) / 360);
  return { eye: pose.eye, right, up: cross(back, right), back, parallel: pose.parallel, halfWidth: (halfHeight * width) / height, halfHeight };
}

/** A direction of the World along the lens's axes. */
export function turned(lens: Lens, v: Vector): Vector {
  return [dot(lens.right, v), dot(lens.up, v), dot(lens.back, v)];
}

/** A place of the World in eye space. */
export function seenFrom(lens: Lens, p: Vector): Vector {
  return turned(lens, minus(p, lens.eye));
}

/** Affine maps as docs/protocol.md has them: three axes and an origin, 12 numbers. */
export function column(map: readonly number[], i: number): Vector {
  return [map[3 * i]!, map[3 * i + 1]!, map[3 * i + 2]!];
}

export function composed(after: readonly number[], before: readonly number[]): number[] {
  const linear = (v: Vector): Vector => [0, 1, 2].map((row) => dot([after[row]!, after[3 + row]!, after[6 + row]!], v)) as Vector;
  const origin = linear(column(before, 3)).map((v, i) => v + after[9 + i]!);
  return [...linear(column(before, 0)), ...linear(column(before, 1)), ...linear(column(before, 2)), ...origin];
}

/** From numbers of a file to eye space: 12 numbers. */
export function toEye(lens: Lens, map: readonly number[]): number[] {
  return [...turned(lens, column(map, 0)), ...turned(lens, column(map, 1)), ...turned(lens, column(map, 2)), ...seenFrom(lens, column(map, 3))];
}

/** Whether a map makes left from right. */
export function isMirrored(map: readonly number[]): boolean {
  return dot(column(map, 0), cross(column(map, 1), column(map, 2))) < 0;
}

/** How covectors (gradients) turn under a map: the inverse transposed, up to a positive factor; nine numbers, by column. */
export function covectors(map: readonly number[]): number[] {
  const [x, y, z] = [column(map, 0), column(map, 1), column(map, 2)];
  const sides = [cross(y, z), cross(z, x), cross(x, y)];
  const sign = dot(x, sides[0]!) < 0 ? -1 : 1;
  const largest = Math.max(...sides.flat().map(Math.abs)) || 1;
  return sides.flat().map((v) => (sign * v) / largest);
}

/** Smallest and largest distance before the eye, along the line of sight, of a box that is given in numbers of a map. */
export function depthsOf(map: readonly number[], lo: Vector, hi: Vector): [number, number] {
  const depths = Array.from({ length: 8 }, (_, c) => {
    const p: Vector = [c & 1 ? hi[0] : lo[0], c & 2 ? hi[1] : lo[1], c & 4 ? hi[2] : lo[2]];
    return -dot([map[2]!, map[5]!, map[8]!], p) - map[11]!;
  });
  return [Math.min(...depths), Math.max(...depths)];
}

const NEAREST = 1e-4; // of the farthest: what is left of 24 bits of depth beyond it is enough

/** From eye space to the graphics card's clip space, by column; depths that matter are between near and far. */
export function projection(lens: Lens, near: number, far: number): number[] {
  const end = far > 0 ? far * 1.001 : 1;
  if (lens.parallel) return [1 / lens.halfWidth, 0, 0, 0, 0, 1 / lens.halfHeight, 0, 0, 0, 0, -2 / end, 0, 0, 0, -1, 1];
  const begin = Math.max(near * 0.999, NEAREST * end);
  const share = 1 / (begin - end);
  return [1 / lens.halfWidth, 0, 0, 0, 0, 1 / lens.halfHeight, 0, 0, 0, 0, (end + begin) * share, -1, 0, 0, 2 * end * begin * share, 0];
}

/** What keeps n . p >= offset in the World, in eye space. */
export function seenPlane(lens: Lens, plane: readonly number[]): [number, number, number, number] {
  const normal: Vector = [plane[0]!, plane[1]!, plane[2]!];
  return [...turned(lens, normal), plane[3]! - dot(normal, lens.eye)];
}
