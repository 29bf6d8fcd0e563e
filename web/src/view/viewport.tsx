/** The Navigator's viewport: the server's pictures, what the hands do on them, and a few words over them. */
import { useEffect, useRef } from "preact/hooks";
import { asksWhere, ownsKey } from "../actions";
import { drawFrame } from "../frames";
import { ViewportInput } from "../input/viewport_input";
import { attachPainter, pick, resize, send } from "../session";
import * as store from "../store";
import { IconButton } from "../ui/controls";
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
      asksWhere,
    });
    const alone = () => { if (store.layout.value === "slices") store.maximised.value = store.maximised.value ? null : "navigator"; };
    element.addEventListener("dblclick", alone);
    return () => {
      unwatch();
      element.removeEventListener("dblclick", alone);
      input.dispose();
    };
  }, []);

  const alone = store.maximised.value;
  return (
    <div class={`viewport-frame ${alone === "navigator" ? "maximised" : ""}`} hidden={alone !== null && alone !== "navigator"}>
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
      <RefinementState frame={store.frame.value} name={store.layout.value === "one" ? "" : "Navigator"} />
      <AxesGizmo />
      <ProbeBar />
      {store.layout.value === "slices" ? (
        <div class="overlay overlay-tools">
          <IconButton icon="maximise" label={alone ? "All viewports" : "Navigator alone"} pressed={alone === "navigator"} onClick={() => { store.maximised.value = alone ? null : "navigator"; }} />
        </div>
      ) : null}
    </div>
  );
}
