/** From what is plotted to places of a drawing, and back to words. */
import { formatNumber } from "../values";
import type { Curve, Plot } from "./plots";

export interface Range {
  lo: number;
  hi: number;
}

export interface Frame {
  left: number;
  right: number;
  top: number;
  bottom: number;
  x: Range;
  y: Range;
  toX(value: number): number;
  toY(value: number): number;
}

const ROOM = 0.04; // above and below a curve

/** Of both axes. Counts begin at 0. */
export function rangeOf(plot: Plot): [Range, Range] {
  if (plot.what === "density") return [{ lo: plot.x[0], hi: plot.x[1] }, { lo: plot.y[0], hi: plot.y[1] }];
  const x = { lo: plot.x[0] ?? 0, hi: plot.x[plot.x.length - 1] ?? 1 };
  const values = plot.y.filter((v): v is number => typeof v === "number" && Number.isFinite(v));
  let lo = values.reduce((a, b) => Math.min(a, b), Infinity);
  let hi = values.reduce((a, b) => Math.max(a, b), -Infinity);
  if (!(hi >= lo)) [lo, hi] = [0, 1];
  if (plot.what === "steps") return [x, { lo: 0, hi: hi > 0 ? hi * (1 + ROOM) : 1 }];
  const room = (hi - lo || Math.abs(hi) || 1) * ROOM;
  return [x.hi > x.lo ? x : { lo: x.lo, hi: x.lo + 1 }, { lo: lo - room, hi: hi + room }];
}

const at = (x: number, y: number): string => `${x.toFixed(1)} ${y.toFixed(1)}`;

/** Gaps where there is no value. */
export function curvePath(plot: Curve, f: Frame): string {
  let pen = "M";
  let path = "";
  plot.y.forEach((y, i) => {
    if (y === null) {
      pen = "M";
      return;
    }
    path += `${pen}${at(f.toX(plot.x[i]!), f.toY(y))}`;
    pen = "L";
  });
  return path;
}

/** Columns of the drawing: of the bins in one, the highest, so that no peak is lost. */
export function stepsPath(plot: Curve, f: Frame): string {
  const columns = new Map<number, number>();
  plot.y.forEach((y, i) => {
    const [from, to] = [f.toX(plot.x[i]!), f.toX(plot.x[i + 1]!)].map((v) => Math.round(v * 2) / 2) as [number, number];
    for (let x = from; x < Math.max(to, from + 0.5); x += 0.5) columns.set(x, Math.max(columns.get(x) ?? 0, y ?? 0));
  });
  const path = [...columns].sort((a, b) => a[0] - b[0]).map(([x, y]) => `V${f.toY(y).toFixed(1)}H${(x + 0.5).toFixed(1)}`);
  return `M${at(f.left, f.bottom)}${path.join("")}V${f.bottom.toFixed(1)}Z`;
}

/** From 0 to 1, by the logarithm; what occurs once is seen. */
export function densityLevel(count: number, most: number): number {
  return count > 0 ? 0.12 + (0.88 * Math.log(count)) / Math.log(Math.max(most, 2)) : 0;
}

/** Number of the sample or bin at a place. */
export function indexAt(plot: Plot, f: Frame, x: number): number {
  const n = plot.what === "density" ? plot.nx : plot.y.length;
  const share = (x - f.left) / (f.right - f.left);
  const index = plot.what === "curve" ? Math.round(share * (n - 1)) : Math.floor(share * n);
  return Math.max(0, Math.min(n - 1, index));
}

/** "Distance 12.5, value 143". */
export function readout(plot: Plot, f: Frame, x: number, y: number): string {
  const i = indexAt(plot, f, x);
  const name = (label: string) => label.split(",")[0]!;
  const unit = (label: string) => (label.includes(", ") ? ` ${label.slice(label.indexOf(", ") + 2)}` : "");
  const say = (label: string, value: string) => `${name(label)} ${value}${unit(label)}`;
  if (plot.what === "density") {
    const j = Math.max(0, Math.min(plot.ny - 1, Math.floor(((f.bottom - y) / (f.bottom - f.top)) * plot.ny)));
    const middle = ([lo, hi]: [number, number], k: number, n: number) => formatNumber(lo + ((hi - lo) * (k + 0.5)) / n);
    return `${say(plot.xLabel, middle(plot.x, i, plot.nx))} · ${name(plot.yLabel)} ${middle(plot.y, j, plot.ny)} · ${plot.counts[j * plot.nx + i] ?? 0} samples`;
  }
  if (plot.what === "curve") return `${say(plot.xLabel, formatNumber(plot.x[i]!))} · ${say(plot.yLabel, plot.y[i] == null ? "none" : formatNumber(plot.y[i]!))}`;
  return `${say(plot.xLabel, `${formatNumber(plot.x[i]!)} to ${formatNumber(plot.x[i + 1]!)}`)} · ${plot.y[i]} samples`;
}
