/** The transfer-function editor: the plot, the point that is selected in numbers, presets, and all points as a list. */
import { useEffect, useRef, useState } from "preact/hooks";
import { hexOfLinear, linearOfHex } from "../colors";
import type { Edit } from "../protocol";
import { fetchHistogram, fetchTransfer, Gesture } from "../session";
import * as store from "../store";
import { IconButton, NumberField } from "../ui/controls";
import {
  fullAxis, insertNode, isMap, moveAlong, moveEnd, moveNode, removeNode, sampleNodes, thin, tidy, zoomAxis, type Axis, type ColorNode, type OpacityNode,
} from "./curve";
import { TransferPlot, type Selected } from "./plot";
import { PresetList } from "./presets";

interface Nodes {
  opacity: OpacityNode[];
  color: ColorNode[];
}

const MAP_POINTS = 12; // of a colour map that becomes points

type Tab = "presets" | "maps" | "list";

export function TransferEditor({ volume }: { volume: string }) {
  const [drawn, setDrawn] = useState<Nodes | null>(null); // while a drag goes on, ahead of the server
  const [selected, setSelected] = useState<Selected>(null);
  const [log, setLog] = useState(true);
  const [zoom, setZoom] = useState<Axis | null>(null);
  const [tab, setTab] = useState<Tab>("presets");
  const gesture = useRef<Gesture | null>(null);
  const transfer = store.transfers.value[volume];
  const histogramOrWhy = store.histograms.value[volume];
  const histogram = histogramOrWhy && typeof histogramOrWhy !== "string" ? histogramOrWhy : null;

  useEffect(() => {
    setSelected(null);
    setZoom(null);
    setDrawn(null);
    void fetchTransfer(volume);
  }, [volume]);
  useEffect(() => void fetchHistogram(volume), [volume, histogramOrWhy === undefined]);
  // What the server has now is what was drawn, or what somebody else made of it: the drawing has done its work.
  useEffect(() => { if (!gesture.current) setDrawn(null); }, [transfer]);

  const nodes: Nodes = drawn ?? {
    opacity: (transfer?.opacity ?? []) as OpacityNode[],
    color: (transfer?.color ?? []) as ColorNode[],
  };
  const full = fullAxis(histogram?.lo ?? nodes.opacity[0]?.[0] ?? 0, histogram?.hi ?? nodes.opacity.at(-1)?.[0] ?? 1, nodes.opacity);
  const axis = zoom ?? full;
  const length = transfer?.opacity_length ?? 1;
  const perLength = `per ${length === 1 ? "" : `${Number(length.toPrecision(3))} `}${store.lengthUnit.value}`;
  const path = `volumes.${volume}.segmentation.transfer`;

  /** Opacity that is given counts for a length of 1: the length it was shown with is given with it. */
  const edits = (list: "opacity" | "color", next: Nodes): Edit[] =>
    list === "color" ? [{ op: "set", path: `${path}.color`, value: next.color }] : [
      { op: "set", path: `${path}.opacity`, value: next.opacity },
      ...(store.isSet(`${path}.opacity_length`) ? [] : [{ op: "set" as const, path: `${path}.opacity_length`, value: length }]),
    ];
  const change = (list: "opacity" | "color", next: Nodes) => {
    setDrawn(next);
    (gesture.current ?? new Gesture()).change(...edits(list, next));
  };
  const move = (which: NonNullable<Selected>, value: number, opacity: number) => {
    if (which.list === "opacity") change("opacity", { ...nodes, opacity: moveNode(nodes.opacity, which.index, value, opacity) });
    else if (isMap(nodes.color)) moveMap(moveEnd(nodes.color, which.index, value));
    else change("color", { ...nodes, color: moveAlong(nodes.color, which.index, value) });
  };
  /** A map that is worked out over a range stays one; colours that are given, or a preset's, become nodes. */
  const moveMap = (color: ColorNode[]) => {
    const given = store.isSet(`${path}.color`) || (store.isSet(`${path}.preset`) && !store.isSet(`${path}.colormap`));
    if (given) return change("color", { ...nodes, color });
    setDrawn({ ...nodes, color });
    (gesture.current ?? new Gesture()).change(
      { op: "set", path: `${path}.range_lo`, value: color[0]![0] }, { op: "set", path: `${path}.range_hi`, value: color.at(-1)![0] });
  };
  const add = (list: "opacity" | "color", value: number, opacity: number) => {
    if (list === "opacity") {
      const { nodes: next, index } = insertNode<OpacityNode>(nodes.opacity, [tidy(value), tidy(opacity)]);
      change("opacity", { ...nodes, opacity: next });
      setSelected({ list, index });
    } else {
      const [r = 1, g = 1, b = 1] = sampleNodes(nodes.color, value);
      const few = isMap(nodes.color) ? thin(nodes.color, MAP_POINTS) : nodes.color;
      const { nodes: next, index } = insertNode<ColorNode>(few, [tidy(value), r, g, b]);
      change("color", { ...nodes, color: next });
      setSelected({ list, index });
    }
  };
  const remove = (which: NonNullable<Selected>) => {
    if (nodes[which.list].length <= 1 || (which.list === "color" && isMap(nodes.color))) return;
    if (which.list === "opacity") change("opacity", { ...nodes, opacity: removeNode(nodes.opacity, which.index) });
    else change("color", { ...nodes, color: removeNode(nodes.color, which.index) });
    setSelected(null);
  };
  const recolor = (index: number, hex: string) =>
    change("color", { ...nodes, color: nodes.color.map((node, i): ColorNode => (i === index ? [node[0], ...linearOfHex(hex)] : node)) });

  const unit = histogram?.unit ?? "";
  const points = { nodes, unit, perLength, disabled: store.readOnly.value, move, remove, add, recolor, begin, end };
  function begin() { gesture.current ??= new Gesture(); }
  function end() { gesture.current = null; }

  return (
    <div class="transfer">
      <div class="transfer-tools">
        <span class="transfer-axis">Opacity {perLength}</span>
        <button type="button" class="chip" aria-pressed={log} title="Logarithmic counts" onClick={() => setLog(!log)}>log</button>
        <IconButton icon="minus" label="Zoom out of the values" disabled={!zoom} onClick={() => setZoom(zoomAxis(axis, full, (axis.lo + axis.hi) / 2, 1.6))} />
        <IconButton icon="add" label="Zoom into the values" onClick={() => setZoom(zoomAxis(axis, full, (axis.lo + axis.hi) / 2, 0.625))} />
        <IconButton icon="fit" label="All values" disabled={!zoom} onClick={() => setZoom(null)} />
      </div>
      <TransferPlot
        {...nodes} histogram={histogram} log={log} axis={axis} full={full} unit={unit} perLength={perLength} selected={selected}
        disabled={store.readOnly.value} onAxis={setZoom} onSelect={setSelected} onBegin={begin} onMove={move} onEnd={end} onAdd={add} onRemove={remove}
      />
      {typeof histogramOrWhy === "string" ? <p class="row-error">{histogramOrWhy}</p> : null}
      <SelectedPoint {...points} selected={selected} />
      <div class="tabs" role="tablist" aria-label="Transfer function">
        {(["presets", "maps", "list"] as const).map((name) => (
          <button key={name} type="button" role="tab" class="tab" id={`tab-${name}`} aria-selected={tab === name} aria-controls="transfer-tab" tabIndex={tab === name ? 0 : -1}
            onClick={() => setTab(name)} onKeyDown={(e) => tabKey(e, name, setTab)}>
            {TAB_NAMES[name]}
          </button>
        ))}
      </div>
      <div class="tab-panel" id="transfer-tab" role="tabpanel" aria-labelledby={`tab-${tab}`} tabIndex={0}>
        {tab === "list" ? <PointList {...points} selected={selected} onSelect={setSelected} middle={(axis.lo + axis.hi) / 2} />
          : <PresetList kind={tab === "presets" ? "transfer" : "colormap"} volume={volume} />}
      </div>
    </div>
  );
}

const TAB_NAMES: { [tab in Tab]: string } = { presets: "Presets", maps: "Colour maps", list: "Points" };

function tabKey(event: KeyboardEvent, now: Tab, setTab: (tab: Tab) => void): void {
  const tabs = Object.keys(TAB_NAMES) as Tab[];
  const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
  if (!by) return;
  const next = tabs[(tabs.indexOf(now) + by + tabs.length) % tabs.length]!;
  setTab(next);
  document.getElementById(`tab-${next}`)?.focus();
}

interface Points {
  nodes: Nodes;
  unit: string;
  perLength: string;
  disabled: boolean;
  move(which: NonNullable<Selected>, value: number, opacity: number): void;
  remove(which: NonNullable<Selected>): void;
  add(list: "opacity" | "color", value: number, opacity: number): void;
  recolor(index: number, hex: string): void;
  begin(): void;
  end(): void;
}

function OpacityFields({ index, ...p }: Points & { index: number }) {
  const node = p.nodes.opacity[index]!;
  const which = { list: "opacity" as const, index };
  const entered = (value: number, opacity: number) => { if (Number.isFinite(value) && Number.isFinite(opacity)) p.move(which, value, opacity); };
  return (
    <>
      <NumberField label={`Value of opacity point ${index + 1}`} value={node[0]} unit={p.unit} disabled={p.disabled} onCommit={(t) => entered(Number(t), node[1])} />
      <NumberField label={`Opacity of point ${index + 1}, ${p.perLength}`} value={node[1]} step={0.01} disabled={p.disabled} onCommit={(t) => entered(node[0], Number(t))} />
      <IconButton icon="remove" label={`Remove opacity point ${index + 1}`} disabled={p.disabled || p.nodes.opacity.length <= 1} onClick={() => p.remove(which)} />
    </>
  );
}

function ColorFields({ index, ...p }: Points & { index: number }) {
  const node = p.nodes.color[index]!;
  const which = { list: "color" as const, index };
  if (isMap(p.nodes.color))
    return <NumberField label={`Value where the colour map ${index ? "ends" : "begins"}`} value={node[0]} unit={p.unit} disabled={p.disabled} onCommit={(t) => { if (Number.isFinite(Number(t))) p.move(which, Number(t), 0); }} />;
  return (
    <>
      <NumberField label={`Value of colour point ${index + 1}`} value={node[0]} unit={p.unit} disabled={p.disabled} onCommit={(t) => { if (Number.isFinite(Number(t))) p.move(which, Number(t), 0); }} />
      <span class="field">
        <input type="color" aria-label={`Colour of point ${index + 1}`} value={hexOfLinear(node.slice(1))} disabled={p.disabled}
          onFocus={p.begin} onInput={(e) => p.recolor(index, e.currentTarget.value)} onChange={p.end} onBlur={p.end} />
      </span>
      <IconButton icon="remove" label={`Remove colour point ${index + 1}`} disabled={p.disabled || p.nodes.color.length <= 1} onClick={() => p.remove(which)} />
    </>
  );
}

function SelectedPoint({ selected, ...p }: Points & { selected: Selected }) {
  const there = selected && selected.index < p.nodes[selected.list].length;
  if (!there) return <p class="hint">Double-click adds a point, on the bar below a colour. Delete removes the selected one.</p>;
  return (
    <div class="point-fields">
      <span class="point-name">{selected.list === "opacity" ? `Opacity ${selected.index + 1}` : isMap(p.nodes.color) ? (selected.index ? "Map ends" : "Map begins") : `Colour ${selected.index + 1}`}</span>
      {selected.list === "opacity" ? <OpacityFields {...p} index={selected.index} /> : <ColorFields {...p} index={selected.index} />}
    </div>
  );
}

/** The same without a mouse: all points in numbers. */
function PointList({ selected, onSelect, middle, ...p }: Points & { selected: Selected; onSelect: (s: Selected) => void; middle: number }) {
  const current = (list: "opacity" | "color", index: number) => selected?.list === list && selected.index === index;
  return (
    <div class="point-list">
      <h3>Opacity {p.perLength}</h3>
      {p.nodes.opacity.map((_, index) => (
        <div key={index} class={`point-fields ${current("opacity", index) ? "point-current" : ""}`} onFocusIn={() => onSelect({ list: "opacity", index })}>
          <span class="point-name">{index + 1}</span>
          <OpacityFields {...p} index={index} />
        </div>
      ))}
      <button type="button" class="button button-small" disabled={p.disabled} onClick={() => p.add("opacity", middle, sampleNodes(p.nodes.opacity, middle)[0] ?? 0)}>Add an opacity point</button>
      <h3>Colour</h3>
      {p.nodes.color.map((_, index) => isMap(p.nodes.color) && index > 0 && index < p.nodes.color.length - 1 ? null : (
        <div key={index} class={`point-fields ${current("color", index) ? "point-current" : ""}`} onFocusIn={() => onSelect({ list: "color", index })}>
          <span class="point-name">{!isMap(p.nodes.color) ? index + 1 : index ? "to" : "from"}</span>
          <ColorFields {...p} index={index} />
        </div>
      ))}
      <button type="button" class="button button-small" disabled={p.disabled} onClick={() => p.add("color", middle, 0)}>Add a colour point</button>
    </div>
  );
}
