/**
 * The Rendering viewport is a client of its own, with a view of its own in the World: another method and quality than
 * the Navigator's, from the same place. It looks where the Navigator has come to rest.
 */
import type { Pose, ServerMessage } from "../protocol";
import * as store from "../store";
import { OwnView } from "./own_view";

export class SecondView extends OwnView {
  private placed = false;

  override stop(): void {
    super.stop();
    store.secondView.value = null;
  }

  follow(pose: Pose | null): void {
    if (!pose || pose.moving || !store.secondView.value) return;
    const { eye, at, up, parallel, fov, height } = pose;
    this.send({ type: "camera", eye, at, up, ...(parallel ? { parallel, height } : { fov }) });
  }

  protected override take(message: ServerMessage): void {
    super.take(message);
    if (message.type === "welcome") {
      store.secondView.value = message.view;
      this.placed = false;
    } else if (message.type === "pose" && !this.placed) {
      this.placed = true; // its camera stands: from now on it can be moved
      this.follow(store.pose.value);
    }
  }
}
