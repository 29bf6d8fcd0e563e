/** What is being drawn, and handles of what is there, over a viewport. What is finished, the server's pictures show. */
import type { JSX, TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useRef } from "preact/hooks";
import type { Pose } from "../protocol";
import type { Vec3 } from "../slices/geometry";
import * as store from "../store";
import { formatNumber } from "../values";
import { angleOf, lengthOf, project } from "./geometry";
import type { Target } from "./hands";
import { extentOf, isFlat, type Drawn, type Frame } from "./regions";
import { draft, hover, isOpen, Move, pointsOf, regionKind, rows, selected, tool } from "./room";
import { mainFigure } from "./rows";

interface OverlayProps {
  target: Target;
  pose: Pose | null;
  width: number;
  height: number;
  /** Whether a place belongs to what this viewport shows. */
  isHere?: (p: Vec3) => boolean;
  /** The place that a hand drags one to; null: none. */
  drag: (x: number, y: number, from: Vec3) => Promise<Vec3 | null>;
}

type Pixel = [number, number];

function pathOf(points: (Pixel | null)[], closed = false): string {
  const seen = points.filter((p): p is Pixel => p !== null);
  return seen.length > 1 ? `M${seen.map((p) => p.map((v) => v.toFixed(1)).join(" ")).join("L")}${closed ? "Z" : ""}` : "";
}

/** What it would be if the pointer were clicked. */
function liveText(points: Vec3[], frame: Frame | null): string {
  const of = tool.value;
  if (of && (isFlat(of.takes) || of.takes === "sphere") && points.length >= of.least) {
    const { area, radius } = extentOf(of.takes as Drawn, points, frame);
    return area !== undefined ? `${formatNumber(area)} ${store.lengthUnit.value}²` : radius !== undefined ? `radius ${formatNumber(radius)} ${store.lengthUnit.value}` : "";
  }
  if (of?.takes !== "points" || points.length < 2) return "";
  if (of.kinds[0] === "angle") return points.length === 3 ? `${formatNumber(angleOf(points as [Vec3, Vec3, Vec3]))}°` : "";
  return `${formatNumber(lengthOf(points))} ${store.lengthUnit.value}`;
}

const LIVE_ROOM = 100; // pixels

const Spanned = ([x, y]: Pixel, [u, v]: Pixel) => <rect class="measure-line measure-region" x={Math.min(x, u)} y={Math.min(y, v)} width={Math.abs(u - x)} height={Math.abs(v - y)} />;
/** What two clicks span, as it is seen in a slice. */
const SHAPES: { [takes: string]: (from: Pixel, to: Pixel) => JSX.Element } = {
  box: Spanned,
  rectangle: Spanned,
  ellipse: ([x, y], [u, v]) => <ellipse class="measure-line measure-region" cx={(x + u) / 2} cy={(y + v) / 2} rx={Math.abs(u - x) / 2} ry={Math.abs(v - y) / 2} />,
  sphere: ([x, y], [u, v]) => <circle class="measure-line measure-region" cx={x} cy={y} r={Math.hypot(u - x, v - y)} />,
};

function Draft({ target, toPixel, width, height }: { target: Target; toPixel: (p: Vec3) => Pixel | null; width: number; height: number }) {
  const of = tool.value;
  const here = hover.value?.where === target.name ? hover.value : null;
  if (!of || (!draft.value.length && !here)) return null;
  const points = draft.value.map((p) => p.at);
  const pixels = points.map(toPixel);
  const tip: Pixel | null = here ? [here.x * width, here.y * height] : null;
  const first = pixels[0];
  const spans = first && tip ? { from: first, to: tip } : null;
  const isShape = spans !== null && SHAPES[of.takes] !== undefined;
  const live = here?.at && points.length ? liveText([...points, here.at], target.frame?.() ?? null) : "";
  return (
    <g aria-hidden="true">
      {isShape ? SHAPES[of.takes]!(spans.from, spans.to) : <path class="measure-line" d={pathOf(pixels)} />}
      {tip && !isShape && pixels.length
        ? <path class="measure-line measure-band" d={pathOf(of.takes === "polygon" && pixels.length > 1 ? [pixels[pixels.length - 1]!, tip, pixels[0]!] : [pixels[pixels.length - 1]!, tip])} /> : null}
      {pixels.map((p, i) => p ? <circle key={i} class="measure-dot" cx={p[0]} cy={p[1]} r={4} /> : null)}
      {tip ? <circle class="measure-tip" cx={tip[0]} cy={tip[1]} r={3} /> : null}
      {tip && live ? <text class="measure-live" x={tip[0] + (tip[0] > width - LIVE_ROOM ? -12 : 12)} y={Math.max(14, tip[1] - 10)} text-anchor={tip[0] > width - LIVE_ROOM ? "end" : "start"}>{live}</text> : null}
    </g>
  );
}

const KEY_PIXELS = 1;

function Handle({ id, title, index, at, n, isSelected, p }: { id: string; title: string; index: number; at: Pixel; n: number; isSelected: boolean; p: OverlayProps }) {
  const move = useRef<Move | null>(null);
  const from = useRef<Pixel>([0, 0]);
  const busy = useRef(false);
  const next = useRef<Pixel | null>(null);
  const start = pointsOf(id)[index]!;
  /** One question at a time, the newest place next. */
  const drag = async (to: Pixel, by: Move) => {
    next.current = to;
    if (busy.current) return;
    busy.current = true;
    while (next.current) {
      const [x, y] = next.current;
      next.current = null;
      const there = await p.drag(x / p.width, y / p.height, by.now?.[index] ?? start);
      if (there) by.to(index, there);
    }
    busy.current = false;
  };
  const down = (event: TargetedPointerEvent<SVGGElement>) => {
    if (event.button !== 0) return;
    event.stopPropagation();
    store.selection.value = `measurements.${id}`;
    if (store.readOnly.value) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    from.current = [event.clientX - at[0], event.clientY - at[1]];
    move.current = new Move(id);
  };
  const go = (event: TargetedPointerEvent<SVGGElement>) => {
    if (move.current) void drag([event.clientX - from.current[0], event.clientY - from.current[1]], move.current);
  };
  const up = async () => {
    const by = move.current;
    move.current = null;
    while (busy.current) await new Promise(requestAnimationFrame);
    await by?.end();
  };
  const key = async (event: TargetedKeyboardEvent<SVGGElement>) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!by || store.readOnly.value) return;
    event.preventDefault();
    event.stopPropagation();
    const step = KEY_PIXELS * (event.shiftKey ? 10 : 1);
    const one = new Move(id);
    await drag([at[0] + by[0]! * step, at[1] + by[1]! * step], one);
    await one.end();
  };
  return (
    <g
      class={`measure-handle ${isSelected ? "measure-selected" : ""}`} transform={`translate(${at[0].toFixed(1)} ${at[1].toFixed(1)})`} tabindex={isSelected ? 0 : -1}
      role="button" aria-roledescription="handle" aria-label={`Point ${index + 1} of ${n} of ${title}`}
      onPointerDown={down} onPointerMove={go} onPointerUp={up} onPointerCancel={up} onKeyDown={key}
    >
      <circle class="measure-hit" r={14} />
      {isSelected ? <circle class="measure-dot" r={5} /> : null}
    </g>
  );
}

export function MeasureOverlay(p: OverlayProps) {
  const { pose, width, height, isHere = () => true } = p;
  if (!isOpen.value || !pose || !(width > 0) || !(height > 0)) return null;
  const toPixel = (point: Vec3): Pixel | null => {
    const at = project(pose, width / height, point);
    return at && [at[0] * width, at[1] * height];
  };
  const all = rows.value.filter((row) => row.visible).map((row) => {
    const points = pointsOf(row.id);
    const kind = regionKind(row.id);
    return { ...row, points, line: (row.busy ? null : mainFigure(row)?.path) ?? points, closed: kind !== "", around: ["ellipse", "ellipsoid"].includes(kind) };
  }).filter((row) => row.points.length);
  return (
    <svg class={`measure-overlay ${tool.value ? "measure-busy" : ""}`} width={width} height={height} role="group" aria-label={`Measurements: ${p.target.name}`}>
      {all.map((row) => row.id === selected.value && row.points.every(isHere) ? <path key={row.id} class={`measure-line ${row.around ? "measure-band" : "measure-chosen"}`} aria-hidden="true" d={pathOf(row.line.map(toPixel), row.closed)} /> : null)}
      {all.flatMap((row) => row.points.map((point, i) => {
        const at = isHere(point) ? toPixel(point) : null;
        return at ? <Handle key={`${row.id} ${i}`} id={row.id} title={row.title} index={i} n={row.points.length} at={at} isSelected={row.id === selected.value} p={p} /> : null;
      }))}
      <Draft target={p.target} toPixel={toPixel} width={width} height={height} />
    </svg>
  );
}
