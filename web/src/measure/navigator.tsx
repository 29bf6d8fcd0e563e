/** Measuring in the Navigator: points lie on what is seen; flat regions in the plane through the first one that faces the
    viewer then, also when the view is turned between two clicks. */
import type { RefObject } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Pick } from "../protocol";
import { ask } from "../session";
import type { Vec3 } from "../slices/geometry";
import * as store from "../store";
import { axesOf } from "../view/light_geometry";
import { cross, onPlane } from "./geometry";
import { pointAt, type Target } from "./hands";
import { MeasureOverlay } from "./overlay";
import { isFlat, type Frame } from "./regions";
import { draft, hover, isOpen, planeOf, selected, tool } from "./room";

const pick = (x: number, y: number) => ask<Pick>({ type: "pick", x, y }).catch(() => null);

let aspect = 1;

function onFrame(x: number, y: number, through: Vec3, frame: Frame): Vec3 | null {
  return store.pose.value && onPlane(store.pose.value, aspect, [x, y], through, cross(frame.right, frame.up));
}

function frame(): Frame | null {
  if (draft.value[0]?.frame) return draft.value[0].frame;
  const [right, up] = store.pose.value ? axesOf(store.pose.value) : [];
  return right && up ? { right, up } : null;
}

function at(x: number, y: number): Vec3 | null {
  const first = draft.value[0];
  return first?.frame && isFlat(tool.value?.takes ?? "") ? onFrame(x, y, first.at, first.frame) : null;
}

export const navigatorTarget: Target = { name: "Navigator", at, pick, frame, middle: () => [0.5, 0.5] };

/** A corner of a flat region stays in its plane. */
async function drag(x: number, y: number, from: Vec3): Promise<Vec3 | null> {
  const plane = selected.value && planeOf(selected.value);
  if (plane) return onFrame(x, y, from, plane);
  const seen = await pick(x, y);
  return seen?.hit ? (seen.position as Vec3 | null) : null;
}

export function MeasureNavigator({ area }: { area: RefObject<HTMLElement | null> }) {
  const [[width, height], setSize] = useState<[number, number]>([0, 0]);
  useEffect(() => {
    const element = area.current!;
    const stop = new AbortController();
    const observer = new ResizeObserver(() => {
      aspect = element.clientWidth / element.clientHeight || 1;
      setSize([element.clientWidth, element.clientHeight]);
    });
    observer.observe(element);
    element.addEventListener("pointermove", (event) => {
      const rect = element.getBoundingClientRect();
      pointAt(navigatorTarget, (event.clientX - rect.left) / rect.width, (event.clientY - rect.top) / rect.height);
    }, { signal: stop.signal });
    element.addEventListener("pointerleave", () => { hover.value = null; }, { signal: stop.signal });
    return () => {
      observer.disconnect();
      stop.abort();
    };
  }, []);
  return isOpen.value ? <MeasureOverlay target={navigatorTarget} pose={store.pose.value} width={width} height={height} drag={drag} /> : null;
}
