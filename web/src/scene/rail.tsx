/** The left rail: the system's components, what the scene is made of, and what is known of the data. */
import { addObject, runAction } from "../actions";
import { addCutPlane } from "../cut_planes";
import { Icon, type IconName } from "../icons";
import { isOpen as measuring, toggleRoom } from "../measure/room";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { DataCard } from "./data_card";
import { SceneTree } from "./tree";

/** Where a component of the system is at home on this page. */
function components(): { name: string; doc: string; icon: IconName; path: string | null }[] {
  const volume = store.currentVolume.value;
  return [
    { name: "Object Control", doc: "which parts of a volume are shown, and how", icon: "volume", path: volume ? `volumes.${volume}` : null },
    { name: "Navigator", doc: "where the image is seen from", icon: "camera", path: `${store.viewPath.value}.camera` },
    { name: "Rendering", doc: "rendering method and quality", icon: "render", path: `${store.viewPath.value}.render` },
  ];
}

function Components() {
  return (
    <nav class="components" aria-label="Components">
      {components().map(({ name, doc, icon, path }) => (
        <button
          key={name} type="button" class="component" title={doc} disabled={path === null}
          aria-pressed={path !== null && store.selection.value === path} onClick={() => { store.selection.value = path ?? ""; store.rightOpen.value = true; }}
        >
          <Icon name={icon} />
          <span>{name}</span>
        </button>
      ))}
      <button
        type="button" class="component" title="all operations on data, with a preview" disabled={store.isEmpty.value || store.readOnly.value}
        aria-haspopup="dialog" onClick={() => runAction("filter")}
      >
        <Icon name="operation" />
        <span>Filter</span>
      </button>
      <button type="button" class="component" title="points, distances, angles, profiles, regions and a table of all" disabled={store.isEmpty.value} aria-pressed={measuring.value} onClick={toggleRoom}>
        <Icon name="measure" />
        <span>Measurement</span>
      </button>
    </nav>
  );
}

export function Rail() {
  const disabled = store.readOnly.value;
  return (
    <aside class="rail" aria-label="Scene">
      <Components />
      <div class="rail-head">
        <h2>Scene</h2>
        <IconButton icon="cut" label="Add a cut plane" disabled={disabled} onClick={addCutPlane} />
        <IconButton icon="light" label="Add a light" disabled={disabled} onClick={() => addObject("lights", { frame: "camera", intensity: 0.5 })} />
        <IconButton icon="add" label="Add a file to the scene" disabled={disabled} onClick={() => { store.dialog.value = { name: "open", add: true }; }} />
      </div>
      <SceneTree />
      <DataCard />
    </aside>
  );
}
