"""Labels whose ids are one double and two integers: told apart wherever labels are used; truth is numpy's integers."""
import csv
import io
import json
import os
import numpy as np
from PIL import Image

from harness import fails, main, ok, says, volvis
from harness import write_labels as write_organs

# name: samples, two ids that float64 takes for one
CASES = {"far": ("u8", (864691135000000001, 864691135000000002)),
         "below": ("i8", (-864691135000000001, -864691135000000002)),
         "top": ("u8", (2**64 - 2, 2**64 - 1))}
TYPES = {"u1": "uint8", "u4": "uint32", "u8": "uint64", "i8": "int64"}
SIZES = (288, 480)  # samples of the two
GREYS = {(v, v, v) for v in range(256)}
RED, BLUE = "1 0 0", "0 0 1"


def cells(kind, ids):
    """Two boxes side by side, 0 around them."""
    labels = np.zeros((12, 14, 24), kind)
    labels[3:9, 3:11, 4:10] = np.array(ids[0], kind)
    labels[3:9, 3:11, 10:20] = np.array(ids[1], kind)
    return labels


def write_labels(name, kind, ids, named=False, mins="0 0 0"):
    labels, path = cells(kind, ids), name + ".nrrd"
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: {TYPES[kind]}\ndimension: 3\nsizes: 24 14 12\nspacings: 1 1 1\naxis mins: {mins}\nencoding: raw\n"
                   f"endian: little\nvolvis meaning:=label\n".encode())
        for i, label in enumerate(ids if named else ()):
            file.write(f"Segment{i}_ID:=s{i}\nSegment{i}_LabelValue:={label}\nSegment{i}_Name:={'one two'.split()[i]}\n"
                       f"Segment{i}_Color:={(RED, BLUE)[i]}\n".encode())
        file.write(b"\n" + labels.astype("<" + kind).tobytes())
    return path, labels


def each(**more):
    for name, (kind, ids) in CASES.items():
        assert float(ids[0]) == float(ids[1])
        yield (name, ids, *write_labels(name, kind, ids, **more))


def colors(path):
    return {tuple(p) for p in np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).tolist()}


def test_they_are_counted_apart():
    small, _ = write_labels("small", "u1", (1, 2))
    areas = {row["count"]: row["area"] for row in ok("measure", "labels", small, "--json").json["labels"]}
    for name, ids, path, labels in each():
        found = ok("measure", "labels", path, "--json").json["labels"]
        assert [(row["label"], row["count"]) for row in found] == sorted(zip(ids, SIZES)), name
        assert {row["count"]: row["area"] for row in found} == areas, name
        rows = csv.DictReader(io.StringIO(ok("measure", "labels", path, "--csv").text))
        assert [int(row["label"]) for row in rows] == sorted(ids)
        counted = ok("info", path, "--stats", "--json").json["labels"]
        truth = zip(*(part.tolist() for part in np.unique(labels, return_counts=True)))
        assert [(row["value"], row["count"]) for row in counted] == list(truth), name
        for label, n in zip(ids, SIZES):
            assert ok("measure", "volume", path, f"--label={label}", "--json").json["volume"] == n, (name, label)


def test_values_are_those_of_each():
    values = np.random.default_rng(3).integers(0, 200, (12, 14, 24)).astype("u1")
    np.save("values.npy", values)
    for name, _, path, labels in each():
        for row in ok("measure", "labels", path, "--values", "values.npy", "--json").json["labels"]:
            inside = values[labels == np.array(row["label"], labels.dtype)]
            assert abs(row["mean"] - inside.mean()) < 1e-9 and row["median"] == np.median(inside), (name, row)


def test_they_have_surfaces_of_their_own():
    for name, ids, path, _ in each():
        ok("isosurface", path, "-o", "both.obj", "--overwrite")
        both = open("both.obj").read()
        for label, n in zip(ids, SIZES):
            assert f"label {label}" in both or f"label_{label}" in both, name
            ok("isosurface", path, "-o", "one.ply", "--overwrite", f"--label={label}", "--smoothing", "0")
            found = ok("measure", "volume", "one.ply", "--json").json["volume"]
            assert abs(found - n) < 0.06 * n, (name, found, n)
        missing = ids[0] - 3
        says(fails(2, "isosurface", path, "-o", "no.ply", f"--label={missing}"), str(missing), "is not in the volume")


def test_they_are_picked():
    words = [word for x in range(4, 96, 8) for word in ("--pixel", f"{x},28")]
    for name, ids, path, labels in each():
        for more in ([], ["--set", f"volumes.{name}.interpolation=linear"], ["--slice", "axial"]):
            found = set()
            for pixel in ok("pick", path, "--size", "96x56", "--json", *more, *words).json["pixels"]:
                i, j, k = (min(max(int(round(c)), 0), n - 1) for c, n in zip(pixel.get("index", (0, 0, 0)), (24, 14, 12)))
                assert not pixel.get("label") or int(labels[k, j, i]) in (0, pixel["label"]), (name, more, pixel)
                found.add(pixel.get("label") or 0)
            assert found >= set(ids), (name, more, found)


def test_pictures_show_two_colors():
    for name, _, path, _ in each():
        ok("info", path, "--preview", "-o", "slices.png", "--overwrite")
        assert len(colors("slices.png") - GREYS) >= 2, name
        ok("render", path, "-o", "a.png", "--size", "96x56", "--slice", "axial", "--overwrite")
        assert len({p for p in colors("a.png") - GREYS if max(p) - min(p) > 60}) >= 2, name


def test_small_ids_of_wide_types_are_drawn_as_those_of_narrow_ones():
    for ids in ((1, 1), (1, 2)):
        for kind in ("u1", "u4", "i8"):
            ok("render", write_labels(kind, kind, ids)[0], "-o", f"{kind}.png", "--size", "64")
        assert colors("u1.png") == colors("u4.png") == colors("i8.png"), ids


def is_red_and_blue(path):
    found = colors(path)
    return any(r > 2 * b + 20 for r, g, b in found) and any(b > 2 * r + 20 for r, g, b in found)


def test_few_ids_are_sensed_and_few_levels_are_not():
    def drawn(values, kind="u8"):
        samples = np.zeros((20, 20, 20), kind)
        for i, value in enumerate(values):
            samples[2 + 4 * i : 6 + 4 * i] = value
        np.save("few.npy", samples)
        said = ok("render", "few.npy", "-o", "few.png", "--overwrite", "--size", "32x32", "-v").message
        return said.split('volumes.few.segmentation.kind = "')[1].split('"')[0]
    assert drawn([2**33 + 5, 2**40 + 77, 2**35 + 123, 2**37 + 9]) == "labels"
    assert drawn([2**63 + 2**20 + 1, 2**63 + 5]) == "labels"
    assert drawn([-(2**40) - 1, 2**45 + 3], "i8") == "labels"
    for amounts in ([2**33, 2 * 2**33, 3 * 2**33, 4 * 2**33],  # multiples of a step
                    [10**12, 3 * 10**12], [1, 2, 2**40 + 7], [2**40 + 7], [5, 2**33 + 1]):
        assert drawn(amounts) == "transfer", amounts
    assert drawn([-(2**31), 1, 2], "i4") == "transfer"  # a value that stands for none


def test_files_and_scenes_name_and_color_them():
    for name, ids, path, _ in each(named=True):
        labels = ok("info", path, "--json").json["labels"]
        assert {row["value"]: row["name"] for row in labels} == dict(zip(ids, ("one", "two"))), labels
        for more in ([], ["--slice", "axial"], ["--method", "surface"]):
            ok("render", path, "-o", "a.png", "--size", "96x56", "--overwrite", *more)
            assert is_red_and_blue("a.png"), (name, more)
        ok("info", path, "--preview", "-o", "slices.png", "--overwrite")
        assert is_red_and_blue("slices.png"), name
        for suffix in ("nrrd", "seg.nrrd", "h5", "ome.zarr", "nii"):
            copy = f"{name}-copy.{suffix}"
            ok("convert", path, "-o", copy, "--overwrite")
            again = ok("info", copy, "--json").json["labels"]
            assert again == labels, (copy, again)
            counted = ok("measure", "labels", copy, "--json").json["labels"]
            assert [(row["label"], row["count"]) for row in counted] == sorted(zip(ids, SIZES)), copy
        rows = [[str(label), *color, 1] for label, color in zip(ids, ((0, 1, 0), (1, 1, 0)))]
        ok("render", path, "-o", "a.png", "--save-scene", "a.vv.json", "--overwrite", "--set",
           f"volumes.{name}.segmentation.labels.table={json.dumps(sorted(rows, key=lambda row: int(row[0])))}")
        with open("a.vv.json") as file:
            table = json.load(file)["volumes"][name]["segmentation"]["labels"]["table"]
        assert sorted(int(row[0]) for row in table) == sorted(ids), table


def test_segments_have_the_digits_of_their_ids():
    for name, ids, path, labels in each():
        ok("convert", path, "-o", f"{name}.seg.nrrd", "--overwrite")
        with open(f"{name}.seg.nrrd", "rb") as file:
            header = file.read().split(b"\n\n")[0].decode().splitlines()
        for key in ("LabelValue:=", "ID:=Segment_", "Name:=Segment_"):
            found = [int(line.split(key)[1]) for line in header if line.startswith("Segment") and f"_{key}" in line]
            assert sorted(found) == sorted(ids), (name, key, header)


def test_ids_of_json_beyond_those_with_a_sign_leave_the_others_what_they_are():
    path, _ = write_labels("top", *CASES["top"], named=True)
    ok("convert", path, "-o", "top.ome.zarr", "--overwrite")
    at = next(p for p in ("top.ome.zarr/zarr.json", "top.ome.zarr/.zattrs") if os.path.exists(p))
    with open(at) as file:
        tree = json.load(file)
    image_label = (tree.get("attributes", tree).get("ome") or tree)["image-label"]
    names = {2**63: "half", 2**53 + 1: "odd", 7: "seven", 2**64 - 1: "a \\ \"9223372036854775808\" b"}
    image_label["properties"] = [{"label-value": label, "name": name} for label, name in names.items()]
    image_label["colors"] = []
    with open(at, "w") as file:
        json.dump(tree, file)
    labels = ok("info", "top.ome.zarr", "--json").json["labels"]
    assert {row["value"]: row["name"] for row in labels} == names, labels


def test_operations_and_types_keep_them():
    for name, ids, path, labels in each():
        for words, truth in ((("resample", "--dims", "12,7,6"), None), (("resample", "--spacing", "0.5"), None),
                             (("flip", "--axes", "x"), labels[:, :, ::-1]), (("convert",), labels)):
            ok(words[0], path, *words[1:], "-o", "o.npy", "--overwrite")
            made = np.load("o.npy")
            assert set(np.unique(made).tolist()) == {0, *ids}, (name, words)
            assert truth is None or (made == truth).all(), (name, words)
    path, labels = write_labels("far", *CASES["far"])
    ok("convert", path, "-o", "o.npy", "--overwrite", "--type", "i64")
    assert (np.load("o.npy") == labels.astype("i8")).all() and np.load("o.npy").dtype == "i8"
    says(fails(2, "convert", path, "-o", "o.npy", "--overwrite", "--type", "f64"), "labels are names", "integers")


def test_compare_sees_that_they_differ():
    for name, ids, path, labels in each():
        np.save("a.npy", labels)
        ok("compare", "a.npy", "a.npy", "--max-difference", "0")
        other = labels.copy()
        other[labels == labels[4, 4, 5]] = np.array(ids[1], labels.dtype)
        np.save("b.npy", other)
        found = ok("compare", "a.npy", "b.npy", "--json").json
        assert found["different_samples"] == SIZES[0] and found["max_difference"] == 1 and not found["identical"], found
        assert volvis("compare", "a.npy", "b.npy", "--max-difference", "0").code == 6


def test_places_in_a_slice_are_rounded_to_what_is_known():
    path, _ = write_labels("far", *CASES["far"], mins="-11.5 -6.5 -5.5")
    text = ok("pick", path, "--slice", "axial", "--size", "96x56", "--pixel", "30,28", "--pixel", "60,28").text
    places = [line for line in text.split("\n") if line.strip().startswith(("world", "index"))]
    assert len(places) == 4 and not any("e-" in line for line in places), places


def test_what_may_stand_for_several_is_refused():
    path, _ = write_labels("far", *CASES["far"])
    signed, _ = write_labels("below", *CASES["below"])
    says(fails(2, "measure", "volume", path, "--label", "8.64691135e17"), "--label", "all of its digits")
    says(fails(2, "isosurface", path, "-o", "a.ply", "--label", "8.64691135e17"), "may stand for several labels")
    says(fails(2, "measure", "volume", signed, "--label", str(2**64 - 1)), "i64", "2^63")
    says(fails(2, "isosurface", signed, "-o", "a.ply", "--label", str(2**64 - 1)), "is not in the volume", "i64")


def test_stored_measurements_are_of_the_same_label():
    for name, ids, path, _ in each():
        ok("measure", "volume", path, f"--label={ids[1]}", "--store", f"{name}.vv.json:one")
        again = ok("measure", "stored", f"{name}.vv.json", "--json").json
        assert again["n_changed"] == 0 and again["measurements"][0]["volume"] == SIZES[1], again


def test_labels_have_their_names_on_the_command_line():
    """A name makes what its number makes, of a file, of a scene of it, and where a result is kept."""
    write_organs("a.seg.nrrd")
    ok("render", "a.seg.nrrd", "-o", "a.png", "--size", 16, "--save-scene", "a.vv.json")

    def surface(source, label):
        ok("isosurface", source, "-o", "a.ply", "--overwrite", "--label", label)
        with open("a.ply", "rb") as file:
            return file.read()
    for source in ("a.seg.nrrd", "a.vv.json"):
        assert surface(source, "Left Kidney") == surface(source, "7") != surface(source, "2")
        assert surface(source, 'left kidney, liver "lobe" \u00e9') == surface(source, "7,2")
        says(fails(2, "isosurface", source, "-o", "b.ply", "--label", "left kidny"), "no label 'left kidny'", "did you mean 'left kidney'?")
        volume = [ok("measure", "volume", source, "--label", label, "--json").json["volume"] for label in ("left kidney", "7")]
        assert volume == [256] * 2  # 16 x 16 x 8 samples of an eighth
        says(fails(2, "measure", "volume", source, "--label", "spleen"), "no label 'spleen'; there are left kidney")
    ok("measure", "volume", "a.vv.json", "--label", "left kidney", "--store", "a.vv.json:k")
    says(ok("measure", "stored", "a.vv.json").text, "label 7", "0 changed")
    apart = [ok("measure", "distance", "a.seg.nrrd", "a.seg.nrrd", "--label", a, "--other-label", b, "--json").json["hausdorff"]
             for a, b in (("left kidney", 'LIVER "lobe" \u00e9'), ("7", "2"))]
    assert apart[0] == apart[1]
    for label, name in (("left kidney", "name.seg.nrrd"), ("7", "number.seg.nrrd")):
        ok("dilate", "a.seg.nrrd", "-o", name, "--radius", "1", "--label", label)
    with open("name.seg.nrrd", "rb") as named, open("number.seg.nrrd", "rb") as numbered:
        assert named.read() == numbered.read()
    says(fails(2, "dilate", "a.seg.nrrd", "-o", "no.seg.nrrd", "--label", "left kidny"), "did you mean 'left kidney'?")
    says(fails(2, "isosurface", "a.seg.nrrd", "-o", "b.ply", "--label", "7,2x"), "whole numbers or names", "'7,2x'")


main()
