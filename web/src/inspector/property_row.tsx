/** One property: its name, a control of its kind, and the way back to its default. */
import { useEffect, useRef, useState } from "preact/hooks";
import { focusProperty } from "../actions";
import { hexOf } from "../colors";
import type { Json, Property } from "../protocol";
import { edit, Gesture } from "../session";
import * as store from "../store";
import { IconButton, NumberField, Select, Slider, Switch, TextField, useTyped } from "../ui/controls";
import { flawOf, formatNumber, labelOf, parseEntry, parseLabel, parseRow, sliderScale, tipOf, titleOf, unitOf, valueAt } from "../values";
import { ColormapField } from "./colormap_field";
import { cutPlaneScale, valueScale, voxelScale } from "./data_scales";
import type { ParameterStore } from "./properties";

interface RowContext {
  id: string;
  path: string;
  row: Property;
  /** What somebody set; undefined: nothing. */
  set: Json | undefined;
  /** Set, worked out, or default. */
  value: Json | undefined;
  placeholder: string;
  unit: string;
  disabled: boolean;
  /** Whether the page knows what a switch is while nothing is set. */
  isKnown: boolean;
  /** Of an operation that has not run. */
  isParameter: boolean;
  error: string;
  describedBy: string;
  commit(value: Json | undefined): void;
  /** Changes of a drag: begin, change..., end. */
  begin(): void;
  drag(value: Json): void;
  end(): void;
}

/** What a control shows while nothing is set. */
function automaticText(row: Property, worked: Json | undefined, unit: string): string {
  if (typeof worked === "number") return `automatic: ${formatNumber(worked)}${unit ? ` ${unit}` : ""}`;
  if (typeof worked === "string") return `automatic: ${worked}`;
  if (row.automatic) return row.kind === "string" || row.kind === "number" || row.kind === "integer" || row.kind === "numbers" ? row.automatic : "automatic";
  if (typeof row.default === "number") return formatNumber(row.default);
  return typeof row.default === "string" ? row.default : "";
}

/** A switch that is "on with lighting cinematic": whether it is now; undefined: that is not known here. */
function automaticSwitch(row: Property, path: string): boolean | undefined {
  const [, name, value] = /^on with (\w+) (\w+)$/.exec(row.kind === "bool" ? row.automatic ?? "" : "") ?? [];
  return name ? store.valueOf(path.replace(/\w+$/, name)) === value : undefined;
}

export function PropertyRow({ path, row, base }: { path: string; row: Property; base?: ParameterStore }) {
  const [error, setError] = useState("");
  const gesture = useRef<Gesture | null>(null);
  const element = useRef<HTMLDivElement>(null);
  const set = base ? base.get(path) : valueAt(store.world.value, path);
  const worked = base ? undefined : valueAt(store.resolved.value, path) ?? automaticSwitch(row, path);
  const volume = store.currentVolume.value;
  const histogram = volume ? store.histograms.value[volume] : undefined;
  const unit = unitOf(row, store.lengthUnit.value, histogram && typeof histogram !== "string" ? (histogram.unit ?? "") : "");
  const id = `p-${path}`;

  useEffect(() => {
    if (focusProperty.value !== path) return;
    focusProperty.value = "";
    element.current?.scrollIntoView({ block: "center" });
    element.current?.querySelector<HTMLElement>("input, select, button, textarea")?.focus();
  }, [focusProperty.value]);

  const commit = (value: Json | undefined) => {
    const flaw = flawOf(value, row.kind);
    setError(flaw);
    if (flaw) return;
    if (base) {
      base.set(path, value);
      return;
    }
    if (value === undefined && set === undefined) return;
    edit(value === undefined ? { op: "unset", path } : { op: "set", path, value }).catch((e: Error) => setError(e.message));
  };
  const context: RowContext = {
    id, path, row, set, value: set ?? worked ?? (row.automatic ? undefined : row.default), unit, error, commit,
    placeholder: automaticText(row, worked, unit),
    isKnown: automaticSwitch(row, path) !== undefined,
    disabled: !base && store.readOnly.value,
    isParameter: base !== undefined,
    describedBy: error ? `${id}-error` : `${id}-doc`,
    begin: () => { gesture.current ??= new Gesture(setError); },
    drag: (value) => {
      setError("");
      if (base) base.set(path, value);
      else (gesture.current ??= new Gesture(setError)).change({ op: "set", path, value });
    },
    end: () => { gesture.current = null; },
  };

  return (
    <div ref={element} class={`row row-${row.kind} ${set !== undefined ? "row-set" : ""}`}>
      <label class="row-label" id={`${id}-label`} for={id} title={tipOf(row)}>{labelOf(row)}</label>
      <div class="row-control"><Control {...context} /></div>
      <span class="row-reset">
        {set !== undefined && !context.disabled
          ? <IconButton icon="reset" label={`${labelOf(row)}: back to ${row.automatic ? "automatic" : "the default"}`} onClick={() => commit(undefined)} /> : null}
      </span>
      <span class="hidden" id={`${id}-doc`}>{tipOf(row)}</span>
      {error ? <p class="row-error" id={`${id}-error`} role="alert">{error}</p> : null}
    </div>
  );
}

function Control(c: RowContext) {
  const { row } = c;
  switch (row.kind) {
    case "bool":
      if (row.automatic && !c.isKnown) return <SwitchChoice {...c} />;
      return <Switch id={c.id} on={c.value === true} disabled={c.disabled} describedBy={c.describedBy} onChange={(on) => c.commit(on)} />;
    case "integer":
    case "number":
      return <NumberControl {...c} />;
    case "enum":
      return <Choice {...c} names={row.names ?? []} />;
    case "reference":
      return <Choice {...c} names={store.idsOf(row.ref_to ?? "")} text={(id) => titleOf(valueAt(store.world.value, `${row.ref_to}.${id}`), id)} />;
    case "vector":
      return <VectorControl {...c} />;
    case "color":
      return <ColorControl {...c} />;
    case "numbers":
      return <NumbersControl {...c} />;
    default:
      return <StringControl {...c} />;
  }
}

function stepOf(row: Property, value: number): number {
  if (row.kind === "integer") return 1;
  if (row.quantity === "angle") return 1;
  return value === 0 ? 0.1 : 10 ** Math.floor(Math.log10(Math.abs(value)) - 1);
}

function NumberControl(c: RowContext) {
  const lengths = voxelScale(c.row, c.path, c.isParameter);
  const scale = sliderScale(c.row) ?? cutPlaneScale(c.path) ?? valueScale(c.row) ?? lengths;
  const typed = typeof c.set === "string" && c.unit !== "" && c.set.endsWith(c.unit) ? parseFloat(c.set) : NaN; // "3mm"
  const value = typeof c.value === "number" ? c.value : Number.isFinite(typed) ? typed : null;
  const labelled = c.row.quantity === "label";
  const shown = typeof c.set === "number" ? c.set : c.row.automatic ? null : value;
  // text: a label of many digits, or a length with its unit in what data are made with
  const own = typeof c.set === "string" ? c.set : labelled && shown !== null ? String(shown) : shown;
  const field = (
    <NumberField
      id={c.id} value={own} placeholder={scale && value !== null ? formatNumber(value) : c.placeholder} unit={typeof own === "number" || labelled ? c.unit : ""} step={stepOf(c.row, value ?? 0)} disabled={c.disabled}
      invalid={!!c.error} describedBy={c.describedBy} onCommit={(text) => c.commit(labelled ? parseLabel(text) : parseEntry(text))}
    />
  );
  if (!scale || (value === null && own === null && !lengths)) return field;
  return (
    <span class="slider-field">
      <Slider
        label={`${labelOf(c.row)}, slider`} share={scale.toShare(value ?? c.row.min ?? 0)} valueText={value === null ? c.placeholder : `${formatNumber(value)} ${c.unit}`.trim()}
        disabled={c.disabled} onBegin={c.begin} onChange={(share) => c.drag(scale.toValue(share))} onEnd={c.end}
      />
      {field}
    </span>
  );
}

function Choice(c: RowContext & { names: string[]; text?: (name: string) => string }) {
  const automatic = typeof c.value === "string" && c.set === undefined ? c.value : null;
  const first = c.row.automatic ? [{ value: "", text: automatic ? `automatic: ${automatic}` : "automatic" }] : [];
  const value = c.row.automatic ? (typeof c.set === "string" ? c.set : "") : typeof c.value === "string" ? c.value : "";
  const options = [...first, ...c.names.map((name) => ({ value: name, text: c.text ? c.text(name) : name }))];
  return (
    <Select id={c.id} value={value} options={options} disabled={c.disabled} invalid={!!c.error} describedBy={c.describedBy}
      onChange={(chosen) => c.commit(chosen === "" ? undefined : chosen)} />
  );
}

/** A switch of which nobody here knows what it is while it is automatic. */
function SwitchChoice(c: RowContext) {
  const options = [{ value: "", text: "automatic" }, { value: "true", text: "on" }, { value: "false", text: "off" }];
  return (
    <Select id={c.id} value={typeof c.set === "boolean" ? String(c.set) : ""} options={options} disabled={c.disabled} invalid={!!c.error}
      describedBy={c.describedBy} onChange={(chosen) => c.commit(chosen === "" ? undefined : chosen === "true")} />
  );
}

function StringControl(c: RowContext) {
  const { row } = c;
  if (row.name === "colormap" || row.name === "preset") return <ColormapField context={c} />;
  const renderers = store.welcome.value?.renderers ?? [];
  if (row.table === "renderers") return <Choice {...c} names={renderers.map((r) => r.name)} text={(name) => renderers.find((r) => r.name === name)?.label ?? name} />;
  return (
    <TextField id={c.id} live={c.isParameter} value={typeof c.set === "string" ? c.set : ""} placeholder={c.placeholder} disabled={c.disabled} invalid={!!c.error}
      describedBy={c.describedBy} onCommit={(text) => c.commit(text === "" ? undefined : text)} />
  );
}

const AXES = ["x", "y", "z"];

function VectorControl(c: RowContext) {
  const value = Array.isArray(c.value) ? c.value.map((v) => (typeof v === "string" ? v : Number(v))) : null;
  const numberAt = (axis: number) => Number(value?.[axis] ?? 0);
  const shown = c.set !== undefined || !c.row.automatic ? value : null;
  const commit = (axis: number, text: string) => {
    const entry = parseEntry(text);
    const next: Json[] = [...(value ?? [0, 0, 0])];
    if (entry === undefined) return;
    next[axis] = entry;
    c.commit(next);
  };
  return (
    <span class="vector" role="group" aria-labelledby={`${c.id}-label`}>
      {AXES.map((axis, i) => (
        <span class="vector-part" key={axis}>
          <span class="vector-axis" aria-hidden="true">{axis}</span>
          <NumberField
            id={i === 0 ? c.id : undefined} label={`${labelOf(c.row)} ${axis}`} value={shown ? (shown[i] ?? null) : null}
            placeholder={value ? formatNumber(numberAt(i), 3) : "auto"} step={stepOf(c.row, numberAt(i))} disabled={c.disabled}
            invalid={!!c.error} describedBy={c.describedBy} onCommit={(text) => commit(i, text)}
          />
        </span>
      ))}
    </span>
  );
}

function ColorControl(c: RowContext) {
  const hex = hexOf(c.value) ?? "#ffffff";
  return (
    <span class="color-field">
      <input
        id={c.id} type="color" value={hex} disabled={c.disabled} aria-describedby={c.describedBy} onFocus={c.begin}
        onInput={(e) => c.drag(e.currentTarget.value)} onChange={c.end}
      />
      <TextField label={`${labelOf(c.row)}, as text`} value={c.set === undefined && c.row.automatic ? "" : typeof c.value === "string" ? c.value : hex} placeholder={c.placeholder}
        disabled={c.disabled} invalid={!!c.error} onCommit={(text) => c.commit(text === "" ? undefined : text)} />
    </span>
  );
}

/** Rows of numbers as text, one row a line. */
function NumbersControl(c: RowContext) {
  const rows = Array.isArray(c.set) ? c.set : null;
  const text = rows ? rows.map((r) => (Array.isArray(r) ? r.join(", ") : String(r))).join("\n") : "";
  const [typed, setTyped] = useTyped(text);
  const columns = c.row.columns ?? 1;
  const every = c.row.quantity === "label" ? columns : 0;
  const commit = () => {
    if (typed === null || typed === text) return;
    const lines = typed.split("\n").map((line) => line.trim()).filter(Boolean);
    const values = lines.map((line) => parseRow(line, every));
    c.commit(values.length === 0 ? undefined : columns > 1 ? values : values.flat());
  };
  return (
    <textarea
      id={c.id} class="numbers" rows={Math.min(6, Math.max(2, text.split("\n").length))} spellcheck={false} value={typed ?? text} placeholder={c.placeholder}
      disabled={c.disabled} aria-describedby={c.describedBy} aria-invalid={c.error ? true : undefined} onInput={(e) => setTyped(e.currentTarget.value)} onBlur={commit}
    />
  );
}

export type { RowContext };
