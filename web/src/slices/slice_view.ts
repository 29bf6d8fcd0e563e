/** One slice: a client with a view of its own whose method is slice. What is seen in it is the World's. */
import { signal } from "@preact/signals";
import { KnownWorld } from "../changes";
import type { JsonObject, Pick, Pose, ServerMessage } from "../protocol";
import * as store from "../store";
import { valueAt } from "../values";
import { OwnView } from "../view/own_view";
import type { Plane } from "./geometry";

export class SliceView extends OwnView {
  readonly pose = signal<Pose | null>(null);
  private view = "";
  private known = new KnownWorld();
  private seen = false; // its view stands in the World
  private picking = false;
  private next: [number, number] | null = null;

  constructor(readonly plane: Plane) {
    super({ plane });
  }

  override stop(): void {
    super.stop();
    const { [this.plane]: _, ...others } = store.sliceViews.value;
    store.sliceViews.value = others;
  }

  look(pose: Pose): void {
    this.pose.value = pose;
    const { eye, at, up, height } = pose;
    this.send({ type: "camera", eye, at, up, parallel: true, height });
  }

  /** What is under the pointer: one question at a time, the newest place next. */
  async point(x: number, y: number): Promise<void> {
    this.next = [x, y];
    if (this.picking) return;
    this.picking = true;
    while (this.next) {
      const [px, py] = this.next;
      this.next = null;
      const value = await this.ask<Pick>({ type: "pick", x: px, y: py }).catch(() => null);
      store.pointed.value = value?.hit ? value : null;
    }
    this.picking = false;
  }

  protected override take(message: ServerMessage): void {
    super.take(message);
    if (message.type === "welcome") {
      this.view = message.view;
      this.seen = false;
      store.sliceViews.value = { ...store.sliceViews.value, [this.plane]: message.view };
    } else if (message.type === "pose") {
      this.pose.value = message;
    } else if (message.type === "world") {
      const world = this.known.take(message);
      if (world) this.findView(world);
      else this.send({ type: "world" });
    }
  }

  private findView(world: JsonObject): void {
    const method = valueAt(world, `views.${this.view}.render.method`);
    const there = !!store.welcome.value?.renderers.some((row) => row.plane && row.name === method);
    if (this.seen && !there) this.again(); // another World, which has no such view yet
    this.seen ||= there;
  }
}
