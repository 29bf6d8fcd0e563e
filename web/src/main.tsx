import { effect } from "@preact/signals";
import { render } from "preact";
import { handleServerAction } from "./actions";
import { App } from "./app";
import { start } from "./session";
import { leftOpen, rightOpen, title } from "./store";
import { applyTheme } from "./theme";

applyTheme();
if (matchMedia("(max-width: 900px)").matches) {
  leftOpen.value = false; // panels lie over the picture there
  rightOpen.value = false;
}
effect(() => { document.title = title.value ? `${title.value} · VolVis` : "VolVis"; });
const root = document.getElementById("app")!;
root.replaceChildren();
render(<App />, root);
start(handleServerAction);
