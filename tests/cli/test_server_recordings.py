"""Recordings that strangers made: they are played into a folder of their own, and in bounds."""
import json
import os
import re
import stat
import time

from harness import fails, main, ok, says, volvis, write_ball
from page import Page, Server, run


def states():
    return {"XDG_STATE_HOME": os.path.abspath("state")}


def record():
    """A session whose result a saved scene shows: the lines of its recording, and that file."""
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", "--record", "session.jsonl") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"})
                await page.until(lambda: len(page.world["world"]["datasets"]) == 2)
                path = page.world["world"]["datasets"]["ball-gaussian"]["path"]
                # a page names a result by where it is
                await page.ask("edit", edits=[{"op": "add", "path": "datasets", "id": "again", "value": {"path": path}}])
                await page.ask("save", path=os.path.abspath("mine.vv.json"))
                return path
        path = run(work())
    with open("session.jsonl", encoding="utf-8") as file:
        return [json.loads(line) for line in file], path


def write(lines, name="stranger.jsonl"):
    with open(name, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines)
    return name


def folders():
    return {name for name in os.listdir("state/volvis") if name.startswith("replay-")}


def test_results_are_played_into_a_new_folder_alone():
    lines, path = record()
    with open(path, "rb") as file:
        before, seen = file.read(), os.stat(path)
    assert stat.S_IMODE(seen.st_mode) == 0o400
    stranger = [{**line} for line in lines]
    for line in stranger:  # another sigma, and its results where mine are
        if line.get("says", {}).get("type") == "run":
            line["says"]["parameters"]["sigma"] = "3vox"
    for results in (0, 2):
        stranger[0]["results"] = results
        ok("replay", write(stranger), "-o", "theirs.vv.json", env=states())
        with open("theirs.vv.json", encoding="utf-8") as file:
            data = json.load(file)["datasets"]
        made = os.path.abspath(data["ball-gaussian"]["path"])
        if results == 0:  # what was said of the result is said of this one
            assert os.path.abspath(data["again"]["path"]) == made, data
        assert re.fullmatch(r".*/state/volvis/replay-\w{6}/result-\d/result-\d\.nrrd", made), made
        ok("render", "theirs.vv.json", "-o", "theirs.png")
    with open(path, "rb") as file:
        after = os.stat(path)
        assert file.read() == before and (after.st_ino, after.st_mtime_ns) == (seen.st_ino, seen.st_mtime_ns)
    assert len(folders()) == 2
    ok("replay", "stranger.jsonl", env=states())
    assert len(folders()) == 2, "without -o nobody has use for results"
    for line in lines:
        if line.get("says", {}).get("type") == "run":
            line["says"]["operation"] = "isosurface"
            line["says"]["parameters"] = {"iso": 1e9}
    assert volvis("replay", write(lines), env=states()).code == 3  # a warning says what the operation has found
    assert len(folders()) == 2, "a folder of a recording that cannot be played"


def test_a_line_without_end_costs_no_more_than_a_long_one():
    with open("long.jsonl", "wb") as file:
        file.truncate(1 << 32)
    began = time.monotonic()
    says(fails(3, "replay", "long.jsonl", env=states()), "long.jsonl:line 1: is longer than 2 MiB")
    assert time.monotonic() - began < 30


def test_jobs_that_run_beside_each_other_end_as_they_did():
    write_ball("large.nrrd", 32)
    with Server("large.nrrd", "--record", "two.jsonl") as server:
        async def work():
            async with Page(server, 64, 64) as one, Page(server, 64, 64) as other:
                await one.resting()
                await one.say("run", id=1000, operation="flip", dataset="large", parameters={"axes": "x"})
                await one.heard()
                await other.ask("run", operation="gaussian", dataset="large", parameters={"sigma": "1vox"})
                await one.until(lambda: any(m.get("id") == 1000 and m["ok"] for m in one.messages))
        run(work())
    with open("two.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    ends = [line for line in lines if "ends" in line]
    assert sorted((line["ends"], line["job"]) for line in ends) == [(True, 1), (True, 2)], ends
    lines = [line for line in lines if "ends" not in line and "leaves" not in line] + ends
    for jobs, shown in (((2, 1), "large-gaussian"), ((1, 2), "large-flip")):  # the first takes the volume's place
        for line, job in zip(ends, jobs):
            line["job"], line["t"] = job, lines[-3]["t"]
        ok("replay", write(lines, "again.jsonl"), "-o", "again.vv.json", env=states())
        with open("again.vv.json", encoding="utf-8") as file:
            world = json.load(file)
        assert set(world["datasets"]) == {"large", "large-gaussian", "large-flip"}, world["datasets"]
        assert world["volumes"]["large"]["data"] == shown, (jobs, world["volumes"])
    ends[0]["job"] = 7
    fails(3, "replay", write(lines, "again.jsonl"), env=states())


def test_times_and_numbers_are_bounded():
    write_ball("ball.nrrd", 16)
    hello = {"type": "hello", "width": 64, "height": 64}
    with Server("ball.nrrd", "--record", "short.jsonl") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
        run(work())
    with open("short.jsonl", encoding="utf-8") as file:
        first = json.loads(file.readline())
    for world in (5, None, "text", []):
        name = write([{**first, "world": world}, {"t": 1, "page": 1, "joins": True}])
        says(fails(3, "replay", name, env=states()), "stranger.jsonl:line 1: 'world' is not a World")
    numbers = (2 ** 63 - 1, -2 ** 63, -1, 10 ** 18 + 1, 1.5, "1", None)
    began = time.monotonic()
    for number in numbers:
        name = write([first, {"t": number, "page": 1, "joins": True}, {"t": number, "page": 1, "says": hello}])
        says(fails(3, "replay", name, env=states()), "stranger.jsonl:line 2: 't' is a whole number of nanoseconds from 0 to")
        name = write([{**first, "results": number}, {"t": 1, "page": 1, "joins": True}])
        if number is not None:
            says(fails(3, "replay", name, env=states()), "stranger.jsonl:line 1: 'results' is a whole number from 0 to")
    for times in ((10 ** 18, 10 ** 18), (10 ** 18, 0), (0, 10 ** 18)):
        name = write([first, {"t": times[0], "page": 1, "joins": True}, {"t": times[1], "page": 1, "says": hello},
                      {"t": times[1], "page": 1, "says": {"type": "events", "lines": f"{10 ** 15} mouse axis x 0.5\n"}},
                      {"t": times[1], "page": 1, "says": {"type": "edit", "id": 1, "gesture": "g", "edits": [
                          {"op": "set", "path": "title", "value": "x"}]}}])
        ok("replay", name, "-o", "played.vv.json", env=states())
        with open("played.vv.json", encoding="utf-8") as file:
            assert json.load(file)["title"] == "x"
    assert time.monotonic() - began < 60
    assert not folders()


if __name__ == "__main__":
    main()
