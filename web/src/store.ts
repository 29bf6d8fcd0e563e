/** What the page knows, as signals. The World is the server's: nothing here changes it, edits.ts asks for that. */
import { computed, signal } from "@preact/signals";
import type { ConnectionState } from "./connection";
import type { Failure } from "./failure";
import type { Frame } from "./frames";
import type { Histogram, JobMessage, Json, JsonObject, Notice, Operand, Pick, Pose, Renderer, StatusMessage, Transfer, Welcome } from "./protocol";
import { isObject, valueAt, type Classes } from "./values";

export const connection = signal<{ state: ConnectionState; why: string }>({ state: "connecting", why: "" });
export const welcome = signal<Welcome | null>(null);
export const world = signal<JsonObject>({});
/** What was worked out of the World for the last picture: what automatic values are. */
export const resolved = signal<JsonObject>({});
/** What the last message about the World said that has changed; null: all. */
export const change = signal<{ paths: string[] | null }>({ paths: [] });
export const commit = signal(0);
export const title = signal("");
export const canUndo = signal(false);
export const canRedo = signal(false);
export const pose = signal<Pose | null>(null);
export const status = signal<StatusMessage | null>(null);
export const frame = signal<Omit<Frame, "picture"> | null>(null);
/** A newer frame than the one on the screen is being made. */
export const outdated = signal(false);
/** Why none can be made. */
export const failed = signal<Failure | null>(null);
/** Changes that the server has not answered yet. */
export const unanswered = signal(0);
/** Hands did something that the server has not said to have taken in. */
export const unheard = signal(false);
/** Nothing better will come, as far as the page can know. */
export const isFinal = computed(() => frame.value?.final === true && !outdated.value && unanswered.value === 0);
export const clients = signal(1);
export const jobs = signal<JobMessage[]>([]);
export const description = signal("");
export const picked = signal<(Pick & { x: number; y: number }) | null>(null);

export interface ShownNotice extends Notice {
  key: number;
}
export const notices = signal<ShownNotice[]>([]);
/** What is read out to those who do not see the page. */
export const announcement = signal("");

/** Path of the object that the inspector shows. */
export const selection = signal("");
export const leftOpen = signal(true);
export const rightOpen = signal(true);
/** Whether the Rendering viewport stands beside the Navigator, and which view of the World is its own. */
export type Layout = "one" | "two" | "slices";
export const layout = signal<Layout>("one");
export const split = computed(() => layout.value === "two");
export const secondView = signal<string | null>(null);
/** Views of the World that slices have, by plane. */
export const sliceViews = signal<{ [plane: string]: string }>({});
/** Of the layout of slices, the viewport that fills it: a plane, or "navigator". */
export const maximised = signal<string | null>(null);
/** What is under the pointer in a slice. */
export const pointed = signal<Pick | null>(null);
/** Where the cross-hair is while a hand moves it and the server does not say so yet. */
export const heldCrossHair = signal<[number, number, number] | null>(null);

export type Dialog =
  | { name: "search" } | { name: "help" } | { name: "open"; add: boolean } | { name: "save" } | { name: "picture"; plain?: boolean }
  | { name: "sessions" } | { name: "command"; text: string } | { name: "filters"; after?: string } | { name: "write"; dataset: string };
export const dialog = signal<Dialog | null>(null);

/** Pages that look at this scene: viewports of this one are clients of their own. */
export const people = computed(() => clients.value - (secondView.value ? 1 : 0) - Object.keys(sliceViews.value).length);

/** By volume id; asked for when they are looked at. */
export const histograms = signal<{ [volume: string]: Histogram | string }>({});
export const transfers = signal<{ [volume: string]: Transfer }>({});
export const dataInfos = signal<{ [dataset: string]: JsonObject | string }>({});

export const classes = computed<Classes>(() => welcome.value?.classes ?? {});
export const lengthUnit = computed(() => {
  const unit = world.value["unit"];
  return typeof unit !== "string" || unit === "voxels" ? "voxel" : unit === "units" ? "unit" : unit;
});
export const volumeIds = computed(() => idsOf("volumes"));
/** The scene's own title, else what its first data is called. */
export const shownTitle = computed(() => title.value || (idsOf("datasets")[0] ?? ""));
export const isEmpty = computed(() => welcome.value !== null && volumeIds.value.length === 0);
/** The volume that is selected, or else the first. */
export const currentVolume = computed(() => {
  const [map, id] = selection.value.split(".");
  if (map === "volumes" && id && volumeIds.value.includes(id)) return id;
  return volumeIds.value[0] ?? null;
});
/** Where slices meet. */
export const crossHair = computed(() => {
  const value = heldCrossHair.value ?? valueOf("cross_hair");
  return Array.isArray(value) && value.length === 3 ? (value as [number, number, number]) : null;
});
export const viewPath = computed(() => `views.${welcome.value?.view ?? "main"}`);
export const readOnly = computed(() => welcome.value?.read_only ?? false);

export function idsOf(map: string): string[] {
  const objects = world.value[map];
  return isObject(objects) ? Object.keys(objects) : [];
}

/** What is set, else what was worked out. */
export function valueOf(path: string): Json | undefined {
  return valueAt(world.value, path) ?? valueAt(resolved.value, path);
}

export function isSet(path: string): boolean {
  return valueAt(world.value, path) !== undefined;
}

/** The method that is in use, of the choice at a path. */
export function rendererAt(path: string): Renderer | undefined {
  const named = valueOf(`${path}.method`);
  const method = typeof named === "string" ? named : status.value?.method;
  const rows = welcome.value?.renderers;
  return rows?.find((row) => row.name === method) ?? rows?.[0];
}

/** Where `lighting` of that method is; null: it has no shadows and ambient occlusion. */
export function lightingAt(path: string): string | null {
  const method = rendererAt(path);
  return method && classes.value[method.class]?.properties.some((row) => row.name === "lighting") ? `${path}.${method.name}.lighting` : null;
}

/** The dataset that a volume shows: the only one, where it does not say. */
export function datasetOf(volume: string): string | null {
  const named = valueOf(`volumes.${volume}.data`);
  if (typeof named === "string") return named;
  const all = idsOf("datasets");
  return all.length === 1 ? all[0]! : null;
}

/** The unit of lengths is the World's; that of values comes with the data. */
export function valueUnit(volume: string | null): string {
  const histogram = volume ? histograms.value[volume] : undefined;
  return histogram && typeof histogram !== "string" ? (histogram.unit ?? "") : "";
}

/** Meshes have no samples: nothing to be classified. */
export function isMesh(volume: string): boolean {
  return isMeshData(datasetOf(volume) ?? "");
}

export function isMeshData(dataset: string): boolean {
  const operation = valueOf(`datasets.${dataset}.operation`);
  const made = operation !== undefined && valueOf(`datasets.${dataset}.path`) === undefined;
  const gives = made ? welcome.value?.operations.find((row) => row.name === operation)?.gives : undefined;
  return gives === "mesh" || valueOf(`datasets.${dataset}.kind`) === "mesh";
}

/** What an operation can be done to; first what the current volume shows. */
export function datasetsFor(operand: Operand | undefined): string[] {
  const shown = currentVolume.value ? datasetOf(currentVolume.value) : null;
  const fit = idsOf("datasets").filter((id) => operand && (isMeshData(id) ? operand.mesh : operand.volume));
  return shown && fit.includes(shown) ? [shown, ...fit.filter((id) => id !== shown)] : fit;
}

let nextNotice = 1;
const NOTICES_MOST = 4;
const NOTICE_MS = 8000;

/** Errors stay until they are put away; the rest goes by itself. */
export function notify(level: Notice["level"], text: string): void {
  const key = nextNotice++;
  notices.value = [...notices.value.filter((n) => n.text !== text), { type: "notice" as const, level, text, key }].slice(-NOTICES_MOST);
  if (level !== "error") setTimeout(() => dismiss(key), NOTICE_MS);
}

export function dismiss(key: number): void {
  notices.value = notices.value.filter((notice) => notice.key !== key);
}
