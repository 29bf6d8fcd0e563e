/** A client of its own, with a view of its own in the World: its frames, its size, and coming back. */
import { batch, computed, signal } from "@preact/signals";
import { Connection } from "../connection";
import type { Failure } from "../failure";
import { drawFrame, Finality, isWhole, parseFrame, type Frame } from "../frames";
import type { Json, ServerMessage, StatusMessage } from "../protocol";

export class OwnView {
  readonly frame = signal<Omit<Frame, "picture"> | null>(null);
  private readonly outdated = signal(false);
  readonly failed = signal<Failure | null>(null);
  readonly isFinal = computed(() => this.frame.value?.final === true && !this.outdated.value);
  readonly status = signal<StatusMessage | null>(null);
  private finality = new Finality();
  private size = { width: 400, height: 300 };
  private canvas: HTMLCanvasElement | null = null;
  private link = new Connection({
    state: (state) => { if (state === "open") this.link.send({ type: "hello", ...this.size, ...this.greeting }); },
    message: (message) => this.take(message),
    binary: (buffer) => void this.draw(buffer),
  }, null);

  /** `greeting`: what is said with hello. */
  constructor(private greeting: { plane?: string } = {}) {}

  start(canvas: HTMLCanvasElement): void {
    this.canvas = canvas;
    void this.link.start();
  }

  stop(): void {
    this.link.close();
  }

  resize(width: number, height: number): void {
    if (width === this.size.width && height === this.size.height) return;
    this.size = { width, height };
    this.link.send({ type: "size", ...this.size });
  }

  send(message: { type: string; [name: string]: unknown }): void {
    this.link.send(message);
  }

  ask<T = Json>(message: { type: string; [name: string]: unknown }): Promise<T> {
    return this.link.ask<T>(message);
  }

  /** Another connection, and so another greeting. */
  protected again(): void {
    this.link.restart();
  }

  protected take(message: ServerMessage): void {
    if (message.type === "status") this.status.value = message;
    if (message.type === "welcome") this.finality.begin();
    else if (message.type === "outdated") this.finality.outdate();
    else if (message.type === "failed") this.finality.fail(message);
    else return;
    batch(() => {
      this.outdated.value = true;
      this.failed.value = this.finality.failure;
    });
  }

  private async draw(buffer: ArrayBuffer): Promise<void> {
    const frame = parseFrame(buffer);
    if (!frame || !this.canvas) return;
    if (!isWhole(frame)) {
      this.link.send({ type: "ack", frame: frame.number });
      return;
    }
    this.finality.take(frame.number);
    await drawFrame(this.canvas, frame).catch(() => {});
    const { picture: _, ...rest } = frame;
    this.finality.show(rest.number);
    batch(() => {
      this.frame.value = rest;
      this.failed.value = this.finality.failure;
      this.outdated.value = this.finality.isOutdated(rest.number);
    });
    this.link.send({ type: "ack", frame: frame.number });
  }
}
