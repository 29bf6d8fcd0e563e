/** A thread of its own for files of megabytes: while it fetches one and makes triangles of it, the picture goes on turning. */
import { decodeSurface } from "./decode";
import type { Surface } from "./surface";

export interface Asked {
  id: number;
  url: string;
}

export type Answered = { id: number; surface: Surface; bytes: number } | { id: number; error: string };

async function answer({ id, url }: Asked): Promise<void> {
  try {
    const response = await fetch(url, { credentials: "same-origin" });
    if (!response.ok) throw new Error(`The server no longer has a surface at ${url}.`);
    const buffer = await response.arrayBuffer();
    const surface = decodeSurface(buffer);
    const own = [surface.positions, surface.normals, surface.indices, surface.colors].flatMap((array) => (array ? [array.buffer as ArrayBuffer] : []));
    post({ id, surface, bytes: buffer.byteLength }, own);
  } catch (error) {
    post({ id, error: (error as Error).message }, []);
  }
}

function post(message: Answered, transfer: ArrayBuffer[]): void {
  (self as unknown as { postMessage(message: Answered, transfer: ArrayBuffer[]): void }).postMessage(message, transfer);
}

self.onmessage = (event: MessageEvent<Asked>) => void answer(event.data);
