/** Over the Navigator: who draws it while it moves, and what is seen now. */
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { atRest, choice, CHOICES, choose, toggleAtRest, own, wanted, type Choice } from "./choice";

export function DrawingChooser() {
  const doc = CHOICES.find((row) => row.value === choice.value)!.doc;
  return (
    <>
      <select class="overlay-select" aria-label="Drawing while the Navigator moves" title={doc} value={choice.value} onChange={(e) => choose(e.currentTarget.value as Choice)}>
        {CHOICES.map((row) => <option key={row.value} value={row.value}>{row.text}</option>)}
      </select>
      {wanted.value ? (
        <IconButton icon="rest" label="The page also draws at rest" pressed={atRest.value} onClick={toggleAtRest} />
      ) : null}
    </>
  );
}

const WORDS = { reduced: "Reduced surface", boxes: "Boxes" };

/** In the place of how far the server's frame is refined. */
export function OwnState() {
  const moving = store.pose.value?.moving === true;
  const state = moving ? "moving" : atRest.value ? "final" : "refining";
  return (
    <div class="overlay overlay-state">
      <span class={`dot dot-${state}`} aria-hidden="true" />
      {store.layout.value === "one" ? null : <strong>Navigator</strong>}
      <span>{own.value ? `${WORDS[own.value.method]} · drawn by the page` : ""}</span>
    </div>
  );
}
