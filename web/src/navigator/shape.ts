/** The answer to a request `shape`: docs/protocol.md. */
import type { Vector } from "./lens";

export interface ShapePart {
  volume: string;
  url: string;
  bytes: number;
  triangles: number;
  /** One sample in so many is taken; zeros where it is no matter of samples. */
  step: [number, number, number];
  value: number | null;
  solid: boolean;
  place: number[];
  color: Vector;
  shading: "none" | "phong" | "blinn";
  light: [number, number, number, number];
  planes: number[][];
}

export interface ShapeLight {
  kind: "directional" | "point" | "spot";
  frame: "camera" | "world";
  color: Vector;
  position: Vector;
  direction: Vector;
  cone: [number, number];
  falloff: Vector;
}

export interface Shape {
  method: "reduced" | "boxes";
  parts: ShapePart[];
  lights: ShapeLight[];
  ambient: Vector;
  background: [number, number, number, number];
  left_out: string[];
}
