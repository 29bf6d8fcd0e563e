/** What is known of the data that is shown: size, spacing, type, range, memory. */
import { useEffect } from "preact/hooks";
import type { Json, JsonObject } from "../protocol";
import { fetchHistogram, fetchInfo } from "../session";
import * as store from "../store";
import { formatBytes, formatNumber } from "../values";

function numbers(value: Json | undefined): number[] | null {
  return Array.isArray(value) && value.every((v) => typeof v === "number") ? (value as number[]) : null;
}

function spacingText(info: JsonObject): string | null {
  const spacing = numbers(info["spacing"]);
  const unit = typeof info["unit"] === "string" && info["unit"] ? info["unit"] : "voxels";
  return spacing && unit !== "voxels" ? `${spacing.map((v) => formatNumber(v, 3)).join(" × ")}${unit === "units" ? "" : ` ${unit}`}` : null;
}

function rows(info: JsonObject | null, volume: string): [string, string][] {
  const found: [string, string][] = [];
  const histogram = store.histograms.value[volume];
  const add = (name: string, text: string | null | undefined) => { if (text) found.push([name, text]); };
  if (info) {
    add("Size", numbers(info["dims"])?.join(" × "));
    add("Spacing", spacingText(info));
    add("Type", typeof info["type"] === "string" ? `${info["type"]}${Number(info["components"]) > 1 ? ` × ${String(info["components"])}` : ""}` : null);
    add("Axes", typeof info["orientation"] === "string" ? info["orientation"] : null);
  }
  if (histogram && typeof histogram !== "string")
    add("Values", `${formatNumber(histogram.min ?? histogram.lo)} to ${formatNumber(histogram.max ?? histogram.hi)} ${histogram.unit ?? ""}`);
  if (info && typeof info["memory_bytes"] === "number") add("Memory", formatBytes(info["memory_bytes"]));
  return found;
}

export function DataCard() {
  const volume = store.currentVolume.value;
  const dataset = volume ? store.datasetOf(volume) : null;
  const info = dataset ? store.dataInfos.value[dataset] : undefined;
  useEffect(() => {
    if (dataset) void fetchInfo(dataset);
    if (volume && !store.isMesh(volume)) void fetchHistogram(volume);
  }, [volume, dataset, info === undefined, volume ? store.histograms.value[volume] === undefined : false]);
  if (!volume || !dataset) return null;
  const all = rows(info && typeof info !== "string" ? info : null, volume);
  if (!all.length) return null;
  return (
    <section class="data-card" aria-label="Data">
      <h2>{dataset}</h2>
      <dl>
        {all.map(([name, text]) => (
          <div key={name}><dt>{name}</dt><dd title={text}>{text}</dd></div>
        ))}
      </dl>
    </section>
  );
}
