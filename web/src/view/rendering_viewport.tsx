/** The Rendering viewport, beside the Navigator. */
import { useSignalEffect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { runAction } from "../actions";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { pictureClass, RefinementState } from "./overlays";
import { watchSize } from "./pixel_size";
import { SecondView } from "./second_view";

export function RenderingViewport() {
  const area = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const view = useMemo(() => new SecondView(), []);
  useEffect(() => {
    const unwatch = watchSize(area.current!, (width, height) => view.resize(width, height));
    view.start(canvas.current!);
    return () => {
      unwatch();
      view.stop();
    };
  }, []);
  useSignalEffect(() => view.follow(store.pose.value));
  const settings = () => {
    if (!store.secondView.value) return;
    store.selection.value = `views.${store.secondView.value}.render`;
    store.rightOpen.value = true;
  };
  return (
    <section class="viewport-frame rendering" aria-label="Rendering">
      <div ref={area} class="viewport viewport-still">
        <canvas ref={canvas} class={pictureClass(view.failed.value)} role="img" aria-label={`Rendering by ${view.status.value?.method ?? "the method of its view"}`} />
      </div>
      <RefinementState frame={view.frame.value} final={view.isFinal.value} failure={view.failed.value} name="Rendering" />
      <div class="overlay overlay-tools">
        <IconButton icon="render" label="Method and quality of this viewport" onClick={settings} />
        <IconButton icon="close" label="Close the Rendering viewport" onClick={() => runAction("split")} />
      </div>
    </section>
  );
}
