/** Regions that are drawn: what clicks make of them, how large they are, and the handles by which they are changed. */
import type { Json, JsonObject } from "../protocol";
import type { Vec3 } from "../slices/geometry";
import { cross, dot, minus } from "./geometry";

export type Drawn = "rectangle" | "ellipse" | "polygon" | "sphere";
/** Unit vectors of the plane that one draws in. */
export interface Frame {
  right: Vec3;
  up: Vec3;
}

const rounded = (p: Vec3): Vec3 => p.map((v) => Number(v.toPrecision(9)) || 0) as Vec3;
const from = (p: Vec3, ...steps: [Vec3, number][]): Vec3 => steps.reduce<Vec3>((q, [way, far]) => q.map((v, i) => v + way[i]! * far) as Vec3, p);
const between = (a: Vec3, b: Vec3): Vec3 => a.map((v, i) => (v + b[i]!) / 2) as Vec3;

/** Whether it lies in a slice. */
export const isFlat = (drawn: string): boolean => drawn === "rectangle" || drawn === "ellipse" || drawn === "polygon";

/** Of an outline, half of the length of what Newell's sum gives. */
function outlineArea(points: Vec3[]): number {
  const sum = points.slice(1).reduce<Vec3>((n, p, i) => from(n, [cross(minus(p, points[0]!), minus(points[i + 2] ?? p, points[0]!)), 1]), [0, 0, 0]);
  return Math.hypot(...sum) / 2;
}

/** Whole extents of what two corners span. */
const extents = ([a, b]: Vec3[], { right, up }: Frame): [number, number] => [Math.abs(dot(minus(b!, a!), right)), Math.abs(dot(minus(b!, a!), up))];

/** In a plane the area; of a sphere the radius. */
export function extentOf(drawn: Drawn, points: Vec3[], frame: Frame | null): { area?: number; radius?: number } {
  if (drawn === "sphere") return { radius: Math.hypot(...minus(points[1]!, points[0]!)) };
  if (drawn === "polygon") return { area: outlineArea(points) };
  if (!frame) return {};
  const [wide, high] = extents(points, frame);
  return { area: wide * high * (drawn === "ellipse" ? Math.PI / 4 : 1) };
}

const TINY = 1e-9;

/** The property `region` of a measurement in the World's space; a sentence: it is none. Where it is flat, it is one slice thick, or
 * as thick as is said: of what has no slices. */
export function regionOf(drawn: Drawn, points: Vec3[], frame: Frame | null, thickness = 0): JsonObject | string {
  const { area, radius } = extentOf(drawn, points, frame);
  if (!((area ?? radius ?? 0) > TINY)) return "What is drawn has no extent.";
  if (drawn === "sphere") return { kind: "ellipsoid", center: rounded(points[0]!), size: rounded([2 * radius!, 2 * radius!, 2 * radius!]) };
  const normal = rounded(cross(frame!.right, frame!.up));
  if (drawn === "polygon") return { kind: "polygon", outline: points.map(rounded), normal, ...(thickness ? { thickness } : {}) };
  return {
    kind: drawn === "ellipse" ? "ellipse" : "box", center: rounded(between(points[0]!, points[1]!)),
    size: rounded([...extents(points, frame!), thickness]), normal, right: rounded(frame!.right),
  };
}

// Handles -------------------------------------------------------------------------------------------------------------

const isPlace = (value: Json | undefined): value is [number, number, number] => Array.isArray(value) && value.length === 3 && value.every((v) => typeof v === "number");
const unit = (v: Vec3): Vec3 => v.map((x) => x / (Math.hypot(...v) || 1)) as Vec3;

/** As the program chooses what is not set. */
export function frameOf(region: JsonObject): Frame {
  const normal = unit(isPlace(region["normal"]) ? region["normal"] : [0, 0, 1]);
  const way: Vec3 = isPlace(region["right"]) ? region["right"] : Math.abs(normal[0]) <= Math.max(Math.abs(normal[1]), Math.abs(normal[2])) ? [1, 0, 0] : [0, 1, 0];
  const right = unit(from(way, [normal, -dot(normal, way)]));
  return { right, up: cross(normal, right) };
}

const CORNERS: [number, number][] = [[-1, -1], [1, -1], [1, 1], [-1, 1]];

/** Corners; of an ellipse those of the rectangle around it; of an ellipsoid its middle and one end. */
export function handlesOf(region: JsonObject): Vec3[] {
  const { kind, outline, center, size } = region;
  if (kind === "polygon") return Array.isArray(outline) ? outline.filter(isPlace) : [];
  if (!isPlace(center) || !isPlace(size)) return [];
  const { right, up } = frameOf(region);
  if (kind === "ellipsoid") return [center, from(center, [right, size[0] / 2])];
  return CORNERS.map(([x, y]) => from(center, [right, (x * size[0]) / 2], [up, (y * size[1]) / 2]));
}

/** What it becomes when a handle is elsewhere: of a corner, the one across stays. */
export function movedRegion(region: JsonObject, index: number, at: Vec3): JsonObject {
  const handles = handlesOf(region);
  if (region["kind"] === "polygon") return { ...region, outline: handles.map((p, i) => (i === index ? rounded(at) : p)) };
  const size = region["size"] as Vec3;
  if (region["kind"] === "ellipsoid") {
    if (index === 0) return { ...region, center: rounded(at) };
    const by = (2 * Math.hypot(...minus(at, handles[0]!))) / size[0];
    return by > TINY ? { ...region, size: rounded(size.map((v) => v * by) as Vec3) } : region;
  }
  const across = handles[(index + 2) % 4]!;
  const [wide, high] = extents([across, at], frameOf(region));
  return wide > TINY && high > TINY ? { ...region, center: rounded(between(across, at)), size: rounded([wide, high, size[2]]) } : region;
}
