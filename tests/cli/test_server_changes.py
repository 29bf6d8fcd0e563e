"""Large Worlds are told as what has changed: few bytes, and the same World as one that is told as a whole."""
import json
import random
import time

from harness import main, write_ball

try:
    from page import Page, Server, run
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")

OBJECTS = 1000


def write_scene(path="large.vv.json", n=OBJECTS):
    """A ball, and so many lights that do not shine: nothing that costs time in pictures."""
    write_ball("ball.nrrd", 16)
    lights = {f"light{i}": {"on": False, "title": f"light {i}", "position": [i, 2 * i, 3 * i], "kind": "point"} for i in range(n)}
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"schema": 1, "datasets": {"ball": {"path": "ball.nrrd"}}, "volumes": {"ball": {"data": "ball"}}, "lights": lights}, file)


def ordered(world):
    """As text: names in the order that they have in maps, which people see; in objects it is nothing to them."""
    maps = {name: list(world.get(name, {})) for name in ("datasets", "volumes", "lights", "views", "measurements")}
    return json.dumps([maps, world], sort_keys=True)


async def the_whole(server):
    async with Page(server, 64, 64) as page:
        return page.world


async def compare(server, page):
    """A page that has been told changes, and one that comes now and is told all."""
    whole = await the_whole(server)
    await page.until(lambda: page.world["number"] >= whole["number"])
    other = {**whole["world"], "views": {name: view for name, view in whole["world"]["views"].items() if name in page.world["world"]["views"]}}
    assert ordered(page.world["world"]) == ordered(other), (page.world["world"], whole["world"])
    return whole


def changes_of(page):
    return [m for m in page.messages if m["type"] == "world" and "changes" in m]


def test_a_drag_among_a_thousand_objects_is_few_bytes():
    write_scene()
    with Server("large.vv.json") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                whole, before = page.told_bytes, len(page.messages)
                for i in range(30):
                    await page.edit(("set", "lights.light500.position", [i, 1, 2]), gesture="drag")
                    await page.until(lambda: page.world["world"]["lights"]["light500"]["position"] == [i, 1, 2])
                    assert page.told_bytes < 2000, page.told_bytes
                told = [m for m in page.messages[before:] if m["type"] == "world"]
                assert len(told) >= 10 and all("changes" in m for m in told), len(told)
                await compare(server, page)
                await page.say("world")  # as a page that has missed one
                await page.until(lambda: "changes" not in [m for m in page.messages if m["type"] == "world"][-1])
                assert page.told_bytes > 0.9 * whole > 50000, (whole, page.told_bytes)
        run(work())


def test_a_small_world_is_told_as_a_whole():
    write_scene(n=3)
    with Server("large.vv.json") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.edit(("set", "title", "small"))
                await page.until(lambda: page.world["world"].get("title") == "small")
                assert not changes_of(page)
        run(work())


def random_edit(chance, world):
    """Edits of all kinds of properties; some are refused, which changes nothing."""
    names, light = list(world["lights"]), f"light{chance.randrange(300)}"
    number, flag = round(chance.uniform(0.1, 9), 3), chance.random() < 0.5
    planes = world.get("cut_planes", [])
    return chance.choice((
        {"op": "set", "path": f"lights.{light}.intensity", "value": number},
        {"op": "unset", "path": f"lights.{light}.{chance.choice(('intensity', 'title', 'position'))}"},
        {"op": "remove", "path": f"lights.{chance.choice(names)}"},
        {"op": "add", "path": "lights", "id": f"new{chance.randrange(40)}", "value": {"on": False, "intensity": number}},
        {"op": "set", "path": f"lights.{light}", "value": {"on": False, "title": "another"}},
        {"op": "add", "path": "cut_planes", "value": {"on": False, "offset": number}},
        {"op": "set", "path": f"cut_planes.{chance.randrange(4)}.offset", "value": number},
        {"op": "remove", "path": f"cut_planes.{chance.randrange(max(1, len(planes)))}"},
        {"op": "set", "path": "volumes.ball.segmentation.transfer.opacity", "value": [[0, 0], [100 + number, 0.5], [255, 1]]},
        {"op": "unset", "path": "volumes.ball.segmentation.transfer.opacity"},
        {"op": "set", "path": "volumes.ball.shading.ambient", "value": number},
        {"op": "unset", "path": "volumes.ball.shading.ambient"},
        {"op": "set", "path": "volumes.ball.segmentation.labels.names", "value": [{"label": i, "name": f"n{i}"} for i in range(chance.randrange(4))]},
        {"op": "set", "path": "views.main.render.methods.raycast.mode", "value": chance.choice(("composite", "maximum", "mean"))},
        {"op": "unset", "path": "views.main.render.methods.raycast.mode"},
        {"op": "add", "path": "datasets", "id": f"made{chance.randrange(9)}", "value": {"operation": "gaussian", "inputs": {"volume": "ball"}}},
        {"op": "set", "path": f"datasets.made{chance.randrange(9)}.parameters.sigma", "value": f"{number}vox"},
        {"op": "set", "path": f"datasets.made{chance.randrange(9)}.on", "value": flag},
        {"op": "remove", "path": f"datasets.made{chance.randrange(9)}"},
        {"op": "set", "path": "title", "value": f"t{number}"}, {"op": "unset", "path": "title"},
        {"op": "set", "path": "background", "value": "#102030"}, {"op": "unset", "path": "background"},
        {"op": "add", "path": "measurements", "id": f"m{chance.randrange(3)}", "value": {"what": "area"}},
        {"op": "remove", "path": f"measurements.m{chance.randrange(3)}"}))


def test_changes_make_the_world_that_others_are_told_as_a_whole():
    seed = time.time_ns() % 1000000
    print(f"seed {seed}", flush=True)
    chance = random.Random(seed)
    write_scene(n=300)
    with Server("large.vv.json") as server:
        async def work():
            async with Page(server, 64, 64) as page, Page(server, 64, 64) as slow:
                done = 0
                for step in range(160):
                    what, number = chance.random(), page.world["number"]
                    if what < 0.2:
                        answer = await page.answer(chance.choice(("undo", "undo", "redo")))
                    else:
                        edits = [random_edit(chance, page.world["world"]) for _ in range(1 + (what > 0.9))]
                        answer = await page.answer("edit", edits=edits, **({"gesture": "g"} if what < 0.3 else {}))
                    done += answer["ok"]
                    if answer["ok"] and chance.random() < 0.4:  # of others it is told together with the next ones
                        await page.until(lambda: page.world["number"] > number)
                    if step % 40 == 39:
                        await compare(server, page)
                        await compare(server, slow)  # who has read nothing meanwhile
                for _ in range(90):  # and the way back in one
                    await page.answer("undo")
                await compare(server, page)
                await compare(server, slow)
                await page.ask("new")
                await page.until(lambda: "volumes" not in page.world["world"])
                await page.ask("undo")
                await compare(server, page)
                return done, len(changes_of(page)), len(changes_of(slow))
        done, told, later = run(work())
    assert done > 60 and told > 20, (seed, done, told, later)


main()
