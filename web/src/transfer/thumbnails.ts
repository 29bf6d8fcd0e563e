/** How the data would look with each preset, seen from where the view rests: small pictures, asked for one at a time. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { hexOfLinear } from "../colors";
import type { Transfer } from "../protocol";
import { ask } from "../session";
import * as store from "../store";
import { sampleNodes, type ColorNode, type OpacityNode } from "./curve";

export const THUMBNAIL = { width: 128, height: 96 };
const QUIET_MS = 350; // after the last change: a hand that moves wants all of the machine

/** By volume and preset. */
export const thumbnails = signal<{ [key: string]: string }>({});
export const proposals = signal<{ [volume: string]: Proposal[] }>({});

export interface Proposal extends Transfer {
  name: string;
  doc: string;
}

export const thumbnailKey = (volume: string, preset: string): string => `${volume} ${preset}`;

/** What thumbnails show, in words that differ when they should be drawn anew: all but the transfer function itself. */
function sceneKey(volume: string): string {
  const { views: _, ...world } = store.world.value;
  const without = JSON.stringify(world, (key, value) => (key === "transfer" || key === "title" ? undefined : value));
  const range = ["range_lo", "range_hi", "opacity_scale"].map((row) => JSON.stringify(store.valueOf(`volumes.${volume}.segmentation.transfer.${row}`)));
  const view = JSON.stringify(store.world.value["views"], (key, value) => (key === "camera" ? undefined : value));
  const pose = store.pose.value;
  return [volume, without, view, range, pose ? JSON.stringify([pose.eye, pose.at, pose.up]) : ""].join("\n");
}

/** Keys of thumbnails that are up to date: the scene that they show. */
const drawn = new Map<string, string>();

/** While a list of presets is on the page, its thumbnails are those of the scene at rest. */
export function useThumbnails(volume: string, presets: string[]): void {
  const moving = store.pose.value?.moving ?? false;
  const scene = sceneKey(volume);
  const open = store.connection.value.state === "open";
  useEffect(() => {
    if (moving || !open) return undefined;
    let stopped = false;
    const timer = setTimeout(async () => {
      for (const preset of presets) {
        const key = thumbnailKey(volume, preset);
        if (stopped) return;
        if (drawn.get(key) === scene) continue;
        const value = await ask<{ picture: string }>({ type: "thumbnail", volume, preset, ...THUMBNAIL }).catch(() => null);
        if (!value) continue; // what has none keeps its colours
        if (!stopped) drawn.set(key, scene);
        thumbnails.value = { ...thumbnails.value, [key]: value.picture };
      }
    }, QUIET_MS);
    return () => { stopped = true; clearTimeout(timer); };
  }, [scene, moving, open, volume, presets.join(" ")]);
}

/** What is proposed for the data of a volume. */
export async function fetchProposals(volume: string): Promise<void> {
  const value = await ask<Proposal[]>({ type: "proposals", volume }).catch(() => null);
  if (value) proposals.value = { ...proposals.value, [volume]: value };
}

const COLORS = 32;

/** Colours over the range of the nodes, as presets have them: "#rrggbbaa". */
export function proposalColors(proposal: Transfer): string[] {
  const opacity = proposal.opacity as OpacityNode[];
  const color = proposal.color as ColorNode[];
  const lo = opacity[0]?.[0] ?? 0;
  const hi = opacity.at(-1)?.[0] ?? 1;
  return Array.from({ length: COLORS }, (_, i) => {
    const at = lo + ((hi - lo) * i) / (COLORS - 1);
    const alpha = Math.round(255 * Math.min(1, Math.max(0, sampleNodes(opacity, at)[0] ?? 0)));
    return hexOfLinear(sampleNodes(color, at)) + alpha.toString(16).padStart(2, "0");
  });
}
