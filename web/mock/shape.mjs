// The mock server's surface: the torus of its pictures as a file of triangles (docs/protocol.md, "Shapes").
const [ROUND, SMALL] = [1.0, 0.42];
const [AROUND, ACROSS] = [64, 32];
const HEAD = 104;

/** Octahedral, as the program writes them. */
function octahedral([x, y, z]) {
  const sum = Math.abs(x) + Math.abs(y) + Math.abs(z);
  let [u, v] = [x / sum, y / sum];
  if (z < 0) [u, v] = [(1 - Math.abs(v)) * (u < 0 ? -1 : 1), (1 - Math.abs(u)) * (v < 0 ? -1 : 1)];
  return [Math.round(32767 * u), Math.round(32767 * v)];
}

export function torusFile() {
  const reach = ROUND + SMALL;
  const scale = (2 * reach) / 65535;
  const [vertices, triangles] = [AROUND * ACROSS, 2 * AROUND * ACROSS];
  const out = Buffer.alloc(HEAD + 8 + 12 * triangles + 10 * vertices);
  out.write("VVS1");
  out.writeUInt16LE(2, 4);
  [scale, 0, 0, 0, scale, 0, 0, 0, scale, -reach, -reach, -reach].forEach((v, i) => out.writeDoubleLE(v, 8 + 8 * i));
  out.writeUInt32LE(vertices, HEAD);
  out.writeUInt32LE(triangles, HEAD + 4);
  let at = HEAD + 8;
  const put = (...corners) => corners.forEach((c) => { at = out.writeUInt32LE(c, at); });
  const number = (i, j) => (i % AROUND) * ACROSS + (j % ACROSS);
  for (let i = 0; i < AROUND; i++)
    for (let j = 0; j < ACROSS; j++) {
      put(number(i, j), number(i + 1, j), number(i + 1, j + 1));
      put(number(i, j), number(i + 1, j + 1), number(i, j + 1));
    }
  for (let i = 0; i < AROUND; i++)
    for (let j = 0; j < ACROSS; j++) {
      const [a, b] = [(2 * Math.PI * i) / AROUND, (2 * Math.PI * j) / ACROSS];
      const normal = [Math.cos(a) * Math.cos(b), Math.sin(a) * Math.cos(b), Math.sin(b)];
      const place = [Math.cos(a) * (ROUND + SMALL * Math.cos(b)), Math.sin(a) * (ROUND + SMALL * Math.cos(b)), SMALL * Math.sin(b)];
      for (const p of place) at = out.writeUInt16LE(Math.round((p + reach) / scale), at);
      for (const n of octahedral(normal)) at = out.writeInt16LE(n, at);
    }
  return out;
}

/** color: sRGB, 0 to 1. */
export function torusShape(method, color) {
  const light = (direction, power) => ({ kind: "directional", frame: "camera", color: [power, power, power], position: [0, 0, 0], direction, cone: [-1, -1], falloff: [1, 0, 0] });
  return {
    method,
    parts: [{
      volume: "ring", url: "/files/7/shape-7.vvs", bytes: torusFile().length, triangles: 2 * AROUND * ACROSS, step: [1, 1, 1], value: 96, solid: true,
      place: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], color: color.map((v) => v ** 2.2), shading: "blinn", light: [0.2, 0.8, 0.3, 32], planes: [],
    }],
    lights: [light([0.447, -0.537, -0.716], 0.9), light([-0.796, 0.1, -0.597], 0.3)], ambient: [1, 1, 1], background: [0, 0, 0, 1], left_out: [],
  };
}
