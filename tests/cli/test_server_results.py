"""What the page makes of a file and writes is what the program makes of it, byte for byte: with names, colours, codes, time steps."""
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
              "watershed", "voxelize"}


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


async def write(page, dataset, path):
    """A dataset of the World as a file, in the place of what is there."""
    assert (await page.ask("write", dataset=dataset, path=os.path.abspath(path), replace=True))["path"] == os.path.abspath(path)
    return path


async def by_page(page, operation, dataset, out, notes):
    """Whether the page's server makes it, and writes it."""
    before = page.world["world"]
    answer = await page.answer("run", operation=operation, dataset=dataset, parameters=PARAMETERS.get(operation, {}))
    if not answer["ok"]:
        await page.heard()
        assert page.world["world"] == before, operation
        return False
    made = answer["value"]["dataset"]
    notes[operation] = answer["value"].get("note", "")
    await page.until(lambda: made in page.world["world"]["datasets"])
    assert "path" not in page.world["world"]["datasets"][made]
    return await write(page, made, out)


def rows(takes):
    """Operations of one such input, and whether they make meshes."""
    return {row["name"]: row["makes"] == "mesh" for row in ok("operations", "--json").json["operations"]
            if row["min_inputs"] == 1 and row["inputs"][0]["takes"] == takes}


def results(path, notes=None, samples=".nrrd"):
    """Every operation of one volume on a file, compared; the files that the page has written, by operation."""
    files, notes = {name: name + (".ply" if mesh else samples) for name, mesh in rows("volume").items()}, {} if notes is None else notes

    async def work():
        made = {}
        async with Page(server) as page:
            name = next(iter(page.world["world"]["datasets"]))
            for operation, out in files.items():
                if await by_page(page, operation, name, out, notes):
                    made[operation] = out
        return made
    with Server(path) as server:
        made = run(work())
    assert not [name for folder, _, names in os.walk("state") for name in names if "result" in os.path.join(folder, name)]
    for operation, out in files.items():
        wanted = by_program(operation, path, out)
        assert (operation in made) == (wanted is not None), operation
        if wanted is not None:
            with open(out, "rb") as opened:
                assert opened.read() == wanted, operation
    return made


def header(path):
    with open(path, "rb") as file:
        return file.read().split(b"\n\n")[0].decode()


def test_a_nifti_stays_one_with_its_codes_and_texts():
    write_nifti("t.nii")
    made = results("t.nii", samples=".nii")
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
    made = results("t.nii", notes, ".nii")
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
            if operation == "voxelize":  # a solid on their grid is none of them
                assert "nuclei" not in header(file) and "membrane" not in header(file), path
            elif file.endswith(".nrrd"):
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
            both = (await page.ask("run", operation="calc", dataset=second, inputs={"a": second, "b": second}, parameters={"formula": "a + b"}))["dataset"]
            await write(page, second, "second.nii")
            await write(page, both, "both.nii")
            return lines
    with Server("t.nii.gz") as server:
        lines = run(work())
    ok("crop", "t.nii.gz", "--x", "2:", "-o", "a.nii")
    ok("flip", "a.nii", "--axes", "y", "-o", "b.nii")
    ok("calc", "a + b", "b.nii", "b.nii", "-o", "c.nii")
    for page, program in (("second.nii", "b.nii"), ("both.nii", "c.nii")):
        with open(page, "rb") as one, open(program, "rb") as other:
            assert one.read() == other.read(), page
    out = nib.load("second.nii").header
    assert out["sform_code"] == 4 and b"contrast 3" in bytes(out["descrip"])
    assert [line.split()[1] for line in lines.split("\n")] == ["crop", "flip", "crop"] and lines.endswith(".nii'"), lines


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
            await write(page, made, "page.ply")
            return page.world["world"]["datasets"][made], lines
    with Server("ball.nrrd", "ramp.nrrd") as server:
        dataset, lines = run(work())
    with open("page.ply", "rb") as page, open("program.ply", "rb") as program:
        assert page.read() == program.read()
    assert dataset == {"operation": "isosurface", "inputs": {"volume": "ball", "values": "ramp"}}, dataset
    says(lines, "volvis pipe ", "'isosurface values=", "ramp.nrrd | simplify' -o 'result.ply'")


def test_formulas_speak_of_inputs_by_their_names():
    write_ball("ball.nrrd", 24)
    write_nrrd("ramp.nrrd", (24, 24, 24), lambda x, y, z: x)
    ok("calc", "b - 2*a", "a=ball.nrrd", "b=ramp.nrrd", "-o", "program.nrrd")

    async def work():
        async with Page(server) as page:
            asked = {"operation": "calc", "dataset": "ball", "inputs": {"a": "ball", "b": "ramp"}, "parameters": {"formula": "b - 2*a"}}
            lines = (await page.ask("command", **asked))["text"]
            made = (await page.ask("run", **asked))["dataset"]
            await write(page, made, "page.nrrd")
            return lines
    with Server("ball.nrrd", "ramp.nrrd") as server:
        lines = run(work())
    with open("page.nrrd", "rb") as page, open("program.nrrd", "rb") as program:
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


def test_files_are_written_where_and_as_they_may_be():
    write_ball("ball.nrrd", 16)
    os.makedirs("shared/inside")
    os.rename("ball.nrrd", "shared/ball.nrrd")
    here = os.path.abspath("shared")

    async def work():
        async with Page(server, 64, 64) as page:
            made = (await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"}))["dataset"]
            for path, words in (("/tmp/x.nrrd", "there is no such"), ("../x.nrrd", "there is no such"), ("inside/", "name of a file"),
                                ("x.ply", "suffix of a mesh"), ("x.xyz", "no suffix that a format writes"), ("x.vv.json", "suffix"),
                                ("ball.nrrd", "is the file of the dataset 'ball'"), ("none/x.nrrd", "there is no such")):
                says(await page.refused("write", dataset=made, path=path, replace=True), words)
            says(await page.refused("write", dataset="nobody", path="x.nrrd"), "no dataset 'nobody'")
            says(await page.refused("write", path="x.nrrd"), "needs a dataset and a path")
            assert sorted(os.listdir(here)) == ["ball.nrrd", "inside"] and not os.listdir(f"{here}/inside")
            assert await page.ask("write", dataset=made, path="inside/x.nrrd") == {"path": "/inside/x.nrrd"}
            again = await page.answer("write", dataset=made, path="inside/x.nrrd")
            assert again["reason"] == "exists" and "already exists" in again["error"], again
            with open(f"{here}/inside/x.nrrd", "rb") as file:
                smooth = file.read()
            await page.edit(("set", f"datasets.{made}.parameters.sigma", "2vox"))
            await page.ask("write", dataset=made, path="inside/x.nrrd", replace=True)
            with open(f"{here}/inside/x.nrrd", "rb") as file:
                assert file.read() != smooth
            await page.ask("write", dataset="ball", path="inside/as_it_is.npy")  # what is not made too
            with open(f"{here}/notes.raw", "w", encoding="ascii") as file:
                file.write("precious")
            os.symlink("ball.nrrd", f"{here}/link.nrrd")
            os.mkfifo(f"{here}/pipe.nrrd")
            for path, words in (("notes.mhd", "may be the data of another header"), ("link.nrrd", "is the file of the dataset 'ball'"),
                                ("pipe.nrrd", "neither a file nor a folder")):
                said = await page.refused("write", dataset=made, path=path, replace=path != "notes.mhd")
                assert words in said and "--" not in said, said  # options are words of the program
            says(await page.refused("save", path="pipe.nrrd/x", replace=True), "there is no such")
            os.mkfifo(f"{here}/pipe.vv.json")
            says(await page.refused("save", path="pipe.vv.json", replace=True), "neither a file nor a folder")
            with open(f"{here}/notes.raw", encoding="ascii") as file:
                assert file.read() == "precious"
            await page.ask("write", dataset="ball", path="own.mhd")
            says(await page.refused("write", dataset=made, path="own.raw", replace=True), "own.mhd")
            assert any(m["type"] == "job" and m["name"] == "write" and m["state"] == "done" for m in page.messages)
    with Server(verb="serve", *("--root", "shared", "shared/ball.nrrd")) as server:
        run(work())
    assert np.array_equal(np.load(f"{here}/inside/as_it_is.npy").shape, (16, 16, 16))
    ok("gaussian", "shared/ball.nrrd", "--sigma", "2vox", "-o", "truth.nrrd")
    with open("truth.nrrd", "rb") as truth, open(f"{here}/inside/x.nrrd", "rb") as file:
        assert truth.read() == file.read()

    async def look():
        async with Page(server, 64, 64) as page:
            says(await page.refused("write", dataset="ball", path="y.nrrd"), "--read-only")
    with Server(verb="serve", *("--root", "shared", "--read-only", "shared/ball.nrrd")) as server:
        run(look())
    assert not os.path.exists("shared/y.nrrd")


def test_many_operations_leave_a_session_as_small_as_it_was():
    write_ball("ball.nrrd", 48)  # 110 kB each time, as a file

    def written():
        return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk("state") for name in names)

    async def work():
        async with Page(server, 64, 64) as page:
            await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"})
            await page.ask("undo")
            before = written()
            for i in range(40):
                await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": f"{1 + i / 40:.3f}vox"})
                await page.ask("undo")
            await page.heard()
            return before, written()
    with Server("ball.nrrd") as server:
        before, after = run(work())
        assert after - before < 40 * 1000, (before, after)  # lines of the journal


def test_an_operation_that_fails_adds_nothing_and_one_that_is_cancelled_too():
    write_ball("ball.nrrd", 32)

    async def work():
        async with Page(server, 64, 64) as page:
            await page.resting()
            before = page.world["world"]
            for asked, words in ((("isosurface", {"iso": 1000}), "no triangles"), (("gaussian", {"sigma": "1s"}), "sigma"),
                                 (("gaussian", {"sgma": 1}), "did you mean 'sigma'"), (("resample", {"spacing": "0.02vox"}), "memory"),
                                 (("resample", {"spacing": "1e-5vox"}), "samples"), (("smooth", {}), "takes a mesh, and 'ball' is a volume")):
                said = await page.refused("run", operation=asked[0], dataset="ball", parameters=asked[1])
                says(said, words)
                assert "datasets." not in said, said
            await page.say("run", id=5000, operation="bilateral", dataset="ball", parameters={"sigma": "12vox", "value_sigma": 50})
            job = await page.until(lambda: next((m for m in page.messages if m["type"] == "job" and m["name"] == "bilateral"), None))
            await page.ask("cancel", job=job["job"])
            await page.until(lambda: any(m["type"] == "answer" and m["id"] == 5000 and not m["ok"] for m in page.messages))
            says(await page.refused("undo"), "nothing")
            await page.heard()
            assert page.world["world"] == before
    with Server("ball.nrrd", "--memory", "300M") as server:
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
