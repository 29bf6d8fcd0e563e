/** Colours as scenes have them: "#rrggbb[aa]", a basic CSS name, or linear red, green, blue. */
import type { Json } from "./protocol";

const NAMES: { [name: string]: string } = {
  black: "#000000", silver: "#c0c0c0", gray: "#808080", grey: "#808080", white: "#ffffff", maroon: "#800000",
  red: "#ff0000", purple: "#800080", fuchsia: "#ff00ff", magenta: "#ff00ff", green: "#008000", lime: "#00ff00",
  olive: "#808000", yellow: "#ffff00", navy: "#000080", blue: "#0000ff", teal: "#008080", aqua: "#00ffff",
  cyan: "#00ffff", orange: "#ffa500",
};

/** IEC 61966-2-1. */
export function encodeSrgb(linear: number): number {
  const v = Math.min(1, Math.max(0, linear));
  return v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
}

export function decodeSrgb(encoded: number): number {
  const v = Math.min(1, Math.max(0, encoded));
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
}

function byte(share: number): string {
  return Math.round(share * 255).toString(16).padStart(2, "0");
}

export function hexOfLinear(rgb: readonly number[]): string {
  return "#" + [0, 1, 2].map((i) => byte(encodeSrgb(rgb[i] ?? 0))).join("");
}

export function linearOfHex(hex: string): [number, number, number] {
  const at = (i: number) => Number(decodeSrgb(parseInt(hex.slice(1 + 2 * i, 3 + 2 * i), 16) / 255).toFixed(5));
  return [at(0), at(1), at(2)];
}

/** "#rrggbb"; null where the value is no colour that this page can show. */
export function hexOf(value: Json | undefined): string | null {
  if (Array.isArray(value)) return value.length >= 3 ? hexOfLinear(value.map(Number)) : null;
  if (typeof value !== "string") return null;
  const name = NAMES[value.toLowerCase()];
  if (name) return name;
  return /^#([0-9a-f]{6}|[0-9a-f]{8})$/i.test(value) ? value.slice(0, 7).toLowerCase() : null;
}
