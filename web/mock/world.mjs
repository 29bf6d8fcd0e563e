// The mock's World: plain JSON with edits by path, commits and undo.

const join = (path, name) => (path ? `${path}.${name}` : String(name));

function walk(root, path, make) {
  const parts = path.split(".");
  let at = root;
  for (const part of parts.slice(0, -1)) {
    if (at[part] === undefined) {
      if (!make) return [null, ""];
      at[part] = {};
    }
    at = at[part];
  }
  return [at, parts.at(-1)];
}

function apply(world, edit) {
  if (edit.op === "set") {
    const [at, name] = walk(world, edit.path, true);
    if (typeof edit.value === "string" && /nonsense/.test(edit.value)) throw new Error(`${edit.path}: "${edit.value}" is not understood; expected a number.`);
    at[name] = edit.value;
  } else if (edit.op === "unset") {
    const [at, name] = walk(world, edit.path, false);
    if (at) delete at[name];
  } else if (edit.op === "add") {
    const [at, name] = walk(world, edit.path, true);
    if (edit.id == null) (at[name] ??= []).push(edit.value ?? {});
    else (at[name] ??= {})[edit.id] = edit.value ?? {};
  } else if (edit.op === "remove") {
    const [at, name] = walk(world, edit.path, false);
    if (!at || at[name] === undefined) throw new Error(`${edit.path}: there is no such thing.`);
    if (Array.isArray(at)) at.splice(Number(name), 1);
    else delete at[name];
  }
}

export class World {
  constructor(value) {
    this.value = value;
    this.number = 1;
    this.past = [];
    this.future = [];
    this.gesture = null;
  }

  commit(edits, gesture) {
    const next = structuredClone(this.value);
    for (const edit of edits) apply(next, edit);
    if (!gesture || gesture !== this.gesture) this.past.push(this.value);
    this.gesture = gesture ?? null;
    this.future = [];
    this.value = next;
    this.number++;
    return edits.map((edit) => (edit.op === "add" && edit.id ? join(edit.path, edit.id) : edit.path));
  }

  step(from, to) {
    if (!this[from].length) throw new Error(`There is nothing to ${from === "past" ? "undo" : "redo"}.`);
    this[to].push(this.value);
    this.value = this[from].pop();
    this.gesture = null;
    this.number++;
  }
}

export const emptyWorld = () => ({ schema: 1, views: { main: {} } });

/** The same through a chain of three steps, the second of which is off. */
export const madeWorld = () => {
  const made = (operation, volume, more = {}) => ({ operation, inputs: { volume }, ...more });
  const world = torusWorld();
  Object.assign(world.datasets, {
    smooth: made("gaussian", "ring", { parameters: { sigma: "1mm" } }), clean: made("median", "smooth", { on: false }),
    body: made("threshold", "clean", { parameters: { range: "80.." } }),
  });
  world.volumes.ring.data = "body";
  return world;
};

export const torusWorld = () => ({
  schema: 1, title: "A ring in fog", unit: "mm",
  datasets: { ring: { path: "samples/ring.nrrd" } },
  volumes: { ring: { data: "ring" } },
  lights: {
    key: { frame: "camera", intensity: 0.9, direction: [0.5, -0.6, -0.8] },
    fill: { frame: "camera", intensity: 0.3, direction: [-0.8, 0.1, -0.6] },
  },
  views: { main: { camera: { azimuth: 30, elevation: 15 } } },
});
