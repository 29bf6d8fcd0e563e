/** The Navigator's viewport: the server's pictures, what the hands do on them, and a few words over them. */
import { useEffect, useRef } from "preact/hooks";
import { ownsKey } from "../actions";
import { drawFrame } from "../frames";
import { ViewportInput } from "../input/viewport_input";
import { attachPainter, pick, resize, send } from "../session";
import * as store from "../store";
import { AxesGizmo } from "./axes";
import { Probe, ProbeBar, RefinementState } from "./overlays";
import { watchSize } from "./pixel_size";

export function Viewport() {
  const area = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);

  useEffect(() => {
    const element = area.current!;
    attachPainter((frame) => drawFrame(canvas.current!, frame));
    const unwatch = watchSize(element, resize);
    const input = new ViewportInput(element, {
      send: (lines) => void send({ type: "events", lines: lines.join("\n") }),
      click: (x, y) => { if (!store.isEmpty.value) void pick(x, y); },
      ownsKey,
    });
    return () => {
      unwatch();
      input.dispose();
    };
  }, []);

  return (
    <div class="viewport-frame">
      <div
        ref={area} class="viewport" data-viewport tabIndex={0} role="application" aria-roledescription="picture to be turned"
        aria-label="Navigator" aria-describedby="scene-description"
      >
        <canvas ref={canvas} class="picture" role="img" aria-label={store.description.value || "The picture of the scene"} />
        <Probe />
      </div>
      <p id="scene-description" class="hidden">
        {store.description.value} Arrow keys turn the picture, plus and minus come nearer and go farther, H lists all keys.
      </p>
      <RefinementState frame={store.frame.value} name={store.split.value ? "Navigator" : ""} />
      <AxesGizmo />
      <ProbeBar />
    </div>
  );
}
