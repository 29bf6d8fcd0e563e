/** Keys as people read them, and which of them the page has for itself. */
import { keyName } from "./input/events";
import type { Binding, Welcome } from "./protocol";

/** "Control+Shift+Z" of an event; modifiers alone are none. */
export function chordOf(event: KeyboardEvent): string {
  const key = keyName(event);
  const parts = [];
  if (event.ctrlKey) parts.push("Control");
  if (event.altKey) parts.push("Alt");
  if (event.metaKey) parts.push("Meta");
  if (event.shiftKey && (key.length > 1 || /[A-Z]/.test(key))) parts.push("Shift"); // "?" has its Shift in it
  return [...parts, key].join("+");
}

const SHOWN: { [name: string]: string } = {
  Control: "Ctrl", ArrowLeft: "Left", ArrowRight: "Right", ArrowUp: "Up", ArrowDown: "Down", left: "Left drag",
  middle: "Middle drag", right: "Right drag", "wheel-y": "Wheel", "wheel-x": "Wheel sideways", "-": "\u2212",
};

/** What is printed on the keycaps: ["Ctrl", "Shift", "Z"]. */
export function keycaps(chord: string): string[] {
  const parts = chord === "+" ? ["+"] : chord.endsWith("++") ? [...chord.slice(0, -2).split("+"), "+"] : chord.split("+");
  return parts.map((part) => SHOWN[part] ?? part.replace(/^Digit/, ""));
}

export function bindingsOf(welcome: Welcome | null): Binding[] {
  const all = welcome?.bindings ?? {};
  const map = "bindings" in all && typeof all.bindings === "object" && !("device" in all.bindings) ? all.bindings : all;
  return Object.values(map as { [name: string]: Binding });
}
