/** Presets as thumbnails of their colours; first those that are for data of this kind. */
import { choosePreset } from "../actions";
import type { Preset } from "../protocol";
import * as store from "../store";
import { label } from "../values";
import { ColorBar } from "./color_bar";

function fits(preset: Preset, unit: string): boolean {
  return preset.kind === "colormap" || !preset.unit || preset.unit === unit;
}

export function PresetList({ kind, volume }: { kind: "transfer" | "colormap"; volume: string }) {
  const histogram = store.histograms.value[volume];
  const unit = histogram && typeof histogram !== "string" ? (histogram.unit ?? "") : "";
  const path = `volumes.${volume}.segmentation.transfer.${kind === "transfer" ? "preset" : "colormap"}`;
  const chosen = store.valueOf(path);
  const presets = (store.welcome.value?.presets ?? []).filter((preset) => preset.kind === kind && fits(preset, unit));
  return (
    <ul class="presets" aria-label={kind === "transfer" ? "Presets" : "Colour maps"}>
      {presets.map((preset) => {
        const colors = preset.colors ?? store.welcome.value?.colormaps[preset.name];
        return (
          <li key={preset.name}>
            <button type="button" class="preset" aria-pressed={chosen === preset.name} title={preset.doc} disabled={store.readOnly.value} onClick={() => choosePreset(preset.name)}>
              {colors ? <ColorBar colors={colors} curve={kind === "transfer"} /> : <span class="preset-blank" />}
              <span class="preset-name">{label(preset.name)}</span>
            </button>
          </li>
        );
      })}
    </ul>
  );
}
