/** Sliders over what the data has: values from its least to its largest, cut planes from one side of it to the other. */
import type { Property } from "../protocol";
import * as store from "../store";
import { valueAt, type SliderScale } from "../values";

function vectorAt(path: string): number[] | null {
  const value = store.valueOf(path);
  return Array.isArray(value) && value.length === 3 ? value.map(Number) : null;
}

/** Half of the diagonal of the data that is shown; null where nothing is known of it yet. */
function halfDiagonal(): number | null {
  const volume = store.currentVolume.value;
  const info = volume ? store.dataInfos.value[store.datasetOf(volume) ?? ""] : undefined;
  if (!info || typeof info === "string") return null;
  const dims = info["dims"];
  const spacing = info["spacing"];
  if (!Array.isArray(dims) || !Array.isArray(spacing)) return null;
  return Math.hypot(...dims.map((n, i) => Number(n) * Number(spacing[i] ?? 1))) / 2;
}

/** Of values of the volume that is worked on: limits, iso values. */
export function valueScale(row: Property): SliderScale | null {
  const volume = store.currentVolume.value;
  const histogram = volume ? store.histograms.value[volume] : undefined;
  if (row.unit !== "value" || row.min != null || !histogram || typeof histogram === "string") return null;
  const lo = histogram.min ?? histogram.lo;
  const hi = histogram.max ?? histogram.hi;
  if (!(hi > lo)) return null;
  return { toShare: (value) => (value - lo) / (hi - lo), toValue: (share) => Number((lo + share * (hi - lo)).toPrecision(4)) };
}

const VOXELS_MOST = 10;

/** Of a length that an operation takes: up to ten voxels of the data. */
export function voxelScale(row: Property, path: string, isParameter: boolean): SliderScale | null {
  const volume = store.currentVolume.value;
  const info = volume ? store.dataInfos.value[store.datasetOf(volume) ?? ""] : undefined;
  const spacing = info && typeof info !== "string" && Array.isArray(info["spacing"]) ? info["spacing"].map(Number).filter((v) => v > 0) : [];
  if (row.quantity !== "length" || !spacing.length || !(isParameter || /^datasets\.[^.]+\.parameters\./.test(path))) return null;
  const most = VOXELS_MOST * Math.min(...spacing);
  return { toShare: (value) => value / most, toValue: (share) => Number((share * most).toPrecision(3)) };
}

/** From side to side along the plane's normal. The camera looks at the middle of what is shown, unless somebody made it look elsewhere. */
export function cutPlaneScale(path: string): SliderScale | null {
  if (!/(^|\.)cut_planes\.\d+\.offset$/.test(path)) return null;
  const half = halfDiagonal();
  const middle = vectorAt(`${store.viewPath.value}.camera.at`) ?? store.pose.value?.at ?? null;
  const normal = vectorAt(path.replace(/offset$/, "normal")) ?? [0, 0, 1];
  const length = Math.hypot(...normal);
  if (!half || !middle || !length) return null;
  const centre = middle.reduce((sum, v, i) => sum + (v * normal[i]!) / length, 0);
  const set = valueAt(store.world.value, path);
  const reach = Math.max(half, typeof set === "number" ? Math.abs(set - centre) : 0); // what is set lies on the slider
  return {
    toShare: (value) => (value - centre + reach) / (2 * reach),
    toValue: (share) => Number((centre + (2 * share - 1) * reach).toPrecision(4)),
  };
}
