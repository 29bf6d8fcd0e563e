/**
 * The Navigator's own drawing: asks for shapes when what is shown changes, draws them from each pose that the server
 * tells, and hands over to the server's refined picture at rest. Where it cannot draw it says so once, and frames of
 * the server go on.
 */
import { effect, untracked } from "@preact/signals";
import { ask, send } from "../session";
import * as store from "../store";
import { atRest, crawls, making, own, shown, wanted } from "./choice";
import { Decoder } from "./decoder";
import type { Drawing } from "./drawing";
import type { Shape } from "./shape";

/** Bytes of all files together: more of them where the graphics card is quick. Boxes are so few that they always fit. */
const BUDGETS = { reduced: [1 << 18, 1 << 20, 1 << 22], boxes: [1 << 22] };
const QUICK_MS = 10;
const SLOW_MS = 40;
const CRAWL_MS = 120;
const SLOW_SCALE = 0.5; // of the picture's sides, while it moves
const LEVEL_FULL = 2;
const PAUSE_MS = 60; // between two questions, while something is dragged

/** Cameras and sizes of views are no part of a shape. */
const OF_CAMERAS = /^views\.[^.]+\.(camera|width|height)(\.|$)/;

export class OwnDrawing {
  private drawing: Drawing | null = null;
  private decoder: Decoder | null = null;
  private broken = false;
  private busy = false;
  private fetching = false;
  private again = false;
  private budget = 0;
  private settled = false;
  private slow = false;
  private scheduled = 0;
  /** A server that has greeted anew sends all frames again. */
  private told: { to: typeof store.welcome.value; frames: string } = { to: null, frames: "all" };
  private size = { width: 16, height: 16 };
  private stops: (() => void)[];

  constructor(private canvas: HTMLCanvasElement) {
    canvas.addEventListener("webglcontextlost", this.lost);
    canvas.addEventListener("webglcontextrestored", this.restored);
    this.stops = [
      effect(() => { if (wanted.value && store.welcome.value) this.refresh(); else this.leave(); }),
      effect(() => { if (store.change.value.paths?.every((path) => OF_CAMERAS.test(path)) !== true) untracked(() => this.refresh()); }),
      effect(() => this.tellFrames(store.welcome.value, own.value !== null, atRest.value)),
      effect(() => this.follow(store.pose.value?.moving === true, own.value !== null, atRest.value)),
      effect(() => { canvas.style.visibility = shown.value ? "visible" : "hidden"; }), // in the same turn as the drawing
      effect(() => { void store.pose.value; this.drawSoon(); }),
      effect(() => this.handOver(store.frame.value)),
    ];
  }

  dispose(): void {
    for (const stop of this.stops) stop();
    cancelAnimationFrame(this.scheduled);
    this.leave();
    this.drawing?.dispose();
    this.drawing = null;
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
    if (shown.value) this.draw(); // at once: a canvas of another size is empty
  }

  // Which picture is seen ------------------------------------------------------------------------------------------

  private tellFrames(welcome: typeof store.welcome.value, ready: boolean, always: boolean): void {
    const frames = !ready ? "all" : always ? "none" : "resting";
    if (!welcome) return;
    if (frames !== (this.told.to === welcome ? this.told.frames : "all")) send({ type: "frames", wanted: frames });
    this.told = { to: welcome, frames };
  }

  private follow(moving: boolean, ready: boolean, always: boolean): void {
    if (!ready) shown.value = false;
    else if (moving || always) shown.value = true;
  }

  /** Coarse pictures of the server are worse than what is there. */
  private handOver(frame: typeof store.frame.value): void {
    if (!frame || frame.moving || atRest.peek() || store.pose.peek()?.moving) return;
    if (frame.final || (frame.level >= LEVEL_FULL && frame.width === frame.fullWidth)) shown.value = false;
  }

  private leave(): void {
    own.value = null;
  }

  // What is drawn --------------------------------------------------------------------------------------------------

  private refresh(): void {
    this.again = true;
    if (!this.busy) void this.run();
    this.tellMaking();
  }

  private tellMaking(): void {
    making.value = this.scheduled !== 0 || (this.busy && this.hasMore());
  }

  private hasMore(): boolean {
    return this.fetching || (this.again && wanted.peek() !== null && !this.broken);
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.hasMore()) {
      this.again = false;
      this.fetching = true;
      try {
        await this.fetch();
      } catch (error) {
        if (!this.again) this.fail((error as Error).message);
      }
      this.fetching = false;
      this.tellMaking();
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
    }
    this.busy = false;
  }

  private bytes(method: Shape["method"]): number {
    const budgets = BUDGETS[method];
    return budgets[Math.min(this.budget, budgets.length - 1)]!;
  }

  private async fetch(): Promise<void> {
    const method = wanted.peek()!;
    this.decoder ??= new Decoder();
    const [shape, drawing] = await Promise.all([ask<never>({ type: "shape", method, bytes: this.bytes(method) }) as Promise<Shape>, this.open()]);
    const parts = await Promise.all(shape.parts.map(async (part) => ({ part, surface: await this.decoder!.surface(part.url) })));
    if (wanted.peek() !== method || this.drawing !== drawing) return;
    this.decoder.keepOnly(shape.parts.map(({ url }) => url));
    drawing.setShape(shape, parts);
    const sum = (of: "triangles" | "bytes") => shape.parts.reduce((all, part) => all + part[of], 0);
    own.value = { method, triangles: sum("triangles"), bytes: sum("bytes") };
    for (const sentence of shape.left_out) store.notify("info", sentence);
    await this.settle(drawing, shape);
    this.drawSoon();
  }

  /** Module and graphics card, when they are needed for the first time. */
  private async open(): Promise<Drawing> {
    if (this.drawing) return this.drawing;
    const address = "/drawing.js";
    const { Drawing } = (await import(address)) as typeof import("./drawing");
    try {
      this.drawing = new Drawing(this.canvas);
    } catch {
      this.broken = true;
      throw new Error("This browser has no WebGL 2: the Navigator shows frames from the server.");
    }
    return this.drawing;
  }

  /** Finer surfaces as long as the graphics card is quick; back where it is not. */
  private async settle(drawing: Drawing, shape: Shape): Promise<void> {
    const pose = store.pose.peek();
    if (this.settled || !pose) return;
    drawing.resize(this.size.width, this.size.height);
    const ms = await drawing.measure(pose);
    this.slow = ms > SLOW_MS;
    crawls.value = this.budget === 0 && ms > CRAWL_MS;
    const coarse = shape.method === "reduced" && shape.parts.some((part) => Math.max(...part.step) > 1);
    if (ms < QUICK_MS && coarse && this.budget + 1 < BUDGETS.reduced.length) {
      this.budget++;
    } else {
      this.settled = coarse;
      if (ms <= SLOW_MS || this.budget === 0 || shape.method === "boxes") return;
      this.budget--; // which was quick
      this.slow = false;
    }
    this.again = true;
  }

  private fail(sentence: string): void {
    own.value = null;
    if (store.connection.peek().state === "open") store.notify("warning", sentence);
  }

  private lost = (event: Event): void => {
    event.preventDefault(); // it may come back
    own.value = null;
    this.drawing = null;
    this.broken = true;
    store.notify("warning", "The page has lost the graphics card: the Navigator shows frames from the server.");
  };

  private restored = (): void => {
    this.broken = false;
    this.refresh();
  };

  // Frames ---------------------------------------------------------------------------------------------------------

  private drawSoon(): void {
    this.scheduled ||= requestAnimationFrame(() => {
      this.scheduled = 0;
      this.draw();
      this.tellMaking();
    });
    this.tellMaking();
  }

  private draw(): void {
    const pose = store.pose.peek();
    if (!pose || !this.drawing || !own.peek() || !shown.peek()) return;
    const scale = this.slow && pose.moving ? SLOW_SCALE : 1;
    this.drawing.resize(Math.round(scale * this.size.width), Math.round(scale * this.size.height));
    this.drawing.draw(pose);
  }
}
