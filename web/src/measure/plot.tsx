/** A plot in the page: axes at round numbers, and what is under the pointer in words. */
import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { ticks } from "../transfer/curve";
import { formatNumber } from "../values";
import type { Curve, Density, Plot } from "./plots";
import { curvePath, densityLevel, indexAt, rangeOf, readout, stepsPath, type Frame } from "./plot_geometry";

const HEIGHT = 210;
const [LEFT, RIGHT, TOP, BOTTOM] = [54, 10, 10, 40];

function Axes({ f, xLabel, yLabel }: { f: Frame; xLabel: string; yLabel: string }) {
  const inner = f.right - f.left;
  return (
    <g aria-hidden="true">
      <rect class="plot-area" x={f.left} y={f.top} width={inner} height={f.bottom - f.top} />
      {ticks(f.y, 5).map((v) => (
        <g key={v}>
          <line class="plot-grid" x1={f.left} x2={f.right} y1={f.toY(v)} y2={f.toY(v)} />
          <text class="plot-tick" x={f.left - 5} y={f.toY(v) + 3.5} text-anchor="end">{formatNumber(v)}</text>
        </g>
      ))}
      {ticks(f.x, inner / 64).map((v) => (
        <g key={v}>
          <line class="plot-grid" x1={f.toX(v)} x2={f.toX(v)} y1={f.bottom} y2={f.bottom + 4} />
          <text class="plot-tick" x={f.toX(v)} y={f.bottom + 15} text-anchor="middle">{formatNumber(v)}</text>
        </g>
      ))}
      <text class="plot-name" x={(f.left + f.right) / 2} y={HEIGHT - 6} text-anchor="middle">{xLabel}</text>
      <text class="plot-name" transform={`translate(11 ${(f.top + f.bottom) / 2}) rotate(-90)`} text-anchor="middle">{yLabel}</text>
    </g>
  );
}

function frameOf(plot: Plot, width: number): Frame {
  const [x, y] = rangeOf(plot);
  const [left, right, top, bottom] = [LEFT, Math.max(LEFT + 40, width - RIGHT), TOP, HEIGHT - BOTTOM];
  return {
    left, right, top, bottom, x, y,
    toX: (v) => left + ((v - x.lo) / (x.hi - x.lo || 1)) * (right - left),
    toY: (v) => bottom - ((v - y.lo) / (y.hi - y.lo || 1)) * (bottom - top),
  };
}

function Line({ plot, f }: { plot: Curve; f: Frame }) {
  return plot.what === "steps"
    ? <path class="measure-steps" d={stepsPath(plot, f)} />
    : <path class="measure-curve" d={curvePath(plot, f)} />;
}

/** Counts by their logarithm, painted once for each answer. */
function Cells({ plot, f }: { plot: Density; f: Frame }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = canvas.current!.getContext("2d")!;
    const image = context.createImageData(plot.nx, plot.ny);
    const color = getComputedStyle(canvas.current!).color.match(/\d+/g)!.map(Number);
    const most = plot.counts.reduce((a, b) => Math.max(a, b), 0);
    plot.counts.forEach((n, i) => {
      const row = plot.ny - 1 - Math.floor(i / plot.nx);
      const at = 4 * (row * plot.nx + (i % plot.nx));
      image.data.set([color[0]!, color[1]!, color[2]!, Math.round(255 * densityLevel(n, most))], at);
    });
    context.putImageData(image, 0, 0);
  }, [plot]);
  return (
    <foreignObject x={f.left} y={f.top} width={f.right - f.left} height={f.bottom - f.top} aria-hidden="true">
      <canvas ref={canvas} class="measure-density" width={plot.nx} height={plot.ny} />
    </foreignObject>
  );
}

export function PlotView({ plot, title }: { plot: Plot; title: string }) {
  const element = useRef<SVGSVGElement>(null);
  const [width, setWidth] = useState(360);
  const [at, setAt] = useState<[number, number] | null>(null);
  useEffect(() => {
    const observer = new ResizeObserver(() => setWidth(element.current?.clientWidth || 360));
    observer.observe(element.current!);
    return () => observer.disconnect();
  }, []);
  const f = frameOf(plot, width);
  const n = plot.what === "density" ? plot.nx : plot.y.length;
  const move = (event: TargetedPointerEvent<SVGSVGElement>) => {
    const rect = element.current!.getBoundingClientRect();
    const [x, y] = [event.clientX - rect.left, event.clientY - rect.top];
    setAt(x < f.left || x > f.right || y < f.top || y > f.bottom ? null : [x, y]);
  };
  const key = (event: TargetedKeyboardEvent<SVGSVGElement>) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const from = at ? indexAt(plot, f, at[0]) : 0;
    const next = Math.max(0, Math.min(n - 1, from + by * (event.shiftKey ? 10 : 1)));
    const value = f.x.lo + ((f.x.hi - f.x.lo) * (plot.what === "curve" ? next / Math.max(1, n - 1) : (next + 0.5) / n));
    setAt([f.toX(value), at?.[1] ?? (f.top + f.bottom) / 2]);
  };
  const words = at ? readout(plot, f, ...at) : "";
  return (
    <figure class="measure-plot">
      <svg
        ref={element} width="100%" height={HEIGHT} viewBox={`0 0 ${width} ${HEIGHT}`} tabindex={0} role="img"
        aria-label={`${title}: ${plot.yLabel} by ${plot.xLabel}. Arrow keys read values.`} onPointerMove={move} onPointerLeave={() => setAt(null)} onKeyDown={key}
      >
        <Axes f={f} xLabel={plot.xLabel} yLabel={plot.yLabel} />
        {plot.what === "density" ? <Cells plot={plot} f={f} /> : <Line plot={plot} f={f} />}
        {at ? <line class="measure-cursor" x1={at[0]} x2={at[0]} y1={f.top} y2={f.bottom} aria-hidden="true" /> : null}
      </svg>
      <figcaption class="measure-readout"><span role="status">{words}</span></figcaption>
    </figure>
  );
}
