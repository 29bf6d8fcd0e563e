/** What an operation begins with in the panel, where it cannot do without: so that its preview shows something at once. */
import type { Histogram, Json, JsonObject } from "../protocol";
import { formatNumber } from "../values";

/** What is known of the data that it works on; histogram: null where it is of other data, or not there. */
export interface Known {
  histogram: Histogram | null;
  crossHair: [number, number, number] | null;
  /** Letters of its axes: "RAS". */
  orientation: string;
}

/** The value that parts a histogram in two classes that differ least within themselves (Otsu 1979). */
export function otsu({ lo, hi, counts }: Histogram): number {
  const total = counts.reduce((sum, n) => sum + n, 0);
  const moment = counts.reduce((sum, n, i) => sum + n * i, 0);
  let below = 0;
  let momentBelow = 0;
  let best = { between: -1, at: 0 };
  counts.forEach((n, i) => {
    below += n;
    momentBelow += n * i;
    if (below === 0 || below === total) return;
    const between = (moment * below - momentBelow * total) ** 2 / (below * (total - below));
    if (between > best.between) best = { between, at: i + 1 };
  });
  return lo + ((hi - lo) * best.at) / counts.length;
}

const percentiles = ({ percentiles: p }: Histogram) => `${formatNumber(p["1"]!)}..${formatNumber(p["99"]!)}`;

/** By operation: the parameters, or null where too little is known. */
const STARTS: { [operation: string]: (of: Known) => { [parameter: string]: Json } | null } = {
  threshold: ({ histogram }) => histogram && { range: `${formatNumber(otsu(histogram))}..` },
  clamp: ({ histogram }) => histogram && { range: percentiles(histogram) },
  grow: ({ crossHair }) => crossHair && { seed: crossHair.map((v) => Number(v.toPrecision(6))), space: "world" },
  calc: () => ({ formula: "a" }),
  reorient: ({ orientation }) => (/^[RLAPIS]{3}$/.test(orientation) ? null : { order: "zyx" }),
};

export function startOf(operation: string, of: Known): JsonObject {
  return STARTS[operation]?.(of) ?? {};
}
