/** All measurements: sorted by a column, renamed where they stand, hidden, removed, and as command lines. */
import { signal } from "@preact/signals";
import type { TargetedKeyboardEvent } from "preact";
import { useRef, useState } from "preact/hooks";
import { Icon } from "../icons";
import { copyText } from "../clipboard";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { leaveRow } from "../ui/focus";
import { formatNumber, label } from "../values";
import { commandOf, remove, rename, rows, selected, show } from "./room";
import { mainFigure, ofText, sorted, type Column, type Order, type Row } from "./rows";
import { unitText } from "./units";

const order = signal<Order | null>(null);

const COLUMNS: { by: Column; text: string; number?: boolean }[] = [
  { by: "title", text: "Name" }, { by: "kind", text: "Kind" }, { by: "of", text: "Of" }, { by: "value", text: "Result", number: true }, { by: "error", text: "Error", number: true },
];

function sortBy(by: Column): void {
  const now = order.value;
  order.value = now?.by !== by ? { by, down: false } : now.down ? null : { by, down: true };
}

/** Of which volume, only where there are several, or time steps. */
const columns = () => COLUMNS.filter(({ by }) => by !== "of" || rows.value.some((row) => row.of !== rows.value[0]!.of || row.step !== undefined));

function Head() {
  const now = order.value;
  return (
    <thead>
      <tr>
        <th class="measure-narrow" scope="col"><span class="hidden">Shown</span></th>
        {columns().map(({ by, text, number }) => (
          <th key={by} scope="col" class={number ? "measure-number" : ""} aria-sort={now?.by !== by ? "none" : now.down ? "descending" : "ascending"}>
            <button type="button" class="measure-sort" title="Sort" onClick={() => sortBy(by)}>
              {text}
              {now?.by === by ? <Icon name={now.down ? "down" : "up"} /> : null}
            </button>
          </th>
        ))}
        <th class="measure-narrow" scope="col"><span class="hidden">What to do</span></th>
      </tr>
    </thead>
  );
}

function drop(id: string): void {
  leaveRow("tr");
  remove(id);
}

/** A name that is a field when it is to be another: by a double click or F2. */
function Name({ row }: { row: Row }) {
  const [typed, setTyped] = useState<string | null>(null);
  const chosen = row.id === selected.value;
  const isBack = useRef(false); // by keys: the focus is where it was
  const isOver = useRef(false); // a field that goes away is left, too
  const end = (keep: boolean, byKey = false) => {
    if (isOver.current) return;
    isOver.current = true;
    isBack.current = byKey;
    if (keep && typed !== null && typed !== row.title) rename(row.id, typed);
    setTyped(null);
  };
  const key = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    if (event.key === "Enter") end(true, true);
    else if (event.key === "Escape") end(false, true);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  if (typed !== null)
    return <input class="measure-rename" type="text" aria-label={`Name of ${row.title}`} value={typed} maxLength={256} ref={(e) => { if (e && document.activeElement !== e) e.focus(); }}
      onInput={(e) => setTyped(e.currentTarget.value)} onKeyDown={key} onBlur={() => end(true)} />;
  const begin = () => {
    isOver.current = false;
    if (!store.readOnly.value) setTyped(row.title);
  };
  return (
    <button
      ref={(e) => { if (e && isBack.current) { isBack.current = false; e.focus(); } }}
      type="button" class="measure-name" aria-current={chosen ? "true" : undefined} title="Double click or F2 renames" onClick={() => { store.selection.value = `measurements.${row.id}`; }}
      onDblClick={begin} onKeyDown={(e) => {
        if (e.key === "F2") begin();
        else if (e.key === "Delete" && !store.readOnly.value) drop(row.id);
        else return;
        e.preventDefault();
        e.stopPropagation();
      }}
    >
      {row.title}
    </button>
  );
}

function Result({ row }: { row: Row }) {
  const figure = mainFigure(row);
  if (row.error) return <td colSpan={2} class="measure-failed" title={row.error}>{row.error}</td>;
  const { value, error, unit } = figure ?? {};
  return (
    <>
      <td class={`measure-number ${row.changed ? "measure-changed" : ""}`} title={row.changed ? "Another than what the scene keeps" : figure ? label(figure.name) : undefined}>
        {value === undefined ? "none" : `${formatNumber(value, 5)}${unitText(unit)}`}
        {row.figures.length > (row.step === undefined ? 1 : 2) && figure ? <span class="measure-which">{label(figure.name).toLowerCase()}</span> : null}
      </td>
      <td class="measure-number measure-error">{error === undefined ? "" : `± ${formatNumber(error, 2)}`}</td>
    </>
  );
}

async function copyLine(id: string): Promise<void> {
  const text = await commandOf(id);
  if (text) await copyText(text);
}

export function Table() {
  const all = sorted(rows.value, order.value);
  return (
    <div class="measure-table" tabIndex={all.length ? -1 : 0} role="region" aria-label="Table of measurements">
      <table>
        <Head />
        <tbody>
          {all.map((row) => (
            <tr key={row.id} class={`${row.id === selected.value ? "measure-current" : ""} ${row.visible ? "" : "measure-hidden"}`}>
              <td class="measure-narrow">
                <IconButton icon={row.visible ? "eye" : "eye-off"} label={`${row.visible ? "Hide" : "Show"} ${row.title}`} pressed={row.visible} disabled={store.readOnly.value} onClick={() => show(row.id, !row.visible)} />
              </td>
              <td><Name row={row} /></td>
              <td>{label(row.kind)}</td>
              {columns().some(({ by }) => by === "of") ? <td class="measure-of" title={ofText(row)}><span class="measure-of-name">{row.of}</span>{row.step === undefined ? null : <span>{`, step ${row.step}`}</span>}</td> : null}
              <Result row={row} />
              <td class="measure-narrow measure-do">
                <IconButton icon="terminal" label={`Copy the command line of ${row.title}`} onClick={() => void copyLine(row.id)} />
                <IconButton icon="remove" label={`Remove ${row.title}`} disabled={store.readOnly.value} onClick={() => drop(row.id)} />
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
