/** Who draws the Navigator while a hand moves it, and at rest: what was chosen, and what follows from it. */
import { computed, signal } from "@preact/signals";
import { keep, kept } from "../storage";
import * as store from "../store";
import type { Shape } from "./shape";

export type Choice = "automatic" | "server" | "reduced" | "boxes";
type Method = Shape["method"];

export const CHOICES: readonly { value: Choice; text: string; doc: string }[] = [
  { value: "automatic", text: "Automatic", doc: "methods reduced and boxes are drawn by the page, others by the server" },
  { value: "server", text: "Frames from the server", doc: "any method; as many frames as it can make" },
  { value: "reduced", text: "Reduced surfaces", doc: "drawn by the page, as fast as the display" },
  { value: "boxes", text: "Boxes", doc: "drawn by the page, as fast as the display" },
];

function storedChoice(): Choice {
  const value = kept("drawing");
  return CHOICES.find((row) => row.value === value)?.value ?? "automatic";
}

export const choice = signal<Choice>(storedChoice());
/** The server's refined picture does not take the place of the page's own at rest. */
export const atRest = signal(kept("drawing-at-rest") === "on");

export function choose(value: Choice): void {
  choice.value = value;
  keep("drawing", value);
  store.announcement.value = `${CHOICES.find((row) => row.value === value)!.text} while the Navigator moves.`;
}

export function toggleAtRest(): void {
  atRest.value = !atRest.value;
  keep("drawing-at-rest", atRest.value ? "on" : "off");
  store.announcement.value = atRest.value ? "The page also draws at rest." : "At rest: the server's picture is shown.";
}

/** The browser draws so slowly (without a graphics card) that frames of the server are better. */
export const crawls = signal(false);

/** What the page is to draw by itself; null: frames of the server are shown. */
export const wanted = computed<Method | null>(() => {
  if (store.isEmpty.value || !store.welcome.value || choice.value === "server") return null;
  if (choice.value !== "automatic") return choice.value;
  if (crawls.value) return null;
  const method = store.valueOf(`${store.viewPath.value}.render.method`);
  return method === "reduced" || method === "boxes" ? method : null;
});

/** What stands ready to be drawn, and whether it is on the screen. */
export interface Own {
  method: Method;
  triangles: number;
  bytes: number;
}
export const own = signal<Own | null>(null);
export const shown = signal(false);
/** Shapes of what is there now are under way, or wait to be drawn. */
export const making = signal(false);
