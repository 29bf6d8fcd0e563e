/**
 * The Rendering viewport is a client of its own, with a view of its own in the World: another method and quality than
 * the Navigator's, from the same place. It looks where the Navigator has come to rest.
 */
import { signal } from "@preact/signals";
import { Connection } from "../connection";
import { drawFrame, parseFrame, type Frame } from "../frames";
import type { Pose, ServerMessage, StatusMessage } from "../protocol";
import * as store from "../store";

export class SecondView {
  readonly frame = signal<Omit<Frame, "picture"> | null>(null);
  readonly status = signal<StatusMessage | null>(null);
  private size = { width: 400, height: 300 };
  private placed = false;
  private canvas: HTMLCanvasElement | null = null;
  private link = new Connection({
    state: (state) => { if (state === "open") this.link.send({ type: "hello", ...this.size }); },
    message: (message) => this.take(message),
    binary: (buffer) => void this.draw(buffer),
  }, null);

  start(canvas: HTMLCanvasElement): void {
    this.canvas = canvas;
    void this.link.start();
  }

  stop(): void {
    this.link.close();
    store.secondView.value = null;
  }

  resize(width: number, height: number): void {
    if (width === this.size.width && height === this.size.height) return;
    this.size = { width, height };
    this.link.send({ type: "size", ...this.size });
  }

  follow(pose: Pose | null): void {
    if (!pose || pose.moving || !store.secondView.value) return;
    const { eye, at, up, parallel, fov, height } = pose;
    this.link.send({ type: "camera", eye, at, up, ...(parallel ? { parallel, height } : { fov }) });
  }

  private take(message: ServerMessage): void {
    if (message.type === "welcome") {
      store.secondView.value = message.view;
      this.placed = false;
    } else if (message.type === "pose" && !this.placed) {
      this.placed = true; // its camera stands: from now on it can be moved
      this.follow(store.pose.value);
    } else if (message.type === "status") {
      this.status.value = message;
    }
  }

  private async draw(buffer: ArrayBuffer): Promise<void> {
    const frame = parseFrame(buffer);
    if (!frame || !this.canvas) return;
    await drawFrame(this.canvas, frame).catch(() => {});
    const { picture: _, ...rest } = frame;
    this.frame.value = rest;
    this.link.send({ type: "ack", frame: frame.number });
  }
}
