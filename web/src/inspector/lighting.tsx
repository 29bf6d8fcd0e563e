/** How light falls, beside each light: what the method in use has of it, for all lights of this view. */
import { signal } from "@preact/signals";
import * as store from "../store";
import { Fold } from "../ui/controls";
import { acts } from "../values";
import { Properties } from "./properties";

const open = signal(true);

export function Lighting() {
  const render = `${store.viewPath.value}.render`;
  const method = store.rendererAt(render);
  if (!method) return null;
  const path = `${render}.${method.name}`;
  const all = store.classes.value[method.class]?.properties ?? [];
  const lighting = all.find((row) => row.name === "lighting");
  const rows = all.filter((row) => lighting && row.when === lighting.when).map((row) => row.name); // those that act where it does
  const valueOf = (name: string) => store.valueOf(`${path}.${name}`) ?? all.find((row) => row.name === name)?.default ?? undefined;
  const why = !lighting ? `${method.label} lights every place as if it were alone.` : acts(lighting.when, valueOf) ? "" : "What this mode shows is a projection, which has no light.";
  return (
    <Fold id="lighting" title="Shadows and ambient light" note="all lights" open={open.value} onToggle={(now) => { open.value = now; }}>
      {why ? <p class="doc">{why}</p> : <Properties path={path} className={method.class} only={rows} />}
    </Fold>
  );
}
