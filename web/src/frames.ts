/** Frames: the head of a binary message, and the canvas that shows the picture behind it. */

import type { Failure } from "./failure";

export interface Frame {
  type: "image/jpeg" | "image/png";
  final: boolean;
  moving: boolean;
  /** It has fewer bytes than it should: the line is thin. */
  compressed: boolean;
  number: number;
  width: number;
  height: number;
  fullWidth: number;
  fullHeight: number;
  level: number;
  passes: number;
  commit: number;
  latency: number;
  picture: Uint8Array;
}

/**
 * Which frames are final no more: the server takes it back while what it sent last may still be on its way to the screen.
 * And whether a newer one is not to be had.
 */
export class Finality {
  private received = 0;
  private outdated = 0;
  failure: Failure | null = null;

  /** Another connection counts its frames anew. */
  begin(): void {
    this.received = this.outdated = 0;
    this.failure = null;
  }

  take(frame: number): void {
    this.received = frame;
  }

  outdate(): void {
    this.outdated = this.received;
    this.failure = null; // it is tried again
  }

  fail({ text, where, frame }: Failure): void {
    this.failure = { text, where, frame };
  }

  /** The frame is on the screen. */
  show(frame: number): void {
    if (this.failure && frame > this.failure.frame) this.failure = null;
  }

  isOutdated(frame: number): boolean {
    return frame <= this.outdated;
  }
}

const HEAD_BYTES = 32;
const MAGIC = 0x31465656; // "VVF1", little-endian

/** The frame in a binary message; null where it is none that this page knows. */
export function parseFrame(buffer: ArrayBuffer): Frame | null {
  if (buffer.byteLength <= HEAD_BYTES) return null;
  const head = new DataView(buffer, 0, HEAD_BYTES);
  const kind = head.getUint16(4, true);
  if (head.getUint32(0, true) !== MAGIC || (kind !== 1 && kind !== 2)) return null;
  const flags = head.getUint16(6, true);
  return {
    type: kind === 1 ? "image/jpeg" : "image/png",
    final: (flags & 1) !== 0,
    moving: (flags & 2) !== 0,
    compressed: (flags & 4) !== 0,
    number: head.getUint32(8, true),
    width: head.getUint16(12, true),
    height: head.getUint16(14, true),
    fullWidth: head.getUint16(16, true),
    fullHeight: head.getUint16(18, true),
    level: head.getUint16(20, true),
    passes: head.getUint16(22, true),
    commit: head.getUint32(24, true),
    latency: head.getFloat32(28, true),
    picture: new Uint8Array(buffer, HEAD_BYTES),
  };
}

/** A picture that the server broke off, since the line is too thin for it: it does not end as such pictures do. */
export function isWhole({ type, picture }: Pick<Frame, "type" | "picture">): boolean {
  const end = type === "image/png" ? [0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82] : [0xff, 0xd9];
  const tail = picture.subarray(-end.length);
  return tail.length === end.length && end.every((byte, i) => tail[i] === byte);
}

/**
 * Draws a frame over the whole canvas; smaller ones are enlarged smoothly. The canvas takes the size that the server
 * made the full picture for, so that a picture at rest meets the pixels of the screen one to one.
 */
export async function drawFrame(canvas: HTMLCanvasElement, frame: Frame): Promise<void> {
  const bitmap = await createImageBitmap(new Blob([frame.picture as BlobPart], { type: frame.type }));
  const width = frame.fullWidth || bitmap.width;
  const height = frame.fullHeight || bitmap.height;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const context = canvas.getContext("2d");
  if (context) {
    context.imageSmoothingEnabled = bitmap.width !== width || bitmap.height !== height;
    context.imageSmoothingQuality = "high";
    context.globalCompositeOperation = "copy"; // pictures may be transparent: nothing of the old one stays
    context.drawImage(bitmap, 0, 0, width, height);
  }
  bitmap.close();
}
