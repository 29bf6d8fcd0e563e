"""Scenes with data that are made of others, in the page: parameters are edits, pictures follow, and nothing runs without bounds."""
import asyncio
import io
import json
import os
import shlex

import numpy as np
from PIL import Image

from harness import main, ok, says, write_ball

try:
    from page import Page, Server, run
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")

CHAIN = "gaussian --sigma 1vox | threshold --range 90.."


def pixels(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(float)


def psnr(a, b):
    error = np.mean((a - b) ** 2)
    return float("inf") if error == 0 else 10 * np.log10(255 ** 2 / error)


def run_lines(lines):
    for line in lines.split("\n"):
        ok(*shlex.split(line)[1:])
    with open("picture.png", "rb") as file:
        return pixels(file.read())


def datasets_of(page):
    return page.world["world"]["datasets"]


def picture_of(*words):
    ok("render", *words, "--size", "320x240", "-o", "truth.png", "--overwrite")
    with open("truth.png", "rb") as file:
        return pixels(file.read())


def test_a_parameter_is_an_edit_and_the_picture_follows():
    write_ball()
    ok("pipe", "head.nrrd", "gaussian --sigma 1vox", "-o", "made.vv.json")
    with Server("made.vv.json") as server:
        async def work():
            async with Page(server) as page:
                before = await page.resting()
                await page.edit(("set", "datasets.gaussian.parameters.sigma", "4vox"))
                after = await page.resting()
                said = datasets_of(page)["gaussian"]["parameters"]
                await page.say("undo")
                await page.until(lambda: datasets_of(page)["gaussian"]["parameters"] != said)
                back = await page.resting()
                await page.edit(("set", "datasets.gaussian.parameters.sigma", "4vox"))
                await page.ask("save", path=os.path.abspath("saved.vv.json"))
                return said, [pixels(frame.data) for frame in (before, after, back)]
        said, (before, after, back) = run(work())
    assert said == {"sigma": "4vox"}, said
    assert psnr(before, after) < 40 <= psnr(before, back)
    assert psnr(before, picture_of("made.vv.json")) >= 40
    assert psnr(after, picture_of("saved.vv.json")) >= 40  # from where it was seen
    ok("gaussian", "head.nrrd", "--sigma", "4vox", "-o", "smooth.nrrd")
    with_file = ("datasets.gaussian.path=smooth.nrrd", "datasets.gaussian.operation=null")
    assert psnr(after, picture_of("saved.vv.json", *(word for setting in with_file for word in ("--set", setting)))) >= 40
    with open("saved.vv.json", encoding="utf-8") as file:
        saved = json.load(file)["datasets"]["gaussian"]
    assert saved == {"operation": "gaussian", "inputs": {"volume": "head"}, "parameters": {"sigma": "4vox"}}, saved


def test_command_lines_are_the_recipe():
    write_ball()
    ok("pipe", "head.nrrd", CHAIN, "-o", "made.vv.json")
    with Server("made.vv.json") as server:
        async def work():
            async with Page(server) as page:
                frame = await page.resting()
                next_one = await page.ask("command", operation="components", dataset="threshold", parameters={})
                return frame, (await page.ask("command"))["text"], next_one["text"]
        frame, lines, next_one = run(work())
    assert [line.split()[1] for line in lines.split("\n")] == ["gaussian", "threshold", "render"], lines
    assert [line.split()[1] for line in next_one.split("\n")] == ["gaussian", "threshold", "components"], next_one
    assert psnr(run_lines(lines), pixels(frame.data)) >= 40, lines


def test_operations_run_on_what_is_made():
    write_ball()
    ok("pipe", "head.nrrd", CHAIN, "-o", "made.vv.json")
    ok("pipe", "head.nrrd", CHAIN + " | dilate --radius 2", "-o", "truth.nrrd")
    with Server("made.vv.json") as server:
        async def work():
            async with Page(server) as page:
                made = (await page.ask("run", operation="dilate", dataset="threshold", parameters={"radius": 2}))["dataset"]
                await page.ask("write", dataset=made, path=os.path.abspath("made.nrrd"))
        run(work())
    with open("made.nrrd", "rb") as made, open("truth.nrrd", "rb") as truth:
        assert made.read() == truth.read()


def test_a_new_name_that_two_pages_want_at_once_is_that_of_one():
    write_ball()
    ok("pipe", "head.nrrd", "resample --size 128,128,128 --interpolation cubic", "-o", "made.vv.json")
    with Server("made.vv.json") as server:
        async def work():
            async with Page(server) as one, Page(server) as two:
                dataset = next(name for name in datasets_of(one) if name != "head")
                return [await asyncio.gather(*(page.answer("write", dataset=dataset, path=os.path.abspath(f"{i}.nrrd")) for page in (one, two)))
                        for i in range(3)]
        for i, answers in enumerate(run(work())):
            won, lost = sorted(answers, key=lambda answer: not answer["ok"])
            assert won["ok"] and lost.get("reason") == "exists" and f"{i}.nrrd already exists" in lost["error"].replace(":", ""), answers


def test_a_folder_that_is_a_volume_has_no_place_for_other_files():
    write_ball()
    ok("convert", "head.nrrd", "-o", "z.ome.zarr")
    ok("convert", "head.nrrd", "-o", "slices/%03d.png")
    ok("convert", "head.nrrd", "-o", "other.ome.zarr")
    with Server("z.ome.zarr", "slices") as server:
        async def work():
            async with Page(server) as page:
                dataset = next(iter(datasets_of(page)))
                for kind, path, said in (("write", "z.ome.zarr/x.nrrd", "is the folder of the dataset"), ("write", "slices/x.png", "is the folder of the dataset"),
                                         ("write", "other.ome.zarr/0/x.nrrd", "other.ome.zarr' is a volume"), ("save", "z.ome.zarr/x", "is a volume, and no folder for")):
                    members = {"dataset": dataset} if kind == "write" else {}
                    says(await page.refused(kind, path=os.path.abspath(path), **members), said)
                await page.ask("save", path=os.path.abspath("slices/x"))  # no data: the slices are what they were
                await page.ask("write", dataset=dataset, path=os.path.abspath("new.ome.zarr"))
        run(work())
    ok("info", "new.ome.zarr")
    assert not os.path.exists("z.ome.zarr/x.nrrd") and not os.path.exists("slices/x.png") and not os.path.exists("other.ome.zarr/0/x.nrrd")


def test_a_step_that_is_switched_off_is_left_out():
    write_ball()
    ok("pipe", "head.nrrd", "gaussian --sigma 4vox | median --radius 1", "-o", "made.vv.json")
    with Server("made.vv.json") as server:
        async def work():
            async with Page(server) as page:
                both = await page.resting()
                await page.edit(("set", "datasets.gaussian.on", False))
                one = await page.resting()
                lines = (await page.ask("command"))["text"]
                await page.ask("write", dataset="median", path=os.path.abspath("one.nrrd"))
                await page.edit(("set", "datasets.median.on", False))
                await page.ask("write", dataset="median", path=os.path.abspath("none.nrrd"))
                none = (await page.ask("command"))["text"]
                await page.edit(("set", "datasets.median.on", True), ("set", "datasets.gaussian.on", True))
                back = await page.resting()
                return [pixels(frame.data) for frame in (both, one, back)], lines, none
        (both, one, back), lines, none = run(work())
    assert psnr(both, one) < 40 <= psnr(both, back)
    assert [line.split()[1] for line in lines.split("\n")] == ["median", "render"], lines
    assert psnr(run_lines(lines), one) >= 40, lines
    assert [line.split()[1] for line in none.split("\n")] == ["render"], none
    ok("median", "head.nrrd", "--radius", 1, "-o", "truth.nrrd")
    ok("convert", "head.nrrd", "-o", "as_it_is.nrrd")
    for made, truth in (("one.nrrd", "truth.nrrd"), ("none.nrrd", "as_it_is.nrrd")):
        with open(made, "rb") as one, open(truth, "rb") as other:
            assert one.read() == other.read(), made


def test_what_becomes_labels_or_none_any_more_is_shown_so_unless_somebody_said_how():
    write_ball()
    ok("threshold", "head.nrrd", "--range", "90..", "-o", "body.nii.gz")
    with Server("body.nii.gz") as server:
        async def work():
            async with Page(server) as page:
                async def kind():
                    await page.resting()
                    await page.until(lambda: [m for m in page.messages if m["type"] == "resolved" and m["number"] == page.world["number"]])
                    said = [m for m in page.messages if m["type"] == "resolved"][-1]["world"]["volumes"]["body"]
                    return said["segmentation"]["kind"], said["interpolation"]
                kinds = [await kind()]
                made = (await page.ask("run", operation="calc", dataset="body", inputs={"a": "body"}, parameters={"formula": "a * 2.5"}))["dataset"]
                kinds.append(await kind())
                await page.edit(("set", f"datasets.{made}.on", False))
                kinds.append(await kind())
                await page.edit(("set", f"datasets.{made}.on", True))
                await page.ask("run", operation="threshold", dataset=made, parameters={"range": "2.."})
                kinds.append(await kind())
                await page.edit(("set", "volumes.body.segmentation.kind", "transfer"))
                kinds.append(await kind())
                return kinds
        kinds = run(work())
    labels, amounts = ("labels", "nearest"), ("transfer", "linear")
    assert kinds == [labels, amounts, labels, labels, ("transfer", "nearest")], kinds


def test_results_that_older_versions_wrote_are_files():
    write_ball()
    ok("gaussian", "head.nrrd", "--sigma", "3vox", "-o", "result-1.nrrd")
    with open("old.vv.json", "w", encoding="utf-8") as file:
        json.dump({"schema": 1, "datasets": {"head": {"path": "head.nrrd"},
                                             "head-gaussian": {"path": "result-1.nrrd", "source": "head", "operation": "gaussian",
                                                               "parameters": {"sigma": "3vox"}}},
                   "volumes": {"head": {"data": "head-gaussian"}}}, file)
    with Server("old.vv.json") as server:
        async def work():
            async with Page(server) as page:
                frame = await page.resting()
                await page.ask("write", dataset="head-gaussian", path=os.path.abspath("same.nrrd"))
                return pixels(frame.data), (await page.ask("command"))["text"]
        shown, lines = run(work())
    assert [line.split()[1] for line in lines.split("\n")] == ["gaussian", "render"], lines
    assert psnr(run_lines(lines), shown) >= 40, lines
    assert psnr(shown, picture_of("old.vv.json")) >= 40
    with open("same.nrrd", "rb") as same, open("result-1.nrrd", "rb") as result:
        assert same.read()[-1000:] == result.read()[-1000:]


def test_what_cannot_be_made_is_said_and_the_server_goes_on():
    write_ball()
    ok("pipe", "head.nrrd", "gaussian --sigma 1vox", "-o", "made.vv.json")
    links = {f"d{i}": {"operation": "flip", "inputs": {"volume": f"d{i - 1}" if i else "head"}, "parameters": {"axes": "x"}} for i in range(99)}
    bad = (("datasets.gaussian.parameters.sgma", 2, "did you mean 'sigma'"),
           ("datasets.gaussian.operation", "gausian", "did you mean 'gaussian'"),
           ("datasets.gaussian.inputs.volume", "gaussian", "made of itself"),
           ("datasets.gaussian", {"operation": "resample", "inputs": {"volume": "head"}, "parameters": {"spacing": "1e-5vox"}}, "samples"),
           ("datasets.gaussian", {"operation": "resample", "inputs": {"volume": "head"}, "parameters": {"spacing": "0.02vox"}}, "memory"))
    with Server("made.vv.json", "--memory", "300M") as server:
        async def work():
            async with Page(server) as page:
                before = await page.resting()
                for path, value, sentence in bad:
                    await page.edit(("set", path, value))
                    error = await page.until(lambda: next((m for m in page.messages if m["type"] == "failed" and sentence in m["text"]), None))
                    says(error["text"], "datasets.gaussian")
                    assert error["where"].startswith("datasets.gaussian") and error["frame"] >= before.number, error
                    says(await page.refused("info", dataset="gaussian"), "datasets.gaussian") if sentence != "memory" else None
                    told = len(page.messages)
                    await page.say("undo")
                    # what failed is tried again: that is said, unless the newer frame is there first and says it itself
                    await page.until(lambda: page.frames[-1].number > error["frame"] or any(m["type"] == "outdated" for m in page.messages[told:]))
                    assert (await page.resting()).number > error["frame"]
                assert not [m for m in page.messages if m["type"] == "notice" and m["level"] == "error"], page.messages
                await page.edit(*(("set", f"datasets.{name}", value) for name, value in links.items()))
                says(await page.refused("info", dataset="d98"), "more than 64 operations")
                assert (await page.ask("info", dataset="d50"))["dims"] == (await page.ask("info", dataset="head"))["dims"]
                return pixels(before.data), pixels((await page.resting()).data)
        before, after = run(work())
    assert psnr(before, after) >= 40


main()
