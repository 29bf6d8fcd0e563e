/** How the World is turned: its three axes in a corner. A click on an end looks from there; so do keys and the search. */
import type { TargetedMouseEvent } from "preact";
import { send } from "../session";
import * as store from "../store";
import { axisEnds, cameraFrom, type AxisEnd } from "./axes_geometry";

const RADIUS = 30;
const MIDDLE = 44;
const REACH = 14; // pixels about an end that are its own

function nearest(ends: AxisEnd[], x: number, y: number): AxisEnd | null {
  let best: AxisEnd | null = null;
  for (const end of ends)
    if (Math.hypot(x - MIDDLE - RADIUS * end.x, y - MIDDLE - RADIUS * end.y) < REACH) best = end; // later ones are in front
  return best;
}

/** Ends may lie over each other: one drawing takes the click, and is no button to readers, who have the keys. */
export function AxesGizmo() {
  const pose = store.pose.value;
  const cube = store.valueOf(`${store.viewPath.value}.decorations.cube`) === true; // it stands there, and says more
  if (!pose || store.isEmpty.value || cube) return null;
  const ends = axisEnds(pose);
  const click = (event: TargetedMouseEvent<SVGSVGElement>) => {
    const rect = event.currentTarget.getBoundingClientRect();
    const end = nearest(ends, event.clientX - rect.left, event.clientY - rect.top);
    if (end) void send({ type: "camera", ...cameraFrom(pose, end) });
  };
  return (
    <svg class="axes" viewBox="0 0 88 88" width="88" height="88" aria-hidden="true" onClick={click}>
      {ends.map((end) => {
        const x = MIDDLE + RADIUS * end.x;
        const y = MIDDLE + RADIUS * end.y;
        return (
          <g key={`${end.positive}${end.axis}`} class={`axis axis-${end.axis} ${end.positive ? "" : "axis-back"}`}>
            <title>From {end.positive ? "+" : "−"}{end.axis}</title>
            {end.positive ? <line x1={MIDDLE} y1={MIDDLE} x2={x} y2={y} /> : null}
            <circle cx={x} cy={y} r={end.positive ? 8 : 5} />
            {end.positive ? <text x={x} y={y + 3.5}>{end.axis}</text> : null}
          </g>
        );
      })}
    </svg>
  );
}
