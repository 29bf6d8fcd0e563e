/** Histogram, opacity curve and its points, and the colours under them, drawn to be dragged. */
import type { RefObject, TargetedKeyboardEvent, TargetedMouseEvent, TargetedPointerEvent } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { hexOfLinear } from "../colors";
import type { Histogram } from "../protocol";
import { formatNumber } from "../values";
import {
  clampAxis, columns, heightOpacity, isMap, opacityHeight, sampleNodes, ticks, zoomAxis, type Axis, type ColorNode, type OpacityNode,
} from "./curve";

export type Selected = { list: "opacity" | "color"; index: number } | null;

interface PlotProps {
  opacity: OpacityNode[];
  color: ColorNode[];
  histogram: Histogram | null;
  log: boolean;
  axis: Axis;
  full: Axis;
  unit: string;
  perLength: string;
  selected: Selected;
  disabled: boolean;
  onAxis(axis: Axis): void;
  onSelect(selected: Selected): void;
  onBegin(): void;
  onMove(selected: NonNullable<Selected>, value: number, opacity: number): void;
  onEnd(): void;
  onAdd(list: "opacity" | "color", value: number, opacity: number): void;
  onRemove(selected: NonNullable<Selected>): void;
}

const HEIGHT = 168;
const TOP = 10;
const LEFT = 30;
const RIGHT = 10;
const BASE = 118; // where opacity is 0
const BAR_TOP = 124;
const BAR_HEIGHT = 16;
const OPACITY_TICKS = [0.01, 0.1, 0.3, 1];

/** The drawing is as wide as the panel is, so that lines and letters keep their sizes. */
function useWidth(): [RefObject<SVGSVGElement | null>, number] {
  const element = useRef<SVGSVGElement>(null);
  const [width, setWidth] = useState(300);
  useEffect(() => {
    const observer = new ResizeObserver(() => setWidth(Math.max(160, element.current?.clientWidth ?? 300)));
    observer.observe(element.current!);
    return () => observer.disconnect();
  }, []);
  return [element, width];
}

export function TransferPlot(p: PlotProps) {
  const [element, width] = useWidth();
  const drag = useRef<{ selected: Selected; axis: Axis; x: number } | null>(null);
  const inner = width - LEFT - RIGHT;
  const xOf = (value: number) => LEFT + (inner * (value - p.axis.lo)) / (p.axis.hi - p.axis.lo);
  const valueOf = (x: number) => p.axis.lo + ((x - LEFT) / inner) * (p.axis.hi - p.axis.lo);
  const yOf = (opacity: number) => BASE - (BASE - TOP) * opacityHeight(opacity);
  const opacityOf = (y: number) => heightOpacity((BASE - y) / (BASE - TOP));

  const bars = useMemo(() => {
    if (!p.histogram) return "";
    const n = Math.min(256, Math.round(inner));
    const heights = columns(p.histogram.counts, p.histogram.lo, p.histogram.hi, p.axis, n, p.log);
    const step = inner / n;
    return `M${LEFT} ${BASE}${heights.map((h, i) => `V${(BASE - (BASE - TOP) * h).toFixed(1)}H${(LEFT + (i + 1) * step).toFixed(1)}`).join("")}V${BASE}z`;
  }, [p.histogram, p.axis.lo, p.axis.hi, p.log, inner]);

  const curve = useMemo(() => curvePoints(p.opacity, p.axis, inner).map(([v, o]) => `${xOf(v).toFixed(1)} ${yOf(o).toFixed(1)}`), [p.opacity, p.axis, inner]);
  const stops = useMemo(() => Array.from({ length: 33 }, (_, i) => hexOfLinear(sampleNodes(p.color, p.axis.lo + ((p.axis.hi - p.axis.lo) * i) / 32))), [p.color, p.axis]);

  const at = (event: PointerEvent | MouseEvent | WheelEvent): [number, number] => {
    const rect = element.current!.getBoundingClientRect();
    return [((event.clientX - rect.left) * width) / rect.width, ((event.clientY - rect.top) * HEIGHT) / rect.height];
  };
  const grab = (event: TargetedPointerEvent<SVGElement>, selected: Selected) => {
    if (event.button !== 0) return;
    event.stopPropagation();
    element.current!.setPointerCapture(event.pointerId);
    drag.current = { selected, axis: p.axis, x: at(event)[0] };
    if (selected) {
      p.onSelect(selected);
      if (!p.disabled) p.onBegin();
    }
  };
  const move = (event: TargetedPointerEvent<SVGSVGElement>) => {
    const d = drag.current;
    if (!d) return;
    const [x, y] = at(event);
    if (d.selected && !p.disabled) p.onMove(d.selected, valueOf(x), opacityOf(y));
    else if (!d.selected) {
      const by = ((d.x - x) / inner) * (d.axis.hi - d.axis.lo);
      p.onAxis(clampAxis({ lo: d.axis.lo + by, hi: d.axis.hi + by }, p.full));
    }
  };
  const release = () => {
    if (drag.current?.selected) p.onEnd();
    drag.current = null;
  };
  const add = (event: TargetedMouseEvent<SVGSVGElement>) => {
    const [x, y] = at(event);
    if (p.disabled || x < LEFT || x > width - RIGHT) return;
    p.onAdd(y > BASE + 3 ? "color" : "opacity", valueOf(x), opacityOf(y));
  };
  useEffect(() => {
    const svg = element.current!;
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      p.onAxis(zoomAxis(p.axis, p.full, valueOf(at(event)[0]), 1.2 ** Math.sign(event.deltaY)));
    };
    svg.addEventListener("wheel", wheel, { passive: false });
    return () => svg.removeEventListener("wheel", wheel);
  });

  const key = (event: TargetedKeyboardEvent<SVGElement>, selected: NonNullable<Selected>, node: readonly number[]) => {
    const big = event.shiftKey ? 10 : 1;
    const stepX = ((p.axis.hi - p.axis.lo) / 200) * big;
    const opacity = selected.list === "opacity" ? node[1]! : 0;
    const moves: { [name: string]: [number, number] } = {
      ArrowLeft: [-stepX, 0], ArrowRight: [stepX, 0], ArrowUp: [0, 0.01 * big], ArrowDown: [0, -0.01 * big],
    };
    const by = moves[event.key];
    if (by && !p.disabled) {
      p.onBegin();
      p.onMove(selected, node[0]! + by[0], opacity + by[1]);
      p.onEnd();
    } else if ((event.key === "Delete" || event.key === "Backspace") && !p.disabled) {
      p.onRemove(selected);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  };

  const map = isMap(p.color);
  const inside = (value: number) => value >= p.axis.lo - 1e-9 && value <= p.axis.hi + 1e-9;
  return (
    <svg
      ref={element} class="plot" viewBox={`0 0 ${width} ${HEIGHT}`} role="group" aria-label="Opacity and colour by value"
      onPointerDown={(e) => grab(e, null)} onPointerMove={move} onPointerUp={release} onPointerCancel={release} onDblClick={add}
    >
      <defs>
        <linearGradient id="plot-colors">{stops.map((color, i) => <stop key={i} offset={i / 32} stop-color={color} />)}</linearGradient>
        <clipPath id="plot-clip"><rect x={LEFT} y={0} width={inner} height={HEIGHT} /></clipPath>
      </defs>
      <g aria-hidden="true">
        <rect class="plot-area" x={LEFT} y={TOP} width={inner} height={BASE - TOP} />
        <path class="plot-bars" d={bars} />
        {OPACITY_TICKS.map((o) => (
          <g key={o}>
            <line class="plot-grid" x1={LEFT} x2={width - RIGHT} y1={yOf(o)} y2={yOf(o)} />
            <text class="plot-tick" x={LEFT - 4} y={yOf(o) + 3.5} text-anchor="end">{o}</text>
          </g>
        ))}
        <g clip-path="url(#plot-clip)">
          <path class="plot-fill" fill="url(#plot-colors)" d={`M${LEFT} ${BASE}L${curve.join("L")}L${width - RIGHT} ${BASE}z`} />
          <path class="plot-curve" d={`M${curve.join("L")}`} />
        </g>
        <rect class="plot-bar" x={LEFT} y={BAR_TOP} width={inner} height={BAR_HEIGHT} fill="url(#plot-colors)" />
        {ticks(p.axis, inner / 56).map((v) => (
          <text key={v} class="plot-tick" x={xOf(v)} y={HEIGHT - 12} text-anchor={xOf(v) < LEFT + 12 ? "start" : xOf(v) > width - RIGHT - 14 ? "end" : "middle"}>{formatNumber(v)}</text>
        ))}
      </g>
      {p.opacity.map((node, index) => inside(node[0]) ? (
        <g
          key={`o${index}`} class={`plot-point ${isSelected(p.selected, "opacity", index) ? "plot-selected" : ""}`} tabIndex={0} role="slider"
          aria-label={`Opacity point ${index + 1} of ${p.opacity.length}`} aria-valuemin={0} aria-valuemax={1} aria-valuenow={node[1]}
          aria-valuetext={`${formatNumber(node[0])} ${p.unit}: opacity ${formatNumber(node[1])} ${p.perLength}`} aria-disabled={p.disabled || undefined}
          onFocus={() => p.onSelect({ list: "opacity", index })} onKeyDown={(e) => key(e, { list: "opacity", index }, node)}
          onPointerDown={(e) => grab(e, { list: "opacity", index })} onDblClick={(e) => e.stopPropagation()}
        >
          <circle class="plot-hit" cx={xOf(node[0])} cy={yOf(node[1])} r={12} />
          <circle class="plot-dot" cx={xOf(node[0])} cy={yOf(node[1])} r={4.5} />
        </g>
      ) : null)}
      {p.color.map((node, index) => inside(node[0]) && (!map || index === 0 || index === p.color.length - 1) ? (
        <g
          key={`c${index}`} class={`plot-point ${isSelected(p.selected, "color", index) ? "plot-selected" : ""}`} tabIndex={0} role="slider"
          aria-label={map ? `Where the colour map ${index ? "ends" : "begins"}` : `Colour point ${index + 1} of ${p.color.length}`} aria-valuemin={p.full.lo} aria-valuemax={p.full.hi} aria-valuenow={node[0]}
          aria-valuetext={`${formatNumber(node[0])} ${p.unit}: ${hexOfLinear(node.slice(1))}`} aria-disabled={p.disabled || undefined}
          onFocus={() => p.onSelect({ list: "color", index })} onKeyDown={(e) => key(e, { list: "color", index }, node)}
          onPointerDown={(e) => grab(e, { list: "color", index })} onDblClick={(e) => e.stopPropagation()}
        >
          <rect class="plot-hit" x={xOf(node[0]) - 12} y={BAR_TOP - 4} width={24} height={24} />
          <path class="plot-dot" d={`M${xOf(node[0])} ${BAR_TOP + BAR_HEIGHT - 5}l5 6v5h-10v-5z`} fill={hexOfLinear(node.slice(1))} />
        </g>
      ) : null)}
    </svg>
  );
}

function isSelected(selected: Selected, list: "opacity" | "color", index: number): boolean {
  return selected?.list === list && selected.index === index;
}

/** The curve through the columns of the drawing: straight in opacity is bent on an axis of square roots. */
function curvePoints(nodes: OpacityNode[], axis: Axis, width: number): [number, number][] {
  const n = Math.max(2, Math.round(width / 2));
  const points: [number, number][] = Array.from({ length: n + 1 }, (_, i) => {
    const value = axis.lo + ((axis.hi - axis.lo) * i) / n;
    return [value, sampleNodes(nodes, value)[0] ?? 0];
  });
  for (let i = 0; i < nodes.length; i++) {
    const [value, opacity] = nodes[i]!;
    if (value > axis.lo && value < axis.hi) points.push([value, opacity]);
  }
  // Stable: of two nodes at one value the first comes first, and the jump is upright.
  return points.map((point, i) => ({ point, i })).sort((a, b) => a.point[0] - b.point[0] || a.i - b.i).map(({ point }) => point);
}
