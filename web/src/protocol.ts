/** What page and server say to each other: docs/protocol.md as types. */

import type { Failure } from "./failure";

export type Json = null | boolean | number | string | Json[] | { [name: string]: Json };
export type JsonObject = { [name: string]: Json };

export type Kind =
  | "bool" | "integer" | "number" | "enum" | "string" | "path" | "reference" | "vector" | "color" | "numbers"
  | "object" | "list" | "map" | "variants" | "members";

/** A row of a property table. */
export interface Property {
  name: string;
  kind: Kind;
  doc: string;
  automatic?: string | null;
  quantity?: "length" | "angle" | "time" | "bytes" | "ratio" | "label" | null;
  unit?: string | null;
  /** What panels call it where its name says too little. */
  label?: string | null;
  /** "mode=composite|mean": acts while that property beside it has one of these values; "pieces|least": while one is set. */
  when?: string | null;
  min?: number | null;
  max?: number | null;
  default?: Json;
  names?: string[] | null;
  class?: string | null;
  ref_to?: string | null;
  table?: string | null;
  columns?: number | null;
}

export interface ObjectClass {
  doc: string;
  properties: Property[];
}

/** An input of an operation. */
export interface Operand {
  name: string;
  doc: string;
  volume: boolean;
  mesh: boolean;
  least: number;
  most: number;
  named: boolean;
}

export interface Operation {
  name: string;
  component: string;
  /** Of a menu: "smoothing". */
  group: string;
  doc: string;
  class: string;
  inputs: Operand[];
  gives: "volume" | "mesh";
  /** What is known of the input's values and labels does not hold of the result's. */
  new_values?: boolean;
}

/** A way in which a kind is measured: of which data, from how many points (0: however many), with which properties. */
export interface MeasureForm {
  of: ("volume" | "mesh" | "shown")[];
  other: boolean;
  points: number;
  uses: string[];
}

/** A kind of measurement. */
export interface Measure {
  name: string;
  doc: string;
  /** The figure that stands for it; where none is named, the first. */
  main?: string;
  plot: boolean;
  /** That it is told by; 0: by none. */
  least_points: number;
  any_points: boolean;
  forms: MeasureForm[];
}

export interface Renderer {
  name: string;
  /** In menus. */
  label: string;
  doc: string;
  class: string;
  /** It shows planes through the cross-hair. */
  plane: boolean;
}

export interface Preset {
  name: string;
  doc: string;
  kind: "transfer" | "proposal" | "colormap";
  unit?: string | null;
  colors?: string[];
}

export interface Binding {
  device: string;
  when?: string | null;
  method: string;
  action?: string | null;
  gain?: number;
}

export interface Welcome {
  type: "welcome";
  version: string;
  client: string;
  view: string;
  read_only: boolean;
  root: string;
  /** Where browsing begins. */
  folder?: string;
  classes: { [name: string]: ObjectClass };
  operations: Operation[];
  renderers: Renderer[];
  measures: Measure[];
  presets: Preset[];
  colormaps: { [name: string]: string[] };
  bindings: { [name: string]: Binding } | { bindings: { [name: string]: Binding } };
  methods: { [name: string]: string };
  samples: { name: string; doc: string }[];
  /** Commits of a session that broke off. */
  restored?: number;
}

/** What has changed of a World: to be done in order. After null: it comes first. */
export type Change =
  | { op: "set"; path: string; value: Json }
  | { op: "unset" | "remove"; path: string }
  | { op: "add"; path: string; id: string; after: string | null; value: Json };

/** The World as a whole, or, where that would be long, its changes since the one with the number `since`. */
export type WorldMessage = {
  type: "world";
  number: number;
  who: string;
  paths: string[] | null;
  undo: boolean;
  redo: boolean;
  title: string | null;
} & ({ world: JsonObject } | { since: number; changes: Change[] });

export interface Pose {
  type: "pose";
  eye: [number, number, number];
  at: [number, number, number];
  up: [number, number, number];
  parallel: boolean;
  fov?: number;
  height?: number;
  moving: boolean;
}

export interface JobMessage {
  type: "job";
  job: number;
  name: string;
  stage: string;
  done: number;
  total: number;
  eta: number | null;
  state: "running" | "done" | "failed" | "cancelled";
  error?: string | null;
}

export interface StatusMessage {
  type: "status";
  frames: number;
  latency: number;
  memory: number;
  memory_limit: number;
  method: string | null;
  level: number;
  passes: number;
  final: boolean;
  scale: number;
}

export interface Notice {
  type: "notice";
  level: "error" | "warning" | "info";
  text: string;
}

export type ServerMessage =
  | Welcome | WorldMessage | Pose | JobMessage | StatusMessage | Notice
  | { type: "resolved"; number: number; world: JsonObject }
  | { type: "clients"; n: number }
  | { type: "outdated" }
  | ({ type: "failed" } & Failure)
  | ActionMessage
  | { type: "answer"; id: number; ok: boolean; value?: Json; error?: string; reason?: string };

/** A binding asked for something that the page does; places as those of input events. */
export interface ActionMessage {
  type: "action";
  name: string;
  at?: [number, number];
  phase?: "begin" | "move" | "end" | "cancel";
  from?: [number, number];
}

export type Edit =
  | { op: "set"; path: string; value: Json }
  | { op: "unset"; path: string }
  | { op: "add"; path: string; id: string | null; value: Json }
  | { op: "remove"; path: string };

export interface Histogram {
  lo: number;
  hi: number;
  counts: number[];
  /** Of the values. */
  unit: string | null;
  min?: number;
  max?: number;
  mean: number;
  deviation: number;
  n: number;
  percentiles: { [share: string]: number };
}

/** What a volume is shown with: rows (value, opacity) and (value, red, green, blue), linear. */
export interface Transfer {
  opacity: number[][];
  color: number[][];
  opacity_length: number;
}

export interface Pick {
  hit: boolean;
  volume: string | null;
  position: number[] | null;
  index: number[] | null;
  value: number | null;
  /** Of position and depth. */
  unit: string | null;
  depth: number | null;
  text: string;
}

export interface FolderEntry {
  name: string;
  folder: boolean;
  bytes: number;
  kind: "volume" | "mesh" | "scene" | "picture" | null;
}
