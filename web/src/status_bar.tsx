/** The line at the bottom: what goes on, what to do next, and what it costs. */
import { runAction } from "./actions";
import { plan } from "./filter/state";
import { Icon } from "./icons";
import { hint as measuringHint, tool } from "./measure/room";
import { cancelJob } from "./session";
import * as store from "./store";
import { IconButton } from "./ui/controls";
import { formatBytes, formatNumber, formatSeconds } from "./values";

function Jobs() {
  return (
    <>
      {store.jobs.value.map((job) => {
        const share = job.total > 0 ? Math.min(1, job.done / job.total) : 0;
        const words = [job.name, job.stage, job.eta == null ? null : `${formatSeconds(job.eta)} left`].filter(Boolean).join(" · ");
        return (
          <div class="job" key={job.job}>
            <span class="job-words">{words}</span>
            <progress max={1} value={share} aria-label={`${job.name}, ${Math.round(100 * share)} percent`} />
            <IconButton icon="close" label={`Cancel ${job.name}`} onClick={() => cancelJob(job.job)} />
          </div>
        );
      })}
    </>
  );
}

/** One sentence on what to do next, by what is there. */
function hint(): string {
  if (store.connection.value.state === "lost") return "What you see is the last picture; edits wait for the connection.";
  if (tool.value && measuringHint(tool.value)) return `${tool.value.title}: ${measuringHint(tool.value)}`;
  if (store.isEmpty.value) return "Open a file, drop one here, or try a sample.";
  const [map] = store.selection.value.split(".");
  if (store.frame.value?.moving) return "Release to refine the picture.";
  if (plan.value) return "Drag the line in the picture to compare before and after. Apply makes it, Escape closes the panel.";
  if (store.layout.value === "slices") return "Wheel or arrows step through slices; click or Shift moves the cross-hair, a right drag the window.";
  if (map === "volumes") return "Drag the picture to rotate it; drag the points of the curve to change what is seen.";
  if (map === "lights") return "A light in the camera's frame stays where the viewer is.";
  if (map === "cut_planes") return "The normal points towards the side that is kept.";
  return "Drag to rotate, wheel to zoom, click for the value there. H lists all keys.";
}

/** What is under the pointer in a slice. */
function Pointed() {
  const { value, volume, position, index } = store.pointed.value!;
  const unit = store.valueUnit(volume);
  return (
    <span class="status-hint pointed">
      <strong>{value === null ? "none" : formatNumber(value)} {unit}</strong>
      {` · ${volume} · ${(position ?? []).map((v) => formatNumber(v)).join(", ")} ${store.lengthUnit.value} · voxel ${(index ?? []).map((v) => Math.round(v)).join(", ")}`}
    </span>
  );
}

/** Where one is connected, it leads to who else may be. */
function Connection() {
  const { state } = store.connection.value;
  const words = <><span class="dot" aria-hidden="true" />{state === "open" ? "connected" : state}</>;
  return state === "open" && !store.readOnly.value
    ? <button type="button" class="status-item connection connection-open" title="Who is let in" onClick={() => runAction("sessions")}>{words}</button>
    : <span class={`status-item connection connection-${state}`}>{words}</span>;
}

export function StatusBar() {
  const status = store.status.value;
  const still = !store.frame.value?.moving;
  const past = still ? ", during the last motion" : "";
  const people = store.people.value;
  return (
    <footer class="status">
      {store.jobs.value.length ? <Jobs /> : store.pointed.value && !tool.value ? <Pointed /> : <span class="status-hint">{hint()}</span>}
      <span class="grow" />
      {people > 1 ? <span class="status-item" title="Number of viewers of this scene"><Icon name="people" />{people}</span> : null}
      {status ? (
        <>
          {status.method ? <span class="status-item" title="Rendering method">{status.method}</span> : null}
          {still && status.frames < 0.5 ? null : (
            <>
              <span class={`status-item${still ? " status-past" : ""}`} title={`Frames per second${past}`}>{status.frames.toFixed(0)} fps</span>
              <span class={`status-item${still ? " status-past" : ""}`} title={`Latency from input to picture${past}`}>{Math.round(status.latency)} ms</span>
            </>
          )}
          <span class="status-item" title={`Memory, of ${formatBytes(status.memory_limit)}`}>{formatBytes(status.memory)}</span>
        </>
      ) : null}
      <Connection />
    </footer>
  );
}
