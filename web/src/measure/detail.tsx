/** All that one measurement says: figures, remarks, a plot or a table, and each of them as a file. */
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { formatNumber, label, titleOf, valueAt } from "../values";
import { saveText } from "./output";
import { PlotView } from "./plot";
import { csvOfAnswer, labelRows, plotOf } from "./plots";
import { found, plotFile, rows, selected } from "./room";
import type { Figure } from "./rows";
import { unitText } from "./units";

function Figures({ all }: { all: Figure[] }) {
  return (
    <dl class="measure-figures">
      {all.map((f) => (
        <div key={f.name}>
          <dt>{label(f.name)}</dt>
          <dd title={f.value === undefined ? undefined : String(f.value)}>
            {f.value === undefined ? "none" : formatNumber(f.value, 6)}{unitText(f.unit)}
            {f.error ? <span class="measure-error"> ± {formatNumber(f.error, 2)}</span> : null}
          </dd>
        </div>
      ))}
    </dl>
  );
}

const ROWS_MOST = 200;

function Labels({ head, rows: all }: { head: string[]; rows: (string | number | null)[][] }) {
  return (
    <div class="measure-labels" tabIndex={0} role="region" aria-label="Labels">
      <table>
        <thead><tr>{head.map((name) => <th key={name} scope="col">{label(name)}</th>)}</tr></thead>
        <tbody>
          {all.slice(0, ROWS_MOST).map((row, i) => (
            <tr key={i}>{row.map((cell, k) => <td key={k} class={typeof cell === "number" ? "measure-number" : ""}>{typeof cell === "number" ? formatNumber(cell, 5) : cell ?? ""}</td>)}</tr>
          ))}
        </tbody>
      </table>
      {all.length > ROWS_MOST ? <p class="hint">{all.length - ROWS_MOST} more are in the saved table.</p> : null}
    </div>
  );
}

export function Detail() {
  const id = selected.value;
  const row = rows.value.find((one) => one.id === id);
  if (!id || !row) return <div class="measure-detail measure-empty"><p class="hint">{rows.value.length ? "Select a measurement to see all of it." : ""}</p></div>;
  const title = titleOf(valueAt(store.world.value, `measurements.${id}`), id);
  const answer = found.value[id]?.answer ?? null;
  const plot = answer ? plotOf(answer.answer) : null;
  const labels = answer ? labelRows(answer.answer) : null;
  const csv = answer && (plot || labels) ? () => saveText(csvOfAnswer(answer.answer)!, `${title}.csv`, "text/csv") : null;
  const picture = async () => {
    const svg = await plotFile(id);
    if (svg) saveText(svg, `${title}.svg`, "image/svg+xml");
  };
  return (
    <section class="measure-detail" tabIndex={0} aria-label={`Measurement ${title}`}>
      <header class="measure-detail-head">
        <h3>{title}</h3>
        {csv ? <IconButton icon="save" label="Save data as CSV" onClick={csv} /> : null}
        {plot ? <IconButton icon="picture" label="Save plot as SVG" onClick={() => void picture()} /> : null}
      </header>
      {row.error ? <p class="row-error">{row.error}</p> : null}
      {plot ? <PlotView plot={plot} title={title} /> : null}
      {labels ? <Labels {...labels} /> : <Figures all={row.figures} />}
      {(answer?.notes ?? []).map((note) => <p key={note} class="hint">{note}</p>)}
    </section>
  );
}
