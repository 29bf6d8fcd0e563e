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
    """A session whose sample a saved scene shows: the lines of its recording, and that file."""
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", "--record", "session.jsonl") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                await page.ask("sample", name="orbital")
                await page.until(lambda: "orbital" in page.world["world"]["datasets"])
                path = page.world["world"]["datasets"]["orbital"]["path"]
                # a page names a sample by where it is
                await page.ask("edit", edits=[{"op": "add", "path": "datasets", "id": "again", "value": {"path": path}}])
                await page.ask("run", operation="crop", dataset="again", parameters={"x": "0:8"})
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


def test_samples_are_played_into_a_new_folder_alone():
    lines, path = record()
    with open(path, "rb") as file:
        before, seen = file.read(), os.stat(path)
    assert stat.S_IMODE(seen.st_mode) == 0o400
    stranger = [{**line} for line in lines]
    for i in range(2):
        stranger[0]["results"] = 7  # of an older version, which had files of results
        ok("replay", write(stranger), "-o", "theirs.vv.json", env=states())
        with open("theirs.vv.json", encoding="utf-8") as file:
            data = json.load(file)["datasets"]
        made = os.path.abspath(data["orbital"]["path"])
        assert os.path.abspath(data["again"]["path"]) == made, data  # what was said of the sample is said of this one
        assert data["again-crop"] == {"operation": "crop", "inputs": {"volume": "again"}, "parameters": {"x": "0:8"}}, data
        assert re.fullmatch(r".*/state/volvis/replay-\w{6}/samples/orbital\.nrrd", made), made
        ok("render", "theirs.vv.json", "-o", "theirs.png", "--overwrite")
    with open(path, "rb") as file:
        after = os.stat(path)
        assert file.read() == before and (after.st_ino, after.st_mtime_ns) == (seen.st_ino, seen.st_mtime_ns)
    assert len(folders()) == 2
    ok("replay", "stranger.jsonl", env=states())
    assert len(folders()) == 2, "without -o nobody has use for samples"
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
