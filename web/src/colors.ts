/** Colours as scenes have them: "#rrggbb[aa]", a name of CSS, or linear red, green, blue. */
import type { Json } from "./protocol";

let painter: CanvasRenderingContext2D | null = null;

/** A browser knows the names of CSS, as the program does; others leave a canvas the colour it had, which no name has. */
function hexOfName(name: string): string | null {
  if (!/^[a-z]+$/i.test(name) || typeof document === "undefined") return null;
  painter ??= document.createElement("canvas").getContext("2d");
  if (!painter) return null;
  painter.fillStyle = "#010203";
  painter.fillStyle = name;
  const hex = String(painter.fillStyle);
  if (hex === "#010203") return null;
  return hex.startsWith("#") ? hex : "#000000"; // transparent: black that is not seen
}

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
  return /^#([0-9a-f]{6}|[0-9a-f]{8})$/i.test(value) ? value.slice(0, 7).toLowerCase() : hexOfName(value);
}
