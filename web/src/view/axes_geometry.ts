/** Where the ends of the World's axes are in the picture. */

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
