/** The page: bar, rail, picture, inspector, status line, and what lies over them. */
import { useEffect, useState } from "preact/hooks";
import { handleKey } from "./actions";
import { Dialogs } from "./dialogs/dialogs";
import { FilterPanel } from "./filter/panel";
import { plan } from "./filter/state";
import { Inspector } from "./inspector/inspector";
import { MeasureRoom } from "./measure/panel";
import { tool } from "./measure/room";
import { ConnectionNotice, LiveRegion, Notices } from "./notices";
import { Rail } from "./scene/rail";
import { SliceViewports } from "./slices/slice_viewport";
import { StartPage } from "./start_page";
import { StatusBar } from "./status_bar";
import * as store from "./store";
import { TopBar } from "./top_bar";
import { upload } from "./uploads";
import { RenderingViewport } from "./view/rendering_viewport";
import { Viewport } from "./view/viewport";

/** Files that are dropped anywhere are opened; the browser must not leave for it. */
function useDrop(): boolean {
  const [over, setOver] = useState(false);
  useEffect(() => {
    const stop = new AbortController();
    const on = (type: string, fn: (event: DragEvent) => void) => window.addEventListener(type, fn as EventListener, { signal: stop.signal });
    on("dragover", (event) => { event.preventDefault(); setOver(true); });
    on("dragleave", (event) => { if (!event.relatedTarget) setOver(false); });
    on("drop", (event) => {
      event.preventDefault();
      setOver(false);
      const files = [...(event.dataTransfer?.files ?? [])];
      if (!files.length) return;
      if (store.readOnly.value) store.notify("warning", "This session is read-only: files cannot be opened.");
      else void upload(files, event.shiftKey);
    });
    return () => stop.abort();
  }, []);
  return over;
}

export function App() {
  const over = useDrop();
  useEffect(() => {
    window.addEventListener("keydown", handleKey);
    return () => window.removeEventListener("keydown", handleKey);
  }, []);
  const layout = store.isEmpty.value ? "one" : store.layout.value;
  const classes = ["page", store.leftOpen.value ? "" : "no-left", store.rightOpen.value ? "" : "no-right"];
  return (
    <div class={classes.join(" ")}>
      <TopBar />
      {store.leftOpen.value ? <Rail /> : null}
      <main class={`centre ${tool.value ? "measuring" : ""}`} aria-label="Picture">
        <div class={`viewports viewports-${layout} ${store.maximised.value ? "viewports-alone" : ""}`}>
          <Viewport />
          {layout === "two" ? <RenderingViewport /> : null}
          {layout === "slices" ? <SliceViewports /> : null}
        </div>
        <MeasureRoom />
        {store.isEmpty.value ? <StartPage /> : null}
        <ConnectionNotice />
        {over ? <div class="drop" aria-hidden="true"><p>Drop to open. With Shift: add to the scene.</p></div> : null}
      </main>
      {store.rightOpen.value ? (plan.value ? <FilterPanel /> : <Inspector />) : null}
      <StatusBar />
      <Notices />
      <Dialogs />
      <LiveRegion />
    </div>
  );
}
