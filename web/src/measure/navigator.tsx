/** Measuring in the Navigator: points lie on what is seen. */
import type { RefObject } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Pick } from "../protocol";
import { ask } from "../session";
import type { Vec3 } from "../slices/geometry";
import * as store from "../store";
import { pointAt, type Target } from "./hands";
import { MeasureOverlay } from "./overlay";
import { hover, isOpen } from "./room";

const pick = (x: number, y: number) => ask<Pick>({ type: "pick", x, y }).catch(() => null);

export const navigatorTarget: Target = { name: "Navigator", at: () => null, pick, middle: () => [0.5, 0.5] };

async function drag(x: number, y: number): Promise<Vec3 | null> {
  const seen = await pick(x, y);
  return seen?.hit ? (seen.position as Vec3 | null) : null;
}

export function MeasureNavigator({ area }: { area: RefObject<HTMLElement | null> }) {
  const [[width, height], setSize] = useState<[number, number]>([0, 0]);
  useEffect(() => {
    const element = area.current!;
    const stop = new AbortController();
    const observer = new ResizeObserver(() => setSize([element.clientWidth, element.clientHeight]));
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
