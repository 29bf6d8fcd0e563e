/** All keys and gestures: those of the bindings, and the page's own. */
import { allActions } from "../actions";
import { GESTURES } from "../gestures";
import { bindingsOf } from "../keys";
import type { Binding } from "../protocol";
import * as store from "../store";
import { Modal } from "../ui/dialog";
import { label } from "../values";
import { Keys } from "./search";

const SLICES = [
  ["Next and previous slice", ["Wheel", "ArrowUp", "ArrowDown", "PageUp", "PageDown"]], ["Ten slices", ["Shift+PageUp", "Shift+PageDown"]], ["First and last", ["Home", "End"]],
  ["Cross-hair", ["Click", "Shift+Move"]], ["Window", ["right", "W+left"]], ["Zoom in", ["Control+Wheel", "+", "-"]],
  ["Move", ["middle", "Shift+ArrowLeft"]], ["See everything", ["R"]], ["Alone", ["Double click", "Enter"]],
] as const;
const TOUCH = [["One finger", "turn"], ["Two fingers", "move, zoom, roll"], ["Tap", "what is there"]] as const;

/** What methods say of angles is for a gain of 1. */
export function scaledAngle(text: string, gain: number): string {
  return text.replace(/(\d+) degrees?/, (_, degrees: string) => {
    const angle = Number((Number(degrees) * gain).toPrecision(3));
    return `${angle} degree${angle === 1 ? "" : "s"}`;
  });
}

function docOf(binding: Binding): string {
  if (binding.action) return GESTURES[binding.action]?.title ?? allActions().find((action) => action.name === binding.action)?.title ?? label(binding.action);
  const text = store.welcome.value?.methods[binding.method] ?? binding.method.replace(/-/g, " ");
  return label(scaledAngle(text, Math.abs(binding.gain ?? 1)));
}

interface Line {
  text: string;
  chords: string[];
}

/** One line for each thing, with all its keys. */
function linesOf(bindings: Binding[]): Line[] {
  const lines = new Map<string, string[]>();
  for (const binding of bindings) {
    const text = docOf(binding);
    const chord = binding.method === "click" ? `${binding.when}-click` : binding.when;
    if (chord) lines.set(text, [...(lines.get(text) ?? []), chord]);
  }
  return [...lines].map(([text, chords]) => ({ text, chords }));
}

function Table({ title, lines }: { title: string; lines: Line[] }) {
  return (
    <section class="help-group">
      <h3>{title}</h3>
      <dl>
        {lines.map(({ text, chords }) => (
          <div key={text} class="help-line">
            <dt>{text}</dt>
            <dd>{chords.map((chord) => <Keys key={chord} chord={chord} />)}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

export function HelpDialog() {
  const bindings = bindingsOf(store.welcome.value);
  const page = allActions().filter((action) => action.keys?.length && action.group !== "Navigator").map((action) => ({ text: action.title, chords: action.keys! }));
  const steps = bindings.filter((b) => b.device === "keyboard" && b.method !== "action");
  const views = allActions().filter((action) => action.group === "Navigator").map((action) => action.name);
  const asked = bindings.filter((b) => b.device === "keyboard" && b.action && (views.includes(b.action) || GESTURES[b.action]));
  return (
    <Modal title="Keys and gestures" wide>
      <div class="help" tabIndex={0} role="region" aria-label="List of keys">
        <Table title="Mouse" lines={[...linesOf(bindings.filter((b) => b.device === "mouse")), { text: "What is there", chords: ["Click"] }]} />
        <Table title="Keys in the picture" lines={linesOf(steps)} />
        <Table title="Views" lines={linesOf(asked)} />
        <Table title="Slices" lines={SLICES.map(([text, chords]) => ({ text, chords: [...chords] }))} />
        <Table title="Page" lines={page} />
        <Table title="Touch" lines={TOUCH.map(([chord, text]) => ({ text: label(text), chords: [chord] }))} />
        <Table title="Panels" lines={[{ text: "Next control", chords: ["Tab"] }, { text: "Show or hide in the scene", chords: ["Space"] }, { text: "Remove the selected", chords: ["Delete"] }]} />
      </div>
    </Modal>
  );
}
