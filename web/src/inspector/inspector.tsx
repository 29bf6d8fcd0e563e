/** The right panel: the properties of what is selected, made from the tables of its class. */
import { isMade } from "../filter/chain";
import { Pipeline } from "../filter/pipeline";
import { Icon } from "../icons";
import { tryEdit } from "../session";
import * as store from "../store";
import { removableAt } from "../scene/tree";
import { IconButton } from "../ui/controls";
import { classAt, label, titleOf, valueAt } from "../values";
import { Lighting } from "./lighting";
import { Properties } from "./properties";
import { SegmentationPanel } from "./segmentation";

const NOUNS: { [className: string]: string } = { cut_plane: "Cut plane", render: "Rendering", world: "World" };

function Head({ path, className }: { path: string; className: string }) {
  const id = path.split(".").pop() ?? "";
  const noun = NOUNS[className] ?? label(className);
  const named = /^(volumes|lights|datasets|measurements)\./.test(path);
  return (
    <header class="inspector-head">
      <div class="inspector-title">
        <h2>{named ? titleOf(valueAt(store.world.value, path), id) : noun}</h2>
        {named ? <span class="inspector-kind">{noun}</span> : null}
      </div>
      {removableAt(path) && !store.readOnly.value
        ? <IconButton icon="remove" label={`Remove this ${noun.toLowerCase()}`} onClick={() => tryEdit({ op: "remove", path })} /> : null}
    </header>
  );
}

/** What a dataset that is made has not, or has in its pipeline. */
const OF_FILES = ["on", "parameters", "operation", "kind", "path", "format", "part", "raw", "checksum", "source"];

/** The dataset whose making is told: that which is selected, or which the selected volume shows. */
function madeAt(path: string): string | null {
  const [map, id] = path.split(".");
  const dataset = map === "datasets" ? id : map === "volumes" && id ? store.datasetOf(id) : null;
  return dataset && isMade(store.world.value, dataset) ? dataset : null;
}

export function Inspector() {
  const path = store.selection.value;
  const made = madeAt(path);
  const className = classAt(store.classes.value, path);
  const rows = className ? store.classes.value[className] : undefined;
  return (
    <aside class="inspector" aria-label="Inspector">
      {rows && className ? (
        <>
          <Head path={path} className={className} />
          <div class="inspector-body" key={path}>
            {made ? <Pipeline key={made} dataset={made} /> : null}
            {className === "volume" && !store.isMesh(path.split(".")[1]!) ? <SegmentationPanel path={`${path}.segmentation`} volume={path.split(".")[1]!} /> : null}
            <Properties path={path} className={className} skip={className === "volume" ? ["segmentation"] : made ? OF_FILES : []} />
            {className === "light" ? <Lighting /> : null}
          </div>
        </>
      ) : (
        <p class="empty-words"><Icon name="property" /> Select something in the scene to see its properties here.</p>
      )}
    </aside>
  );
}
