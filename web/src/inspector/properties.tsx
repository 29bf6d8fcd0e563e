/** All properties of an object: those of the plain kinds first, then the groups, folded. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { focusProperty } from "../actions";
import type { Property } from "../protocol";
import { tryEdit } from "../session";
import * as store from "../store";
import { Fold, IconButton } from "../ui/controls";
import { acts, isObject, join, label, labelOf, sentence, valueAt } from "../values";
import { PropertyRow } from "./property_row";

/** Which groups are open, by class path without ids, so that it is the same for the next volume. */
const opened = signal<{ [group: string]: boolean }>({});

function groupKey(path: string): string {
  return path.replace(/^(\w+)\.[^.]+/, "$1");
}

export function isGroup(row: Property): boolean {
  return row.kind === "object" || row.kind === "list" || row.kind === "variants" || row.kind === "members";
}

/** How many properties somebody has set below this path: so that a folded group tells. */
function countSet(path: string): number {
  const value = valueAt(store.world.value, path);
  if (Array.isArray(value)) return value.length;
  return isObject(value) ? Object.keys(value).length : 0;
}

export function Group({ path, row, open }: { path: string; row: Property; open?: boolean }) {
  const key = groupKey(path);
  const isOpen = opened.value[key] ?? open ?? false;
  const target = focusProperty.value;
  useEffect(() => {
    if (target.startsWith(`${path}.`)) opened.value = { ...opened.value, [key]: true };
  }, [target]);
  const n = countSet(path);
  return (
    <Fold
      id={`fold-${path}`} title={labelOf(row)} open={isOpen} note={n ? (row.kind === "list" ? String(n) : `${n} set`) : undefined}
      onToggle={(now) => { opened.value = { ...opened.value, [key]: now }; }}
    >
      <p class="doc">{sentence(row.doc)}</p>
      {row.kind === "list" ? <List path={path} row={row} /> : <Properties path={path} className={row.class!} />}
    </Fold>
  );
}

function List({ path, row }: { path: string; row: Property }) {
  const value = valueAt(store.world.value, path);
  const n = Array.isArray(value) ? value.length : 0;
  const noun = row.class?.replace(/_/g, " ") ?? "entry";
  return (
    <div class="list">
      {Array.from({ length: n }, (_, i) => (
        <div class="list-entry" key={i} role="group" aria-label={`${noun} ${i + 1}`}>
          <div class="list-head">
            <span>{label(noun)} {i + 1}</span>
            <IconButton icon="remove" label={`Remove ${noun} ${i + 1}`} disabled={store.readOnly.value} onClick={() => tryEdit({ op: "remove", path: join(path, i) })} />
          </div>
          <Properties path={join(path, i)} className={row.class!} />
        </div>
      ))}
      <button type="button" class="button button-small" disabled={store.readOnly.value} onClick={() => tryEdit({ op: "add", path, id: null, value: {} })}>
        Add a {noun}
      </button>
    </div>
  );
}

/** The parameters of the method that is in use; the other methods keep theirs. */
function MethodParameters({ path }: { path: string }) {
  const renderer = store.rendererAt(path);
  if (!renderer || !store.classes.value[renderer.class]?.properties.length) return null;
  const row: Property = { name: renderer.name, kind: "object", doc: renderer.doc, class: renderer.class };
  return <Group path={join(path, renderer.name)} row={row} open />;
}

/** What data are made of, and with which parameters: rows of the operation that makes them. */
function Recipe({ path, row }: { path: string; row: Property }) {
  const named = store.valueOf(`${path}.operation`);
  const operation = store.welcome.value?.operations.find((one) => one.name === named);
  const where = join(path, row.name);
  if (!operation) return null;
  if (row.name === "parameters") return <Group path={where} row={{ ...row, kind: "object", class: operation.class }} open />;
  const value = valueAt(store.world.value, where);
  const inputs = isObject(value) ? Object.keys(value) : [];
  return (
    <div class="rows">
      {inputs.map((name) => (
        <PropertyRow
          key={name} path={join(where, name)}
          row={{ name, kind: "reference", ref_to: "datasets", doc: operation.inputs.find((operand) => operand.name === name)?.doc ?? row.doc }}
        />
      ))}
    </div>
  );
}

export function Properties({ path, className, skip = [], only, base }: {
  path: string; className: string; skip?: string[]; only?: string[];
  /** Where values are kept, if not in the World: parameters of an operation that has not run. */
  base?: ParameterStore;
}) {
  const all = store.classes.value[className]?.properties ?? [];
  const setAt = (name: string) => (base ? base.get(join(path, name)) : valueAt(store.world.value, join(path, name)));
  const valueOf = (name: string) => setAt(name) ?? (base ? undefined : valueAt(store.resolved.value, join(path, name))) ?? all.find((row) => row.name === name)?.default ?? undefined;
  const rows = all.filter((row) => !skip.includes(row.name) && (!only || only.includes(row.name)) && row.kind !== "map" && row.name !== "schema" && (setAt(row.name) !== undefined || acts(row.when, row.when?.includes("=") ? valueOf : setAt)));
  const plain = rows.filter((row) => !isGroup(row));
  const groups = rows.filter(isGroup);
  return (
    <>
      {plain.length ? <div class="rows">{plain.map((row) => <PropertyRow key={row.name} path={join(path, row.name)} row={row} base={base} />)}</div> : null}
      {groups.map((row) =>
        row.kind === "variants"
          ? <MethodParameters key={row.name} path={path} />
          : row.kind === "members"
          ? <Recipe key={row.name} path={path} row={row} />
          : <Group key={row.name} path={join(path, row.name)} row={row} />)}
    </>
  );
}

export interface ParameterStore {
  get(path: string): import("../protocol").Json | undefined;
  set(path: string, value: import("../protocol").Json | undefined): void;
}
