/** The table of measurements: what stands in its rows, their order, and all of it as comma-separated values. */
import type { Json, JsonObject } from "../protocol";
import type { Vec3 } from "../slices/geometry";
import { isObject, titleOf } from "../values";

export interface Figure {
  name: string;
  value?: number;
  error?: number;
  unit?: string;
  /** Of a length along a surface: the path, in the measurement's space. */
  path?: Vec3[];
}

export interface Row {
  id: string;
  title: string;
  kind: string;
  /** The name of the figure that stands for its kind. */
  main: string;
  /** The volume that it is of, in the World's words. */
  of: string;
  /** Of a series: which time step. */
  step: number | undefined;
  visible: boolean;
  figures: Figure[];
  /** Why it has none. */
  error: string;
  busy: boolean;
  /** What is stored is not what comes out now. */
  changed: boolean;
}

export type Column = "title" | "kind" | "of" | "value" | "error";
export interface Order {
  by: Column;
  down: boolean;
}

export function figuresOf(value: Json | undefined): Figure[] {
  return Array.isArray(value) ? value.filter((row) => isObject(row) && typeof row["name"] === "string").map((row) => row as unknown as Figure) : [];
}

/** The one that stands in the table. */
export function mainFigure(row: Pick<Row, "figures" | "main">): Figure | null {
  return row.figures.find((figure) => figure.name === row.main) ?? row.figures[0] ?? null;
}

const ROUNDING = 1e-9;

/** b: what is kept; that of older versions does not say its time step. */
export function isSame(a: Figure[], b: Figure[]): boolean {
  if (stepOf(b) === undefined && stepOf(a) !== undefined) return isSame(a.filter((figure) => figure.name !== "time_step"), b);
  return a.length === b.length && a.every((row, i) => {
    const [x, y] = [row.value, b[i]!.value];
    return row.name === b[i]!.name && (x === y || Math.abs((x ?? NaN) - (y ?? NaN)) <= ROUNDING * Math.max(Math.abs(x ?? 0), Math.abs(y ?? 0)));
  });
}

export function rowOf(id: string, stored: Json | undefined, now: { figures: Figure[] | null; error: string; busy: boolean }, of: string, main: (kind: string) => string): Row {
  const object: JsonObject = isObject(stored) ? stored : {};
  const kept = figuresOf(object["figures"]);
  const what = String(object["what"] ?? "summary");
  const points = object["points"];
  const figures = now.figures ?? (now.error ? [] : kept);
  const step = stepOf(figures);
  const kind = what === "distance" && Array.isArray(points) && points.length > 2 ? "polyline" : what; // as its tool is called
  return {
    id, title: titleOf(object, id), kind, main: main(what), of, step, visible: object["visible"] !== false,
    figures, error: now.error, busy: now.busy, changed: now.figures !== null && kept.length > 0 && !isSame(now.figures, kept),
  };
}

/** Which time step of a series was measured. */
const stepOf = (figures: Figure[]): number | undefined => figures.find((figure) => figure.name === "time_step")?.value;

/** "heart, step 3". */
export function ofText({ of, step }: Row): string {
  return step === undefined ? of : `${of}, step ${step}`;
}

function keyOf(row: Row, by: Column): string | number {
  const figure = mainFigure(row);
  if (by === "of") return ofText(row);
  if (by === "value" || by === "error") return figure?.[by] ?? NaN;
  return row[by];
}

/** What has no value comes last either way; equal ones stay in their order. */
export function sorted(rows: Row[], order: Order | null): Row[] {
  if (!order) return rows;
  const sign = order.down ? -1 : 1;
  return rows.map((row, i) => ({ row, i, key: keyOf(row, order.by) })).sort((a, b) => {
    if (typeof a.key === "number" && typeof b.key === "number") {
      const [none, other] = [Number.isNaN(a.key), Number.isNaN(b.key)];
      return none || other ? Number(none) - Number(other) || a.i - b.i : sign * (a.key - b.key) || a.i - b.i;
    }
    return sign * String(a.key).localeCompare(String(b.key), "en", { numeric: true }) || a.i - b.i;
  }).map(({ row }) => row);
}

/** A field as RFC 4180 has it; what a spreadsheet would take for a formula is told as text. */
export function csvField(value: string | number | null | undefined): string {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
  const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : value;
  return /[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
}

export function csvOf(head: string[], rows: (string | number | null | undefined)[][]): string {
  return [head, ...rows].map((row) => `${row.map(csvField).join(",")}\r\n`).join("");
}

/** A line for each figure, with all digits. */
export function csvOfRows(rows: Row[]): string {
  return csvOf(["name", "kind", "of", "quantity", "value", "error", "unit"],
    rows.flatMap((row) => row.figures.map((f) => [row.title, row.kind, ofText(row), f.name, f.value, f.error, f.unit])));
}
