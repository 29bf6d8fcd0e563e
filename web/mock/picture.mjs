// Pictures for the mock server: a shaded torus by sphere tracing, written as PNG without any library.
import { crc32, deflateSync } from "node:zlib";

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc(body), body.length + 4);
  return out;
}

function crc(data) {
  if (crc32) return crc32(data); // node 22 and newer
  let c = 0xffffffff;
  for (const byte of data) {
    c ^= byte;
    for (let k = 0; k < 8; k++) c = c & 1 ? (c >>> 1) ^ 0xedb88320 : c >>> 1;
  }
  return (c ^ 0xffffffff) >>> 0;
}

export function png(width, height, rgb) {
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 2, 0, 0, 0], 8);
  const rows = Buffer.alloc(height * (1 + 3 * width));
  for (let y = 0; y < height; y++) rgb.copy(rows, y * (1 + 3 * width) + 1, y * 3 * width, (y + 1) * 3 * width);
  return Buffer.concat([
    Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]),
    chunk("IHDR", head), chunk("IDAT", deflateSync(rows, { level: 1 })), chunk("IEND", Buffer.alloc(0)),
  ]);
}

const TORUS = [1.0, 0.42];

function distance(x, y, z) {
  const q = Math.hypot(x, y) - TORUS[0];
  return Math.hypot(q, z) - TORUS[1];
}

/** The torus as seen by a camera { eye, at, up } with a vertical field of view of 20 degrees; colour and threshold by `look`. */
export function picture(width, height, camera, look) {
  const rgb = Buffer.alloc(width * height * 3);
  const sub = (a, b) => a.map((v, i) => v - b[i]);
  const unit = (v) => v.map((c) => c / (Math.hypot(...v) || 1));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const forward = unit(sub(camera.at, camera.eye));
  const right = unit(cross(forward, camera.up));
  const up = cross(right, forward);
  const reach = Math.hypot(...sub(camera.at, camera.eye));
  const scale = Math.tan((10 * Math.PI) / 180) / (height / 2);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const dir = unit(forward.map((f, i) => f + right[i] * (x - width / 2 + 0.5) * scale - up[i] * (y - height / 2 + 0.5) * scale));
      let t = reach - 2;
      let hit = false;
      for (let k = 0; k < 40 && t < reach + 2; k++) {
        const d = distance(...camera.eye.map((e, i) => e + t * dir[i]));
        if (d < 0.004) { hit = true; break; }
        t += d;
      }
      if (!hit) continue;
      const p = camera.eye.map((e, i) => e + t * dir[i]);
      const h = 0.001;
      const n = unit([0, 1, 2].map((i) => distance(...p.map((v, k) => v + (k === i ? h : 0))) - distance(...p)));
      const light = unit(right.map((r, i) => -0.4 * r + 0.6 * up[i] - 0.8 * forward[i]));
      const diffuse = Math.max(0, n[0] * light[0] + n[1] * light[1] + n[2] * light[2]);
      const shine = diffuse ** 24 * 0.3;
      for (let c = 0; c < 3; c++) rgb[3 * (y * width + x) + c] = Math.round(255 * Math.min(1, look[c] * (0.16 + 0.8 * diffuse) + shine) ** (1 / 1.6));
    }
  return png(width, height, rgb);
}
