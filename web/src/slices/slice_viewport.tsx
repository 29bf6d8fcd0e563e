/** A slice: its picture, the cross-hair over it, and where it is. */
import { useSignalEffect } from "@preact/signals";
import type { TargetedEvent } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { PreviewOverlay } from "../filter/preview";
import { isInSlice } from "../measure/geometry";
import type { Target } from "../measure/hands";
import { MeasureOverlay } from "../measure/overlay";
import type { Pick } from "../protocol";
import { fetchInfo } from "../session";
import * as store from "../store";
import { IconButton } from "../ui/controls";
import { formatNumber, label } from "../values";
import { FailureState, pictureClass } from "../view/overlays";
import { watchSize } from "../view/pixel_size";
import { datasetOfRuns, endGesture, goToSlice, runOf } from "./edits";
import { AXIS, frameOf, PLANES, sliceAt, toPicture, toWorld, type Plane, type Vec3 } from "./geometry";
import { toggleMaximised, useHands } from "./hands";
import { SliceView } from "./slice_view";

const GAP = 10; // pixels around the cross-hair, so that it hides nothing of what it is at

const EDGE = 24;

/** The planes that cut this one: the line that goes up and the one that goes across. */
const LINES: { [plane in Plane]: [Plane, Plane] } = {
  axial: ["sagittal", "coronal"], coronal: ["sagittal", "axial"], sagittal: ["coronal", "axial"],
};
const AXES = ["x", "y", "z"] as const;

/** A line of the cross-hair in pieces: not at its middle, and not at the borders, where letters are. */
function lines(middle: number, length: number): [number, number][] {
  const pieces: [number, number][] = [[EDGE, middle - GAP], [middle + GAP, length - EDGE]];
  return pieces.map(([from, to]): [number, number] => [Math.max(EDGE, from), Math.min(length - EDGE, to)]).filter(([from, to]) => to > from);
}

function CrossHair({ view, width, height }: { view: SliceView; width: number; height: number }) {
  const pose = view.pose.value;
  const hair = store.crossHair.value;
  if (!pose || !hair || !(width > 0)) return null;
  const [u, v] = toPicture(pose, width / height, hair);
  const [x, y] = [u * width, v * height];
  const [upright, across] = LINES[view.plane];
  return (
    <svg class="cross-hair" width={width} height={height} aria-hidden="true">
      <path class={`line-${AXES[AXIS[upright]]}`} d={lines(y, height).map(([from, to]) => `M${x} ${from}V${to}`).join("")} />
      <path class={`line-${AXES[AXIS[across]]}`} d={lines(x, width).map(([from, to]) => `M${from} ${y}H${to}`).join("")} />
    </svg>
  );
}

/** Where the slice is: a slider over all of them, in words the place and the number. */
function Place({ plane }: { plane: Plane }) {
  const run = runOf(plane);
  const hair = store.crossHair.value;
  const place = hair ? hair[AXIS[plane]] : 0;
  const slice = run ? sliceAt(run, place) : 0;
  const words = run ? `${formatNumber(place)} ${store.lengthUnit.value}, slice ${slice + 1} of ${run.n}` : "";
  const to = (event: TargetedEvent<HTMLInputElement>) => goToSlice(plane, Number(event.currentTarget.value));
  return (
    <>
      <input
        type="range" class="slice-slider" min={0} max={(run?.n ?? 1) - 1} step={1} value={slice} disabled={!run || store.readOnly.value}
        aria-label={`${label(plane)} slice`} aria-valuetext={words} onInput={to} onChange={endGesture}
      />
      <span class="slice-place">{run ? `${formatNumber(place)} ${store.lengthUnit.value}` : ""}</span>
      <span class="slice-number">{run ? `${slice + 1} / ${run.n}` : ""}</span>
    </>
  );
}

/** What measuring asks of a slice: every place of it is one of the World. */
function targetOf(view: SliceView, size: () => [number, number]): Target {
  const aspect = () => { const [width, height] = size(); return width / Math.max(1, height); };
  const hair = () => store.crossHair.value;
  return {
    name: view.plane,
    at: (x, y) => (view.pose.value && hair() ? toWorld(view.pose.value, aspect(), x, y, hair()!) : null),
    pick: (x, y) => view.ask<Pick>({ type: "pick", x, y }).catch(() => null),
    frame: () => (view.pose.value ? frameOf(view.pose.value) : null),
    middle: () => (view.pose.value && hair() ? toPicture(view.pose.value, aspect(), hair()!) : [0.5, 0.5]),
  };
}

/** Handles that are dragged stay as deep as they are. */
function Measures({ view, target, width, height }: { view: SliceView; target: Target; width: number; height: number }) {
  const pose = view.pose.value;
  const hair = store.crossHair.value;
  const dataset = datasetOfRuns();
  const info = dataset ? store.dataInfos.value[dataset] : undefined;
  const isHere = (p: Vec3) => hair !== null && isInSlice(info && typeof info !== "string" ? info : null, view.plane, hair, p);
  const drag = (x: number, y: number, from: Vec3) => Promise.resolve(pose ? toWorld(pose, width / height, x, y, from) : null);
  return <MeasureOverlay target={target} pose={pose} width={width} height={height} isHere={isHere} drag={drag} />;
}

function SliceViewport({ plane }: { plane: Plane }) {
  const area = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const view = useMemo(() => new SliceView(plane), []);
  const [[width, height], setSize] = useState([0, 0]);
  const target = useMemo(() => targetOf(view, () => [area.current?.clientWidth ?? 1, area.current?.clientHeight ?? 1]), []);
  useEffect(() => {
    const element = area.current!; // its size is told once more when it is gone from here
    const unwatch = watchSize(element, (w, h) => {
      view.resize(w, h);
      setSize([element.clientWidth, element.clientHeight]);
    });
    view.start(canvas.current!);
    return () => {
      unwatch();
      view.stop();
    };
  }, []);
  useHands(area, view, target);
  const large = store.maximised.value === plane;
  const hidden = store.maximised.value !== null && !large;
  return (
    <section class={`viewport-frame slice ${large ? "maximised" : ""}`} hidden={hidden} aria-label={`${label(plane)} slice`} data-slice={plane} data-final={view.isFinal.value ? "" : undefined}>
      <div
        ref={area} class="viewport slice-area" tabIndex={0} role="application" aria-roledescription="slice"
        aria-label={`${label(plane)} slice: arrow keys step, plus and minus zoom, Enter fills the page`}
      >
        <canvas ref={canvas} class={pictureClass(view.failed.value)} role="img" aria-label={`${label(plane)} slice`} />
        <PreviewOverlay viewport={plane} ask={(message) => view.ask(message)} frame={view.frame.value?.number ?? 0} still={(view.isFinal.value || view.failed.value !== null) && !hidden} />
        <CrossHair view={view} width={width!} height={height!} />
        <Measures view={view} target={target} width={width!} height={height!} />
      </div>
      <FailureState failure={view.failed.value} />
      <div class="slice-bar">
        <span class={`slice-name line-${AXES[AXIS[plane]]}`}>{label(plane)}</span>
        <Place plane={plane} />
        <IconButton icon="maximise" label={large ? "All viewports" : `${label(plane)} slice alone`} pressed={large} onClick={() => toggleMaximised(plane)} />
      </div>
    </section>
  );
}

export function SliceViewports() {
  useSignalEffect(() => {
    const dataset = datasetOfRuns();
    if (dataset && !store.dataInfos.value[dataset]) void fetchInfo(dataset);
  });
  return <>{PLANES.map((plane) => <SliceViewport key={plane} plane={plane} />)}</>;
}
