/** What an operation would make of a view, over its picture: right of a divider that is dragged. */
import type { Signal } from "@preact/signals";
import type { TargetedPointerEvent } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import * as store from "../store";
import { label } from "../values";
import { chainOf, takersOf } from "./chain";
import { asked, previewOn, previews, request, tables, waiting, wipe, type Plan, type Preview } from "./state";

/** Of a step between others: what stands on it then, and the volume that shows what is made of it. */
function insertion(of: Plan): { takers?: string[]; volume?: string } {
  if (!of.inserts) return {};
  const shows = (volume: string) => {
    const { source, steps } = chainOf(tables(), store.datasetOf(volume) ?? "");
    return source === of.dataset || steps.some((step) => step.id === of.dataset);
  };
  const volume = [store.currentVolume.value ?? "", ...store.volumeIds.value].find((id) => id !== "" && shows(id));
  return { takers: takersOf(tables(), of.dataset), ...(volume ? { volume } : {}) };
}

type Ask = (message: { type: string; [name: string]: unknown }) => Promise<Preview>;

function keep(viewport: string, value: Preview | string | null): void {
  const { [viewport]: _, ...others } = previews.value;
  previews.value = value === null ? others : { ...others, [viewport]: value };
}

/** The newest wish alone counts: the server cancels those before. */
function usePreview(viewport: string, ask: Ask, of: Plan | null, at: string, still: boolean): Preview | null {
  const [shown, setShown] = useState<{ preview: Preview; at: string } | null>(null);
  useEffect(() => {
    if (!of) {
      keep(viewport, null);
      setShown(null);
      return;
    }
    if (!still) return;
    let isNewest = true;
    if (typeof previews.peek()[viewport] === "string") keep(viewport, null); // it was of what is changed now
    const take = (value: Preview | string) => {
      if (!isNewest) return;
      keep(viewport, value);
      setShown(typeof value !== "string" && value.picture ? { preview: value, at } : null);
    };
    waiting.value++;
    void ask({ type: "preview", ...request(of), whole: of.whole, ...insertion(of) }).then(take, (error: Error) => take(error.message)).finally(() => { waiting.value--; });
    return () => { isNewest = false; };
  }, [of, at, still]);
  useEffect(() => () => keep(viewport, null), []);
  return shown && shown.at === at && still && of ? shown.preview : null;
}

const STEP = 0.02;

function Divider() {
  const frame = useRef<HTMLDivElement>(null);
  const share = wipe.value;
  const set = (value: number) => { wipe.value = Math.min(1, Math.max(0, value)); };
  useLayoutEffect(() => frame.current?.style.setProperty("--wipe", String(share)));
  const drag = (event: TargetedPointerEvent<HTMLDivElement>) => {
    const box = event.currentTarget.parentElement!.getBoundingClientRect();
    if (event.currentTarget.hasPointerCapture(event.pointerId)) set((event.clientX - box.left) / box.width);
  };
  return (
    <div
      ref={frame} class="wipe" role="slider" tabIndex={0} aria-label="Before and after" aria-orientation="horizontal" aria-valuemin={0} aria-valuemax={100}
      aria-valuenow={Math.round(share * 100)} aria-valuetext={`before up to ${Math.round(share * 100)} %, after from there`}
      onPointerDown={(event) => { event.stopPropagation(); event.currentTarget.setPointerCapture(event.pointerId); }} onPointerMove={drag}
      onDblClick={(event) => { event.stopPropagation(); set(0.4); }}
      onKeyDown={(event) => {
        const to = { ArrowLeft: share - STEP, ArrowRight: share + STEP, Home: 0, End: 1 }[event.key];
        if (to === undefined) return;
        set(to);
        event.preventDefault();
        event.stopPropagation();
      }}
    >
      <span class="wipe-grip" />
    </div>
  );
}

/** Slices do not show it. */
function makesMesh(of: Plan | null): boolean {
  const { volume } = of ? insertion(of) : {};
  return volume ? store.isMeshData(store.datasetOf(volume) ?? "") : of?.operation.gives === "mesh";
}

/** at: changes with everything that the view shows; still: nothing of it is on its way. */
export function PreviewOverlay({ viewport, ask, frame, still }: { viewport: string; ask: Ask; frame: number; still: boolean }) {
  const image = useRef<HTMLImageElement>(null);
  const wanted = viewport !== "navigator" && makesMesh(asked.value) ? null : asked.value;
  const preview = usePreview(viewport, ask, wanted, `${frame}`, still);
  const share = wipe.value;
  useLayoutEffect(() => image.current?.style.setProperty("--wipe", String(share)));
  if (!preview?.picture || !previewOn.value) return null;
  return (
    <div class="preview" data-preview={viewport}>
      {preview.input ? <img class="preview-before" src={preview.input} alt={`Before ${label(wanted!.operation.name)}`} draggable={false} /> : null}
      <img ref={image} class="preview-after" src={preview.picture} alt={`${label(wanted!.operation.name)}, a preview`} draggable={false} />
      {share > 0.12 ? <span class="preview-word preview-word-before" aria-hidden="true">Before</span> : null}
      {share < 0.88 ? <span class="preview-word preview-word-after" aria-hidden="true">After</span> : null}
      <Divider />
    </div>
  );
}

/** Of the Navigator, while no slices are there to be looked at. */
export function NavigatorPreview({ ask, outdated }: { ask: Ask; outdated: Signal<boolean> }) {
  if (!asked.value || (store.layout.value === "slices" && !makesMesh(asked.value))) return null;
  return <PreviewOverlay viewport="navigator" ask={ask} frame={store.frame.value?.number ?? 0} still={((store.isFinal.value && !outdated.value) || store.failed.value !== null) && store.pose.value?.moving !== true} />;
}
