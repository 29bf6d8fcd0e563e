/** Raw events of input devices as lines of text (src/input/event.h), and their coalescing. */

export type RawEvent =
  | { kind: "place"; x: number; y: number }
  | { kind: "wheel"; axis: "wheel-x" | "wheel-y"; notches: number }
  | { kind: "button"; button: string; down: boolean }
  | { kind: "key"; key: string; down: boolean }
  | { kind: "touch"; id: number; phase: "begin" | "move" | "end" | "cancel"; x: number; y: number }
  | { kind: "lost"; device: "mouse" | "keyboard" | "touch" };

export type TimedEvent = RawEvent & { t: number };

/** From the middle of the viewport, in half of its smaller side, x right and y up. */
export function placeIn(rect: { left: number; top: number; width: number; height: number }, x: number, y: number): [number, number] {
  const half = Math.max(1, Math.min(rect.width, rect.height)) / 2;
  return [(x - rect.left - rect.width / 2) / half, (rect.top + rect.height / 2 - y) / half];
}

/** Letters as capitals, digits by their key so that Shift does not change them, others as browsers name them. */
export function keyName(event: { key: string; code: string }): string {
  const digit = /^(?:Digit|Numpad)(\d)$/.exec(event.code);
  if (digit) return `Digit${digit[1]}`;
  if (event.key === " ") return "Space";
  return /^[a-z]$/i.test(event.key) ? event.key.toUpperCase() : event.key;
}

/** Names that the line format can hold: ASCII without blanks, below 24 bytes. */
export function isSendable(name: string): boolean {
  return /^[!-~]{1,23}$/.test(name);
}

const PIXELS_A_NOTCH = 100;
const LINES_A_NOTCH = 3;

/** Wheels speak in pixels, lines or pages; positive is away from oneself, or to the right. */
export function wheelNotches(delta: number, mode: number): number {
  const unit = mode === 1 ? LINES_A_NOTCH : mode === 2 ? 1 : PIXELS_A_NOTCH;
  return Math.max(-10, Math.min(10, delta / unit));
}

function number(value: number): string {
  return String(Number(value.toFixed(6)));
}

/** The lines of one event. */
export function printEvent(event: TimedEvent): string[] {
  const t = Math.max(0, Math.round(event.t * 1e6)); // milliseconds of performance.now() to nanoseconds
  switch (event.kind) {
    case "place":
      return [`${t} mouse axis x ${number(event.x)}`, `${t} mouse axis y ${number(event.y)}`];
    case "wheel":
      return [`${t} mouse axis ${event.axis} ${number(event.notches)}`];
    case "button":
      return [`${t} mouse button ${event.button} ${event.down ? "down" : "up"}`];
    case "key":
      return [`${t} keyboard key ${event.key} ${event.down ? "down" : "up"}`];
    case "touch":
      return [`${t} touch touch ${event.id} ${event.phase} ${number(event.x)} ${number(event.y)}`];
    case "lost":
      return [`${t} ${event.device} lost`];
  }
}

/**
 * Adds an event to those that wait, in place of an older one that it makes superfluous: of moves that follow each other
 * the last counts, and turns of the wheel add up. The order of all others stays.
 */
export function addEvent(waiting: TimedEvent[], event: TimedEvent): void {
  const last = waiting[waiting.length - 1];
  if (event.kind === "place" && last?.kind === "place") {
    waiting[waiting.length - 1] = event;
    return;
  }
  if (event.kind === "wheel" && last?.kind === "wheel" && last.axis === event.axis) {
    waiting[waiting.length - 1] = { ...event, notches: last.notches + event.notches };
    return;
  }
  if (event.kind === "touch" && event.phase === "move") {
    for (let i = waiting.length - 1; i >= 0; i--) {
      const other = waiting[i];
      if (other?.kind !== "touch" || other.phase !== "move") break;
      if (other.id !== event.id) continue;
      waiting.splice(i, 1);
      break;
    }
  }
  waiting.push(event);
}
