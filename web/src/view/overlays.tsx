/** Words over the picture: how far it is refined, and what was picked. */
import { datasetOf, reasonOf, type Failure } from "../failure";
import type { Frame } from "../frames";
import { Icon } from "../icons";
import { IconButton } from "../ui/controls";
import * as store from "../store";
import { formatNumber, label } from "../values";

const LEVELS = 3;

/** A picture that is older than what it should show. */
export function pictureClass(failure: Failure | null): string {
  return failure ? "picture picture-outdated" : "picture";
}

/** Why there is no newer picture; the one from before stays. */
export function FailureState({ failure }: { failure: Failure | null }) {
  if (!failure || store.isEmpty.value) return null;
  const made = store.valueOf(`datasets.${datasetOf(failure)}.operation`);
  return (
    <div class="overlay overlay-failed" title={failure.text}>
      <Icon name="error" />
      <span>{typeof made === "string" ? <strong>{label(made)} cannot be made: </strong> : null}{reasonOf(failure).replace(/\.?$/, ".")} The picture is from before.</span>
    </div>
  );
}

/** Reduced detail is always said; the dot is full when nothing better will come. */
export function RefinementState({ frame, final, failure, name }: { frame: Omit<Frame, "picture"> | null; final: boolean; failure: Failure | null; name: string }) {
  if (failure) return <FailureState failure={failure} />;
  if (!frame || store.isEmpty.value) return null;
  const share = frame.fullWidth ? Math.round((100 * frame.width) / frame.fullWidth) : 100;
  const state = final ? "final" : frame.moving ? "moving" : "refining";
  const words = [
    final ? "Finished" : frame.moving ? "Moving" : frame.compressed ? "Compressed: the connection is slow" : "Refining",
    final || frame.compressed ? null : `level ${Math.min(frame.level + 1, LEVELS)} of ${LEVELS}`,
    share < 100 ? `${share} % size` : null,
    frame.passes > 1 ? `${frame.passes} samples` : null,
  ].filter(Boolean);
  return (
    <div class="overlay overlay-state">
      <span class={`dot dot-${state}`} aria-hidden="true" />
      {name ? <strong>{name}</strong> : null}
      <span>{words.join(" · ")}</span>
    </div>
  );
}

/** The mark stays on the picture, the words at its lower edge. */
export function Probe() {
  const hit = store.picked.value;
  if (!hit) return null;
  return <Mark x={hit.x} y={hit.y} />;
}

function Mark({ x, y }: { x: number; y: number }) {
  return (
    <svg class="probe-mark" viewBox="0 0 24 24" width="24" height="24" aria-hidden="true" style={{ left: `${100 * x}%`, top: `${100 * y}%` }}>
      <circle cx="12" cy="12" r="5" />
      <path d="M12 1v6M12 17v6M1 12h6M17 12h6" />
    </svg>
  );
}

function list(values: number[] | null): string {
  return values ? values.map((value) => formatNumber(value)).join(", ") : "";
}

export function ProbeBar() {
  const hit = store.picked.value;
  if (!hit) return null;
  return (
    <div class="overlay probe" role="group" aria-label="Picked point">
      {hit.hit ? (
        <dl class="probe-list">
          <div><dt>Value</dt><dd>{hit.value === null ? "none" : formatNumber(hit.value)} {store.valueUnit(hit.volume)}</dd></div>
          <div><dt>Position</dt><dd>{list(hit.position)} {store.lengthUnit.value}</dd></div>
          {hit.index ? <div><dt>Voxel</dt><dd>{list(hit.index.map((v) => Math.round(v)))}</dd></div> : null}
          {hit.volume ? <div><dt>Volume</dt><dd>{hit.volume}</dd></div> : null}
        </dl>
      ) : <span>{hit.text || "Nothing is seen there."}</span>}
      <IconButton icon="close" label="Dismiss the picked point" onClick={() => { store.picked.value = null; }} />
    </div>
  );
}
