"""The World as a page keeps it: told as a whole, or as what has changed since (docs/protocol.md)."""
import copy


def descend(world, parts):
    """What is at a path, whose objects are made where they are not there."""
    for part in parts:
        world = world[int(part)] if isinstance(world, list) else world.setdefault(part, {})
    return world


def put(owner, name, value):
    if isinstance(owner, list):
        owner[int(name)] = value
    else:
        owner[name] = value


def insert(entries, name, value, after):
    rest = list(entries.items())
    at = 0 if after is None else [key for key, _ in rest].index(after) + 1
    entries.clear()
    entries.update(rest[:at] + [(name, value)] + rest[at:])


def apply(world, changes):
    """The World that changes make of another, in its place."""
    for change in changes:
        *parts, last = change["path"].split(".")
        if change["path"] == "":
            world.clear()
            world.update(change["value"])
        elif change["op"] == "add":
            insert(descend(world, [*parts, last]), change["id"], change["value"], change["after"])
        elif change["op"] == "set":
            put(descend(world, parts), last, change["value"])
        else:
            del descend(world, parts)[last]


def take(before, message):
    """The message `world` with all of the World, whichever it told; before: the last one, which is left as it is."""
    if "world" in message:
        return message
    assert before["number"] == message["since"], (before["number"], message["since"])
    world = copy.deepcopy(before["world"])
    apply(world, message["changes"])
    return {**message, "world": world}
