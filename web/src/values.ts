/** Values of the World by path, and how numbers are shown and read. */
import type { Json, JsonObject, ObjectClass, Property } from "./protocol";

export type Classes = { [name: string]: ObjectClass };

export function isObject(value: Json | undefined): value is JsonObject {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

/** The value at "volumes.head.place"; undefined where there is none. "" is the root. */
/** Whether a property acts beside others (Property.when), of which `of` has the values; what is worked out may be anything. */
export function acts(when: string | null | undefined, of: (name: string) => Json | undefined): boolean {
  const [name, values] = (when ?? "").split("=");
  if (!name) return true;
  if (values === undefined) return name.split("|").some((one) => of(one) !== undefined);
  const value = of(name);
  return value === undefined || values.split("|").includes(String(value));
}

export function valueAt(root: Json | undefined, path: string): Json | undefined {
  let value: Json | undefined = root;
  if (path === "") return value;
  for (const part of path.split(".")) {
    if (Array.isArray(value)) value = value[Number(part)];
    else if (isObject(value)) value = Object.hasOwn(value, part) ? value[part] : undefined;
    else return undefined;
  }
  return value;
}

export function join(path: string, name: string | number): string {
  return path === "" ? String(name) : `${path}.${name}`;
}

/** "range_lo" is "Range lo", "top-hat" "Top hat": the words that scenes and command lines have, so that one can be found by the other. */
export function label(name: string): string {
  const words = name.replace(/[_-]/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** What panels call a property. */
export function labelOf(row: Property): string {
  return label(row.label ?? row.name);
}

/** What a tool tip says of it, with the word that scenes and command lines have where that is another. */
export function tipOf(row: Property): string {
  const automatic = row.automatic ? ` Automatic: ${row.automatic}.` : "";
  return `${sentence(row.doc)}${automatic}${row.label ? ` In scenes and lines: ${row.name}.` : ""}`;
}

/** Docs of tables are lines without capital and full stop. */
export function sentence(doc: string): string {
  return doc ? doc.charAt(0).toUpperCase() + doc.slice(1) + (doc.endsWith(".") ? "" : ".") : "";
}

/** Up to four significant digits, without trailing zeros; powers of ten for what is very large or small. */
export function formatNumber(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-4) return value.toExponential(Math.max(0, digits - 1)).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(value.toPrecision(size >= 10 ** digits ? Math.ceil(Math.log10(size + 1)) : digits)));
}

export function formatBytes(bytes: number): string {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let at = 0;
  let value = bytes;
  while (value >= 1024 && at < units.length - 1) {
    value /= 1024;
    at++;
  }
  return `${value >= 100 || at === 0 ? Math.round(value) : value.toFixed(1)} ${units[at]}`;
}

export function formatSeconds(seconds: number): string {
  if (seconds < 60) return `${Math.max(1, Math.round(seconds))} s`;
  return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/** What stands beside a number: "mm", "°", "value". */
export function unitOf(property: Property, lengthUnit: string, valueUnit: string): string {
  switch (property.quantity) {
    case "length":
      return lengthUnit;
    case "angle":
      return "°";
    case "time":
      return "s";
    default:
      if (property.unit === "value") return valueUnit;
      if (property.unit === "value per length") return `${valueUnit || "1"}/${lengthUnit}`;
      if (property.unit === "per length") return `1/${lengthUnit}`;
      return property.unit ?? "";
  }
}

/** A number, or, where it has a unit of its own ("1.5mm"), the text as it is: the server reads it. */
export function parseEntry(text: string): Json | undefined {
  const plain = text.trim().replace(/,/g, ".").replace(/\u2212/g, "-");
  if (plain === "") return undefined;
  const value = Number(plain);
  return Number.isFinite(value) ? value : text.trim();
}

/** Numbers of labels have 64 bits: beyond 2^53 they are text with all of their digits, both ways. */
export function parseLabel(text: string): Json | undefined {
  const plain = text.trim().replace(/\u2212/g, "-");
  return /^[-+]?\d+$/.test(plain) && !Number.isSafeInteger(Number(plain)) ? plain : parseEntry(text);
}

/** The numbers of a line; where rows begin with labels, `every` is how long they are, else 0. */
export function parseRow(line: string, every: number): Json[] {
  return line.split(/[,;\s]+/).filter(Boolean).map((word, i) => (every > 0 && i % every === 0 ? parseLabel(word) ?? null : Number(word)));
}

/** How a slider runs over a property's range; null: the range is too wide for one. */
export interface SliderScale {
  toShare(value: number): number;
  toValue(share: number): number;
}

const WIDEST = 1e5;
const MOST_STEPS = 1000;

export function sliderScale(property: Property): SliderScale | null {
  const { min, max, kind } = property;
  if (min == null || max == null || !(max > min) || max - min > WIDEST) return null;
  if (kind === "integer" && min <= 0 && max - min > MOST_STEPS) return null;
  const round = (value: number) => (kind === "integer" ? Math.round(value) : Number(value.toPrecision(4)));
  if (min > 0 && max / min >= 1000) {
    const decades = Math.log(max / min);
    return { toShare: (v) => Math.log(Math.max(min, v) / min) / decades, toValue: (s) => round(min * Math.exp(s * decades)) };
  }
  return { toShare: (v) => (v - min) / (max - min), toValue: (s) => round(min + s * (max - min)) };
}

/** The class of the object at a path, found by walking the tables from the World's. */
export function classAt(classes: Classes, path: string): string | null {
  let name = "world";
  const parts = path === "" ? [] : path.split(".");
  for (let i = 0; i < parts.length; i++) {
    const property = classes[name]?.properties.find((row) => row.name === parts[i]);
    if (!property?.class) return null;
    name = property.class;
    if (property.kind === "map" || property.kind === "list") i++;
  }
  return name;
}

/** Whether the entry of a map or list that a path leads to, or is within, is there. */
export function hasEntry(world: JsonObject, path: string): boolean {
  const [map, id] = path.split(".");
  if (!map || id === undefined) return true;
  const all = world[map];
  return Array.isArray(all) ? Number(id) < all.length : isObject(all) && Object.hasOwn(all, id);
}

/** What is wrong with a value before it is sent; "": nothing. Whole numbers beyond 2^53 are no longer those that were typed. */
export function flawOf(value: Json | undefined, kind: string): string {
  const isTooLarge = kind === "integer" && typeof value === "number" && Number.isInteger(value) && !Number.isSafeInteger(value);
  return isTooLarge ? `Whole numbers beyond ${Number.MAX_SAFE_INTEGER} are not accepted.` : "";
}

/** A name that the map does not have yet: "light", "light2". */
export function freeName(taken: Iterable<string>, wish: string): string {
  const names = new Set(taken);
  if (!names.has(wish)) return wish;
  for (let i = 2; ; i++) if (!names.has(`${wish}${i}`)) return `${wish}${i}`;
}

/** What people call an object: its title where it has one, else its name in the World. */
export function titleOf(object: Json | undefined, id: string): string {
  const title = isObject(object) ? object["title"] : null;
  return typeof title === "string" && title !== "" ? title : id;
}
