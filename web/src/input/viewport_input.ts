/** Listens to a viewport's pointers, wheel and keys and sends what they do, raw, at most once a frame of the screen. */
import { addEvent, isSendable, keyName, placeIn, printEvent, wheelNotches, type RawEvent, type TimedEvent } from "./events";

export interface InputTarget {
  send(lines: string[]): void;
  /** Something will be sent with the next frame of the screen. */
  expect(): void;
  /** A click without a drag, from 0 to 1 from the top left. */
  click(x: number, y: number): void;
  /** Keys that the page has for itself; true: not the server's. */
  ownsKey(event: KeyboardEvent): boolean;
  /** Keys that ask for something where the pointer is. */
  asksWhere(event: KeyboardEvent): boolean;
}

const BUTTONS = ["left", "middle", "right"];
const MODIFIERS = [["Shift", "shiftKey"], ["Control", "ctrlKey"], ["Alt", "altKey"], ["Meta", "metaKey"]] as const;
const CLICK_PIXELS = 4;
const CLICK_MS = 400;

export class ViewportInput {
  private waiting: TimedEvent[] = [];
  private scheduled = 0;
  private clock = 0;
  private held = new Set<string>(); // modifiers that the server believes to be down
  private keys = new Set<string>();
  private hover: PointerEvent | null = null; // where the pointer is without a button: keys ask for what is there
  private press: { x: number; y: number; t: number } | null = null;
  private stop = new AbortController();

  constructor(private element: HTMLElement, private target: InputTarget) {
    const listen = <K extends keyof HTMLElementEventMap>(type: K, fn: (e: HTMLElementEventMap[K]) => void, passive = true) =>
      element.addEventListener(type, fn, { passive, signal: this.stop.signal });
    listen("pointerdown", this.pointerDown, false);
    listen("pointermove", this.pointerMove);
    listen("pointerup", this.pointerUp);
    listen("pointercancel", this.pointerCancel);
    listen("pointerleave", () => { this.hover = null; });
    listen("wheel", this.wheel, false);
    listen("keydown", this.keyDown, false);
    listen("keyup", this.keyUp);
    listen("contextmenu", (e) => e.preventDefault(), false);
    listen("blur", this.blur);
    window.addEventListener("blur", this.blur, { signal: this.stop.signal });
  }

  dispose(): void {
    this.stop.abort();
    cancelAnimationFrame(this.scheduled);
  }

  private add(event: RawEvent, t: number = performance.now()): void {
    this.clock = Math.max(this.clock, t); // events may be stamped before ones that came first: time never runs back
    addEvent(this.waiting, { ...event, t: this.clock });
    this.scheduled ||= requestAnimationFrame(this.flush);
    this.target.expect();
  }

  private flush = (): void => {
    cancelAnimationFrame(this.scheduled);
    this.scheduled = 0;
    if (this.waiting.length) this.target.send(this.waiting.flatMap(printEvent));
    this.waiting = [];
  };

  /** Modifiers may have been pressed while the focus was elsewhere. */
  private syncModifiers(event: MouseEvent | KeyboardEvent): void {
    for (const [name, flag] of MODIFIERS) {
      if (event[flag] === this.held.has(name)) continue;
      this.add({ kind: "key", key: name, down: event[flag] });
      if (event[flag]) this.held.add(name);
      else this.held.delete(name);
    }
  }

  private place(event: MouseEvent): [number, number] {
    return placeIn(this.element.getBoundingClientRect(), event.clientX, event.clientY);
  }

  private touch(event: PointerEvent, phase: "begin" | "move" | "end" | "cancel"): void {
    const [x, y] = this.place(event);
    this.add({ kind: "touch", id: event.pointerId, phase, x, y }, event.timeStamp);
  }

  private movePointer(event: MouseEvent): void {
    const [x, y] = this.place(event);
    this.add({ kind: "place", x, y }, event.timeStamp);
  }

  private pointerDown = (event: PointerEvent): void => {
    event.preventDefault(); // no scrolling by the middle button, no selection of text
    this.element.dataset["pointer"] = ""; // who has the picture in hand needs no ring around it
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    this.press = event.button === 0 ? { x: event.clientX, y: event.clientY, t: event.timeStamp } : null;
    if (event.pointerType === "touch") {
      this.touch(event, "begin");
      return;
    }
    this.hover = event;
    this.syncModifiers(event);
    this.movePointer(event);
    this.button(event, true);
  };

  private button(event: PointerEvent, down: boolean): void {
    const button = BUTTONS[event.button];
    if (button) this.add({ kind: "button", button, down }, event.timeStamp);
  }

  /** Between frames a held mouse may press further buttons: browsers tell that as moves. */
  private pointerMove = (event: PointerEvent): void => {
    if (event.pointerType === "touch") {
      this.touch(event, "move");
      return;
    }
    if (event.button >= 0) this.button(event, (event.buttons & [1, 4, 2][event.button]!) !== 0);
    this.hover = event;
    if (event.buttons) this.movePointer(event);
  };

  private pointerUp = (event: PointerEvent): void => {
    if (event.pointerType === "touch") {
      this.touch(event, "end");
    } else {
      this.movePointer(event);
      this.button(event, false);
    }
    this.maybeClick(event);
  };

  private maybeClick(event: PointerEvent): void {
    const press = this.press;
    this.press = null;
    if (!press || event.timeStamp - press.t > CLICK_MS) return;
    if (Math.hypot(event.clientX - press.x, event.clientY - press.y) > CLICK_PIXELS) return;
    if (event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    const rect = this.element.getBoundingClientRect();
    this.target.click((event.clientX - rect.left) / rect.width, (event.clientY - rect.top) / rect.height);
  }

  private pointerCancel = (event: PointerEvent): void => {
    this.press = null;
    if (event.pointerType === "touch") this.touch(event, "cancel");
    else this.add({ kind: "lost", device: "mouse" });
    this.flush();
  };

  private wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const pinch = event.ctrlKey && !this.held.has("Control"); // a trackpad's pinch comes as a wheel with Control
    if (!pinch) this.syncModifiers(event);
    this.movePointer(event);
    const notchesY = -wheelNotches(event.deltaY * (pinch ? 10 : 1), event.deltaMode);
    const notchesX = wheelNotches(event.deltaX, event.deltaMode);
    if (notchesY) this.add({ kind: "wheel", axis: "wheel-y", notches: notchesY }, event.timeStamp);
    if (notchesX) this.add({ kind: "wheel", axis: "wheel-x", notches: notchesX }, event.timeStamp);
  };

  private keyDown = (event: KeyboardEvent): void => {
    delete this.element.dataset["pointer"];
    if (event.key === "Tab" || this.target.ownsKey(event)) return; // Tab leaves: no trap
    const key = keyName(event);
    if (!isSendable(key) || event.isComposing) return;
    if (!MODIFIERS.some(([name]) => name === key)) {
      this.syncModifiers(event);
      if (!event.repeat && this.target.asksWhere(event)) this.pointAt();
      this.keys.add(key);
      event.preventDefault();
      this.add({ kind: "key", key, down: true }, event.timeStamp);
    } else {
      this.syncModifiers(event);
    }
  };

  /** Without a pointer over the picture keys speak of its middle. */
  private pointAt(): void {
    const [x, y] = this.hover ? this.place(this.hover) : [0, 0];
    this.add({ kind: "place", x, y });
  }

  private keyUp = (event: KeyboardEvent): void => {
    const key = keyName(event);
    if (this.keys.delete(key)) this.add({ kind: "key", key, down: false }, event.timeStamp);
    this.syncModifiers(event);
  };

  private blur = (): void => {
    delete this.element.dataset["pointer"];
    if (!this.keys.size && !this.held.size && !this.press) return;
    this.keys.clear();
    this.held.clear();
    this.press = null;
    this.add({ kind: "lost", device: "keyboard" });
    this.add({ kind: "lost", device: "mouse" });
    this.flush();
  };
}
