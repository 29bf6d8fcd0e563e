/** The page's side of the conversation: takes the server's messages into the store and asks for what is missing. */
import { batch } from "@preact/signals";
import { KnownWorld } from "./changes";
import { Connection, takeToken } from "./connection";
import { plan } from "./filter/state";
import { Finality, isWhole, parseFrame, type Frame } from "./frames";
import type { ActionMessage, Edit, Histogram, JobMessage, Json, JsonObject, Pick, Pose, ServerMessage, Transfer, WorldMessage } from "./protocol";
import * as store from "./store";
import { hasEntry } from "./values";

type ActionHandler = (message: ActionMessage) => void;

let viewport = { width: 800, height: 600 };
let painter: ((frame: Frame) => Promise<void>) | null = null;
let onAction: ActionHandler = () => {};

const link = new Connection({ state: onState, message: onMessage, binary: onBinary }, takeToken());

export function start(handler: ActionHandler): void {
  onAction = handler;
  void link.start();
}

export const reconnect = (): void => link.retryNow();
export const endSessions = (): Promise<void> => link.endAll();
type Message = { type: string; [name: string]: unknown };

// What the server has not heard of or not answered yet: until it has, no picture is called final -------------------

const CHANGES = ["edit", "undo", "redo", "new"];

/** What this is about is not done before the promise is. */
export async function whileUnanswered<T>(promise: Promise<T>): Promise<T> {
  store.unanswered.value++;
  return promise.finally(() => { store.unanswered.value--; });
}

export function ask<T = Json>(message: Message): Promise<T> {
  const answer = link.ask<T>(message);
  return CHANGES.includes(message.type) ? whileUnanswered(answer) : answer;
}

let hasQueued = false; // input that is not sent yet
let hasSent = false; // something since the server was asked last whether it has heard all
let isAsking = false;

/** Input has come that is sent with the next frame of the screen. */
export function expectInput(): void {
  hasQueued = store.unheard.value = true;
}

/** What moves the view and has no answer of its own. */
export function send(message: Message): void {
  link.send(message);
  if (message.type === "events") hasQueued = false;
  hasSent = store.unheard.value = true;
  if (!isAsking) void listen();
}

/** One question at a time, however much is sent: thin lines carry no answer to each motion of a hand. */
async function listen(): Promise<void> {
  isAsking = true;
  while (hasSent) {
    hasSent = false;
    await link.ask({ type: "events", lines: "" }).catch(() => {});
  }
  isAsking = false;
  store.unheard.value = hasQueued;
}

/** Frames go to the viewport that is on the page. */
export function attachPainter(paint: (frame: Frame) => Promise<void>): void {
  painter = paint;
}

export function resize(width: number, height: number): void {
  if (width === viewport.width && height === viewport.height) return;
  viewport = { width, height };
  send({ type: "size", ...viewport });
}

let isLost = false; // until it is open again, however often it was tried

function onState(state: typeof store.connection.value.state, why: string): void {
  const before = store.connection.value.state;
  store.connection.value = { state, why };
  if (state === "open") link.send({ type: "hello", ...viewport });
  if (state === "lost" && before === "open") store.announcement.value = "The connection was lost.";
  if (state === "open" && isLost) store.announcement.value = "The connection is back.";
  isLost = state === "lost" || (isLost && state !== "open");
}

const finality = new Finality();

function onBinary(buffer: ArrayBuffer): void {
  const frame = parseFrame(buffer);
  if (!frame) return;
  if (!isWhole(frame)) { // one that this line carries follows
    link.send({ type: "ack", frame: frame.number });
    return;
  }
  finality.take(frame.number);
  const { picture: _, ...rest } = frame;
  const drawn = painter ? painter(frame) : Promise.resolve();
  // A picture that cannot be drawn is acknowledged too: else the server would wait for ever.
  void drawn.catch(() => {}).then(() => {
    finality.show(rest.number);
    batch(() => {
      store.frame.value = rest;
      store.failed.value = finality.failure;
      store.outdated.value = finality.isOutdated(rest.number);
    });
    link.send({ type: "ack", frame: frame.number });
  });
}

/** What is on the screen is not the newest that there might be. */
function takeFinality(): void {
  batch(() => {
    store.outdated.value = true;
    store.failed.value = finality.failure;
  });
}

function onMessage(message: ServerMessage): void {
  switch (message.type) {
    case "welcome":
      if (!store.welcome.value && message.restored)
        store.notify("info", "The interrupted session has been restored, with everything that was done in it. Undo takes it back step by step.");
      store.welcome.value = message;
      finality.begin();
      takeFinality();
      break;
    case "outdated":
      finality.outdate();
      takeFinality();
      break;
    case "failed":
      finality.fail(message);
      takeFinality();
      store.announcement.value = message.text;
      break;
    case "world":
      takeWorld(message);
      break;
    case "resolved":
      store.resolved.value = message.world;
      break;
    case "pose":
      store.pose.value = message;
      if (pickedFrom && hasMoved(pickedFrom, message)) store.picked.value = null; // its mark would stay where nothing is any more
      break;
    case "clients":
      store.clients.value = message.n;
      break;
    case "status":
      store.status.value = message;
      break;
    case "job":
      takeJob(message);
      break;
    case "notice":
      store.notify(message.level, message.text);
      break;
    case "action":
      onAction(message);
      break;
  }
}

function touches(paths: string[] | null, prefix: string): boolean {
  return paths === null || paths.some((path) => path === "" || path.startsWith(prefix) || prefix.startsWith(`${path}.`));
}

/** What is opened first is selected; from then on people say. */
let hasChosen = false;

/** What was asked for, is selected and is not answered yet: it need not be there. */
let awaited = "";

function selectFirst(): void {
  const first = store.volumeIds.value[0];
  store.selection.value = first ? `volumes.${first}` : "";
}

function selectWhatIsThere(): void {
  if (store.selection.value !== awaited && !hasEntry(store.world.value, store.selection.value)) selectFirst();
}

const known = new KnownWorld();

function takeWorld(message: WorldMessage): void {
  const world = known.take(message);
  if (!world) {
    link.send({ type: "world" });
    return;
  }
  const fresh = message.paths === null || message.paths.includes("");
  store.world.value = world;
  store.commit.value = message.number;
  store.change.value = { paths: message.paths };
  store.canUndo.value = message.undo;
  store.canRedo.value = message.redo;
  store.title.value = message.title ?? "";
  if (fresh) {
    store.histograms.value = {};
    store.transfers.value = {};
    store.dataInfos.value = {};
  }
  const ids = store.volumeIds.value;
  if (!hasChosen) selectFirst();
  selectWhatIsThere();
  hasChosen = ids.length > 0;
  for (const volume of ids) {
    if (touches(message.paths, `volumes.${volume}.segmentation.`)) void fetchTransfer(volume);
    if (["data", "attribute", "component", "frame", "missing"].some((name) => touches(message.paths, `volumes.${volume}.${name}`)) ||
        touches(message.paths, "datasets."))
      forgetData(volume);
  }
  store.picked.value = null;
  describeSoon();
}

function forgetData(volume: string): void {
  const { [volume]: _, ...others } = store.histograms.value;
  store.histograms.value = others;
  store.dataInfos.value = {};
}

function takeJob(message: JobMessage): void {
  // One runs at a time, and of ends a page that reads slowly hears the newest alone.
  const others = store.jobs.value.filter((job) => job.job !== message.job);
  store.jobs.value = message.state === "running" ? [message] : others;
  // The dialog or panel that asked waits for the same answer, and shows it there.
  const shown = ["open", "write", "picture"].includes(store.dialog.value?.name ?? "") || plan.value?.operation.name === message.name;
  if (message.state === "failed" && !shown) store.notify("error", message.error ?? `${message.name} failed.`);
  if (message.state === "cancelled") store.notify("info", `${message.name} was cancelled.`);
  if (message.state === "done") store.announcement.value = `${message.name} is done.`;
}

/** Asks, and shows a refusal as a sentence. */
export async function tryAsk<T = Json>(message: Message): Promise<T | null> {
  try {
    return await ask<T>(message);
  } catch (error) {
    store.notify("error", (error as Error).message);
    return null;
  }
}

export async function fetchTransfer(volume: string): Promise<void> {
  const value = await link.ask<Transfer>({ type: "transfer", volume }).catch(() => null);
  if (value) store.transfers.value = { ...store.transfers.value, [volume]: value };
}

/** What was asked for and has not come: it is not asked for again. */
const asked = new Set<string>();

async function once(what: string, fetch: () => Promise<void>): Promise<void> {
  if (asked.has(what)) return;
  asked.add(what);
  await fetch().finally(() => asked.delete(what));
}

export async function fetchHistogram(volume: string): Promise<void> {
  if (!store.histograms.value[volume]) await once(`histogram ${volume}`, () => takeHistogram(volume));
}

async function takeHistogram(volume: string): Promise<void> {
  const value = await link.ask<Histogram>({ type: "histogram", volume }).catch((error: Error) => error.message);
  store.histograms.value = { ...store.histograms.value, [volume]: value };
}

export async function fetchInfo(dataset: string): Promise<void> {
  if (!store.dataInfos.value[dataset]) await once(`info ${dataset}`, () => takeInfo(dataset));
}

async function takeInfo(dataset: string): Promise<void> {
  const value = await link.ask<JsonObject>({ type: "info", dataset }).catch((error: Error) => error.message);
  store.dataInfos.value = { ...store.dataInfos.value, [dataset]: value };
}

let pickedFrom: Pose | null = null;
const STILL = 0.01; // of the distance: a hand that clicks is not quite still

function hasMoved(from: Pose, to: Pose): boolean {
  const distance = Math.hypot(...from.eye.map((v, i) => v - from.at[i]!)) || 1;
  return [...from.eye, ...from.at].some((v, i) => Math.abs(v - [...to.eye, ...to.at][i]!) > STILL * distance);
}

/** What lies under a point of the picture, from 0 to 1 from the top left. */
export async function pick(x: number, y: number): Promise<void> {
  const value = await link.ask<Pick>({ type: "pick", x, y }).catch(() => null);
  store.picked.value = value ? { ...value, x, y } : null;
  pickedFrom = store.pose.value;
  if (value) store.announcement.value = value.text;
}

let describing = 0;

/** The picture in words, when it has been at rest for a while. */
function describeSoon(): void {
  clearTimeout(describing);
  describing = window.setTimeout(async () => {
    const value = await link.ask<{ text: string }>({ type: "describe" }).catch(() => null);
    if (value) store.description.value = value.text;
  }, 1000);
}

// Edits ------------------------------------------------------------------------------------------------------------

/** One commit. The promise tells of a refusal: the place that asked shows it. */
export async function edit(...edits: Edit[]): Promise<void> {
  await ask({ type: "edit", edits });
}

/** As edit(), for places that have none of their own to show a refusal. */
export function tryEdit(...edits: Edit[]): void {
  edit(...edits).catch((error: Error) => store.notify("error", error.message));
}

/** Adds to a map (by a name) or to a list (null), and selects it under `path`. */
export function addSelected(path: string, to: string, id: string | null, value: Json): void {
  store.selection.value = awaited = path;
  edit({ op: "add", path: to, id, value }).then(() => { awaited = ""; }, (error: Error) => {
    awaited = "";
    selectWhatIsThere();
    store.notify("error", error.message);
  });
}

let nextGesture = 1;

/**
 * The edits of one drag: they are one step for undo, and no more than one is under way, so that a slow server gets the
 * newest and not all.
 */
export class Gesture {
  private readonly name = `g${nextGesture++}`;
  private waiting: Edit[] | null = null;
  private busy = false;

  constructor(private refused: (sentence: string) => void = (sentence) => store.notify("error", sentence)) {}

  change(...edits: Edit[]): void {
    this.waiting = edits;
    if (!this.busy) void whileUnanswered(this.run());
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.waiting) {
      const edits = this.waiting;
      this.waiting = null;
      try {
        await link.ask({ type: "edit", edits, gesture: this.name });
      } catch (error) {
        this.refused((error as Error).message);
      }
    }
    this.busy = false;
  }
}

export function cancelJob(job: number): void {
  link.send({ type: "cancel", job });
}
