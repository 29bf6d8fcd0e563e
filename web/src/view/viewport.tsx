/** The Navigator's viewport: the server's pictures and the page's own, what the hands do on them, and a few words over them. */
import { useEffect, useRef } from "preact/hooks";
import { asksWhere, ownsKey } from "../actions";
import { NavigatorPreview } from "../filter/preview";
import { drawFrame } from "../frames";
import { ViewportInput } from "../input/viewport_input";
import { MeasureNavigator, navigatorTarget } from "../measure/navigator";
import { focusOn, press } from "../measure/hands";
import { finish, tool } from "../measure/room";
import { DrawingChooser, OwnState } from "../navigator/chooser";
import { shown } from "../navigator/choice";
import { OwnDrawing } from "../navigator/own_drawing";
import { ask, attachPainter, expectInput, pick, resize, send } from "../session";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { AxesGizmo } from "./axes";
import { LightHandles } from "./light_handle";
import { pictureClass, Probe, ProbeBar, RefinementState } from "./overlays";
import { isBusy } from "./busy";
import { watchSize } from "./pixel_size";

export function Viewport() {
  const area = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const drawn = useRef<HTMLCanvasElement>(null);

  useEffect(() => {
    const element = area.current!;
    attachPainter((frame) => drawFrame(canvas.current!, frame));
    const drawing = new OwnDrawing(drawn.current!);
    const unwatch = watchSize(element, (width, height) => {
      resize(width, height);
      drawing.resize(width, height);
    });
    const input = new ViewportInput(element, {
      send: (lines) => send({ type: "events", lines: lines.join("\n") }),
      expect: expectInput,
      click: (x, y) => {
        if (store.isEmpty.value) return;
        if (tool.value) press(navigatorTarget, x, y);
        else void pick(x, y);
      },
      ownsKey,
      asksWhere,
    });
    const focus = () => focusOn(navigatorTarget);
    element.addEventListener("focus", focus);
    const alone = () => { if (tool.value) finish(); else if (store.layout.value === "slices") store.maximised.value = store.maximised.value ? null : "navigator"; };
    element.addEventListener("dblclick", alone);
    return () => {
      unwatch();
      element.removeEventListener("dblclick", alone);
      element.removeEventListener("focus", focus);
      input.dispose();
      drawing.dispose();
    };
  }, []);

  const alone = store.maximised.value;
  return (
    <div class={`viewport-frame ${alone === "navigator" ? "maximised" : ""}`} hidden={alone !== null && alone !== "navigator"}>
      <div
        ref={area} class="viewport" data-viewport tabIndex={0} role="application" aria-roledescription="picture to be turned"
        aria-label="Navigator" aria-describedby="scene-description"
      >
        <canvas ref={canvas} class={pictureClass(store.failed.value)} role="img" aria-busy={isBusy.value} aria-label={store.description.value || "The picture of the scene"} />
        <canvas ref={drawn} class="own-drawing" aria-hidden="true" />
        <NavigatorPreview ask={(message) => ask(message)} outdated={store.outdated} />
        <Probe />
      </div>
      <p id="scene-description" class="hidden">
        {store.description.value} Arrow keys turn the picture, plus and minus come nearer and go farther, H lists all keys.
      </p>
      {shown.value && !store.failed.value ? <OwnState /> : <RefinementState frame={store.frame.value} final={store.isFinal.value} failure={store.failed.value} name={store.layout.value === "one" ? "" : "Navigator"} />}
      <MeasureNavigator area={area} />
      <LightHandles />
      <AxesGizmo />
      <ProbeBar />
      {store.isEmpty.value ? null : (
        <div class="overlay overlay-tools">
          <DrawingChooser />
          {store.layout.value === "slices" ? (
            <IconButton icon="maximise" label={alone ? "All viewports" : "Navigator alone"} pressed={alone === "navigator"} onClick={() => { store.maximised.value = alone ? null : "navigator"; }} />
          ) : null}
        </div>
      )}
    </div>
  );
}
