/** Everything that can be asked for by name: from buttons, keys and the command search. */
import { signal } from "@preact/signals";
import { copyText } from "./clipboard";
import { addCutPlane, toggleCutPlane, turnCutPlane } from "./cut_planes";
import { begin, hindrance } from "./filter/state";
import { GESTURES } from "./gestures";
import type { IconName } from "./icons";
import { isOpen as measuring, toggleRoom } from "./measure/room";
import { bindingsOf, chordOf, keysOfActions } from "./keys";
import { atRest, choice, CHOICES, choose, toggleAtRest, wanted } from "./navigator/choice";
import { togglePanel, togglePanels } from "./panels";
import type { ActionMessage, Json } from "./protocol";
import { addSelected, send, tryAsk, tryEdit } from "./session";
import { keep, kept } from "./storage";
import * as store from "./store";
import { toggleTheme } from "./theme";
import { freeName, label, labelOf } from "./values";

export interface Action {
  name: string;
  title: string;
  doc?: string;
  group: string;
  icon?: IconName;
  keys?: string[];
  enabled?: () => boolean;
  run: () => void;
}

const open = (name: "search" | "help" | "save" | "picture" | "sessions" | "filters") => () => {
  store.dialog.value = { name };
};
const mayEdit = () => !store.readOnly.value;
const somethingShown = () => !store.isEmpty.value;

/** Of this client's commits. */
function step(type: "undo" | "redo"): void {
  void tryAsk({ type });
}

export function addObject(map: "lights", value: Json): void {
  const id = freeName(store.idsOf(map), "light");
  addSelected(`${map}.${id}`, map, id, value);
}

const lightingPath = () => store.lightingAt(`${store.viewPath.value}.render`);

function toggleLighting(): void {
  const path = lightingPath();
  if (path) tryEdit(store.valueOf(path) === "cinematic" ? { op: "unset", path } : { op: "set", path, value: "cinematic" });
}

/** Lines and letters over the picture of this viewport. */
function toggleDecoration(name: string): void {
  const path = `${store.viewPath.value}.decorations.${name}`;
  tryEdit({ op: "set", path, value: store.valueOf(path) !== true });
}

async function copyCommand(): Promise<void> {
  const value = await tryAsk<{ text: string }>({ type: "command" });
  if (value) await copyText(value.text);
}

const LAYOUTS: store.Layout[] = ["one", "two", "slices"];
const LAYOUT_WORDS = { one: "The Navigator alone.", two: "The Rendering viewport is beside the Navigator.", slices: "Axial, coronal and sagittal slices are beside the Navigator." };

function setLayout(layout: store.Layout): void {
  store.layout.value = layout;
  store.maximised.value = null;
  store.announcement.value = LAYOUT_WORDS[layout];
}

function toggleLayout(layout: store.Layout): void {
  setLayout(store.layout.value === layout ? "one" : layout);
}

const own: Action[] = [
  { name: "new", title: "Start over", doc: "nothing is open; undo brings it back", group: "File", icon: "new", enabled: () => mayEdit() && somethingShown(), run: () => void tryAsk({ type: "new" }) },
  { name: "open", title: "Open a file", group: "File", icon: "open", enabled: mayEdit, run: () => { store.dialog.value = { name: "open", add: false }; } },
  { name: "add", title: "Add a file to the scene", group: "File", icon: "add", enabled: mayEdit, run: () => { store.dialog.value = { name: "open", add: true }; } },
  { name: "save", title: "Save the scene", group: "File", icon: "save", enabled: mayEdit, run: open("save") },
  { name: "picture", title: "Save a picture", group: "File", icon: "picture", enabled: somethingShown, run: open("picture") },
  { name: "picture-plain", title: "Save a picture without overlays", group: "File", icon: "picture", enabled: somethingShown, run: () => { store.dialog.value = { name: "picture", plain: true }; } },
  { name: "command", title: "Copy as a command line", group: "File", icon: "terminal", enabled: somethingShown, run: () => void copyCommand() },
  { name: "undo", title: "Undo", group: "Edit", icon: "undo", enabled: () => store.canUndo.value, run: () => step("undo") },
  { name: "redo", title: "Redo", group: "Edit", icon: "redo", enabled: () => store.canRedo.value, run: () => step("redo") },
  { name: "filter", title: "Filter", doc: "all operations on data, with a preview", group: "Edit", icon: "operation", enabled: () => mayEdit() && somethingShown(), run: open("filters") },
  { name: "add-light", title: "Add a light", group: "Edit", icon: "light", enabled: mayEdit, run: () => addObject("lights", { frame: "camera", intensity: 0.5 }) },
  { name: "cinematic", title: "Shadows and ambient occlusion on or off", doc: "cinematic lighting", group: "Edit", icon: "light", enabled: () => mayEdit() && somethingShown() && lightingPath() !== null, run: toggleLighting },
  { name: "add-cut-plane", title: "Add a cut plane", group: "Edit", icon: "cut", enabled: mayEdit, run: addCutPlane },
  { name: "cut", title: "Cut plane on or off", group: "Edit", icon: "cut", enabled: () => mayEdit() && somethingShown(), run: toggleCutPlane },
  { name: "cut-next", title: "Cut from the next side", group: "Edit", icon: "cut", enabled: () => mayEdit() && somethingShown(), run: turnCutPlane },
  { name: "axes", title: "Coordinates on or off", group: "Overlays", icon: "axes", enabled: mayEdit, run: () => toggleDecoration("axes") },
  { name: "box", title: "Boxes around volumes on or off", group: "Overlays", icon: "volume", enabled: mayEdit, run: () => toggleDecoration("box") },
  { name: "scale-bar", title: "Scale bar on or off", group: "Overlays", icon: "scale", enabled: mayEdit, run: () => toggleDecoration("scale_bar") },
  { name: "search", title: "Search commands", group: "Page", icon: "search", run: open("search") },
  { name: "help", title: "Keys and gestures", group: "Page", icon: "help", run: open("help") },
  { name: "theme", title: "Dark or light theme", group: "Page", icon: "theme", run: toggleTheme },
  { name: "split", title: "Rendering viewport beside the Navigator", group: "Page", icon: "split", enabled: somethingShown, run: () => toggleLayout("two") },
  { name: "slices", title: "Slices beside the Navigator", doc: "axial, coronal, sagittal", group: "Page", icon: "slices", enabled: somethingShown, run: () => toggleLayout("slices") },
  { name: "layout", title: "Next layout of viewports", group: "Page", icon: "split", enabled: somethingShown, run: () => { setLayout(LAYOUTS[(LAYOUTS.indexOf(store.layout.value) + 1) % LAYOUTS.length]!); } },
  { name: "measure", title: "Measurement room", doc: "points, distances, angles, profiles, regions, a table of all", group: "Page", icon: "measure", enabled: () => somethingShown() || measuring.value, run: toggleRoom },
  { name: "left-panel", title: "Show or hide the scene", group: "Page", icon: "panel-left", run: () => togglePanel("left") },
  { name: "right-panel", title: "Show or hide the inspector", group: "Page", icon: "panel-right", run: () => togglePanel("right") },
  { name: "panels", title: "Show or hide both panels", group: "Page", icon: "maximise", run: togglePanels },
  { name: "sessions", title: "End all sessions", doc: "everybody is sent away, and the link changes", group: "Page", icon: "people", enabled: mayEdit, run: open("sessions") },
  { name: "letters", title: "Single-letter keys on or off", group: "Page", run: () => { toggleLetters(); } },
];

function drawings(): Action[] {
  const rows: Action[] = CHOICES.map((row) => ({
    name: `drawing-${row.value}`, title: `While the Navigator moves: ${row.text}`, doc: row.doc, group: "Drawing", icon: "view", enabled: somethingShown,
    run: () => choose(row.value),
  }));
  const next = () => choose(CHOICES[(CHOICES.findIndex((row) => row.value === choice.value) + 1) % CHOICES.length]!.value);
  rows.push({ name: "drawing", title: "Drawing while the Navigator moves: next", group: "Drawing", icon: "view", enabled: somethingShown, run: next });
  const title = atRest.value ? "At rest: the server's picture" : "At rest: the page's own drawing too";
  return [...rows, { name: "drawing-at-rest", title, group: "Drawing", icon: "rest", enabled: () => wanted.value !== null, run: toggleAtRest }];
}

const NAVIGATOR: [string, string, IconName][] = [
  ["fit", "See everything", "fit"], ["front", "Front", "view"], ["back", "Back", "view"], ["right", "Right side", "view"],
  ["left", "Left side", "view"], ["top", "Top", "view"], ["bottom", "Bottom", "view"],
  ["view-back", "Previous view", "undo"], ["view-forward", "Next view", "redo"],
  ["isometric", "Isometric", "view"], ["projection", "Perspective or parallel", "projection"],
];

/** The server knows what these do. */
function navigator_(): Action[] {
  return NAVIGATOR.map(([name, title, icon]) => ({
    name, title, icon, group: "Navigator", enabled: somethingShown, run: () => void send({ type: "action", name }),
  }));
}

function operations(): Action[] {
  return (store.welcome.value?.operations ?? []).map((operation) => ({
    name: `operation-${operation.name}`,
    title: label(operation.name),
    doc: operation.doc,
    group: label(operation.group),
    icon: "operation" as const,
    enabled: () => hindrance(operation) === "",
    run: () => begin(operation.name),
  }));
}

/** Opacity and colours that were set by hand would hide the preset: they go with the same step. */
export function choosePreset(name: string): void {
  const volume = store.currentVolume.value;
  const preset = store.welcome.value?.presets.find((row) => row.name === name);
  if (!volume) return;
  const path = `volumes.${volume}.segmentation.transfer`;
  const unset = (row: string) => (store.isSet(`${path}.${row}`) ? [{ op: "unset" as const, path: `${path}.${row}` }] : []);
  if (preset && preset.kind !== "colormap")
    tryEdit({ op: "set", path: `${path}.preset`, value: name }, ...unset("opacity"), ...unset("color"),
      ...unset("opacity_length"), ...unset("colormap"));
  else tryEdit({ op: "set", path: `${path}.colormap`, value: name }, ...unset("color"));
}

function presets(): Action[] {
  return (store.welcome.value?.presets ?? []).map((preset) => ({
    name: `preset-${preset.name}`,
    title: label(preset.name),
    doc: preset.doc,
    group: preset.kind === "colormap" ? "Colour map" : "Transfer function",
    icon: "transfer" as const,
    enabled: () => mayEdit() && store.currentVolume.value !== null,
    run: () => choosePreset(preset.name),
  }));
}

function renderers(): Action[] {
  return (store.welcome.value?.renderers ?? []).map((renderer) => ({
    name: `renderer-${renderer.name}`,
    title: renderer.label,
    doc: renderer.doc,
    group: "Rendering method",
    icon: "render" as const,
    enabled: mayEdit,
    run: () => tryEdit({ op: "set", path: `${store.viewPath.value}.render.method`, value: renderer.name }),
  }));
}

/** Every property of what is selected. */
function properties(): Action[] {
  const path = store.selection.value;
  const found: Action[] = [];
  const walk = (className: string, at: string, before: string) => {
    for (const row of store.classes.value[className]?.properties ?? []) {
      const where = at ? `${at}.${row.name}` : row.name;
      if (row.kind === "object" && row.class) walk(row.class, where, `${before}${labelOf(row)} › `);
      else if (row.kind !== "map" && row.kind !== "list" && row.kind !== "variants")
        found.push({
          name: `property-${where}`, title: labelOf(row), doc: `${before}${row.doc}${labelOf(row) === label(row.name) ? "" : ` (${row.name})`}`, group: "Property",
          icon: "property", run: () => { store.rightOpen.value = true; focusProperty.value = where; },
        });
    }
  };
  const [map] = path.split(".");
  const top = store.classes.value["world"]?.properties.find((row) => row.name === map);
  if (top?.class && path) walk(top.class, path, "");
  return found;
}

/** The inspector opens the groups above this property and puts the focus there. */
export const focusProperty = signal("");

/** All, with the keys that are bound to them. */
export function allActions(): Action[] {
  const keys = keysOfActions(bindingsOf(store.welcome.value));
  const all = [...own, ...navigator_(), ...drawings(), ...renderers(), ...presets(), ...operations(), ...properties()];
  return all.map((action) => ({ ...action, keys: keys.get(action.name) }));
}

export function runAction(name: string): boolean {
  const action = [...own, ...navigator_()].find((row) => row.name === name) ?? allActions().find((row) => row.name === name);
  if (!action || action.enabled?.() === false) return false;
  action.run();
  return true;
}

// Keys -------------------------------------------------------------------------------------------------------------

let lettersOn = kept("letters") !== "off";

/** People who speak to their computer set off single letters by accident (WCAG 2.1.4). */
function toggleLetters(): void {
  lettersOn = !lettersOn;
  keep("letters", lettersOn ? "on" : "off");
  store.notify("info", lettersOn ? "Single-letter keys are on." : "Single-letter keys are off; keys with Ctrl still work.");
}

function isTyping(target: EventTarget | null): boolean {
  const element = target as HTMLElement | null;
  return !!element?.closest?.("input:not([type=range]):not([type=checkbox]), textarea, select");
}

/** What the server does with the keys that it is sent: undo is the same here and there. */
const SERVERS = ["undo", "redo", ...NAVIGATOR.map(([name]) => name)];

function boundTo(chord: string): string | undefined {
  return bindingsOf(store.welcome.value).find((row) => row.device === "keyboard" && row.method === "action" && row.when === chord)?.action ?? undefined;
}

/** Of the keys that are bound, the page's own while the viewport has the focus; all others are the server's, which knows
 * where the pointer was. */
export function ownsKey(event: KeyboardEvent): boolean {
  const chord = chordOf(event);
  if (chord.length === 1 && !lettersOn) return true;
  const action = boundTo(chord);
  return action !== undefined && !SERVERS.includes(action) && !GESTURES[action];
}

/** "Look at what is under the pointer". */
export function asksWhere(event: KeyboardEvent): boolean {
  return GESTURES[boundTo(chordOf(event)) ?? ""] !== undefined;
}

/** Called for keys that nothing on the page has taken. */
export function handleKey(event: KeyboardEvent): void {
  const chord = chordOf(event);
  const inViewport = !!(event.target as HTMLElement | null)?.closest?.("[data-viewport]");
  if (event.defaultPrevented || event.isComposing) return;
  const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
  if (isTyping(event.target) && (plain || /\+[ZYA-CVX]$/.test(chord) && !/\+(K|S|O)$/.test(chord)) && !/^F\d+$/.test(chord)) return;
  if (plain && chord.length === 1 && !lettersOn) return;
  if (store.dialog.value && chord !== "Control+K") return;
  const action = boundTo(chord);
  if (!action || (inViewport && !ownsKey(event))) return;
  if (!inViewport && (chord === "Enter" || chord === "Space")) return; // those of buttons
  event.preventDefault();
  runAction(action);
}

/** Bindings ask for what the page does itself. */
export function handleServerAction(message: ActionMessage): void {
  const gesture = GESTURES[message.name];
  if (gesture) gesture.run(message);
  else if (!message.phase || message.phase === "begin") runAction(message.name);
}
