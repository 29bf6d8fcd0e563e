/** The scene as a tree: what there is, whether it shows, and what the inspector is about. */
import { useRef } from "preact/hooks";
import type { TargetedKeyboardEvent } from "preact";
import { Icon, type IconName } from "../icons";
import { tryEdit } from "../session";
import * as store from "../store";
import { isObject, titleOf, valueAt } from "../values";

interface Row {
  path: string;
  text: string;
  icon: IconName;
  level: 1 | 2;
  /** The property that shows or hides it. */
  toggle?: "visible" | "on";
  color?: string;
}

const MAPS: { map: string; text: string; icon: IconName; toggle?: "visible" | "on" }[] = [
  { map: "volumes", text: "Volumes", icon: "volume", toggle: "visible" },
  { map: "lights", text: "Lights", icon: "light", toggle: "on" },
  { map: "datasets", text: "Data", icon: "dataset" },
  { map: "measurements", text: "Measurements", icon: "measure", toggle: "visible" },
];

function cutPlaneRows(at: string): Row[] {
  const planes = valueAt(store.world.value, at);
  if (!Array.isArray(planes)) return [];
  return planes.map((_, i) => ({ path: `${at}.${i}`, text: `Cut plane ${i + 1}`, icon: "cut", level: 2, toggle: "on" }));
}

export function treeRows(): Row[] {
  const view = store.viewPath.value;
  const rows: Row[] = [{ path: "", text: "World", icon: "world", level: 1 }];
  for (const { map, icon, toggle } of MAPS)
    for (const id of store.idsOf(map))
      rows.push({ path: `${map}.${id}`, text: titleOf(valueAt(store.world.value, `${map}.${id}`), id), icon, level: 2, toggle });
  rows.push(...cutPlaneRows("cut_planes"));
  rows.push({ path: view, text: "View", icon: "view", level: 1 });
  rows.push({ path: `${view}.camera`, text: "Camera", icon: "camera", level: 2 });
  rows.push({ path: `${view}.render`, text: "Rendering", icon: "render", level: 2 });
  rows.push({ path: `${view}.decorations`, text: "Decorations", icon: "scene", level: 2 });
  if (store.secondView.value) rows.push({ path: `views.${store.secondView.value}.render`, text: "Rendering viewport", icon: "split", level: 2 });
  return rows;
}

function isOn(row: Row): boolean {
  return store.valueOf(`${row.path}.${row.toggle}`) !== false;
}

function Toggle({ row }: { row: Row }) {
  const on = isOn(row);
  return (
    <button
      type="button" class="icon-button tree-eye" tabIndex={-1} aria-label={`${on ? "Hide" : "Show"} ${row.text}`} aria-pressed={on}
      title={on ? "Hide" : "Show"} disabled={store.readOnly.value}
      onClick={(e) => { e.stopPropagation(); tryEdit({ op: "set", path: `${row.path}.${row.toggle}`, value: !on }); }}
    >
      <Icon name={on ? "eye" : "eye-off"} />
    </button>
  );
}

function canRemove(path: string): boolean {
  return /^(volumes|lights|datasets|measurements|cut_planes)\.[^.]+$/.test(path);
}

export function SceneTree() {
  const list = useRef<HTMLDivElement>(null);
  const rows = treeRows();
  const selected = rows.findIndex((row) => row.path === store.selection.value);

  const select = (index: number) => {
    const row = rows[Math.max(0, Math.min(rows.length - 1, index))]!;
    store.selection.value = row.path;
    requestAnimationFrame(() => list.current?.querySelector<HTMLElement>('[aria-current="true"]')?.focus());
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLDivElement>) => {
    const row = rows[selected];
    switch (event.key) {
      case "ArrowDown": select(selected + 1); break;
      case "ArrowUp": select(selected - 1); break;
      case "Home": select(0); break;
      case "End": select(rows.length - 1); break;
      case " ":
        if (!row?.toggle || store.readOnly.value) return;
        tryEdit({ op: "set", path: `${row.path}.${row.toggle}`, value: !isOn(row) });
        break;
      case "Delete":
        if (!row || !canRemove(row.path) || store.readOnly.value) return;
        tryEdit({ op: "remove", path: row.path });
        break;
      default: return;
    }
    event.preventDefault();
    event.stopPropagation();
  };

  return (
    <div ref={list} class="tree" role="group" aria-label="Contents of the scene" onKeyDown={onKeyDown}>
      {rows.map((row, i) => {
        const current = row.path === store.selection.value;
        const off = row.toggle !== undefined && !isOn(row);
        return (
          <div key={row.path} class={`tree-row tree-level-${row.level} ${current ? "tree-current" : ""} ${off ? "tree-off" : ""}`}>
            <button
              type="button" class="tree-name" aria-current={current ? "true" : undefined} tabIndex={current || (selected < 0 && i === 0) ? 0 : -1}
              aria-label={off ? `${row.text}, hidden` : row.text} onClick={() => select(i)}
            >
              <Icon name={row.icon} />
              <span class="tree-text" title={row.text}>{row.text}</span>
            </button>
            {row.toggle ? <Toggle row={row} /> : null}
          </div>
        );
      })}
    </div>
  );
}

/** Whether the object at a path is one that the inspector can remove, and which. */
export function removableAt(path: string): boolean {
  return canRemove(path) && isObject(valueAt(store.world.value, path));
}
