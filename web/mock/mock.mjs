// A server with the page's protocol and no VolVis behind it, for working on the page and for its tests.
//   node mock/mock.mjs BUILTDIR [--port N] [--token T] [--empty] [--made] [--read-only] [--quick] [--held]
// VOLVIS_TABLES names what 'volvis schema --tables' has written; the build writes it into build/tests/web.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, join } from "node:path";
import { argv } from "node:process";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";
import { measured } from "./measured.mjs";
import { picture } from "./picture.mjs";
import { torusFile, torusShape } from "./shape.mjs";
import { emptyWorld, madeWorld, torusWorld, World } from "./world.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const tables = readTables(process.env.VOLVIS_TABLES ?? join(here, "../../build/tests/web/tables.json"));
const TYPES = { "/": ["index.html", "text/html"], ...Object.fromEntries(["app.js", "drawing.js", "worker.js"].map((name) => [`/${name}`, [name, "text/javascript"]])), "/app.css": ["app.css", "text/css"], "/icon.svg": ["icon.svg", "image/svg+xml"] };
const HEAD = {
  "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; form-action 'none'; base-uri 'none'",
  "X-Content-Type-Options": "nosniff", "Cache-Control": "no-cache", "Referrer-Policy": "no-referrer",
};

function readTables(path) {
  try {
    return JSON.parse(readFileSync(path, "utf8"));
  } catch (problem) {
    throw new Error(`${path}: the tables cannot be read (${problem.message}). Build VolVis, or name in VOLVIS_TABLES what 'volvis schema --tables' wrote.`);
  }
}

/**
 * Serves the folder `built`, by words as above; { url, down, up, stop }. held: a job goes on until it is cancelled.
 * down() lets nobody in any more and ends what there is; the port stays its own, so that up() is always there again.
 */
export async function serve(built, words = []) {
  const option = (name, otherwise) => (words.includes(name) ? words[words.indexOf(name) + 1] : otherwise);
  let token = option("--token", "mock");
  let pass = "mock"; // the cookie
  const readOnly = words.includes("--read-only");
  const held = words.includes("--held");
  const PIXELS = words.includes("--quick") ? 96 : 460;
  let isDown = false;
  let isEnded = false;

  let world = new World(words.includes("--empty") ? emptyWorld() : words.includes("--made") ? madeWorld() : torusWorld());
  const clients = new Set();
  const camera = { azimuth: 30, elevation: 20, distance: 9, parallel: false };

  const hasPass = (request) => (request.headers.cookie ?? "").split("; ").includes(`volvis=${pass}`);

  const http = createServer((request, response) => {
    if (isDown) return void request.socket.destroy();
    const path = request.url.split("?")[0];
    const cookie = hasPass(request);
    const setCookie = () => ({ "Set-Cookie": `volvis=${pass}; HttpOnly; SameSite=Strict; Path=/` });
    const reply = (status, text = "", more = {}) => { response.writeHead(status, { ...HEAD, ...more }); response.end(text); };
    if (request.method === "GET" && TYPES[path]) {
      const [file, type] = TYPES[path];
      reply(200, readFileSync(join(built, file)), { "Content-Type": `${type}; charset=utf-8` });
    } else if (request.method === "POST" && path === "/session") {
      let body = "";
      request.on("data", (part) => { body += part; });
      request.on("end", () => (JSON.parse(body).token === token ? reply(204, "", setCookie()) : reply(403)));
    } else if (request.method === "DELETE" && path === "/session" && cookie) {
      token = pass = `${pass}-again`;
      for (const client of clients) client.socket.close(1008, "all sessions were ended; the program has printed another link");
      reply(204, "", setCookie());
    } else if (request.method === "PUT" && path.startsWith("/files/") && cookie) {
      request.resume();
      request.on("end", () => reply(201, JSON.stringify({ path: `uploads/${decodeURIComponent(path.split("/").pop())}` })));
    } else if (request.method === "GET" && path.endsWith(".vvs") && cookie) {
      reply(200, torusFile(), { "Content-Type": "application/octet-stream" });
    } else if (request.method === "GET" && path.startsWith("/files/") && cookie) {
      reply(200, picture(320, 240, pose(), look()), { "Content-Type": "image/png" });
    } else {
      reply(404, "There is no such thing.");
    }
  });
  http.on("connection", (socket) => { if (isDown) socket.destroy(); });
  const sockets = new WebSocketServer({ noServer: true, handleProtocols: () => "volvis" });
  http.on("upgrade", (request, socket, head) => {
    if (isDown) return void socket.destroy();
    if (!hasPass(request)) socket.end("HTTP/1.1 403 Forbidden\r\n\r\n");
    else sockets.handleUpgrade(request, socket, head, meet);
  });

  function pose() {
    const a = (camera.azimuth * Math.PI) / 180;
    const e = (camera.elevation * Math.PI) / 180;
    const eye = [-Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e)].map((v) => v * camera.distance);
    return { eye, at: [0, 0, 0], up: [0, 0, 1] };
  }

  /** From the feet, the front, the left; the torus is 64 across. */
  function planePose(plane) {
    const [eye, up] = { axial: [[0, 0, -99], [0, 1, 0]], coronal: [[0, 99, 0], [0, 0, 1]], sagittal: [[-99, 0, 0], [0, 0, 1]] }[plane];
    return { eye, at: [0, 0, 0], up, parallel: true, height: 80 };
  }

  function look(preset) {
    const transfer = world.value.volumes?.ring?.segmentation?.transfer;
    const row = preset ? null : transfer?.color?.at(-1);
    if (row) return row.slice(1).map((v) => v ** (1 / 2.2));
    const colors = tables.colormaps[preset ?? transfer?.colormap] ?? tables.colormaps.tissue;
    const hex = colors[24];
    return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  }

  function resolved() {
    const value = structuredClone(world.value);
    for (const id of Object.keys(value.volumes ?? {})) {
      const volume = value.volumes[id];
      volume.interpolation ??= "linear";
      volume.slices = { window_lo: 10, window_hi: 210, ...volume.slices };
      const s = (volume.segmentation ??= {});
      s.kind ??= "transfer";
      s.transfer = { range_lo: 12, range_hi: 240, colormap: "tissue", opacity_length: 0.5, ...s.transfer };
      s.threshold = { lo: 96, hi: 255, ...s.threshold };
    }
    value.cross_hair ??= [0, 0, 0];
    const view = (value.views.main ??= {});
    view.camera = { ...pose(), fov: 20, ...view.camera };
    view.render = { method: "raycast", samples: 1, ...view.render, raycast: { iso: 96, threshold: 96, step: 0.5, ...view.render?.raycast } };
    return value;
  }

  function histogram() {
    const counts = Array.from({ length: 256 }, (_, i) => Math.round(90000 * Math.exp(-i / 6) + 5200 * Math.exp(-(((i - 96) / 14) ** 2)) + 2600 * Math.exp(-(((i - 170) / 26) ** 2))));
    return { lo: 0, hi: 255, counts, unit: "", mean: 31.4, deviation: 48.2, n: 2097152, percentiles: { 1: 0, 50: 8, 99: 206 } };
  }

  function transfer() {
    const t = world.value.volumes.ring?.segmentation?.transfer ?? {};
    const hex = (c) => [1, 3, 5].map((i) => (parseInt(c.slice(i, i + 2), 16) / 255) ** 2.2);
    const colors = tables.colormaps[t.colormap ?? "tissue"];
    const color = [0, 6, 12, 18, 24, 31].map((i) => [12 + (228 * i) / 31, ...hex(colors[i])]);
    return { opacity: t.opacity ?? [[60, 0], [96, 0.04], [140, 0.12], [200, 0.6]], color: t.color ?? color, opacity_length: t.opacity_length ?? 0.5 };
  }

  const FOLDERS = {
    "": [["scans", true], ["papers", true], ["head.nii.gz", false, 7_402_112, "volume"], ["engine.nrrd", false, 16_777_528, "volume"], ["bolt.stl", false, 884_084, "mesh"], ["figure-3.vv.json", false, 1_204, "scene"], ["figure-3.png", false, 402_118, "picture"], ["notes.txt", false, 911, null]],
    scans: [["2026-03", true], ["embryo.ome.zarr", true, 4096, "volume"], ["knee.nrrd", false, 33_554_992, "volume"]],
  };

  function meet(socket) {
    const client = { socket, width: 800, height: 600, busy: false, dirty: true, frames: "all", frame: 0, moving: 0, held: null, last: [0, 0], level: 0, name: `client${clients.size + 1}` };
    clients.add(client);
    tell({ type: "clients", n: clients.size });
    socket.on("message", (data) => take(client, JSON.parse(data)));
    socket.on("close", () => { clients.delete(client); tell({ type: "clients", n: clients.size }); });
  }

  const send = (client, message) => client.socket.send(JSON.stringify(message));
  function tell(message) {
    for (const client of clients) send(client, message);
  }

  function worldMessage(paths) {
    return { type: "world", number: world.number, who: "client1", paths, world: world.value, undo: world.past.length > 0, redo: world.future.length > 0, title: world.value.title ?? "" };
  }

  function changed(paths) {
    tell(worldMessage(paths));
    tell({ type: "resolved", number: world.number, world: resolved() });
    for (const client of clients) stir(client, 0);
  }

  function stir(client, moving) {
    if (client.final || client.failed) send(client, { type: "outdated" });
    client.failed = false;
    client.moving = moving ? Date.now() + 120 : 0;
    client.level = moving ? 0 : client.level;
    client.final = false;
    client.dirty = true;
    if (client.moving && client.frames !== "all") withoutFrames(client);
    draw(client);
  }

  /** Poses are told all the same. */
  function withoutFrames(client) {
    const tell = (moving) => send(client, { type: "pose", ...pose(), parallel: camera.parallel, fov: 20, height: 3.2, moving });
    tell(true);
    clearTimeout(client.rests);
    client.rests = setTimeout(() => { tell(false); draw(client); }, 150);
  }

  /** A threshold needs a range. */
  function cannotBeMade() {
    const flawed = Object.entries(world.value.datasets ?? {}).find(([, data]) => data.operation === "threshold" && !data.parameters?.range);
    if (!flawed) return null;
    const where = `datasets.${flawed[0]}.parameters`;
    return { text: `${where}: expected a range, as in 100..200; none was given`, where };
  }

  function draw(client) {
    if (client.busy || !client.dirty || !Object.keys(world.value.volumes ?? {}).length) return;
    const moving = Date.now() < client.moving;
    const flaw = cannotBeMade();
    if (flaw) {
      Object.assign(client, { failed: true, dirty: false });
      return void send(client, { type: "failed", ...flaw, frame: client.frame });
    }
    if (client.frames === "none" || (moving && client.frames === "resting")) return;
    const share = moving ? 0.25 : [0.25, 0.5, 0.75][client.level];
    const cap = Math.min(1, PIXELS / client.width); // it is slow
    const width = Math.max(16, Math.round(client.width * share * cap));
    const height = Math.max(16, Math.round(client.height * share * cap));
    const final = !moving && client.level === 2;
    const from = client.plane ? { ...planePose(client.plane), eye: planePose(client.plane).eye.map((v) => v / 11) } : pose();
    const image = picture(width, height, from, look());
    const head = Buffer.alloc(32);
    head.write("VVF1");
    head.writeUInt16LE(2, 4);
    head.writeUInt16LE((final ? 1 : 0) | (moving ? 2 : 0), 6);
    head.writeUInt32LE(++client.frame, 8);
    [final ? client.width : Math.round(client.width * share), final ? client.height : Math.round(client.height * share), client.width, client.height, moving ? 0 : client.level, 1].forEach((v, i) => head.writeUInt16LE(v, 12 + 2 * i));
    head.writeUInt32LE(world.number, 24);
    head.writeFloatLE(18, 28);
    client.busy = true;
    client.dirty = moving || !final;
    if (!moving && !final) client.level++;
    client.final = final;
    client.socket.send(Buffer.concat([head, image]));
    send(client, { type: "status", frames: moving ? 42 : 0, latency: 24, memory: 312e6, memory_limit: 8e9, method: world.value.views?.main?.render?.method ?? "raycast", level: client.level, passes: 1, final, scale: share });
    send(client, client.plane ? { type: "pose", ...planePose(client.plane), moving: false } : { type: "pose", ...pose(), parallel: camera.parallel, fov: 20, moving });
  }

  function onLine(client, line) {
    const [, device, kind, id, value, more] = line.split(" ");
    if (device === "mouse" && kind === "button") client.held = value === "down" ? id : null;
    if (device === "mouse" && kind === "axis" && (id === "x" || id === "y")) {
      const i = id === "x" ? 0 : 1;
      const by = Number(value) - client.last[i];
      client.last[i] = Number(value);
      if (client.held === "left") {
        if (i === 0) camera.azimuth -= by * 90;
        else camera.elevation = Math.max(-89, Math.min(89, camera.elevation - by * 90));
        stir(client, 1);
      }
    }
    if (device === "mouse" && id === "wheel-y") { camera.distance *= 0.9 ** Number(value); stir(client, 1); }
    if (device === "keyboard" && value === "down") {
      const turn = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[id];
      if (turn) { camera.azimuth += turn[0]; camera.elevation += turn[1]; stir(client, 1); }
      if (id === "R") act(client, "fit");
      if (id === "Z" && world.past.length) step("past", "future");
    }
    void more;
  }

  function act(client, name) {
    const sides = { front: [0, 0], back: [180, 0], right: [-90, 0], left: [90, 0], top: [0, 89], bottom: [0, -89], isometric: [45, 35] };
    if (sides[name]) [camera.azimuth, camera.elevation] = sides[name];
    if (name === "fit") camera.distance = 9;
    if (name === "projection") camera.parallel = !camera.parallel;
    stir(client, 0);
  }

  function lookFrom(client, [x, y, z]) {
    camera.distance = Math.hypot(x, y, z);
    camera.elevation = Math.max(-89, Math.min(89, (Math.asin(z / camera.distance) * 180) / Math.PI));
    if (Math.hypot(x, y) > 1e-6) camera.azimuth = (Math.atan2(-x, y) * 180) / Math.PI;
    stir(client, 0);
  }

  function step(from, to) {
    world.step(from, to);
    changed([]);
  }

  function job(name, seconds, finish) {
    const number = Math.floor(Math.random() * 1e6) + 1;
    let done = 0;
    jobs.set(number, false);
    const timer = setInterval(() => {
      if (isEnded) return void clearInterval(timer);
      done = held ? 40 : done + 4;
      const cancelled = jobs.get(number);
      const state = cancelled ? "cancelled" : done >= 100 ? "done" : "running";
      tell({ type: "job", job: number, name, stage: "slices", done, total: 100, eta: ((100 - done) * seconds) / 100, state, error: null });
      if (state === "running") return;
      clearInterval(timer);
      jobs.delete(number);
      if (state === "done") finish();
    }, seconds * 40);
  }
  const jobs = new Map();

  /** A dataset that is made, in the place of what it is made of. */
  function made(m) {
    const id = m.operation in world.value.datasets ? `${m.operation}-2` : m.operation;
    const first = tables.operations.find((row) => row.name === m.operation).inputs[0];
    const shown = Object.keys(world.value.volumes).filter((volume) => world.value.volumes[volume].data === m.dataset);
    const inputs = first.named ? m.inputs : { [first.name]: m.dataset, ...m.inputs };
    changed(world.commit([
      { op: "add", path: "datasets", id, value: { operation: m.operation, inputs, parameters: m.parameters } },
      ...shown.slice(0, 1).map((volume) => ({ op: "set", path: `volumes.${volume}.data`, value: id })),
    ]));
    return id;
  }

  const ANSWERS = {
    edit: (c, m) => {
      if (readOnly) throw new Error("This session is read-only.");
      changed(world.commit(m.edits, m.gesture));
      return null;
    },
    undo: () => step("past", "future"),
    redo: () => step("future", "past"),
    browse: (c, m) => {
      const rows = FOLDERS[m.path];
      if (!rows && m.path !== "papers" && m.path !== "scans/2026-03") throw new Error(`${m.path}: there is no such folder under the root.`);
      return { path: m.path, entries: (rows ?? []).map(([name, folder, bytes = 0, kind = null]) => ({ name, folder, bytes, kind })) };
    },
    open: (c, m, answer) => {
      if (/notes/.test(m.path)) throw new Error(`${m.path}: its content is of no format that VolVis reads; 'volvis formats' lists them.`);
      job(`Open ${m.path}`, 0.5, () => { world = new World(torusWorld()); changed(null); answer(null); });
      return undefined;
    },
    sample: (c, m, answer) => { job(`Make ${m.name}`, 0.5, () => { world = new World(torusWorld()); changed(null); answer(null); }); return undefined; },
    new: () => { world = new World(emptyWorld()); changed(null); return null; },
    save: (c, m) => {
      if (/taken/.test(m.path) && !m.replace) throw Object.assign(new Error("taken.vv.json already exists, and is left as it is"), { reason: "exists" });
      return { path: m.path };
    },
    run: (c, m, answer) => { job(m.operation, held ? 3 : 0.3, () => answer({ dataset: made(m) })); return undefined; },
    write: (c, m) => {
      if (/taken/.test(m.path) && !m.replace) throw Object.assign(new Error("taken.nrrd already exists, and is left as it is"), { reason: "exists" });
      return { path: m.path };
    },
    preview: (c, m) => {
      if (/nonsense/.test(JSON.stringify(m.parameters))) throw new Error('parameters.sigma: expected a length, found "nonsense"');
      const local = m.operation !== "components";
      if (!local && !m.whole) return { whole: true, full: false, bytes: 21_000_000, seconds: 12 };
      const from = c.plane ? { ...planePose(c.plane), eye: planePose(c.plane).eye.map((v) => v / 11) } : pose();
      const box = c.plane ? { lo: [0, 0, 63], n: [128, 128, 3], dims: [128, 128, 128], window: [10, 210], before: 143, after: 118.25 } : { lo: [0, 0, 0], n: [128, 128, 128], dims: [128, 128, 128], before: 143, after: 118.25 };
      return { whole: !local, full: true, bytes: 4_194_304, ...box, picture: `data:image/png;base64,${picture(Math.min(c.width, PIXELS), Math.round((c.height * Math.min(c.width, PIXELS)) / c.width), from, look("fire")).toString("base64")}` };
    },
    pick: (c, m) => {
      const hit = Math.hypot(m.x - 0.5, m.y - 0.5) < 0.3;
      return { hit, volume: hit ? "ring" : null, position: hit ? [12.5, -31.25, 4] : null, index: hit ? [41, 22, 64] : null, value: hit ? 143 : null, unit: "", depth: hit ? 210.5 : null, text: hit ? "Volume ring, value 143, at 12.5, -31.25, 4 mm" : "Nothing is seen there." };
    },
    histogram: () => histogram(),
    transfer: () => transfer(),
    proposals: () => tables.presets.filter((row) => row.kind === "proposal").map((row, i) => ({ name: row.name, doc: row.doc, ...transfer(), opacity: [[20 + 30 * i, 0], [90 + 30 * i, 0.4], [200, 0]] })),
    thumbnail: (c, m) => ({ picture: `data:image/png;base64,${picture(32, 24, pose(), look(m.preset)).toString("base64")}` }),
    picture: (c, m) => ({ url: `/files/1/${encodeURIComponent(m.name)}` }),
    measure: (c, m) => measured(m.question),
    command: (c, m) => ({ text: m.measurement ? `volvis measure ${world.value.measurements[m.measurement].what} samples/ring.nrrd` : "volvis render samples/ring.nrrd -o picture.png --view 30,20 --size 1280x720" }),
    shape: (c, m) => torusShape(m.method, look()),
    describe: () => ({ text: "One volume, ring, a transfer function fitted to its histogram, seen from azimuth 30 and elevation 20 degrees." }),
    info: () => ({ dims: [128, 128, 128], spacing: [0.5, 0.5, 0.75], origin: [-31.75, -31.75, -47.625], directions: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], unit: "mm", type: "u8", components: 1, orientation: "RAS", memory_bytes: 2097152 }),
  };

  function take(client, message) {
    const answer = (value) => { if (client.socket.readyState === 1) send(client, { type: "answer", id: message.id, ok: true, value }); };
    switch (message.type) {
      case "hello":
        Object.assign(client, { width: message.width, height: message.height, plane: message.plane });
        if (client.plane) world.value.views[client.plane] ??= { render: { method: "slice", slice: { orientation: client.plane } } };
        send(client, welcome(client));
        send(client, worldMessage(null));
        send(client, { type: "resolved", number: world.number, world: resolved() });
        return stir(client, 0);
      case "size":
        Object.assign(client, { width: message.width, height: message.height, level: 0 });
        return stir(client, 0);
      case "events":
        message.lines.split("\n").forEach((line) => onLine(client, line));
        return message.id ? answer(null) : undefined;
      case "ack":
        client.busy = false;
        setTimeout(() => draw(client), 30);
        return undefined;
      case "camera":
        return client.plane ? undefined : lookFrom(client, message.eye);
      case "action":
        return act(client, message.name);
      case "frames":
        client.frames = message.wanted;
        return stir(client, 0);
      case "cancel":
        return jobs.set(message.job, true);
    }
    try {
      const value = ANSWERS[message.type]?.(client, message, answer);
      if (value !== undefined || ["undo", "redo"].includes(message.type)) answer(value ?? null);
    } catch (error) {
      send(client, { type: "answer", id: message.id, ok: false, error: error.message, reason: error.reason });
    }
  }

  function welcome(client) {
    return {
      type: "welcome", version: "0.0", client: client.name, view: client.plane ?? "main", read_only: readOnly, root: "/data", ...tables,
      samples: [{ name: "ring", doc: "a torus in fog, 128 cubed" }, { name: "marschner-lobb", doc: "the test signal of Marschner and Lobb" }, { name: "knot", doc: "a trefoil knot with soft edges" }],
    };
  }

  await new Promise((resolve) => http.listen(Number(option("--port", 0)), "127.0.0.1", resolve));
  const end = () => {
    for (const client of clients) client.socket.terminate();
    http.closeAllConnections();
  };
  return {
    url: `http://localhost:${http.address().port}/#${token}`,
    down: () => { isDown = true; end(); },
    up: () => { isDown = false; },
    stop: () => { isEnded = true; http.close(); end(); },
  };
}

if (argv[1] === fileURLToPath(import.meta.url)) console.log((await serve(argv[2], argv.slice(3))).url);
