"""Previews of operations: what a page sees before anything is run is what it sees after, and what `volvis NAME` writes."""
import base64
import io

import numpy as np
from PIL import Image

from harness import main, ok, write_samples
from nrrd_reader import Nrrd

try:
    from page import Page, Server, run
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")

SHAPE = (15, 21, 27)  # z, y, x


def noisy():
    z, y, x = np.indices(SHAPE)
    ball = 800 * ((x - 13) ** 2 + (y - 10) ** 2 + (z - 7) ** 2 < 36)
    return (ball + np.random.default_rng(7).integers(0, 200, SHAPE)).astype("u2")


def write(samples):
    kind = {"u1": "uint8", "u2": "uint16"}[samples.dtype.str[1:]]
    write_samples("a.nrrd", samples.shape[::-1], samples.tobytes(), kind=kind)


def decoded(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def picture(preview, which="picture"):
    kind, text = preview[which].split(",")
    assert kind == "data:image/png;base64", kind
    return decoded(base64.b64decode(text))


async def told(page, *said, **members):
    """What is asked changes the World, and the page has heard of it."""
    number = page.world["number"]
    await page.ask(*said, **members)
    await page.until(lambda: page.world["number"] > number)


async def apply(page, operation, parameters, **inputs):
    await told(page, "edit", edits=[
        {"op": "add", "path": "datasets", "id": "made", "value": {"operation": operation, "inputs": {"volume": "a", **inputs}, "parameters": parameters}},
        {"op": "set", "path": "volumes.a.data", "value": "made"}])
    shown = decoded((await page.resting()).data)
    await told(page, "undo")
    return shown


def on_slices(work, *words):
    write(noisy())
    with Server("a.nrrd", "--set", "volumes.a.slices.window_lo=0", "--set", "volumes.a.slices.window_hi=1000", "--set", "cross_hair=[13,10,7]", *words) as server:
        async def all_planes():
            for plane in ("axial", "coronal", "sagittal"):
                async with Page(server, 200, 150, plane=plane) as page:
                    await work(page)
        run(all_planes())


def test_a_preview_of_a_slice_is_the_slice_of_what_is_run():
    steps = {"gaussian": {"sigma": "1.5vox"}, "median": {"radius": "1vox"}, "dilate": {}, "unsharp": {"amount": 2},
             "resample": {"spacing": "1.5"}, "pad": {"all": 3}}

    async def work(page):
        before = decoded((await page.resting()).data)
        for operation, parameters in steps.items():
            preview = await page.ask("preview", operation=operation, dataset="a", parameters=parameters)
            assert not preview["whole"] and preview["full"], preview
            assert (picture(preview) == await apply(page, operation, parameters)).all(), operation
            assert (picture(preview) != before).any(), operation
            assert min(preview["n"]) <= 6 < max(preview["n"]), preview["n"]  # a slab and not the volume
    on_slices(work)


def test_values_at_the_cross_hair_are_those_of_the_file_that_the_operation_writes():
    write(noisy())
    ok("gaussian", "a.nrrd", "--sigma", "2vox", "-o", "smooth.nrrd")
    truth = Nrrd("smooth.nrrd").data

    async def work(page):
        for x, y, z in ((13, 10, 7), (0, 20, 14), (4, 4, 3)):
            await page.edit(("set", "cross_hair", [x, y, z]))
            preview = await page.ask("preview", operation="gaussian", dataset="a", parameters={"sigma": "2vox"})
            assert preview["before"] == noisy()[z, y, x], preview
            assert preview["after"] == truth[x, y, z], (preview["after"], truth[x, y, z])
    on_slices(work)


def test_what_needs_the_whole_says_so_unless_that_is_quick():
    async def work(page):
        await page.resting()  # from there the page looks
        small = await page.ask("preview", operation="equalize", dataset="a", parameters={})
        assert small["picture"]
        lit = await page.ask("preview", operation="components", dataset="a", parameters={})
        assert lit["whole"] and lit["full"] and lit["picture"], lit
        assert (picture(lit) == await apply(page, "components", {})).all()
    on_slices(work)
    write(np.random.default_rng(3).integers(0, 200, (80, 80, 80)).astype("u1"))
    with Server("a.nrrd") as server:
        async def large():
            async with Page(server, 200, 150) as page:
                told = await page.ask("preview", operation="isosurface", dataset="a", parameters={"iso": 195})
                assert told["whole"] and not told["full"] and "picture" not in told and "seconds" not in told, told
                assert told["bytes"] >= 80 ** 3, told
                assert "picture" in await page.ask("preview", operation="isosurface", dataset="a", parameters={"iso": 195}, whole=True)
                quick = await page.ask("preview", operation="fill-holes", dataset="a", parameters={})
                assert quick["whole"] and ("picture" in quick) == quick["full"] == (quick["seconds"] <= 2), quick
        run(large())


def test_a_preview_is_seen_in_three_dimensions_and_leaves_no_trace():
    write(noisy())
    with Server("a.nrrd") as server:
        async def work():
            async with Page(server, 200, 150) as page:
                before = decoded((await page.resting()).data)
                number, data = page.world["number"], set(page.world["world"]["datasets"])
                preview = await page.ask("preview", operation="gaussian", dataset="a", parameters={"sigma": "3vox"})
                assert preview["full"] and preview["n"] == list(SHAPE[::-1]), preview
                assert (picture(preview) != before).any()
                surface = await page.ask("preview", operation="isosurface", dataset="a", parameters={"iso": 500})
                assert surface["whole"] and (picture(surface) != picture(preview)).any()
                await page.told()
                assert page.world["number"] == number and set(page.world["world"]["datasets"]) == data
        run(work())


def test_a_step_between_others_is_compared_with_what_it_is_made_of_and_its_end_with_what_was_there():
    async def work(page):
        of_input = decoded((await page.resting()).data)
        await told(page, "edit", edits=[
            {"op": "add", "path": "datasets", "id": "body", "value": {"operation": "threshold", "inputs": {"volume": "a"}, "parameters": {"range": "500.."}}},
            {"op": "set", "path": "volumes.a.data", "value": "body"}])
        labels = decoded((await page.resting()).data)
        preview = await page.ask("preview", operation="unsharp", dataset="a", parameters={"amount": 2}, volume="a")
        assert (labels != of_input).any() and (picture(preview, "input") == of_input).all()
        assert preview["before"] == float(noisy()[7, 10, 13]) and preview["after"] != preview["before"], preview
        takers = {"takers": ["datasets.body.inputs.volume"], "volume": "a"}
        end = await page.ask("preview", operation="gaussian", dataset="a", parameters={"sigma": "2vox"}, **takers)
        assert end["end"] and "input" not in end and end["before"] == 1, end
        await told(page, "edit", edits=[
            {"op": "add", "path": "datasets", "id": "soft", "value": {"operation": "gaussian", "inputs": {"volume": "a"}, "parameters": {"sigma": "2vox"}}},
            {"op": "set", "path": "datasets.body.inputs.volume", "value": "soft"}])
        applied = decoded((await page.resting()).data)
        assert (applied != labels).any() and (picture(end) == applied).all()
        await told(page, "undo")
        refused = await page.refused("preview", operation="unsharp", dataset="a", parameters={}, takers=["volumes.a.frame"], volume="a")
        assert "volumes.a.frame" in refused, refused
        alone = await page.ask("preview", operation="erode", dataset="body", parameters={}, volume="a")
        assert "input" not in alone and alone["before"] == 1, alone
        await told(page, "undo")
    on_slices(work)


def test_new_labels_have_no_names_and_colours_of_old_ones():
    async def work(page):
        await told(page, "edit", edits=[
            {"op": "add", "path": "datasets", "id": "body", "value": {"operation": "threshold", "inputs": {"volume": "a"}, "parameters": {"range": "500.."}}},
            {"op": "set", "path": "volumes.a.data", "value": "body"},
            {"op": "set", "path": "volumes.a.segmentation.labels.table", "value": [[1, 1, 0, 0, 1]]},
            {"op": "add", "path": "volumes.a.segmentation.labels.names", "id": None, "value": {"label": 1, "name": "ball"}}])
        red = decoded((await page.resting()).data)
        for operation, keeps in (("dilate", True), ("components", False)):
            preview = await page.ask("preview", operation=operation, dataset="body", parameters={})
            await told(page, "run", operation=operation, dataset="body", parameters={})
            assert (picture(preview) == decoded((await page.resting()).data)).all() and (picture(preview) != red).any(), operation
            labels = page.world["world"]["volumes"]["a"].get("segmentation", {}).get("labels", {})
            assert set(labels) == ({"table", "names"} if keeps else set()), labels
            await told(page, "undo")
        await told(page, "undo")
    on_slices(work)


def test_a_step_whose_time_nobody_knows_is_seen_by_itself_unless_all_is_asked_for():
    write(noisy())
    with Server("a.nrrd") as server:
        async def work():
            async with Page(server, 200, 150) as page:
                await told(page, "edit", edits=[
                    {"op": "add", "path": "datasets", "id": "skin", "value": {"operation": "isosurface", "inputs": {"volume": "a"}, "parameters": {"iso": 500}}},
                    {"op": "add", "path": "datasets", "id": "low", "value": {"operation": "simplify", "inputs": {"mesh": "skin"}, "parameters": {"share": 0.1}}},
                    {"op": "set", "path": "volumes.a.data", "value": "low"}])
                await page.resting()
                shown = [await page.ask("preview", operation="smooth", dataset="skin", parameters={}, volume="a", takers=["datasets.low.inputs.mesh"], whole=whole)
                         for whole in (False, True)]
                assert [one["end"] for one in shown] == [False, True] and "input" in shown[0] and "input" not in shown[1]
                assert (picture(shown[0]) != picture(shown[1])).any()
        run(work())


def test_the_newest_preview_counts():
    write(np.random.default_rng(1).integers(0, 200, (96, 96, 96)).astype("u2"))
    with Server("a.nrrd") as server:
        async def work():
            async with Page(server, 200, 150) as page:
                await page.resting()
                for id_ in (1001, 1002):
                    await page.say("preview", id=id_, operation="denoise", dataset="a", parameters={"radius": f"{id_ - 998}vox"}, whole=True)
                last = await page.ask("preview", operation="gaussian", dataset="a", parameters={"sigma": "1vox"})
                said = {m["id"]: m["ok"] for m in page.messages if m["type"] == "answer" and m["id"] > 1000}
                assert said == {1001: False, 1002: False}, said
                assert last["picture"]
        run(work())


def test_refusals_name_the_property():
    async def work(page):
        for wanted, members in (("parameters.sigma: ", {"operation": "gaussian", "parameters": {"sigma": "lots"}}),
                                ("parameters.sigmo: ", {"operation": "gaussian", "parameters": {"sigmo": 1}}),
                                ("expected an object of parameters", {"operation": "gaussian", "parameters": 3}),
                                ("inputs", {"operation": "mask", "parameters": {}}),
                                ("gaussian", {"operation": "gausian"}),
                                ("which slices do not show", {"operation": "isosurface", "parameters": {"iso": 500}}),
                                ("no visible volume shows 'b'", {"operation": "gaussian", "dataset": "b"}),
                                ("needs an operation", {})):
            said = await page.refused("preview", **{"dataset": "a", **members})
            assert wanted in said, said
    on_slices(work)


def test_who_only_looks_may_look_at_previews_too():
    write(noisy())
    with Server("--root", ".", "--read-only", "a.nrrd", verb="serve") as server:
        async def work():
            async with Page(server, 200, 150, plane="axial") as page:
                assert (await page.ask("preview", operation="mean", dataset="a", parameters={}))["picture"]
        run(work())


main()
