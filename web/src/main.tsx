import { effect } from "@preact/signals";
import { render } from "preact";
import { handleServerAction } from "./actions";
import { App } from "./app";
import { watchPanels } from "./panels";
import { start } from "./session";
import { shownTitle } from "./store";
import { applyTheme } from "./theme";

applyTheme();
watchPanels();
effect(() => { document.title = shownTitle.value ? `${shownTitle.value} · VolVis` : "VolVis"; });
const root = document.getElementById("app")!;
root.replaceChildren();
render(<App />, root);
start(handleServerAction);
