/** Transfer functions as numbers: piecewise linear opacity and colour by value, and the axes they are drawn on. */

/** (value, opacity for one opacity length), by ascending value. */
export type OpacityNode = [number, number];
/** (value, red, green, blue), linear, by ascending value. */
export type ColorNode = [number, number, number, number];

/** Two nodes at one value make a jump: the later one holds from there on. */
export function sampleNodes(nodes: readonly (readonly number[])[], value: number): number[] {
  const n = nodes.length;
  if (n === 0) return [];
  if (value < nodes[0]![0]!) return nodes[0]!.slice(1);
  for (let i = n - 1; i >= 0; i--) {
    const a = nodes[i]!;
    if (value < a[0]!) continue;
    const b = nodes[i + 1];
    if (!b || b[0] === a[0]) return a.slice(1);
    const t = (value - a[0]!) / (b[0]! - a[0]!);
    return a.slice(1).map((v, k) => v + t * (b[k + 1]! - v));
  }
  return nodes[0]!.slice(1);
}

/** Moves a node, not past its neighbours; opacity stays in 0 to 1. */
export function moveNode(nodes: readonly OpacityNode[], index: number, value: number, opacity: number): OpacityNode[] {
  const lo = nodes[index - 1]?.[0] ?? -Infinity;
  const hi = nodes[index + 1]?.[0] ?? Infinity;
  const moved: OpacityNode = [Math.min(hi, Math.max(lo, tidy(value))), tidy(Math.min(1, Math.max(0, opacity)))];
  return nodes.map((node, i) => (i === index ? moved : node));
}

/** Moves a node of any kind along the axis alone. */
export function moveAlong<T extends readonly number[]>(nodes: readonly T[], index: number, value: number): T[] {
  const lo = nodes[index - 1]?.[0] ?? -Infinity;
  const hi = nodes[index + 1]?.[0] ?? Infinity;
  return nodes.map((node, i) => (i === index ? ([Math.min(hi, Math.max(lo, tidy(value))), ...node.slice(1)] as unknown as T) : node));
}

/** With a node more; where it went. */
export function insertNode<T extends readonly number[]>(nodes: readonly T[], node: T): { nodes: T[]; index: number } {
  const at = nodes.findIndex((other) => other[0]! > node[0]!);
  const index = at < 0 ? nodes.length : at;
  return { nodes: [...nodes.slice(0, index), node, ...nodes.slice(index)], index };
}

/** More colours than these are a map: it is moved by its two ends, not node by node. */
export const POINTS_MOST = 16;

export function isMap(nodes: readonly unknown[]): boolean {
  return nodes.length > POINTS_MOST;
}

/** Moves the first or the last node, and all between in proportion. */
export function moveEnd<T extends readonly number[]>(nodes: readonly T[], index: number, value: number): T[] {
  const [lo, hi] = [nodes[0]![0]!, nodes.at(-1)![0]!];
  const least = (hi - lo) / 1000 || 1e-6;
  const [from, to] = index === 0 ? [Math.min(value, hi - least), hi] : [lo, Math.max(value, lo + least)];
  return nodes.map((node) => [tidy(from + ((node[0]! - lo) / (hi - lo || 1)) * (to - from)), ...node.slice(1)] as unknown as T);
}

/** At most n of the nodes, those without which it would be most another one. */
export function thin<T extends readonly number[]>(nodes: readonly T[], n: number): T[] {
  let kept = nodes.length > 2 ? [nodes[0]!, nodes.at(-1)!] : [...nodes];
  while (kept.length < Math.min(n, nodes.length)) {
    const off = nodes.map((node) => Math.max(...sampleNodes(kept, node[0]!).map((v, i) => Math.abs(v - node[i + 1]!))));
    const most = Math.max(...off);
    if (!(most > 0.005)) break;
    const added = nodes[off.indexOf(most)]!;
    kept = nodes.filter((node) => node === added || kept.includes(node));
  }
  return kept;
}

export function removeNode<T>(nodes: readonly T[], index: number): T[] {
  return nodes.filter((_, i) => i !== index);
}

/** Numbers that people read: six significant digits. */
export function tidy(value: number): number {
  return Number(value.toPrecision(6));
}

/** What part of the value axis is seen. */
export interface Axis {
  lo: number;
  hi: number;
}

export function fullAxis(lo: number, hi: number, nodes: readonly (readonly number[])[]): Axis {
  const values = nodes.map((node) => node[0]!);
  const all = { lo: Math.min(lo, ...values), hi: Math.max(hi, ...values) };
  return all.hi > all.lo ? all : { lo: all.lo - 0.5, hi: all.lo + 0.5 };
}

/** Nearer to a value (factor below 1) or farther from it, never beyond the whole. */
export function zoomAxis(axis: Axis, full: Axis, about: number, factor: number): Axis {
  const whole = full.hi - full.lo;
  const width = Math.min(whole, Math.max(whole / 1000, (axis.hi - axis.lo) * factor));
  const share = (about - axis.lo) / (axis.hi - axis.lo);
  return clampAxis({ lo: about - share * width, hi: about + (1 - share) * width }, full);
}

export function clampAxis(axis: Axis, full: Axis): Axis {
  const width = Math.min(axis.hi - axis.lo, full.hi - full.lo);
  const lo = Math.min(full.hi - width, Math.max(full.lo, axis.lo));
  return { lo, hi: lo + width };
}

/**
 * Heights of opacities: by the square root, so that 0.01 of a length, which decides whether fog is seen, has a place
 * of its own beside 1.
 */
export function opacityHeight(opacity: number): number {
  return Math.sqrt(Math.min(1, Math.max(0, opacity)));
}

export function heightOpacity(height: number): number {
  const share = Math.min(1, Math.max(0, height));
  return share * share;
}

/** Heights of histogram bars, 0 to 1, joined to n columns over the axis; the largest count in a column is its height. */
export function columns(counts: readonly number[], lo: number, hi: number, axis: Axis, n: number, log: boolean): number[] {
  const found = new Array<number>(n).fill(0);
  const bins = counts.length;
  if (!bins || !(hi > lo)) return found;
  for (let c = 0; c < n; c++) {
    const from = axis.lo + ((axis.hi - axis.lo) * c) / n;
    const to = axis.lo + ((axis.hi - axis.lo) * (c + 1)) / n;
    if (to < lo || from > hi) continue;
    const first = Math.max(0, Math.floor(((from - lo) / (hi - lo)) * bins));
    const last = Math.min(bins - 1, Math.max(first, Math.ceil(((to - lo) / (hi - lo)) * bins) - 1));
    for (let b = first; b <= last; b++) found[c] = Math.max(found[c]!, counts[b]!);
  }
  // Air or padding, in one bin, must not flatten all others: linear heights are cut at the second largest column.
  const sorted = [...counts].sort((a, b) => b - a);
  const top = log ? Math.log1p(sorted[0]!) : (sorted[Math.min(2, sorted.length - 1)] ?? 1) || sorted[0]!;
  return found.map((count) => (top > 0 ? Math.min(1, (log ? Math.log1p(count) : count) / top) : 0));
}

/** Round values for the ticks of an axis, about n of them. */
export function ticks(axis: Axis, n: number): number[] {
  const raw = (axis.hi - axis.lo) / Math.max(1, n);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw) ?? raw;
  const found: number[] = [];
  for (let i = Math.ceil(axis.lo / step); i * step <= axis.hi + step * 1e-9; i++) found.push(tidy(i * step));
  return found;
}
