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
  middle: "Middle drag", "left-click": "Click", "middle-click": "Middle click", "right-click": "Right click", right: "Right drag", "wheel-y": "Wheel", "wheel-x": "Wheel sideways", "-": "\u2212",
};

/** What is printed on the keycaps: ["Ctrl", "Shift", "Z"]. */
export function keycaps(chord: string): string[] {
  const parts = chord === "+" ? ["+"] : chord.endsWith("++") ? [...chord.slice(0, -2).split("+"), "+"] : chord.split("+");
  return parts.map((part) => SHOWN[part] ?? part.replace(/^Digit/, ""));
}

const MODIFIERS = ["Control", "Alt", "Meta", "Shift"];

/** "Shift+Control+Z" with its modifiers in the order that chordOf() has. */
export function inOrder(when: string): string {
  const held = new Set<string>();
  let rest = when;
  for (let found: string | undefined = ""; found !== undefined; ) {
    found = MODIFIERS.find((name) => rest.startsWith(`${name}+`) && rest.length > name.length + 1);
    if (found) held.add(found), (rest = rest.slice(found.length + 1));
  }
  return [...MODIFIERS.filter((name) => held.has(name)), rest].join("+");
}

/** By action, the keys that ask for it. */
export function keysOfActions(bindings: Binding[]): Map<string, string[]> {
  const keys = new Map<string, string[]>();
  for (const { device, method, action, when } of bindings)
    if (device === "keyboard" && method === "action" && action && when) keys.set(action, [...(keys.get(action) ?? []), when]);
  return keys;
}

export function bindingsOf(welcome: Welcome | null): Binding[] {
  const all = welcome?.bindings ?? {};
  const map = "bindings" in all && typeof all.bindings === "object" && !("device" in all.bindings) ? all.bindings : all;
  return Object.values(map as { [name: string]: Binding }).map((row) => (row.when ? { ...row, when: inOrder(row.when) } : row));
}
