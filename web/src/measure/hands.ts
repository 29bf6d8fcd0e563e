/** Clicks and keys of a tool: where they are in the World is for the viewport to say. */
import type { Pick } from "../protocol";
import type { Vec3 } from "../slices/geometry";
import * as store from "../store";
import type { Frame } from "./regions";
import { draft, finish, hover, isOpen, place, takeBack, takeTool, tool } from "./room";

/** A viewport: what is at a place of it, from 0 to 1 from the top left. */
export interface Target {
  name: string;
  /** Exactly, in the plane that one draws in; null where only what is seen has a place. */
  at(x: number, y: number): Vec3 | null;
  pick(x: number, y: number): Promise<Pick | null>;
  /** The plane that flat regions are drawn in. */
  frame?(): Frame | null;
  /** Where keys place points. */
  middle(): [number, number];
}

let order = Promise.resolve(); // answers come one after the other, as the clicks did

export function press(target: Target, x: number, y: number): void {
  const at = target.at(x, y);
  order = order.then(async () => {
    const seen = await target.pick(x, y);
    const there = at ?? target.at(x, y) ?? (seen?.hit ? (seen.position as Vec3 | null) : null);
    if (there) place(there, seen, target.frame?.() ?? null);
    else store.notify("info", "Nothing is seen there: points are placed on what is seen, or in slices.");
  });
}

export function pointAt(target: Target, x: number, y: number): void {
  if (tool.value) hover.value = { where: target.name, x, y, at: target.at(x, y) };
}

const NEAR = 6; // pixels

/** A press, and the release of the same hand: a drag of some length gives the other end, too. */
export function release(target: Target, from: [number, number], to: [number, number], size: [number, number]): void {
  const drawn = traced !== null;
  traced = null;
  if (tool.value && drawn) order = order.then(finish);
  else if (tool.value && far(from, to, size) > NEAR) press(target, ...to);
}

const far = (a: [number, number], b: [number, number], size: [number, number]): number => Math.hypot((b[0] - a[0]) * size[0], (b[1] - a[1]) * size[1]);

/** Where the outline that is drawn in one go has its last corner. */
let traced: [number, number] | null = null;

/** A hand that goes on from where it was pressed draws an outline. */
export function trace(target: Target, from: [number, number], to: [number, number], size: [number, number]): void {
  const at = target.at(...to);
  if (tool.value?.takes !== "polygon" || !at || far(traced ?? from, to, size) < NEAR) return;
  traced = to;
  order = order.then(() => place(at, null, target.frame?.() ?? null));
}

/** The viewport that has the focus, for keys. */
let focused: Target | null = null;
export function focusOn(target: Target | null): void {
  focused = target;
}

function onKey(event: KeyboardEvent): void {
  const element = event.target as HTMLElement | null;
  if (!isOpen.value || !tool.value || store.dialog.value || event.ctrlKey || event.altKey || event.metaKey) return;
  if (element?.closest?.("input, textarea, select, button, [role=button]") && event.key !== "Escape") return;
  const inViewport = element?.closest?.(".viewport") != null;
  if (event.key === "Escape" && draft.value.length) draft.value = [];
  else if (event.key === "Escape") takeTool(null);
  else if (event.key === "Backspace" && draft.value.length) takeBack();
  else if (event.key === "Enter" && draft.value.length) finish();
  else if (event.key === " " && inViewport && focused) press(focused, ...focused.middle());
  else return;
  event.preventDefault();
  event.stopPropagation();
}

/** Before viewports and bindings hear of them. Returns what ends it. */
export function listenToKeys(): () => void {
  window.addEventListener("keydown", onKey, true);
  return () => window.removeEventListener("keydown", onKey, true);
}
