/** The Measurement room below the pictures: tools, the table of all measurements, and what the chosen one says. */
import { useEffect } from "preact/hooks";
import type { TargetedKeyboardEvent } from "preact";
import { Icon } from "../icons";
import { fetchInfo } from "../session";
import { copyText } from "../clipboard";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { label } from "../values";
import { Detail } from "./detail";
import { listenToKeys } from "./hands";
import { saveText } from "./output";
import { hint, isOpen, keepResults, kindOf, kindsOf, pending, rows, takeTool, toggleRoom, tool, tools, wholeVolume, wish } from "./room";
import { csvOfRows } from "./rows";
import { Table } from "./table";
import type { Tool } from "./tools";

function take(next: Tool): void {
  if (next.takes === "nothing") wholeVolume(next);
  else takeTool(tool.value?.name === next.name ? null : next);
}

/** Arrow keys go from tool to tool; Tab leaves them. */
function onToolKey(event: TargetedKeyboardEvent<HTMLDivElement>): void {
  const by = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (!by) return;
  const buttons = [...event.currentTarget.querySelectorAll<HTMLButtonElement>("button:not(:disabled)")];
  const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
  buttons[(at + by + buttons.length) % buttons.length]?.focus();
  event.preventDefault();
}

function Tools() {
  const disabled = store.readOnly.value || store.isEmpty.value;
  const current = tool.value?.name ?? tools.value.find((row) => kindsOf(row).length)?.name; // that Tab comes to
  return (
    <div class="measure-tools" role="toolbar" aria-label="Measuring tools" onKeyDown={onToolKey}>
      {tools.value.map((row, i) => (
        <>
          {i > 0 && row.takes !== "points" && tools.value[i - 1]!.takes === "points" ? <span class="divider" key={`before ${row.name}`} /> : null}
          <button
            key={row.name} type="button" class="measure-tool" title={`${row.title}: ${kindsOf(row).length ? row.doc : "of volumes, and a mesh is shown"}`} disabled={disabled || !kindsOf(row).length} tabIndex={row.name === current ? 0 : -1}
            aria-pressed={row.takes === "nothing" ? undefined : tool.value?.name === row.name} onClick={() => take(row)}
          >
            <Icon name={row.icon} />
            <span>{row.title}</span>
          </button>
        </>
      ))}
    </div>
  );
}

/** What is measured of what is clicked. */
function Wish({ of }: { of: Tool }) {
  const kinds = kindsOf(of);
  if (kinds.length < 2) return null;
  return (
    <label class="measure-wish">
      <span>Measure its</span>
      <span class="field field-select">
        <select value={kindOf(of)} onChange={(e) => { wish.value = { ...wish.value, [of.name]: e.currentTarget.value }; }}>
          {kinds.map((kind) => <option key={kind} value={kind}>{label(kind).toLowerCase()}</option>)}
        </select>
        <Icon name="down" />
      </span>
    </label>
  );
}

function whole(): Tool | undefined {
  return tools.value.find((row) => row.takes === "nothing");
}

function Hint() {
  const of = tool.value;
  const words = pending.value ? "Measuring." : of ? hint(of) : rows.value.length ? "" : "Choose a tool, then click in a slice or in the Navigator.";
  return words ? <p class="measure-hint">{words}</p> : null;
}

export function MeasureRoom() {
  const dataset = store.currentVolume.value ? store.datasetOf(store.currentVolume.value) : null;
  useEffect(listenToKeys, []);
  useEffect(() => { if (dataset) void fetchInfo(dataset); }, [dataset, dataset ? store.dataInfos.value[dataset] === undefined : false]);
  if (!isOpen.value) return null;
  const of = tool.value;
  const all = rows.value;
  const shown = of ?? whole();
  return (
    <section class="measure-room" aria-label="Measurement">
      <header class="measure-head">
        <h2>Measurement</h2>
        <Tools />
        {shown && shown.takes !== "points" ? <Wish of={shown} /> : null}
        <span class="grow" />
        <IconButton icon="copy" label="Copy CSV" disabled={!all.length} onClick={() => void copyText(csvOfRows(all), "The table is copied as CSV.")} />
        <IconButton icon="save" label="Save CSV" disabled={!all.length} onClick={() => saveText(csvOfRows(all), "measurements.csv", "text/csv")} />
        <IconButton icon="close" label="Close the Measurement room" onClick={toggleRoom} />
      </header>
      <Hint />
      {all.some((row) => row.changed) ? (
        <div class="measure-stale">
          <span><span class="measure-changed" />Figures with a mark are others than those that the scene keeps.</span>
          {store.readOnly.value ? null : <button type="button" class="button button-small" onClick={keepResults}>Keep new results</button>}
        </div>
      ) : null}
      <div class="measure-body">
        <Table />
        <Detail />
      </div>
    </section>
  );
}
