"""What the page measures is what the program measures, and data are named by the World alone."""
import json
import os
import shlex

import numpy as np

from harness import main, ok, says
from measure_inputs import distance_to, noise, write, write_box, write_sphere

try:
    from page import Page, Server, run
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


def prepare():
    write_sphere("ball.nrrd", 24, 8.0, (11.3, 12.1, 11.8), spacing=(0.5, 0.5, 0.7))
    write("mask.nrrd", (distance_to(24, (10, 10, 10)) < 7).astype(np.uint8), spacing=(0.5, 0.5, 0.7))
    write("labels.nrrd", noise("uint8", (9, 10, 11)) % 4)
    write_box("a.stl")
    write_box("b.stl", at=5.0)


def asked(*words):
    """What the program says of it, without what names the run."""
    found = ok("measure", *words, "--json").json
    return {key: value for key, value in found.items() if key not in ("volvis", "command", "measured", "file", "warnings")}


def with_page(work, *files):
    async def begin():
        async with Page(server, 64, 64) as page:
            await work(page)
    with Server(*files) as server:
        run(begin())


def test_every_kind_says_what_the_program_says():
    prepare()
    points = {"points": [[0, 1, 2], [20, 11, 5]]}
    wanted = {
        "summary": ((), {}),
        "area": (("--iso", "0", "--box", "2..20,..,.."), {"iso": 0, "box": "2..20,..,.."}),
        "volume": (("--threshold", "..3", "--method", "count"), {"threshold_hi": 3, "method": "count"}),
        "box": (("--iso", "1", "--seed", "11,12,12"), {"iso": 1, "seed": [11, 12, 12]}),
        "statistics": (("--clip", "plane(n=1,2,0 d=5)"), {"cut_planes": [{"normal": [1, 2, 0], "offset": 5}]}),
        "histogram": (("--bins", "9", "--range", "-5,4"), {"bins": 9, "range": [[-5, 4]]}),
        "joint": (("--bins", "6"), {"bins": 6}),
        "profile": (("--point", "0,1,2", "--point", "20,11,5", "--samples", "7"), {**points, "samples": 7}),
        "distance": (("--point", "0,1,2", "--point", "20,11,5"), points),
        "point": (("--point", "3.5,1,2"), {"points": [[3.5, 1, 2]]}),
        "angle": (("--point", "0,1,2", "--point", "20,11,5", "--point", "1,1,1"), {"points": points["points"] + [[1, 1, 1]]}),
        "geodesic": (("--iso", "0", "--point", "4,12,12", "--point", "12,12,18"),
                     {"iso": 0, "points": [[4, 12, 12], [12, 12, 18]]}),
    }

    async def work(page):
        for kind, (words, question) in wanted.items():
            found = await page.ask("measure", question={"what": kind, **question})
            assert found["answer"] == asked(kind, "ball.nrrd", *words), kind
            assert kind == "angle" or {"name", "value"} <= set(found["figures"][0]), kind
    with_page(work, "ball.nrrd")


def test_labels_and_meshes_are_measured_too():
    prepare()

    async def labels(page):
        found = await page.ask("measure", question={"what": "labels"})
        assert found["answer"] == asked("labels", "labels.nrrd") and len(found["answer"]["labels"]) == 3

    async def mesh(page):
        found = await page.ask("measure", question={"what": "volume"})
        assert abs(found["answer"]["volume"] - 8) < 1e-6 and found["answer"]["mesh"] == "a"
        found = await page.ask("measure", question={"what": "distance", "points": [[5, 1, 1]]})
        assert abs(found["answer"]["distance"] - 3) < 1e-6
        says(await page.refused("measure", question={"what": "histogram"}), "no histogram")
    with_page(labels, "labels.nrrd")
    with_page(mesh, "a.stl")


def test_data_beside_the_first_are_named_by_the_world():
    prepare()

    async def volumes(page):
        found = await page.ask("measure", volume="ball", mask="mask", question={"what": "volume"})
        assert found["answer"]["volume"] == asked("volume", "ball.nrrd", "--mask", "mask.nrrd")["volume"]
        assert found["answer"]["object"] == "where mask is not 0"
        says(await page.refused("measure", mask="mist", question={"what": "volume"}), "'mist'")
        says(await page.refused("measure", volume="mist", question={"what": "volume"}), "'mist'")
        says(await page.refused("measure", mask=7, question={"what": "volume"}), "'mask' must be a name")

    async def meshes(page):
        found = await page.ask("measure", volume="a", other="b", question={"what": "distance"})
        assert abs(found["answer"]["distance"] - 3 * 3 ** 0.5) < 1e-5
        both = await page.ask("measure", question={"what": "volume"})
        assert abs(both["answer"]["volume"] - 16) < 1e-5 and len(both["answer"]["meshes"]) == 2
        one = await page.ask("measure", volume="b", question={"what": "box"})
        assert one["answer"]["box_lo"] == [5, 5, 5]
    with_page(volumes, "ball.nrrd", "mask.nrrd")
    with_page(meshes, "a.stl", "b.stl")


def test_cut_planes_and_thresholds_of_the_world_hold():
    prepare()

    async def work(page):
        whole = await page.ask("measure", question={"what": "volume", "iso": 0})
        await page.edit(("set", "cut_planes", [{"normal": [1, 0, 0], "offset": 5.65}]))
        half = await page.ask("measure", question={"what": "volume", "iso": 0})
        assert abs(half["answer"]["volume"] / whole["answer"]["volume"] - 0.5) < 0.01
        await page.edit(("set", "cut_planes", []), ("set", "volumes.ball.segmentation.kind", "threshold"),
                        ("set", "volumes.ball.segmentation.threshold.lo", 2))
        shown = await page.ask("measure", question={"what": "volume"})
        assert shown["answer"]["object"].endswith("as in the scene") and shown["answer"]["threshold_lo"] == 2
    with_page(work, "ball.nrrd")


def test_an_answer_can_be_kept_in_the_scene_and_asked_again_by_the_program():
    prepare()

    async def work(page):
        question = {"what": "area", "iso": 1}
        found = await page.ask("measure", question=question)
        await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": "skin",
                                       "value": {**question, "figures": found["figures"]}}])
        await page.ask("save", path=os.path.abspath("study.vv.json"))
    with_page(work, "ball.nrrd")
    says(ok("measure", "study.vv.json").text, "skin: area, as before", "1 measured, 0 changed")


def test_each_stored_one_has_the_line_that_measures_it_again():
    prepare()
    kept = {
        "length": {"what": "distance", "points": [[0.25, 1, 2], [5, 6.5, 5], [1, 1, 1]], "space": "world"},
        "piece": {"what": "summary", "iso": 1, "seed": [5, 6, 8.4], "space": "world"},
        "part": {"what": "histogram", "box": "2..20,..,3..9", "bins": 12, "range": [[-3.5, 4]]},
        "cut": {"what": "volume", "threshold_hi": 2.5, "method": "count", "cut_planes": [{"normal": [1, 2, 0], "offset": 5}]},
        "drawn": {"what": "statistics", "space": "world", "region": {"kind": "polygon", "outline": [[2, 2, 4], [9, 3.5, 4], [5, 9, 4]], "center": [1, 2, 3], "thickness": 1.5}},
        "ball": {"what": "volume", "iso": 0, "region": {"kind": "ellipsoid", "center": [10, 9, 8], "size": [12, 9, 7.5], "normal": [0.5, 0, 1]}},
        "off": {"what": "area", "iso": 0.5, "method": "count", "closed": False},
    }

    async def work(page):
        for name, question in kept.items():
            await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": name, "value": question}])
            line = (await page.ask("command", measurement=name))["text"]
            found = await page.ask("measure", question=question, plot=True)
            words = shlex.split(line)
            assert words[:2] == ["volvis", "measure"], line
            assert asked(*words[2:]) == found["answer"], line
            assert ("<svg" in (found["plot"] or "")) == (name == "part"), name
        # the volume is shown by a threshold of the World, and later moved: the scene says so, the file alone does not
        question = {"what": "volume"}
        await page.ask("edit", edits=[{"op": "set", "path": "volumes.ball.segmentation", "value": {"kind": "threshold", "threshold": {"lo": -2}}},
                                      {"op": "add", "path": "measurements", "id": "shown", "value": question}])
        found = (await page.ask("measure", question=question))["answer"]
        words = shlex.split((await page.ask("command", measurement="shown"))["text"])
        assert asked(*words[2:])["volume"] == found["volume"] and "--iso=-2" in words, words
        await page.ask("edit", edits=[{"op": "set", "path": "volumes.ball.place.scale", "value": [2, 1, 1]}])
        line = (await page.ask("command", measurement="shown"))["text"]
        says(line, "volvis measure stored scene.vv.json 'shown'")
        says((await page.refused("command", measurement="nothing")), "there is no measurement 'nothing'")
    with_page(work, "ball.nrrd")


def test_those_of_meshes_have_the_line_of_their_file():
    """Where nothing moves or cuts the mesh, and no other is seen with it."""
    prepare()
    kept = {"skin": {"what": "area"}, "all": {"what": "summary"}, "length": {"what": "distance", "points": [[5, 1, 1]], "space": "world"},
            "bend": {"what": "angle", "points": [[5, 1, 1], [0, 0, 0], [1, 2, 3.5]]}, "way": {"what": "geodesic", "points": [[0, 0.5, 1], [2, 1, 1.25]]},
            "part": {"what": "volume", "region": {"kind": "box", "center": [1, 1, 1], "size": [1, 4, 4]}}}

    async def work(page):
        for name, question in kept.items():
            await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": name, "value": question}])
            found = (await page.ask("measure", question=question))["answer"]
            words = shlex.split((await page.ask("command", measurement=name))["text"])
            assert words[:2] == ["volvis", "measure"] and "a.stl" in " ".join(words), words
            found.pop("mesh", None)
            said = asked(*words[2:])
            said.pop("mesh", None)
            assert said == found, (words, said, found)
        for edit in (("set", "volumes.a.place.scale", [2, 1, 1]), ("set", "cut_planes", [{"normal": [1, 0, 0], "offset": 1}])):
            await page.edit(edit)
            says((await page.ask("command", measurement="skin"))["text"], "volvis measure stored scene.vv.json 'skin'")
            await page.ask("edit", edits=[{"op": "unset", "path": edit[1]}])

    async def both(page):
        for name, volume, words in (("skin", None, "stored scene.vv.json"), ("one", "b", "area 'b.stl'")):
            question = {"what": "area", **({"volume": volume} if volume else {})}
            await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": name, "value": question}])
            line = (await page.ask("command", measurement=name))["text"]
            assert words in line.replace(os.getcwd() + "/", ""), line
    with_page(work, "a.stl")
    with_page(both, "a.stl", "b.stl")


def test_no_file_is_read_that_is_not_of_the_world():
    prepare()

    async def work(page):
        for name in ("file", "other", "mask", "values"):
            says(await page.refused("measure", question={"what": "volume", name: "mask.nrrd"}), f"'{name}'", "beside it")
        says(await page.refused("measure", question={"what": "wolume"}), "volume")
        says(await page.refused("measure", question="area"), "needs a question")
        says(await page.refused("measure"), "needs a question")
        said = await page.refused("measure", question={"what": "area", "seed": [900, 0, 0]})
        says(said, "Seed: 900,0,0 is outside")
        assert "--" not in said, said
    with_page(work, "ball.nrrd")


def test_what_changes_nothing_is_refused():
    prepare()

    async def labels(page):
        ball = {"kind": "ellipsoid", "center": [4, 4, 4], "size": [5, 5, 5]}
        for name, value in (("region", ball), ("seed", [4, 4, 4]), ("iso", 2), ("label", 1), ("points", [[1, 1, 1]]), ("bins", 4), ("closed", True)):
            says(await page.refused("measure", question={"what": "labels", name: value}), f"'{name}' has no effect on the labels of labels, a volume: leave it out")
        says(await page.refused("measure", question={"what": "labels"}, mask="labels"), "'mask' has no effect")
        part = await page.ask("measure", question={"what": "labels", "box": "0..4,..,..", "space": "world"})
        assert sum(row["count"] for row in part["answer"]["labels"]) < 5 * 10 * 9
        says(await page.refused("measure", question={"what": "distance", "points": [[1, 1, 1], [2, 2, 2]], "iso": 1}), "'iso' has no effect on the distance")
        says(await page.refused("measure", question={"what": "profile", "points": [[1, 1, 1], [2, 2, 2]], "region": ball}), "'region' has no effect on the profile")

    async def mesh(page):
        says(await page.refused("measure", question={"what": "volume", "seed": [1, 1, 1]}), "'seed' has no effect on the volume")
        says(await page.refused("measure", question={"what": "area", "label": 1}), "'label' has no effect on the area")
    with_page(labels, "labels.nrrd")
    with_page(mesh, "a.stl")


def test_it_is_a_job_that_can_be_cancelled():
    write_sphere("ball.nrrd", 200, 80.0, (100, 100, 100))

    async def work(page):
        for number in (1001, 1002):  # one after the other
            await page.say("measure", id=number, question={"what": "joint", "bins": 64})
        first = await page.until(lambda: next((m for m in page.messages if m["type"] == "job" and m["name"] == "measure"),
                                              None))
        waiting = first["job"] + 1
        assert await page.ask("cancel", job=waiting)
        ends = await page.until(lambda: [m for m in page.messages if m["type"] == "answer" and m["id"] in (1001, 1002)][1:])
        told = {m["id"]: m for m in page.messages if m["type"] == "answer"}
        assert ends and told[1001]["ok"] and not told[1002]["ok"], json.dumps(told)[:300]
    with_page(work, "ball.nrrd")


main()
