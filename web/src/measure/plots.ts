/** What answers have to be plotted: curves, steps, and counts in a plane; and the same as comma-separated values. */
import type { Json, JsonObject } from "../protocol";
import { isObject } from "../values";
import { csvOf } from "./rows";

export interface Curve {
  what: "curve" | "steps";
  /** Of steps, their edges: one more than heights. */
  x: number[];
  y: (number | null)[];
  xLabel: string;
  yLabel: string;
}

export interface Density {
  what: "density";
  x: [number, number];
  y: [number, number];
  nx: number;
  ny: number;
  /** Rows from the lowest y up. */
  counts: number[];
  xLabel: string;
  yLabel: string;
}

export type Plot = Curve | Density;

const text = (value: Json | undefined): string => (typeof value === "string" ? value : "");
const withUnit = (name: string, unit: string): string => (unit ? `${name}, ${unit}` : name);

/** Null: there is nothing to plot. */
export function plotOf(answer: JsonObject): Plot | null {
  const { profile, histogram, joint } = answer;
  const valueLabel = withUnit("Value", text(answer["value_unit"]));
  if (Array.isArray(profile) && profile.length) {
    const rows = profile as [number, number | null][];
    return { what: "curve", x: rows.map((row) => row[0]), y: rows.map((row) => row[1]), xLabel: withUnit("Distance", text(answer["unit"])), yLabel: valueLabel };
  }
  if (isObject(histogram) && Array.isArray(histogram["counts"])) {
    const counts = histogram["counts"] as number[];
    const [lo, hi] = [Number(histogram["lo"]), Number(histogram["hi"])];
    return { what: "steps", x: Array.from({ length: counts.length + 1 }, (_, i) => lo + ((hi - lo) * i) / counts.length), y: counts, xLabel: valueLabel, yLabel: "Samples" };
  }
  if (isObject(joint) && Array.isArray(joint["counts"]))
    return {
      what: "density", x: joint["values"] as [number, number], y: joint["gradients"] as [number, number], nx: Number(joint["n_values"]), ny: Number(joint["n_gradients"]),
      counts: (joint["counts"] as Json[]).flat() as number[], xLabel: withUnit("Value", text(joint["value_unit"])), yLabel: withUnit("Gradient", text(joint["gradient_unit"])),
    };
  return null;
}

/** The head of a column, with its unit. */
const head = (name: string, unit: Json | undefined): string => (text(unit) ? `${name} [${text(unit)}]` : name);

/** What is plotted as numbers, or the table of an answer. */
export function csvOfAnswer(answer: JsonObject): string | null {
  const plot = plotOf(answer);
  const value = answer["value_unit"];
  if (plot?.what === "curve") {
    const errors = answer["profile_error"] as (number | null)[] | undefined;
    return csvOf([head("distance", answer["unit"]), head("value", value), head("error", value)], plot.x.map((x, i) => [x, plot.y[i], [errors?.[i]].flat()[0]]));
  }
  if (plot?.what === "steps") return csvOf([head("from", value), head("to", value), "count"], plot.y.map((n, i) => [plot.x[i], plot.x[i + 1], n]));
  if (plot?.what === "density") {
    const at = ([lo, hi]: [number, number], i: number, n: number) => lo + ((hi - lo) * i) / n;
    const { value_unit, gradient_unit } = answer["joint"] as JsonObject;
    return csvOf([head("value_from", value_unit), head("value_to", value_unit), head("gradient_from", gradient_unit), head("gradient_to", gradient_unit), "count"], plot.counts.flatMap((n, i) => {
      const [ix, iy] = [i % plot.nx, Math.floor(i / plot.nx)];
      return n ? [[at(plot.x, ix, plot.nx), at(plot.x, ix + 1, plot.nx), at(plot.y, iy, plot.ny), at(plot.y, iy + 1, plot.ny), n]] : [];
    }));
  }
  const labels = labelRows(answer);
  return labels && csvOf(labels.head, labels.rows);
}

/** The table of labels: places become three columns. */
export function labelRows(answer: JsonObject): { head: string[]; rows: (string | number | null)[][] } | null {
  const labels = answer["labels"];
  if (!Array.isArray(labels) || !labels.length) return null;
  const flat = labels.filter(isObject).map((label) => Object.entries(label).flatMap(([name, value]): [string, string | number | null][] =>
    Array.isArray(value) ? value.map((v, i) => [`${name}_${"xyz"[i] ?? i}`, v as number]) : [[name, value as string | number | null]]));
  const head = [...new Set(flat.flatMap((row) => row.map(([name]) => name)))];
  return { head, rows: flat.map((row) => { const by = new Map(row); return head.map((name) => by.get(name) ?? null); }) };
}
