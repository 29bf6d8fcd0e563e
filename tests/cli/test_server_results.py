"""What the page makes of a file is what the program makes of it, byte for byte: with names, colours, codes, time steps."""
import json
import os
import random
import subprocess

import numpy as np

from harness import VOLVIS, Skip, main, ok, says, volvis, write_ball, write_labels, write_named_cells, write_nrrd
from page import Page, Server, run

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")
try:
    import nibabel as nib
except ImportError:
    nib = None

# what an operation does nothing without, or nothing that is seen
PARAMETERS = {"crop": {"x": "2..9", "z": "1:"}, "flip": {"axes": "xz"}, "gaussian": {"sigma": "1vox"}, "channel": {"components": "0"},
              "reorient": {"order": "zyx"}, "resample": {"spacing": "2vox"}, "rescale": {"type": "u8", "percentile": [1, 99]},
              "simplify": {"share": 0.5}}
OPTIONS = {"components": "channel"}
# operations whose results are no longer what the file calls its values
NEW_VALUES = {"rescale", "top-hat", "threshold", "components", "distance", "gradient", "laplacian", "vesselness", "equalize", "calc", "window",
              "watershed"}


def write_nifti(path, frames=1):
    if nib is None:
        raise Skip("nibabel is missing: skipped")
    shape = (12, 11, 10) + ((frames,) if frames > 1 else ())
    x, y, z, t = np.meshgrid(*(np.arange(n) for n in (shape + (1,))[:4]), indexing="ij")
    values = (100 * np.exp(-((x - 6) ** 2 + (y - 5) ** 2 + (z - 5) ** 2) / 9) * (t + 1)).reshape(shape).astype("i2")
    image = nib.Nifti1Image(values, None)
    image.header["descrip"] = b"SPM{T_[262.0]} - contrast 3"
    image.header.set_intent("t test", (262,))
    image.header.set_xyzt_units("mm", "sec")
    affine = np.array([[-2.0, 0, 0, 90], [0, 2.5, 0, -126], [0, 0, 1.5, -72], [0, 0, 0, 1]])
    image.header.set_sform(affine, 4)
    image.header.set_qform(affine, 2)
    nib.save(nib.Nifti1Image(values, None, image.header), path)


def word(name, value):
    text = ",".join(map(str, value)) if isinstance(value, list) else str(value)
    return f"--{OPTIONS.get(name, name).replace('_', '-')}={text}"


def by_program(operation, path, like):
    """The bytes that the program writes; None where it refuses."""
    out = "program" + os.path.splitext(like)[1]
    words = [word(*p) for p in PARAMETERS.get(operation, {}).items()]
    done = volvis(operation, path, *words, "-o", out, "--overwrite")
    if done.code:
        return None
    with open(out, "rb") as file:
        return file.read()


async def by_page(page, operation, dataset, notes):
    """The path of what the page's server writes; None where it refuses."""
    answer = await page.answer("run", operation=operation, dataset=dataset, parameters=PARAMETERS.get(operation, {}))
    if not answer["ok"]:
        return None
    made = answer["value"]["dataset"]
    notes[operation] = answer["value"].get("note", "")
    await page.until(lambda: made in page.world["world"]["datasets"])
    return page.world["world"]["datasets"][made]["path"]


def rows(takes):
    return [row["name"] for row in ok("operations", "--json").json["operations"]
            if row["min_inputs"] == 1 and row["inputs"][0]["takes"] == takes]


def results(path, notes=None):
    """Every operation of one volume on a file, compared; the paths of what the page has made, by operation."""
    made, notes = {}, {} if notes is None else notes

    async def work():
        async with Page(server) as page:
            name = next(iter(page.world["world"]["datasets"]))
            for operation in rows("volume"):
                made[operation] = await by_page(page, operation, name, notes)
    with Server(path) as server:
        run(work())
        for operation, file in made.items():
            wanted = by_program(operation, path, file or "refused.nrrd")
            assert (file is None) == (wanted is None), (operation, file)
            if file:
                with open(file, "rb") as opened:
                    assert opened.read() == wanted, (operation, file)
                os.link(file, operation + os.path.splitext(file)[1])
    return {operation: operation + os.path.splitext(file)[1] for operation, file in made.items() if file}


def header(path):
    with open(path, "rb") as file:
        return file.read().split(b"\n\n")[0].decode()


def test_a_nifti_stays_one_with_its_codes_and_texts():
    write_nifti("t.nii")
    made = results("t.nii")
    assert {"crop", "flip", "gaussian", "channel", "rescale", "isosurface"} <= set(made), made
    for operation, path in made.items():
        if not path.endswith(".ply"):
            out = nib.load(path).header
            assert (out["sform_code"], out["qform_code"]) == (4, 2) and b"contrast 3" in bytes(out["descrip"]), operation
            assert out.get_xyzt_units() == ("mm", "sec"), operation
            assert (out["intent_code"] == 3) == (operation not in NEW_VALUES), operation


def test_every_time_step_goes_through():
    write_nifti("t.nii", frames=3)
    notes = {}
    made = results("t.nii", notes)
    assert "first of 3 time steps" in notes["isosurface"] and not notes["crop"], notes
    for operation in ("crop", "gaussian", "rescale"):
        assert nib.load(made[operation]).shape[3] == 3, operation
    inside = nib.load("t.nii").get_fdata()[2:10, :, 1:]
    assert np.array_equal(nib.load(made["crop"]).get_fdata(), inside)
    most = [nib.load(made["rescale"]).get_fdata()[..., t].max() for t in range(3)]
    assert most[0] < most[2] == 255, most  # one window for all


def test_labels_keep_names_and_colours():
    write_labels()
    made = results("organs.seg.nrrd")
    assert "rescale" not in made, made
    for operation in ("crop", "flip", "reorient", "resample"):
        assert "Segment0_Name:=left kidney" in header(made[operation]), operation
        assert "Segment0_Color:=1 0.5" in header(made[operation]), operation
    with open(made["isosurface"], "rb") as file:
        assert b"left kidney" in file.read(3000)


def test_labels_that_nobody_calls_so_are_sensed_as_the_program_does():
    ids = random.Random(5).choices((0, 3, 11, 19, 25, 40, 52, 77, 90), k=512)
    write_nrrd("ids.nrrd", (48, 48, 48), lambda x, y, z: ids[x // 6 + 8 * (y // 6) + 64 * (z // 6)])
    notes = {}
    made = results("ids.nrrd", notes)
    says(notes["isosurface"], "looks like labels")
    with open(made["isosurface"], "rb") as file:
        assert b"90" in file.read(3000)


def test_channels_keep_names_colours_and_windows_while_they_hold():
    write_named_cells()
    ok("convert", "cells.nrrd", "-o", "cells.ome.tif")
    for path in ("cells.nrrd", "cells.ome.tif"):
        made = results(path)
        for operation, file in made.items():
            if file.endswith(".nrrd"):
                assert "volvis channel 0 name:=nuclei" in header(file), (path, operation)
                assert ("membrane" in header(file)) == (operation != "channel"), (path, operation)
        window = "volvis channel 0 window:=100 900"
        if path == "cells.nrrd":  # an OME-TIFF says nothing of it
            assert window in header(made["crop"]) and window not in header(made["rescale"])
        for file in made.values():
            os.unlink(file)


def test_results_of_results_keep_them_too():
    write_nifti("t.nii.gz")

    async def work():
        async with Page(server) as page:
            first = (await page.ask("run", operation="crop", dataset="t", parameters={"x": "2:"}))["dataset"]
            second = (await page.ask("run", operation="flip", dataset=first, parameters={"axes": "y"}))["dataset"]
            await page.until(lambda: second in page.world["world"]["datasets"])
            lines = (await page.ask("command", operation="crop", dataset=second, parameters={"x": "1:"}))["text"]
            return page.world["world"]["datasets"][second]["path"], lines
    with Server("t.nii.gz") as server:
        path, lines = run(work())
        out = nib.load(path).header
    assert out["sform_code"] == 4 and b"contrast 3" in bytes(out["descrip"])
    assert lines.split("\n")[-1].endswith(".nii'"), lines


def test_other_inputs_are_given_by_name():
    write_ball("ball.nrrd", 24)
    write_nrrd("ramp.nrrd", (24, 24, 24), lambda x, y, z: x)
    ok("isosurface", "ball.nrrd", "ramp.nrrd", "-o", "program.ply")

    async def work():
        async with Page(server) as page:
            asked = {"operation": "isosurface", "dataset": "ball", "parameters": {}}
            for inputs, part in (({"value": "ramp"}, "values"), ({"values": "rump"}, "rump"), ({"values": 5}, "name of a dataset"),
                                 ([], "object"), ({"values": "ball-isosurface"}, "mesh")):
                if part == "mesh":
                    await page.ask("run", **asked)
                    await page.until(lambda: "ball-isosurface" in page.world["world"]["datasets"])
                says((await page.answer("run", **asked, inputs=inputs))["error"], part)
            made = (await page.ask("run", **asked, inputs={"values": "ramp"}))["dataset"]
            await page.until(lambda: made in page.world["world"]["datasets"])
            lines = (await page.ask("command", operation="simplify", dataset=made, parameters={}))["text"]
            return page.world["world"]["datasets"][made], lines
    with Server("ball.nrrd", "ramp.nrrd") as server:
        dataset, lines = run(work())
        with open(dataset["path"], "rb") as page, open("program.ply", "rb") as program:
            assert page.read() == program.read()
    assert dataset["inputs"] == {"values": "ramp"}
    says(lines, " values='", "ramp.nrrd' -o 'ball-isosurface-2.ply'")


def test_formulas_speak_of_inputs_by_their_names():
    write_ball("ball.nrrd", 24)
    write_nrrd("ramp.nrrd", (24, 24, 24), lambda x, y, z: x)
    ok("calc", "b - 2*a", "a=ball.nrrd", "b=ramp.nrrd", "-o", "program.nrrd")

    async def work():
        async with Page(server) as page:
            asked = {"operation": "calc", "dataset": "ball", "inputs": {"a": "ball", "b": "ramp"}, "parameters": {"formula": "b - 2*a"}}
            lines = (await page.ask("command", **asked))["text"]
            made = (await page.ask("run", **asked))["dataset"]
            await page.until(lambda: made in page.world["world"]["datasets"])
            return page.world["world"]["datasets"][made], lines
    with Server("ball.nrrd", "ramp.nrrd") as server:
        dataset, lines = run(work())
        with open(dataset["path"], "rb") as page, open("program.nrrd", "rb") as program:
            assert page.read() == program.read()
    done = subprocess.run(["sh", "-c", lines.replace("volvis ", f"{VOLVIS} ", 1)], capture_output=True, text=True)
    assert done.returncode == 0, (lines, done.stderr)
    with open("result.nrrd", "rb") as again, open("program.nrrd", "rb") as program:
        assert again.read() == program.read()


def test_parameters_that_are_no_object_are_a_sentence():
    write_ball("ball.nrrd", 16)

    async def work():
        async with Page(server, 64, 64) as page:
            for kind in ("run", "command"):
                for found in (5, "text", [], None):
                    said = await page.answer(kind, operation="gaussian", dataset="ball", parameters=found)
                    assert not said["ok"] and said["error"].startswith("expected an object"), said
    with Server("ball.nrrd") as server:
        run(work())


def test_the_histogram_is_that_of_values_that_pictures_show():
    z, y, x = np.meshgrid(*3 * [np.linspace(-1, 1, 24)], indexing="ij")
    inside = x * x + y * y + z * z < 0.8
    values = np.where(inside, 290 + 20 * x * y, -9999).astype("f4")
    np.save("dem.npy", values)

    async def work():
        async with Page(server) as page:
            found = await page.ask("histogram", volume="dem")
            assert abs(found["min"] - values[inside].min()) < 1e-3 and found["lo"] > 200, found
            assert found["n"] == sum(found["counts"]) == inside.sum()
            await page.edit(("set", "volumes.dem.missing", []))
            whole = await page.ask("histogram", volume="dem")
            assert whole["min"] == -9999 and whole["n"] == values.size, whole
    with Server("dem.npy") as server:
        run(work())


main()
