/** The Measurement room: the tool in hand, what it has been shown so far, and what comes out of every measurement. */
import { computed, effect, signal } from "@preact/signals";
import type { Edit, Json, JsonObject, Pick } from "../protocol";
import { ask, edit, Gesture, tryAsk, tryEdit } from "../session";
import type { Vec3 } from "../slices/geometry";
import * as store from "../store";
import { freeName, isObject, valueAt } from "../values";
import { boxBetween, cross, dot, minus, toIndex } from "./geometry";
import { frameOf, handlesOf, isFlat, movedRegion, regionOf, type Frame } from "./regions";
import { figuresOf, rowOf, type Figure, type Row } from "./rows";
import { hintOf, kindsOnMeshes, toolsOf, type Tool } from "./tools";

export const isOpen = signal(false);
export const tools = computed(() => toolsOf(store.welcome.value?.measures ?? []));
export const tool = signal<Tool | null>(null);
/** Nothing that is seen has samples. */
const onlyMeshes = computed(() => {
  const seen = store.volumeIds.value.filter((id) => store.valueOf(`volumes.${id}.visible`) !== false);
  return seen.length > 0 && seen.every((id) => store.isMesh(id));
});
/** What a tool can measure of what is there; none: it is of no use. */
export const kindsOf = (of: Tool, ofMesh = onlyMeshes.value): string[] => (ofMesh ? kindsOnMeshes(of, store.welcome.value?.measures ?? []) : of.kinds);
/** Of a tool that can measure several things of what is clicked: which. */
export const wish = signal<{ [tool: string]: string }>({});
export const kindOf = (of: Tool, ofMesh = onlyMeshes.value): string => {
  const kinds = kindsOf(of, ofMesh);
  return kinds.find((kind) => kind === wish.value[of.name]) ?? kinds[0] ?? of.kinds[0]!;
};

/** A place, and what was under the pointer there. */
export interface Place {
  at: Vec3;
  seen: Pick | null;
  /** Of the plane that is drawn in: of the slice, or as the Navigator is looked into. */
  frame: Frame | null;
}
export const draft = signal<Place[]>([]);
export const hint = (of: Tool): string => hintOf(of, draft.value.length, onlyMeshes.value);
/** Where the pointer is: in which viewport, in shares of it, and, in a slice, in the World. */
export const hover = signal<{ where: string; x: number; y: number; at: Vec3 | null } | null>(null);
/** Measurements are being asked for the first time. */
export const pending = signal(0);

export function toggleRoom(): void {
  isOpen.value = !isOpen.value;
  if (!isOpen.value) takeTool(null);
}

export function takeTool(next: Tool | null): void {
  tool.value = next;
  draft.value = [];
  hover.value = null;
  if (next) store.announcement.value = `${next.title}. ${hint(next)}`;
}

// What is measured --------------------------------------------------------------------------------------------------

/** Properties that say of what, and not what is measured of it: the message names those beside the question. */
const BESIDE = ["title", "figures", "visible", "volume"];
/** Paths of files, which pages do not open. */
const FILES = ["file", "other", "mask", "values", "input_unit"];

const objectAt = (id: string): JsonObject => {
  const value = valueAt(store.world.value, `measurements.${id}`);
  return isObject(value) ? value : {};
};

function firstVisible(): string | null {
  return store.volumeIds.value.find((id) => store.valueOf(`volumes.${id}.visible`) !== false) ?? null;
}

export function volumeOf(measurement: JsonObject): string | null {
  const named = measurement["volume"];
  return typeof named === "string" ? named : firstVisible();
}

export interface Answer {
  answer: JsonObject;
  notes: string[];
  figures: Figure[];
  plot?: string | null;
}

/** The samples of the scene's own file, or of any other that it names, are those that the World shows. */
function isOfFiles(measurement: JsonObject): boolean {
  const own = Object.values(isObject(store.world.value["datasets"]) ? store.world.value["datasets"] : {}).map((data) => (isObject(data) ? data["path"] : null));
  return FILES.some((name) => name in measurement && !(name === "file" && own.includes(measurement[name])));
}

function messageOf(measurement: JsonObject, more: object = {}): { type: string; [name: string]: unknown } {
  const question = Object.fromEntries(Object.entries(measurement).filter(([name]) => !BESIDE.includes(name) && !FILES.includes(name)));
  const volume = measurement["volume"];
  return { type: "measure", question, ...(typeof volume === "string" ? { volume } : {}), ...more };
}

export async function measure(measurement: JsonObject): Promise<Answer> {
  const value = await ask<Answer>(messageOf(measurement));
  return { ...value, figures: figuresOf(value.figures as unknown as Json) };
}

/** What it is called in the World: as its tool, and its label. */
function nameOf(of: Tool, measurement: JsonObject): string {
  if (of.takes === "label") return `label_${measurement["label"]}`;
  if (of.takes === "nothing") return kindOf(of);
  return of.takes === "points" ? of.name : of.title.toLowerCase();
}

/** Asked first: what cannot be measured is told, and does not come into the World. */
async function add(of: Tool, measurement: JsonObject): Promise<void> {
  pending.value++;
  try {
    const { figures, notes } = await measure(measurement);
    const id = freeName(store.idsOf("measurements"), nameOf(of, measurement));
    await edit({ op: "add", path: "measurements", id, value: { ...measurement, figures: figures as unknown as Json } });
    store.selection.value = `measurements.${id}`;
    for (const note of notes) store.notify("info", note);
  } catch (error) {
    store.notify("error", (error as Error).message);
  } finally {
    pending.value--;
  }
}

const rounded = (p: Vec3): Vec3 => p.map((v) => Number(v.toPrecision(9)) || 0) as Vec3;

/** The volume of the World is named where it is not the one that is measured anyway. */
function ofVolume(seen: Pick | null): JsonObject {
  const volume = seen?.volume ?? store.currentVolume.value;
  return volume && volume !== firstVisible() ? { volume } : {};
}

function boxOf(places: Place[]): JsonObject | string {
  const volume = places.find((place) => place.seen?.volume)?.seen?.volume ?? firstVisible();
  const info = volume ? store.dataInfos.value[store.datasetOf(volume) ?? ""] : undefined;
  if (!volume || !info || typeof info === "string") return "There is no volume of samples there.";
  if (store.isSet(`volumes.${volume}.place`)) return `The scene moves ${volume}: its region is given as numbers of samples, in the inspector.`;
  if (info["unit"] !== store.lengthUnit.value) return `${volume} is in ${String(info["unit"])} and the scene in ${store.lengthUnit.value}: its region is given as numbers of samples, in the inspector.`;
  const [a, b] = places.map((place) => toIndex(info, place.at));
  const box = a && b ? boxBetween(a, b, info["dims"] as number[]) : null;
  return box ? { box, ...(volume !== firstVisible() ? { volume } : {}) } : "No sample lies in that region.";
}

/** Beside a volume, what is clicked decides. */
const isOfMesh = (place: Place | undefined): boolean => (place?.seen?.volume ? store.isMesh(place.seen.volume) : onlyMeshes.value);

/** Meshes have no slices: what is drawn on them goes through, from the eye on and as far behind; 0: in a slice of a volume. */
function depthAt(place: Place): number {
  const { at } = place;
  const eye = store.pose.value?.eye;
  return isOfMesh(place) && eye ? Number((2 * Math.hypot(...minus(at, eye as Vec3))).toPrecision(3)) : 0;
}

/** What a tool makes of its clicks; a sentence: it makes nothing of them. */
function measurementOf(of: Tool, places: Place[]): JsonObject | string {
  const what = kindOf(of, isOfMesh(places[0]));
  const seen = places[0]?.seen ?? null;
  switch (of.takes) {
    case "points":
      return { what, points: places.map((place) => rounded(place.at)), space: "world", ...ofVolume(seen) };
    case "box": {
      const box = boxOf(places);
      return typeof box === "string" ? box : { what, ...box };
    }
    case "rectangle":
    case "ellipse":
    case "polygon":
    case "sphere": {
      const region = regionOf(of.takes, places.map((place) => place.at), places[0]!.frame, depthAt(places[0]!));
      return typeof region === "string" ? region : { what, region, space: "world", ...ofVolume(seen) };
    }
    case "seed":
      return seen?.hit ? { what, seed: rounded(places[0]!.at), space: "world", ...ofVolume(seen) } : "Nothing is seen there.";
    case "label":
      return seen?.hit && Number.isInteger(seen.value) ? { what, label: seen.value, ...ofVolume(seen) } : "There is no label there.";
    case "nothing":
      return { what, ...ofVolume(null) };
  }
}

/** The tool has all that it takes. */
export function finish(): void {
  const of = tool.value;
  if (!of || draft.value.length < of.least) return;
  const measurement = measurementOf(of, draft.value);
  draft.value = [];
  if (typeof measurement === "string") store.notify("warning", measurement);
  else void add(of, measurement);
}

const TOO_NEAR = 1e-9;

/** Why a flat region has no corner there. */
function missesPlane(at: Vec3, frame: Frame | null): string | null {
  const first = draft.value[0];
  if (!frame) return "There is no picture yet to draw in.";
  const off = first?.frame ? dot(minus(at, first.at), cross(first.frame.right, first.frame.up)) : 0;
  return Math.abs(off) > TOO_NEAR * (1 + Math.hypot(...at)) ? "All corners lie in one plane: go on where the first one is, or press Escape." : null;
}

export function place(at: Vec3, seen: Pick | null, frame: Frame | null): void {
  const of = tool.value;
  const last = draft.value[draft.value.length - 1];
  if (!of || (last && Math.hypot(...minus(at, last.at)) < TOO_NEAR)) return;
  const why = isFlat(of.takes) ? missesPlane(at, frame) : null;
  if (why) return store.notify("info", why);
  draft.value = [...draft.value, { at, seen, frame }];
  if (draft.value.length >= of.most) finish();
  else store.announcement.value = hint(of);
}

export function takeBack(): void {
  draft.value = draft.value.slice(0, -1);
}

export function wholeVolume(of: Tool): void {
  takeTool(null);
  void add(of, measurementOf(of, []) as JsonObject);
}

// What stands in the World --------------------------------------------------------------------------------------------

function placesOf(object: JsonObject): Vec3[] {
  const { points, region } = object;
  if (object["space"] !== "world" || isOfFiles(object)) return [];
  return Array.isArray(points) ? (points as Vec3[]) : isObject(region) ? handlesOf(region) : [];
}

/** Its places in the World, by which it is moved; none where it has none there. */
export const pointsOf = (id: string): Vec3[] => placesOf(objectAt(id));

/** Which kind of region it is of; "": of none. */
export function regionKind(id: string): string {
  const { region } = objectAt(id);
  return isObject(region) ? String(region["kind"] ?? "") : "";
}

/** The plane that its corners lie in; null: it has none. */
export function planeOf(id: string): Frame | null {
  const { region } = objectAt(id);
  return isObject(region) && region["kind"] !== "ellipsoid" ? frameOf(region) : null;
}

/** A drag: its places, and at the end what comes out of them, are one step. */
export class Move {
  private gesture = new Gesture();
  private moved: JsonObject | null = null;
  constructor(private id: string) {}

  to(index: number, at: Vec3): void {
    const object = this.moved ?? objectAt(this.id);
    const { points, region } = object;
    this.moved = Array.isArray(points)
      ? { ...object, points: (points as Vec3[]).map((p, i) => (i === index ? rounded(at) : p)) }
      : { ...object, region: movedRegion(region as JsonObject, index, at) };
    this.gesture.change(this.edit());
  }

  get now(): Vec3[] | null {
    return this.moved && placesOf(this.moved);
  }

  private edit(): Edit {
    const name = Array.isArray(this.moved!["points"]) ? "points" : "region";
    return { op: "set", path: `measurements.${this.id}.${name}`, value: this.moved![name]! };
  }

  async end(): Promise<void> {
    if (!this.moved) return;
    const found = await measure(this.moved).catch(() => null);
    if (found) this.gesture.change(this.edit(), { op: "set", path: `measurements.${this.id}.figures`, value: found.figures as unknown as Json });
  }
}

export const show = (id: string, on: boolean): void => tryEdit({ op: "set", path: `measurements.${id}.visible`, value: on });
export const remove = (id: string): void => tryEdit({ op: "remove", path: `measurements.${id}` });
export const rename = (id: string, title: string): void =>
  tryEdit(title.trim() === "" || title === id ? { op: "unset", path: `measurements.${id}.title` } : { op: "set", path: `measurements.${id}.title`, value: title.trim() });

export async function commandOf(id: string): Promise<string | null> {
  return (await tryAsk<{ text: string }>({ type: "command", measurement: id }))?.text ?? null;
}

export async function plotFile(id: string): Promise<string | null> {
  return (await tryAsk<Answer>(messageOf(objectAt(id), { plot: true })))?.plot ?? null;
}

// What comes out now --------------------------------------------------------------------------------------------------

interface Found {
  /** What it was asked of: another text asks again. */
  about: string;
  answer: Answer | null;
  error: string;
}

export const found = signal<{ [id: string]: Found }>({});
export const asking = signal<string | null>(null);

const pick = (object: Json | undefined, names: string[]): Json => (isObject(object) ? Object.fromEntries(Object.entries(object).filter(([name]) => names.includes(name))) : null);
const OF_VOLUMES = ["data", "attribute", "component", "frame", "missing", "place", "cut_planes", "segmentation", "visible"];

/** All that its answer may depend on. */
function aboutOf(id: string): string {
  const world = store.world.value;
  const volume = volumeOf(objectAt(id));
  const data = volume ? valueAt(world, `volumes.${volume}`) : undefined;
  const render = valueAt(world, `${store.viewPath.value}.render`);
  return JSON.stringify([messageOf(objectAt(id)), world["datasets"] ?? null, world["cut_planes"] ?? null, world["unit"] ?? null, volume, pick(data, OF_VOLUMES), render ?? null]);
}

let timer = 0;
const PAUSE_MS = 120;

/** One after the other: those that nobody has asked about what is there now. */
async function refresh(): Promise<void> {
  if (asking.value) return;
  for (let id = stale(); id && isOpen.value; id = stale()) {
    asking.value = id;
    const about = aboutOf(id);
    const value = await measure(objectAt(id)).then((answer): Found => ({ about, answer, error: "" }), (error: Error): Found => ({ about, answer: null, error: error.message }));
    found.value = { ...found.value, [id]: value };
  }
  asking.value = null;
}

function stale(): string | null {
  return store.idsOf("measurements").find((id) => !isOfFiles(objectAt(id)) && found.value[id]?.about !== aboutOf(id)) ?? null;
}

effect(() => {
  store.world.value;
  if (!isOpen.value || store.connection.value.state !== "open") return;
  clearTimeout(timer);
  timer = window.setTimeout(() => void refresh(), PAUSE_MS);
});

const mainOf = (kind: string): string => store.welcome.value?.measures.find((row) => row.name === kind)?.main ?? "";

/** All of them, in the World's order. */
export const rows = computed((): Row[] => store.idsOf("measurements").map((id) => {
  const value = found.value[id];
  const object = objectAt(id);
  const file = object["file"];
  return rowOf(id, object, { figures: value?.answer?.figures ?? null, error: value?.error ?? "", busy: asking.value === id }, isOfFiles(object) && typeof file === "string" ? file : volumeOf(object) ?? "", mainOf);
}));

/** What comes out now is kept in the World, where it is something else. */
export function keepResults(): void {
  const edits = rows.value.filter((row) => row.changed).map((row): Edit => ({ op: "set", path: `measurements.${row.id}.figures`, value: row.figures as unknown as Json }));
  if (edits.length) tryEdit(...edits);
}

export const selected = computed(() => {
  const [map, id] = store.selection.value.split(".");
  return map === "measurements" && id && store.idsOf("measurements").includes(id) ? id : null;
});
