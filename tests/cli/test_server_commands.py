"""Each line that a page offers to copy, run as it is, makes what the page shows: data byte for byte, pictures pixel for pixel."""
import io
import os
import re
import shlex
import shutil
import subprocess

import numpy as np
from PIL import Image

from harness import VOLVIS, Skip, environment, main, ok, says, write_ball, write_labels, write_named_cells, write_nrrd
from measure_inputs import distance_to, noise, write, write_box, write_sphere

try:
    from page import Page, Server, run
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")
try:
    import nibabel as nib
except ImportError:
    nib = None

# what an operation does nothing without, or what is not easily written: units, rows, spaces, ranges with one end
PARAMETERS = {
    "crop": [{"x": "2..9", "z": "1:"}], "flip": [{"axes": "xz"}], "channel": [{"components": "0"}], "reorient": [{"order": "zyx"}],
    "resample": [{"spacing": "2vox"}, {"dims": [7, 8, 9], "interpolation": "cubic"}], "rescale": [{"type": "u8", "percentile": [1, 99]}, {"from": [20, 80.5], "to": [0, 1], "type": "f32"}],
    "gaussian": [{"sigma": "1vox"}, {"sigma": "1.3mm"}], "threshold": [{"range": "40.."}, {"method": "otsu"}, {"method": "hysteresis", "range": "20..", "strong": "70.."}, {"method": "otsu", "range": "40.."}],
    "clamp": [{"range": "..60.25"}], "pad": [{"all": "2", "x": "1,3"}], "calc": [{"formula": "a * (a > 50) + 1"}, {"formula": "a / 2", "unit": "kg / m"}],
    "grow": [{"seed": [6, 5, 5], "range": "30.."}], "isosurface": [{"iso": [40]}, {"iso": [30, 60.5], "normals": False}], "project": [{}, {"slab": "4vox"}],
    "median": [{"radius": 1}], "dilate": [{"radius": 2}], "components": [{"range": "40..", "min_size": "3 mm"}], "distance": [{"range": "40.."}],
}


def rows(takes):
    """Operations of one such input, and whether they make meshes."""
    return {row["name"]: row["makes"] == "mesh" for row in ok("operations", "--json").json["operations"]
            if row["min_inputs"] == 1 and row["inputs"][0]["takes"] == takes}


def run_lines(lines):
    """As a shell runs what was pasted into it: what they write is below `lines`, and the files that they read are here."""
    shutil.rmtree("lines", ignore_errors=True)
    os.mkdir("lines")
    for name in os.listdir("."):
        if name not in ("lines", "state"):
            os.symlink(os.path.abspath(name), f"lines/{name}")
    script = f'set -e\nvolvis() {{ "{VOLVIS}" "$@"; }}\n{lines}\n'
    return subprocess.run(["sh", "-c", script], cwd="lines", capture_output=True, text=True, env=environment(), check=False)


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def output_of(lines):
    """The file that the last line writes."""
    return "lines/" + re.findall(r"-o '?([^' ]+)'?", lines)[-1]


def agrees(lines, wanted, what):
    done = run_lines(lines)
    assert done.returncode == 0, (what, lines, done.stderr)
    assert bytes_of(output_of(lines)) == wanted, (what, lines)


def refuses(lines, what):
    done = run_lines(lines)
    assert done.returncode != 0, (what, lines)


async def write_made(page, dataset, like):
    path = os.path.abspath("page" + os.path.splitext(like)[1])
    await page.ask("write", dataset=dataset, path=path, replace=True)
    return bytes_of(path)


async def check_run(page, operation, dataset, parameters, inputs=None):
    """The lines before it is run, those of the dataset that it makes, and the chain of that; its id, or None where it is refused."""
    asked = {"operation": operation, "dataset": dataset, "parameters": parameters, **({"inputs": inputs} if inputs else {})}
    before = await page.answer("command", **asked)
    made = await page.answer("run", **asked)
    what = (operation, dataset, parameters)
    if not made["ok"]:
        if before["ok"]:
            refuses(before["value"]["text"], (*what, made["error"]))
        return None
    assert before["ok"], (what, before)
    lines = before["value"]["text"]
    wanted = await write_made(page, made["value"]["dataset"], output_of(lines))
    agrees(lines, wanted, what)
    pipe = await page.answer("command", form="pipe", dataset=made["value"]["dataset"])
    if pipe["ok"]:
        agrees(pipe["value"]["text"], wanted, what)
    else:
        says(pipe["error"], "cannot name as a file")
    return made["value"]["dataset"]


def all_operations(path, *words):
    """Each operation of one volume on a file: how many were made."""
    names = list(rows("volume"))

    async def work():
        n = 0
        async with Page(server, 32, 32) as page:
            source = next(iter(page.world["world"]["datasets"]))
            for name in names:
                for parameters in PARAMETERS.get(name, [{}]):
                    if await check_run(page, name, source, parameters):
                        n += 1
                        await page.ask("undo")
        return n
    with Server(path, *words) as server:
        return run(work())


def write_nifti(path, frames=1):
    if nib is None:
        raise Skip("nibabel is missing: skipped")
    shape = (12, 11, 10) + ((frames,) if frames > 1 else ())
    x, y, z, t = np.meshgrid(*(np.arange(n) for n in (shape + (1,))[:4]), indexing="ij")
    values = (100 * np.exp(-((x - 6) ** 2 + (y - 5) ** 2 + (z - 5) ** 2) / 9) * (t + 1)).reshape(shape).astype("i2")
    image = nib.Nifti1Image(values, np.array([[-2.0, 0, 0, 90], [0, 2.5, 0, -126], [0, 0, 1.5, -72], [0, 0, 0, 1]]))
    image.header.set_xyzt_units("mm", "sec")
    nib.save(image, path)


def test_lines_of_every_operation_on_a_volume():
    write_ball("ball.nrrd", 12, spacing=(1, 1.5, 2))
    assert all_operations("ball.nrrd") > 30


def test_lines_of_every_operation_on_a_series():
    write_nifti("t.nii.gz", 3)
    assert all_operations("t.nii.gz") > 30


def test_lines_of_every_operation_on_labels():
    write_labels()
    assert all_operations("organs.seg.nrrd") > 10


def test_lines_of_every_operation_on_channels():
    write_named_cells()
    assert all_operations("cells.nrrd") > 10


def test_lines_of_files_that_are_read_in_a_way_that_is_said():
    values = noise("int16", (9, 10, 11))
    values.tofile("scan.dat")
    assert all_operations("scan.dat", "--raw", "11x10x9,i16,spacing=1x1x2") > 30


def test_lines_of_several_inputs():
    write_ball("ball.nrrd", 12)
    write_nrrd("ramp two.nrrd", (12, 12, 12), lambda x, y, z: 10 * x + y)
    write("mask.nrrd", (distance_to(12, (5, 5, 5)) < 4).astype(np.uint8))
    (np.arange(12 ** 3) % 251).astype(np.uint8).tofile("raw.dat")
    wanted = (
        ("mask", {}, {"mask": "mask"}), ("match", {}, {"reference": "ramp_two"}), ("resample", {}, {"onto": "mask"}), ("bias", {}, {"mask": "mask"}),
        ("isosurface", {"iso": [50]}, {"values": "ramp_two"}), ("watershed", {}, {"mask": "mask"}),
        ("merge", {}, {"a": "ball", "b": "ramp_two"}), ("merge", {"names": "gray matter,white matter"}, {"a": "ball", "b": "ramp_two"}),
        ("calc", {"formula": "b - 2 * a"}, {"a": "ball", "b": "ramp_two"}), ("calc", {"formula": "q - p", "names": "p,q"}, {"a": "ball", "b": "ramp_two"}),
        ("calc", {"formula": "bone - soft", "unit": "it's"}, {"soft": "ball", "bone": "ramp_two"}), ("join", {"period": 2, "period_unit": "s"}, {"a": "ball", "b": "ramp_two"}),
        ("calc", {"formula": "b + a"}, {"a": "ball", "b": "raw"}), ("match", {}, {"reference": "raw"}),
    )

    async def work():
        async with Page(server, 32, 32) as page:
            names = {data["path"].split("/")[-1]: name for name, data in page.world["world"]["datasets"].items()}
            await page.ask("edit", edits=[{"op": "add", "path": "datasets", "id": "raw", "value": {"path": "raw.dat", "raw": "12x12x12,u8"}}])
            ids = {"ball": names["ball.nrrd"], "ramp_two": names["ramp two.nrrd"], "mask": names["mask.nrrd"], "raw": "raw"}
            for operation, parameters, inputs in wanted:
                made = await check_run(page, operation, ids["ball"], parameters, {name: ids[data] for name, data in inputs.items()})
                assert made, (operation, parameters)
                await page.ask("undo")
    with Server("ball.nrrd", "ramp two.nrrd", "mask.nrrd") as server:
        run(work())


def test_names_that_are_given_are_those_of_channels():
    write_ball("ball.nrrd", 8)

    async def work():
        async with Page(server, 32, 32) as page:
            made = (await page.ask("run", operation="merge", dataset="ball", inputs={"a": "ball", "b": "ball"}, parameters={"names": "gray matter,white matter"}))["dataset"]
            await page.ask("write", dataset=made, path=os.path.abspath("made.nrrd"))
    with Server("ball.nrrd") as server:
        run(work())
    says(ok("info", "made.nrrd").text, "gray matter", "white matter")


def test_lengths_are_copied_as_they_were_typed():
    write_ball("ball.nrrd", 16)

    async def work():
        async with Page(server, 32, 32) as page:
            a = await check_run(page, "gaussian", "ball", {"sigma": "2mm"})
            says((await page.ask("command", dataset=a))["text"], "--sigma='2mm'")
            await page.edit(("set", f"datasets.{a}.parameters.sigma", "6mm"))
            says((await page.ask("command", dataset=a))["text"], "--sigma='6mm'")
            says((await page.ask("command", form="pipe", dataset=a))["text"], "gaussian --sigma=6mm")
            await page.edit(("set", f"datasets.{a}.parameters.sigma", 3))
            says((await page.ask("command", dataset=a))["text"], "--sigma='3'")
    with Server("ball.nrrd") as server:
        run(work())


def test_lines_of_chains_and_of_what_stands_on_several():
    write_nifti("t.nii")

    async def work():
        async with Page(server, 32, 32) as page:
            a = await check_run(page, "gaussian", "t", {"sigma": "1.5vox"})
            b = await check_run(page, "calc", a, {"formula": "a * 1.1"}, {"a": a})
            c = await check_run(page, "threshold", b, {"range": "30.."})
            d = await check_run(page, "mask", b, {}, {"mask": c})
            e = await check_run(page, "components", c, {})
            assert a and b and c and d and e
            await page.edit(("set", f"datasets.{a}.on", False))
            assert await check_run(page, "dilate", c, {"radius": 1})
            said = await page.ask("command", form="chain", dataset=c)
            assert said["text"].count("|") == 1, said
            for edits, words in (((("set", f"datasets.{b}.on", False), ("set", f"datasets.{c}.on", False)), "no operation is applied"),):
                await page.edit(*edits)
                says(await page.refused("command", form="chain", dataset=c), words)
            says(await page.refused("command", form="pipe", dataset="nobody"), "nobody")
            says(await page.refused("command", form="rings", dataset=c), "'form' must be")
    with Server("t.nii") as server:
        run(work())


def test_lines_of_every_operation_on_meshes_and_chains_of_them():
    write_ball("ball.nrrd", 16, spacing=(1, 1.5, 2))
    write_labels()
    names = list(rows("mesh"))
    more = {"simplify": [{"share": 0.4}, {"share": 0.3, "fix_border": True}], "smooth": [{}, {"iterations": 5}]}

    async def work():
        async with Page(server, 32, 32) as page:
            ids = list(page.world["world"]["datasets"])
            for source, parameters in ((ids[0], {"iso": [60]}), (ids[0], {"iso": [40, 80], "cap": True}), (ids[1], {})):
                first = await check_run(page, "isosurface", source, parameters)
                assert first, source
                for name in names:
                    for own in more.get(name, [{}]):
                        second = await check_run(page, name, first, own)
                        assert second, (source, name)
                        assert await check_run(page, names[0], second, {"share": 0.5} if names[0] == "simplify" else {})
    with Server("ball.nrrd", "organs.seg.nrrd") as server:
        run(work())


def asked(words):
    """What the program says, without what names the run."""
    found = ok(*words, "--json").json
    return {key: value for key, value in found.items() if key not in ("volvis", "command", "measured", "file", "warnings")}


def words_of(line):
    return shlex.split(line.split("#")[0])[1:]


async def check_measured(page, name, question, **data):
    """What comes out in the page, and by its line: one of the file, or of the scene that is saved first."""
    found = await page.ask("measure", question={k: v for k, v in question.items() if k != "volume"}, **data)
    value = {**question, "figures": found["figures"]}
    await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": name, "value": value}])
    line = (await page.ask("command", measurement=name))["text"]
    words = words_of(line.split("\n")[-1])
    if words[1] == "stored":
        await page.ask("save", path=os.path.abspath("scene.vv.json"), replace=True)
        says(ok(*words).text, f"{name}: ", ", as before", "1 measured, 0 changed")
    else:
        lines = line.split("\n")
        for before in lines[:-1]:
            done = run_lines(before.replace("-o ", "--overwrite -o "))
            assert done.returncode == 0, (line, done.stderr)
            if not os.path.exists(os.path.basename(output_of(before))):
                shutil.copy(output_of(before), ".")
        found["answer"].pop("mesh", None)  # its name in the World
        assert asked(words_of(lines[-1])) == found["answer"], (name, line)
    return words[1]


POINTS = [[0.25, 1, 2], [20, 11, 5], [1, 1, 1]]
QUESTIONS = {
    "summary": {"what": "summary"}, "area": {"what": "area", "iso": 0.5, "closed": True}, "volume": {"what": "volume", "threshold_lo": -1, "threshold_hi": 2.75, "method": "count"},
    "box": {"what": "box", "iso": 1, "seed": [11, 12, 12]}, "statistics": {"what": "statistics", "box": "2..20,..,3..9"}, "histogram": {"what": "histogram", "bins": 12, "range": [[-3.5, 4]]},
    "profile": {"what": "profile", "points": POINTS[:2], "samples": 9}, "distance": {"what": "distance", "points": POINTS[:2], "space": "world"},
    "polyline": {"what": "distance", "points": POINTS}, "angle": {"what": "angle", "points": POINTS}, "geodesic": {"what": "geodesic", "iso": 0, "points": [[4, 12, 12], [12, 12, 18]]},
    "joint": {"what": "joint", "bins": 6}, "point": {"what": "point", "points": [[3.5, 1, 2]]}, "to_surface": {"what": "distance", "iso": 0, "points": [[1, 1, 1]]},
    "ellipse": {"what": "statistics", "region": {"kind": "ellipse", "center": [10, 9, 8], "size": [12, 9, 0], "normal": [0.5, 0, 1]}},
    "cut": {"what": "volume", "iso": 0, "cut_planes": [{"normal": [1, 2, 0], "offset": 5}]},
}


def test_lines_of_every_kind_of_measurement():
    write_sphere("ball.nrrd", 24, 8.0, (11.3, 12.1, 11.8), spacing=(0.5, 0.5, 0.7))
    write_labels()
    write_box("a.stl")
    kinds = {row["name"] for row in ok("schema", "--tables").json["measures"]}
    assert {q["what"] for q in QUESTIONS.values()} == kinds - {"labels"}, kinds

    async def volume(page):
        lines = [await check_measured(page, name, question) for name, question in QUESTIONS.items()]
        assert "stored" not in lines, lines
        made = (await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"}))["dataset"]
        assert made
        for name in ("volume", "statistics", "histogram"):
            assert await check_measured(page, f"made_{name}", QUESTIONS[name]) == name
        await page.edit(("set", "volumes.ball.place.scale", [2, 1, 1]))
        assert await check_measured(page, "moved", {"what": "volume", "iso": 0}) == "stored"

    async def labels(page):
        assert await check_measured(page, "all", {"what": "labels"}) == "labels"
        assert await check_measured(page, "part", {"what": "labels", "box": "2..18,..,..", "cut_planes": [{"normal": [1, 2, 0], "offset": 5}]}) == "labels"
        for what in ("volume", "summary", "histogram", "statistics"):
            assert await check_measured(page, f"one_{what}", {"what": what, "label": 7}) == what

    async def mesh(page):
        for what in ("area", "volume", "box", "summary"):
            assert await check_measured(page, what, {"what": what}) == what
        assert await check_measured(page, "point", {"what": "distance", "points": [[5, 1, 1]]}) == "distance"
        await page.edit(("set", "volumes.a.place.scale", [2, 1, 1]))
        assert await check_measured(page, "moved", {"what": "area"}) == "stored"

    for act, file in ((volume, "ball.nrrd"), (labels, "organs.seg.nrrd"), (mesh, "a.stl")):
        async def work():
            async with Page(server, 64, 64) as page:
                await act(page)
        with Server(file) as server:
            run(work())


def test_lines_of_measurements_of_a_series_say_its_time_step():
    write_nifti("t.nii", 3)

    async def work():
        async with Page(server, 64, 64) as page:
            for frame in (0, 2):
                if frame:
                    await page.edit(("set", "volumes.t.frame", frame))
                found = await page.ask("measure", question={"what": "statistics"})
                assert found["answer"]["time_step"] == frame, found["answer"]
                assert {"name": "time_step", "value": frame} in found["figures"], found["figures"]
                want = ok("measure", "statistics", f"t.nii@{frame}", "--json").json
                assert want["time_step"] == frame and want["mean"] == found["answer"]["mean"], (frame, want)
                await check_measured(page, f"at_{frame}", {"what": "statistics"})
    with Server("t.nii") as server:
        run(work())


def pixels_of(file):
    return np.asarray(Image.open(file).convert("RGBA")).astype(int)


async def page_picture(page, server, name):
    """What the page saves as a picture of its view; None: it is refused."""
    answer = await page.answer("picture", width=page.size[0], height=page.size[1], name=f"{name}.png")
    if not answer["ok"]:
        return None
    code, _, body = server.request(answer["value"]["url"], Cookie=server.cookie())
    assert code == 200, body
    return pixels_of(io.BytesIO(body))


async def check_picture(page, server, what):
    """The line of the view that the page saves, to the pixel; or of the scene, where that is saved first."""
    lines = (await page.ask("command"))["text"]
    if "#" in lines:
        await page.ask("save", path=os.path.abspath("scene.vv.json"), replace=True)
    wanted = await page_picture(page, server, "view")
    done = run_lines(lines)
    assert (done.returncode == 0) == (wanted is not None), (what, lines, done.stderr)
    if wanted is None:
        return lines
    found = pixels_of("lines/picture.png")
    assert found.shape == wanted.shape, (what, lines, found.shape, wanted.shape)
    assert np.array_equal(found, wanted), (what, lines, int(np.abs(found - wanted).max()), int((found != wanted).any(axis=2).sum()))
    return lines


def test_lines_of_pictures_with_measurements_series_several_volumes_and_meshes():
    write_ball("ball.nrrd", 24, spacing=(1, 1.5, 2))
    write_nrrd("ramp.nrrd", (24, 24, 24), lambda x, y, z: 10 * x)
    write_nifti("t.nii", 3)

    async def measured(page, server):
        await page.ask("edit", edits=[{"op": "add", "path": "measurements", "id": "length", "value": {"what": "distance", "points": [[0, 0, 0], [20, 20, 20]], "figures": [{"name": "distance", "value": 50, "unit": "mm"}]}}])
        says(await check_picture(page, server, "measured"), "scene.vv.json")
        await page.edit(("set", "measurements.length.visible", False))
        says(await check_picture(page, server, "hidden"), "volvis render 'ball.nrrd'")

    async def series(page, server):
        await page.edit(("set", "volumes.t.frame", 2))
        await check_picture(page, server, "frame")
        await page.ask("run", operation="gaussian", dataset="t", parameters={"sigma": "1vox"})
        await check_picture(page, server, "frame of what is made")

    async def several(page, server):
        await check_picture(page, server, "two volumes")
        ids = list(page.world["world"]["volumes"])
        await page.edit(("remove", f"volumes.{ids[1]}"))
        await check_picture(page, server, "one of two")

    async def mesh(page, server):
        first = (await page.ask("run", operation="isosurface", dataset="t", parameters={"iso": [40.5]}))["dataset"]
        await check_picture(page, server, "a mesh")
        await page.ask("run", operation="smooth", dataset=first, parameters={})
        await check_picture(page, server, "a mesh of a mesh")
        await page.edit(("set", "cut_planes", [{"normal": [1, 0, 0], "offset": 80}]))
        await check_picture(page, server, "a cut mesh")

    for act, files in ((measured, ("ball.nrrd",)), (series, ("t.nii",)), (several, ("ball.nrrd", "ramp.nrrd")), (mesh, ("t.nii",))):
        async def work():
            async with Page(server, 96, 64) as page:
                await page.resting()
                await act(page, server)
        with Server(*files) as server:
            run(work())


def test_lines_of_pictures_are_the_pictures():
    write_ball("ball.nrrd", 24, spacing=(1, 1.5, 2))
    write_labels()
    write_named_cells()
    methods = [row["name"] for row in ok("methods", "--json").json["methods"]]
    looks = {
        "as it is": (), "cut": (("set", "cut_planes", [{"normal": [1, 2, 0.5], "offset": 5}]),), "background": (("set", "background", "#204060"),),
        "threshold": (("set", "volumes.{id}.segmentation.kind", "threshold"), ("set", "volumes.{id}.segmentation.threshold.lo", 60.5)),
        "curve": (("set", "volumes.{id}.segmentation.transfer.opacity", [[10, 0], [90.25, 0.3], [255, 1]]), ("set", "volumes.{id}.segmentation.transfer.colormap", "viridis")),
        "light": (("set", "lights.key.intensity", 0.25), ("set", "volumes.{id}.shading.ambient", 0.5)),
        "moved": (("set", "volumes.{id}.place.rotation", [10, 20, 30]), ("set", "title", "a ball's picture")),
        "letters": (("set", "views.{view}.decorations.axes", True), ("set", "views.{view}.decorations.scale_bar", True)),
    }

    def words(path, page, source):
        return path.replace("{id}", source).replace("{view}", next(iter(page.world["world"]["views"])))

    for file in ("ball.nrrd", "organs.seg.nrrd", "cells.nrrd"):
        async def work():
            async with Page(server, 96, 64) as page:
                source = next(iter(page.world["world"]["volumes"]))
                await page.say("camera", eye=[90, -120, 60], at=[10, 12, 9], up=[0, 0, 1])
                await page.resting()
                for what, edits in looks.items():
                    answer = await page.answer("edit", edits=[dict(zip(("op", "path", "value"), (op, words(path, page, source), value))) for op, path, value in edits]) if edits else {"ok": True}
                    assert answer["ok"], (what, answer)
                    await check_picture(page, server, (file, what))
                    if edits:
                        await page.ask("undo")
                for name in methods:
                    await page.edit(("set", words("views.{view}.render.method", page, source), name))
                    await check_picture(page, server, (file, name))
                await page.edit(("unset", words("views.{view}.render.method", page, source)))
                await page.ask("run", operation="gaussian", dataset=next(iter(page.world["world"]["datasets"])), parameters={"sigma": "1vox"}) if file == "ball.nrrd" else None
                await check_picture(page, server, (file, "made"))
        with Server(file) as server:
            run(work())


main()
