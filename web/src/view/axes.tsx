/** How the World is turned: its three axes in a corner. Each end is a button that looks along it. */
import { send } from "../session";
import * as store from "../store";

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

/** Standard views look from these sides: the front is towards +y, the right towards +x (docs of views). */
const ACTIONS: { [end: string]: string } = { "+x": "right", "-x": "left", "+y": "front", "-y": "back", "+z": "top", "-z": "bottom" };

const RADIUS = 30;
const MIDDLE = 44;

export function AxesGizmo() {
  const pose = store.pose.value;
  if (!pose || store.isEmpty.value) return null;
  const ends = axisEnds(pose);
  return (
    <div class="axes" role="group" aria-label="Directions">
      <svg viewBox="0 0 88 88" width="88" height="88" aria-hidden="true">
        {ends.filter((end) => end.positive).map((end) => (
          <line key={end.axis} class={`axis axis-${end.axis}`} x1={MIDDLE} y1={MIDDLE} x2={MIDDLE + RADIUS * end.x} y2={MIDDLE + RADIUS * end.y} />
        ))}
      </svg>
      {ends.map((end) => {
        const name = ACTIONS[`${end.positive ? "+" : "-"}${end.axis}`]!;
        return (
          <button
            key={`${end.positive}${end.axis}`} type="button" class={`axis-end axis-end-${end.axis} ${end.positive ? "" : "axis-end-back"}`}
            style={{ left: `${MIDDLE + RADIUS * end.x}px`, top: `${MIDDLE + RADIUS * end.y}px`, zIndex: Math.round(10 + 5 * end.depth) }}
            aria-label={`Look from ${name}, ${end.positive ? "plus" : "minus"} ${end.axis}`} title={`From ${name}`}
            onClick={() => void send({ type: "action", name })}
          >
            {end.positive ? end.axis : ""}
          </button>
        );
      })}
    </div>
  );
}
