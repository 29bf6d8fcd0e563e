/** Handles of the light that is selected: its direction on a disc, its place where it is seen. Drags are one step each. */
import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { Gesture } from "../session";
import * as store from "../store";
import { axesOf, fromCamera, fromDisc, onDisc, placedAt, seenAt, toCamera, type Vector } from "./light_geometry";

const DISC = 0.42; // of the smaller side
const STEP = 1 / 36; // of the disc: 5 degrees

function vector(path: string): Vector | null {
  const value = store.valueOf(path);
  return Array.isArray(value) && value.length === 3 && value.every((v) => typeof v === "number") ? (value as Vector) : null;
}

const rounded = (v: Vector): Vector => v.map((x) => Number(x.toFixed(5)) || 0) as Vector;
const tidied = (v: Vector): Vector => v.map((x) => Number(x.toPrecision(6)) || 0) as Vector;

interface HandleProps {
  label: string;
  x: number;
  y: number;
  behind: boolean;
  kind: "sun" | "place";
  step: number;
  /** To a place in pixels of the drawing. */
  onMove(x: number, y: number, gesture: Gesture): void;
}

/** Something that is dragged, or moved by the arrow keys. */
function Handle({ label, x, y, behind, kind, step, onMove }: HandleProps) {
  const gesture = useRef<Gesture | null>(null);
  const from = useRef<[number, number]>([0, 0]);
  const down = (event: TargetedPointerEvent<SVGGElement>) => {
    if (event.button !== 0) return;
    event.stopPropagation();
    event.currentTarget.setPointerCapture(event.pointerId);
    from.current = [event.clientX - x, event.clientY - y];
    gesture.current = new Gesture();
  };
  const move = (event: TargetedPointerEvent<SVGGElement>) => {
    if (gesture.current) onMove(event.clientX - from.current[0], event.clientY - from.current[1], gesture.current);
  };
  const up = () => { gesture.current = null; };
  const key = (event: TargetedKeyboardEvent<SVGGElement>) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    const size = step * (event.shiftKey ? 0.2 : 1);
    onMove(x + by[0]! * size, y + by[1]! * size, new Gesture());
  };
  return (
    <g
      class={`light-handle ${behind ? "light-behind" : ""}`} tabIndex={0} role="button" aria-roledescription="handle" aria-label={label}
      transform={`translate(${x} ${y})`} onPointerDown={down} onPointerMove={move} onPointerUp={up} onPointerCancel={up} onKeyDown={key}
    >
      <circle class="light-hit" r={16} />
      <circle class="light-dot" r={kind === "sun" ? 6 : 5} />
      {kind === "sun" ? <path class="light-rays" d="M0-9v-4M0 9v4M-9 0h-4M9 0h4M-6.4-6.4l-2.8-2.8M6.4-6.4l2.8-2.8M-6.4 6.4l-2.8 2.8M6.4 6.4l2.8 2.8" /> : <path class="light-rays" d="M-11 0h6M5 0h6M0-11v6M0 5v6" />}
    </g>
  );
}

export function LightHandles() {
  const element = useRef<SVGSVGElement>(null);
  const [[width, height], setSize] = useState<[number, number]>([0, 0]);
  const [map, id] = store.selection.value.split(".");
  const path = `lights.${id}`;
  const kind = map === "lights" && id ? store.valueOf(`${path}.kind`) ?? "directional" : null;
  const wanted = kind !== null && kind !== "ambient" && !store.readOnly.value && !store.isEmpty.value;
  useEffect(() => {
    if (!wanted) return undefined;
    const observer = new ResizeObserver(() => setSize([element.current?.clientWidth ?? 0, element.current?.clientHeight ?? 0]));
    observer.observe(element.current!);
    return () => observer.disconnect();
  }, [wanted]);
  const pose = store.pose.value;
  if (!wanted) return null;
  const axes = pose && store.valueOf(`${path}.frame`) !== "camera" ? axesOf(pose) : null;
  const [cx, cy, disc] = [width / 2, height / 2, DISC * Math.min(width, height)];
  const direction = kind === "point" ? null : vector(`${path}.direction`) ?? [0, 0, -1];
  const position = kind === "directional" ? null : vector(`${path}.position`) ?? [0, 0, 0];
  const set = (row: string, value: Vector, gesture: Gesture) => gesture.change({ op: "set", path: `${path}.${row}`, value: row === "direction" ? rounded(value) : tidied(value) });

  const sun = () => {
    const [x, y] = onDisc(toCamera(direction!, axes));
    const to = (px: number, py: number, gesture: Gesture) => set("direction", fromCamera(fromDisc((px - cx) / disc, (cy - py) / disc), axes), gesture);
    return (
      <>
        <circle class="light-ring" cx={cx} cy={cy} r={disc / 2} />
        <circle class="light-ring light-rim" cx={cx} cy={cy} r={disc} />
        <path class="light-line" d={`M${cx} ${cy}L${cx + x * disc} ${cy - y * disc}`} />
        <Handle kind="sun" label={`Direction of the light ${id}`} x={cx + x * disc} y={cy - y * disc} behind={Math.hypot(x, y) > 0.5} step={STEP * disc} onMove={to} />
      </>
    );
  };
  const place = () => {
    const offset = axes ? (position!.map((v, i) => v - pose!.eye[i]!) as Vector) : position!;
    const v = toCamera(offset, axes);
    const at = pose && seenAt(v, pose);
    if (!at) return null;
    const to = (px: number, py: number, gesture: Gesture) => {
      const moved = fromCamera(placedAt((px - cx) / cy, (cy - py) / cy, v, pose!), axes);
      set("position", axes ? (moved.map((m, i) => m + pose!.eye[i]!) as Vector) : moved, gesture);
    };
    return <Handle kind="place" label={`Position of the light ${id}`} x={cx + at[0] * cy} y={cy - at[1] * cy} behind={false} step={8} onMove={to} />;
  };
  return (
    <svg ref={element} class="light-handles" role="group" aria-label={`Light ${id}`}>
      {pose && width > 0 ? <>{direction ? sun() : null}{position ? place() : null}</> : null}
    </svg>
  );
}
