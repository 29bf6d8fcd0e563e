/** A transfer function moved and stretched along the axis of values, as slices have their window. */
import type { Edit, Transfer } from "../protocol";

export type Range = [number, number];

/** From the first to the last value of opacity and colour. */
export function rangeOf(transfer: Transfer): Range | null {
  const values = [...transfer.opacity, ...transfer.color].map((row) => row[0]!);
  const range: Range = [Math.min(...values), Math.max(...values)];
  return values.length && range[1] > range[0] ? range : null;
}

function moved(rows: number[][], [lo, hi]: Range, [to, end]: Range): number[][] {
  return rows.map(([value, ...rest]) => [Number((to + ((value! - lo) / (hi - lo)) * (end - to)).toPrecision(7)), ...rest]);
}

/** `path`: of the transfer. `fixed`: its colours are its own, not a map over the range. */
export function windowEdits(path: string, transfer: Transfer, from: Range, to: Range, fixed: boolean): Edit[] {
  const edits: Edit[] = [{ op: "set", path: `${path}.opacity`, value: moved(transfer.opacity, from, to) }];
  if (fixed) return [...edits, { op: "set", path: `${path}.color`, value: moved(transfer.color, from, to) }];
  const colors = transfer.color.map((row) => row[0]!);
  const [lo, hi] = moved([[Math.min(...colors)], [Math.max(...colors)]], from, to).map((row) => row[0]!);
  return [...edits, { op: "set", path: `${path}.range_lo`, value: lo! }, { op: "set", path: `${path}.range_hi`, value: hi! }];
}
