/** What pointers and keys do in a slice. */
import type { RefObject } from "preact";
import { useEffect } from "preact/hooks";
import { focusOn, pointAt, press, release, trace, type Target } from "../measure/hands";
import { finish, hover, tool } from "../measure/room";
import * as store from "../store";
import { endGesture, goToSlice, moveCrossHair, runOf, setWindow, stepSlices, windowNow } from "./edits";
import { draggedWindow, panned, toWorld, zoomed } from "./geometry";
import type { SliceView } from "./slice_view";

type Drag = { what: "hair" | "window" | "pan" | "measure"; x: number; y: number; window: [number, number] | null };

const ZOOM = 1.15;
const PAN_KEY = 0.05; // of the picture

/** W is held with the focus in any slice. */
let windowKey = false;

class Hands {
  private drag: Drag | null = null;
  private wheel = 0;
  private stop = new AbortController();

  constructor(private area: HTMLElement, private view: SliceView, private target: Target) {
    const on = <K extends keyof HTMLElementEventMap>(type: K, fn: (event: HTMLElementEventMap[K]) => void) =>
      area.addEventListener(type, fn, { signal: this.stop.signal, passive: false });
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.up);
    on("pointerleave", () => { store.pointed.value = hover.value = null; });
    on("focus", () => focusOn(this.target));
    on("wheel", this.turn);
    on("keydown", this.key);
    on("keyup", (event) => { if (event.key.toLowerCase() === "w") windowKey = false; });
    on("blur", () => { windowKey = false; });
    on("contextmenu", (event) => event.preventDefault());
    on("dblclick", () => { if (tool.value) finish(); else toggleMaximised(this.view.plane); });
  }

  dispose(): void {
    this.stop.abort();
  }

  private get aspect(): number {
    return this.area.clientWidth / Math.max(1, this.area.clientHeight);
  }

  private place(event: MouseEvent): [number, number] {
    const rect = this.area.getBoundingClientRect();
    return [(event.clientX - rect.left) / rect.width, (event.clientY - rect.top) / rect.height];
  }

  private hairTo(event: MouseEvent): void {
    const pose = this.view.pose.value;
    const hair = store.crossHair.value;
    if (pose && hair) moveCrossHair(toWorld(pose, this.aspect, ...this.place(event), hair), `hair ${this.view.plane}`);
  }

  private down = (event: PointerEvent): void => {
    this.area.focus();
    this.area.dataset["pointer"] = "";
    event.preventDefault();
    if (this.drag) return;
    this.area.setPointerCapture(event.pointerId);
    const what = event.button === 1 ? "pan" : event.button === 2 || windowKey ? "window" : tool.value ? "measure" : "hair";
    this.drag = { what, x: event.clientX, y: event.clientY, window: what === "window" ? windowNow() : null };
    if (what === "hair") this.hairTo(event);
    if (what === "measure") press(this.target, ...this.place(event));
  };

  private move = (event: PointerEvent): void => {
    const d = this.drag;
    pointAt(this.target, ...this.place(event));
    if (d?.what === "measure") {
      const { clientWidth, clientHeight } = this.area;
      const [x, y] = this.place(event);
      trace(this.target, [x - (event.clientX - d.x) / clientWidth, y - (event.clientY - d.y) / clientHeight], [x, y], [clientWidth, clientHeight]);
      return;
    }
    if (!d) {
      if (event.shiftKey && !tool.value) this.hairTo(event);
      void this.view.point(...this.place(event));
      return;
    }
    const dx = event.clientX - d.x;
    const dy = event.clientY - d.y;
    if (d.what === "hair") {
      this.hairTo(event);
    } else if (d.what === "window") {
      if (d.window) setWindow(draggedWindow(d.window, dx, dy));
    } else if (this.view.pose.value) {
      this.view.look(panned(this.view.pose.value, this.aspect, dx / this.area.clientWidth, dy / this.area.clientHeight));
      d.x = event.clientX;
      d.y = event.clientY;
    }
  };

  private up = (event: PointerEvent): void => {
    const d = this.drag;
    if (d?.what === "measure" && event.type === "pointerup") {
      const { clientWidth, clientHeight } = this.area;
      const [x, y] = this.place(event);
      release(this.target, [x - (event.clientX - d.x) / clientWidth, y - (event.clientY - d.y) / clientHeight], [x, y], [clientWidth, clientHeight]);
    }
    if (d && d.what !== "pan") endGesture();
    this.drag = null;
  };

  private turn = (event: WheelEvent): void => {
    event.preventDefault();
    const pose = this.view.pose.value;
    const notches = event.deltaY / (event.deltaMode === 1 ? 3 : event.deltaMode === 2 ? 1 : 100);
    if (event.ctrlKey) {
      if (pose) this.view.look(zoomed(pose, this.aspect, ZOOM ** Math.max(-5, Math.min(5, notches)), ...this.place(event)));
      return;
    }
    this.wheel += notches; // touch pads speak in parts of a notch
    const whole = Math.trunc(this.wheel);
    this.wheel -= whole;
    if (whole) stepSlices(this.view.plane, -whole);
  };

  private key = (event: KeyboardEvent): void => {
    delete this.area.dataset["pointer"];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { plane } = this.view;
    const steps: { [key: string]: number } = { ArrowUp: 1, ArrowRight: 1, PageUp: 1, ArrowDown: -1, ArrowLeft: -1, PageDown: -1 };
    const moves: { [key: string]: [number, number] } = { ArrowUp: [0, PAN_KEY], ArrowDown: [0, -PAN_KEY], ArrowLeft: [PAN_KEY, 0], ArrowRight: [-PAN_KEY, 0] };
    const pose = this.view.pose.value;
    if (event.key.toLowerCase() === "w") windowKey = true;
    else if (event.shiftKey && moves[event.key] && pose) this.view.look(panned(pose, this.aspect, ...moves[event.key]!));
    else if (steps[event.key]) stepSlices(plane, steps[event.key]! * (event.shiftKey ? 10 : 1));
    else if (event.key === "Home" || event.key === "End") goToSlice(plane, event.key === "Home" ? 0 : (runOf(plane)?.n ?? 1) - 1);
    else if ((event.key === "+" || event.key === "-") && pose) this.view.look(zoomed(pose, this.aspect, event.key === "+" ? 1 / ZOOM : ZOOM, 0.5, 0.5));
    else if (event.key.toLowerCase() === "r") this.view.send({ type: "action", name: "fit" });
    else if (event.key === "Enter") toggleMaximised(plane);
    else return;
    event.preventDefault();
  };
}

export function toggleMaximised(what: string): void {
  store.maximised.value = store.maximised.value === what ? null : what;
}

export function useHands(area: RefObject<HTMLElement | null>, view: SliceView, target: Target): void {
  useEffect(() => {
    const hands = new Hands(area.current!, view, target);
    return () => hands.dispose();
  }, []);
}
