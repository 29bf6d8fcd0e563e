/** What hands ask for in the Navigator besides moving the camera: bindings with the methods click and drag. */
import type { ActionMessage, Pick } from "./protocol";
import { Gesture, send, tryAsk, whileUnanswered } from "./session";
import { draggedWindow } from "./slices/geometry";
import * as store from "./store";
import { rangeOf, windowEdits, type Range } from "./transfer/window";
import type { Transfer } from "./protocol";

/** A place of the input events in pixels from the top left of the Navigator, whose size is told too. */
export function pixelsOf([x, y]: readonly number[], [width, height]: readonly number[]): [number, number] {
  const half = Math.min(width!, height!) / 2;
  return [width! / 2 + x! * half, height! / 2 - y! * half];
}

function sizeOfNavigator(): [number, number] {
  const rect = document.querySelector("[data-viewport]")?.getBoundingClientRect();
  return [rect?.width || 1, rect?.height || 1];
}

/** Looks at the point under the pointer, from where one looks now. */
async function center(message: ActionMessage): Promise<void> {
  const size = sizeOfNavigator();
  const [x, y] = pixelsOf(message.at ?? [0, 0], size);
  const hit = await tryAsk<Pick>({ type: "pick", x: x / size[0], y: y / size[1] });
  const pose = store.pose.value;
  if (!hit || !pose) return;
  if (!hit.hit || !hit.position) {
    store.announcement.value = "There is nothing to look at.";
    return;
  }
  const at = hit.position;
  const eye = pose.eye.map((v, i) => v + at[i]! - pose.at[i]!);
  send({ type: "camera", eye, at, up: pose.up, ...(pose.parallel ? { parallel: true, height: pose.height } : { fov: pose.fov }) });
}

interface Held {
  gesture: Gesture;
  path: string;
  transfer: Transfer;
  range: Range;
  fixed: boolean;
  scale: number;
}

let held: Held | null = null;

function grasp(): Held | null {
  const volume = store.currentVolume.value;
  const transfer = volume ? store.transfers.value[volume] : undefined;
  const range = transfer ? rangeOf(transfer) : null;
  if (!transfer || !range || store.readOnly.value) return null;
  const path = `volumes.${volume}.segmentation.transfer`;
  const scale = store.valueOf(`${path}.opacity_scale`);
  return {
    gesture: new Gesture(), path, transfer, range, scale: typeof scale === "number" ? scale : 1,
    fixed: store.isSet(`${path}.color`) || (store.isSet(`${path}.preset`) && !store.isSet(`${path}.colormap`)),
  };
}

/** Across: the width of what is shown. Up: its level. */
function moveWindow(h: Held, dx: number, dy: number): void {
  h.gesture.change(...windowEdits(h.path, h.transfer, h.range, draggedWindow(h.range, dx, dy), h.fixed));
}

/** Up: denser; 100 pixels are a factor of e. */
function moveOpacity(h: Held, _: number, dy: number): void {
  h.gesture.change({ op: "set", path: `${h.path}.opacity_scale`, value: Number(Math.min(1e6, h.scale * Math.exp(-dy / 100)).toPrecision(4)) });
}

function drag(move: (held: Held, dx: number, dy: number) => void): (message: ActionMessage) => void {
  return (message) => {
    const size = sizeOfNavigator();
    const [x, y] = pixelsOf(message.at ?? [0, 0], size);
    const [x0, y0] = pixelsOf(message.from ?? [0, 0], size);
    if (message.phase === "begin") held = grasp();
    else if (message.phase === "move" && held) move(held, x - x0, y - y0);
    else held = null;
  };
}

/** By the names that bindings have; the words stand in the help. */
export const GESTURES: { [name: string]: { title: string; run: (message: ActionMessage) => void } } = {
  center: { title: "Look at what is under the pointer", run: (message) => void whileUnanswered(center(message)) },
  window: { title: "Value window: width across, level up", run: drag(moveWindow) },
  "window-opacity": { title: "Denser or thinner", run: drag(moveOpacity) },
};
