/** The World as the server tells it: as a whole, or as what has changed since it was told the last time. */
import type { Change, Json, JsonObject, WorldMessage } from "./protocol";
import { isObject } from "./values";

/** What a change makes of a value: undefined, where nothing is left of it. */
type Edit = (value: Json | undefined) => Json | undefined;

/** Own members alone, so that a name such as __proto__ is one like any other; others keep their places. */
function withMember(owner: JsonObject, name: string, value: Json | undefined): JsonObject {
  return value === undefined ? Object.fromEntries(Object.entries(owner).filter(([key]) => key !== name)) : { ...owner, [name]: value };
}

function changeAt(value: Json | undefined, parts: string[], edit: Edit): Json | undefined {
  const [name, ...rest] = parts;
  if (name === undefined) return edit(value);
  if (Array.isArray(value)) return value.map((item, i) => (i === Number(name) ? changeAt(item, rest, edit) ?? null : item));
  const owner = isObject(value) ? value : {};
  return withMember(owner, name, changeAt(Object.hasOwn(owner, name) ? owner[name] : undefined, rest, edit));
}

function insert(map: Json | undefined, id: string, after: string | null, value: Json): JsonObject {
  const entries = isObject(map) ? Object.entries(map) : [];
  entries.splice(after === null ? 0 : entries.findIndex(([key]) => key === after) + 1, 0, [id, value]);
  return Object.fromEntries(entries);
}

function editOf(change: Change): Edit {
  switch (change.op) {
    case "set":
      return () => change.value;
    case "add":
      return (map) => insert(map, change.id, change.after, change.value);
    default:
      return () => undefined;
  }
}

/** The World that changes make of another, which stays as it is; what is not on the way to a change is shared. */
export function applyChanges(world: JsonObject, changes: Change[]): JsonObject {
  let now: Json | undefined = world;
  for (const change of changes) now = changeAt(now, change.path === "" ? [] : change.path.split("."), editOf(change));
  return isObject(now) ? now : {};
}

/** The World of one connection. */
export class KnownWorld {
  private world: JsonObject = {};
  private number = -1;

  /** All of it, as it is after a message; null: this page has missed one before, and must ask for the whole. */
  take(message: WorldMessage): JsonObject | null {
    if (!("changes" in message)) this.world = message.world;
    else if (message.since === this.number) this.world = applyChanges(this.world, message.changes);
    else return null;
    this.number = message.number;
    return this.world;
  }
}
