/**
 * Where the handles of a light are over the picture, and what a drag makes of it.
 *
 * Directions are on a disc in the middle of the picture: its centre is where the viewer is, the way from there is the
 * angle between the light and the viewer, so that every direction has a place, half way the lights from the side and at
 * the rim the one from behind. Places are where they are seen; a drag moves them along the picture.
 */
import type { Pose } from "../protocol";

export type Vector = [number, number, number];
type Camera = Pick<Pose, "eye" | "at" | "up" | "parallel" | "fov" | "height">;

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function unit(v: Vector): Vector {
  const length = Math.hypot(...v) || 1;
  return [v[0] / length, v[1] / length, v[2] / length];
}

/** Right, up, and towards the viewer. */
export function axesOf(camera: Camera): [Vector, Vector, Vector] {
  const towards = unit(camera.eye.map((v, i) => v - camera.at[i]!) as Vector);
  const right = unit(cross(camera.up, towards));
  return [right, cross(towards, right), towards];
}

/** Along the camera's axes; of a frame "camera" it is that already. */
export function toCamera(v: Vector, axes: Vector[] | null): Vector {
  return axes ? [dot(v, axes[0]!), dot(v, axes[1]!), dot(v, axes[2]!)] : v;
}

export function fromCamera(v: Vector, axes: Vector[] | null): Vector {
  return axes ? (v.map((_, i) => v[0] * axes[0]![i]! + v[1] * axes[1]![i]! + v[2] * axes[2]![i]!) as Vector) : v;
}

/** On the disc of radius 1, x right and y up, for the way that light travels, along the camera's axes. */
export function onDisc(direction: Vector): [number, number] {
  const [x, y, z] = unit(direction).map((v) => -v) as Vector;
  const across = Math.hypot(x, y);
  const r = Math.atan2(across, z) / Math.PI;
  return across > 1e-9 ? [(x / across) * r, (y / across) * r] : [r, 0];
}

/** The other way round; beyond the rim is the rim. */
export function fromDisc(x: number, y: number): Vector {
  const r = Math.hypot(x, y);
  const angle = Math.min(1, r) * Math.PI;
  const share = r > 1e-9 ? Math.sin(angle) / r : 0;
  return [-x * share, -y * share, -Math.cos(angle)];
}

/** Half the height of what is seen at a depth. */
export function halfHeight(camera: Camera, depth: number): number {
  return camera.parallel ? (camera.height ?? 1) / 2 : depth * Math.tan((((camera.fov ?? 30) / 2) * Math.PI) / 180);
}

/** Of a place, along the camera's axes from the eye: in half heights of the picture from its middle; null: behind. */
export function seenAt(v: Vector, camera: Camera): [number, number] | null {
  const depth = -v[2];
  if (!camera.parallel && !(depth > 1e-9)) return null;
  const half = halfHeight(camera, depth);
  return [v[0] / half, v[1] / half];
}

/** The place as far away that is seen there. */
export function placedAt(x: number, y: number, v: Vector, camera: Camera): Vector {
  const half = halfHeight(camera, -v[2]);
  return [x * half, y * half, v[2]];
}
