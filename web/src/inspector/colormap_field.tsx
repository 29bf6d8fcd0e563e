/** A colour map or a preset by name, with its colours under it. */
import { choosePreset } from "../actions";
import * as store from "../store";
import { ColorBar } from "../transfer/color_bar";
import { Select } from "../ui/controls";
import type { RowContext } from "./property_row";

export function ColormapField({ context: c }: { context: RowContext }) {
  const kind = c.row.name === "preset" ? "transfer" : "colormap";
  const names = (store.welcome.value?.presets ?? []).filter((preset) => (preset.kind === "proposal" ? "transfer" : preset.kind) === kind).map((preset) => preset.name);
  const value = typeof c.set === "string" ? c.set : "";
  const shown = typeof c.value === "string" ? c.value : "";
  const all = value && !names.includes(value) ? [value, ...names] : names;
  const colors = store.welcome.value?.colormaps[shown] ?? store.welcome.value?.presets.find((preset) => preset.name === shown)?.colors;
  const inTransfer = c.path.includes(".segmentation.transfer.");
  return (
    <span class="colormap-field">
      <Select
        id={c.id} value={value} disabled={c.disabled} invalid={!!c.error} describedBy={c.describedBy}
        options={[{ value: "", text: c.placeholder || "automatic" }, ...all.map((name) => ({ value: name, text: name }))]}
        onChange={(name) => (name === "" ? c.commit(undefined) : inTransfer ? choosePreset(name) : c.commit(name))}
      />
      {colors ? <ColorBar colors={colors} /> : null}
    </span>
  );
}
