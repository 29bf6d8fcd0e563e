/**
 * Presets as small pictures of the data with them, and their colours: what is worked out from the data first, then those
 * that are for data of this kind.
 */
import { useEffect } from "preact/hooks";
import { choosePreset } from "../actions";
import type { Preset } from "../protocol";
import * as store from "../store";
import { label } from "../values";
import { ColorBar } from "./color_bar";
import { fetchProposals, proposalColors, proposals, THUMBNAIL, thumbnailKey, thumbnails, useThumbnails } from "./thumbnails";

function fits(preset: Preset, unit: string): boolean {
  return preset.kind === "colormap" || !preset.unit || preset.unit === unit;
}

interface ListProps {
  volume: string;
  name: string;
  presets: Preset[];
  chosen: string;
}

function Presets({ volume, name, presets, chosen }: ListProps) {
  return (
    <ul class="presets" aria-label={name}>
      {presets.map((preset) => {
        const proposal = proposals.value[volume]?.find((row) => row.name === preset.name);
        const colors = preset.colors ?? (proposal ? proposalColors(proposal) : store.welcome.value?.colormaps[preset.name]);
        const picture = thumbnails.value[thumbnailKey(volume, preset.name)];
        return (
          <li key={preset.name}>
            <button type="button" class="preset" aria-pressed={chosen === preset.name} title={preset.doc} disabled={store.readOnly.value} onClick={() => choosePreset(preset.name)}>
              {picture ? <img class="preset-picture" src={picture} alt="" {...THUMBNAIL} /> : <span class="preset-picture preset-blank" />}
              {colors ? <ColorBar colors={colors} curve={preset.kind !== "colormap"} /> : <span class="color-bar" />}
              <span class="preset-name">{label(preset.name)}</span>
            </button>
          </li>
        );
      })}
    </ul>
  );
}

export function PresetList({ kind, volume }: { kind: "transfer" | "colormap"; volume: string }) {
  const histogram = store.histograms.value[volume];
  const unit = histogram && typeof histogram !== "string" ? (histogram.unit ?? "") : "";
  const path = `volumes.${volume}.segmentation.transfer`;
  const set = store.valueOf(`${path}.${kind === "transfer" ? "preset" : "colormap"}`);
  const fitted = kind === "transfer" && set === undefined && !store.isSet(`${path}.opacity`);
  const chosen = typeof set === "string" ? set : fitted ? "fitted" : "";
  const all = store.welcome.value?.presets ?? [];
  const worked = kind === "transfer" ? all.filter((preset) => preset.kind === "proposal") : [];
  const named = all.filter((preset) => preset.kind === kind && fits(preset, unit));
  useThumbnails(volume, [...worked, ...named].map((preset) => preset.name));
  useEffect(() => { if (worked.length) void fetchProposals(volume); }, [volume, histogram, worked.length]);
  if (!worked.length) return <Presets volume={volume} name={kind === "transfer" ? "Presets" : "Colour maps"} presets={named} chosen={chosen} />;
  return (
    <>
      <h3 class="presets-title">Computed from these data</h3>
      <Presets volume={volume} name="Proposals" presets={worked} chosen={chosen} />
      <h3 class="presets-title">Named</h3>
      <Presets volume={volume} name="Presets" presets={named} chosen={chosen} />
    </>
  );
}
