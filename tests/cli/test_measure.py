"""measure: numbers against numpy and closed forms, in text, JSON and CSV."""
import csv
import io
import json
import math
import numpy as np
import os
import re
import shlex
from harness import fails, main, ok, says, volvis, write_blocks, write_labels
from measure_inputs import distance_to, near, noise, write, write_box, write_sphere

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "measurement.md")

PI = math.pi


def test_ids_that_pictures_show_as_labels_are_measured_as_labels():
    write_blocks()
    said = ok("measure", "volume", "blocks.nrrd")
    says(said.text, "all labels but 0", "5830")  # 18^3, rounded to its error
    says(ok("measure", "volume", "blocks.nrrd", "--iso", "9500").text, "values of 9500 or more")


def test_a_sphere_has_its_area_and_volume_with_both_methods():
    write_sphere(spacing=(0.5, 0.5, 0.5))
    area, volume = 4 * PI * 100, 4 / 3 * PI * 1000
    for method in ("cubes", "count"):
        found = ok("measure", "sphere.nrrd", "--iso", "0", "--method", method, "--json").json
        near(found["area"], area, 0.006)
        near(found["volume"], volume, 0.004)
        assert found["unit"] == "mm" and found["area_unit"] == "mm^2" and found["volume_unit"] == "mm^3"
        assert found["method"] == method and found["region"] == "all"
        for what in ((), ("volume",), ("area",)):
            told = ok("measure", *what, "sphere.nrrd", "--iso", "0", "--method", method, "--json").json
            wanted = (distance_to(64, (31.3, 32.1, 31.8)) <= 20).sum() if method == "count" else None
            assert told.get("voxels") == wanted, what
        assert abs(found["area"] - area) < 3 * found["area_error"]
        assert abs(found["volume"] - volume) < 3 * found["volume_error"]
        for at, want in zip(found["centroid"], (31.3 / 2, 32.1 / 2, 31.8 / 2)):
            assert abs(at - want) < 0.02
    assert found["count"] == (distance_to(64, (31.3, 32.1, 31.8)) <= 20).sum()


def test_text_and_tables_say_the_same_as_json():
    write_sphere()
    found = ok("measure", "area", "sphere.nrrd", "--iso", "0", "--json").json
    text = ok("measure", "area", "sphere.nrrd", "--iso", "0").text
    says(text, "±", "mm^2", "Marching Cubes", "values of 0 or more")
    table = list(csv.DictReader(io.StringIO(ok("measure", "area", "sphere.nrrd", "--iso", "0", "--csv").text)))
    row = next(r for r in table if r["quantity"] == "area")
    assert float(row["value"]) == found["area"] and float(row["error"]) == found["area_error"] and row["unit"] == "mm^2"


def test_the_word_may_stand_before_or_after_the_file():
    write_sphere()
    assert ok("measure", "volume", "sphere.nrrd", "--json").json == ok("measure", "sphere.nrrd", "volume", "--json").json


def test_without_a_threshold_one_is_chosen_and_named():
    write_sphere()
    found = ok("measure", "volume", "sphere.nrrd", "--json").json
    says(found["object"], "best splits")
    again = ok("measure", "volume", "sphere.nrrd", "--iso", found["threshold_lo"], "--json").json
    assert again["volume"] == found["volume"]


def test_statistics_are_those_of_numpy():
    for kind in ("uint8", "uint16", "int16", "int32", "float32", "float64"):
        values = noise(kind)
        write(f"{kind}.nrrd", values)
        found = ok("measure", "statistics", f"{kind}.nrrd", "--json").json
        v = values.astype(float).ravel()
        assert found["count"] == v.size and found["min"] == v.min() and found["max"] == v.max()
        near(found["mean"], v.mean(), 1e-12)
        near(found["standard_error"], v.std() / v.size**0.5, 1e-9)
        assert "mean_error" not in found
        near(found["deviation"], v.std(), 1e-12)
        exact = kind not in ("float32", "float64")
        width = (v.max() - v.min()) / 65536
        for percent, value in found["percentiles"].items():
            near(value, np.percentile(v, float(percent)), 1e-12)
        assert found["percentiles_error"] == found["median_error"] == 0
        near(found["median"], np.median(v), 1e-12)
        assert found["mode_error"] == 0 if exact else 0 < found["mode_error"] <= width * (1 + 1e-9)
        counts, times = np.unique(v, return_counts=True)
        if exact:
            assert found["mode"] in counts[times == times.max()]


def test_percentiles_are_exact_however_far_out_a_sample_lies():
    for kind, far in (("float32", 1e6), ("float64", -1e300), ("int32", 2**31 - 1), ("uint32", 2**32 - 1), ("int64", 2**52)):
        values = np.random.default_rng(1).normal(100, 20 if kind[0] == "f" else 2e4, (10, 21, 22))
        values = np.abs(values).astype(kind)
        values[0, 0, 0] = far
        write("a.nrrd", values)
        for words in ((), ("--threshold", "90,30000"), ("--box", "1:,:,1:")):
            v = values[1:, :, 1:] if "--box" in words else values
            v = v.astype(float)
            v = v[(v >= 90) & (v <= 30000)] if "--threshold" in words else v
            found = ok("measure", "statistics", "a.nrrd", *words, "--json").json
            assert found["count"] == v.size
            near(found["median"], np.median(v), 1e-12)
            for percent, value in found["percentiles"].items():
                near(value, np.percentile(v, float(percent)), 1e-12)


def test_percentiles_have_errors_in_every_form():
    for kind in ("uint8", "float32"):
        write(f"{kind}.nrrd", noise(kind))
        for what in ("statistics", "histogram"):
            found = ok("measure", what, f"{kind}.nrrd", "--json").json
            assert found["percentiles_error"] == found["median_error"] == 0
            assert (found["mode_error"] == 0) == (kind == "uint8")
            text = ok("measure", what, f"{kind}.nrrd", env={"COLUMNS": "200"}).text
        says(next(l for l in text.split("\n") if l.startswith("median")), "± 0")
        table = list(csv.DictReader(io.StringIO(ok("measure", "statistics", f"{kind}.nrrd", "--csv").text)))
        rows = [r for r in table if r["quantity"].startswith(("percentile_", "median", "mode"))]
        assert len(rows) == 9
        for row in rows:
            assert float(row["error"]) == (found["mode_error"] if row["quantity"] == "mode" else 0)
    write("none.nrrd", np.full((3, 3, 3), np.nan, np.float32))
    assert ok("measure", "statistics", "none.nrrd", "--json").json["percentiles_error"] is None


def test_a_histogram_counts_as_numpy_does():
    for kind in ("uint8", "int32", "float32"):
        values = noise(kind)
        write("a.nrrd", values)
        found = ok("measure", "histogram", "a.nrrd", "--bins", "50", "--range", "-10,40", "--json").json
        v = values.astype(float).ravel()
        want, _ = np.histogram(v, 50, (-10, 40))
        got = found["histogram"]["counts"]
        assert found["histogram"]["below"] == (v < -10).sum() and found["histogram"]["above"] == (v > 40).sum()
        assert sum(got) == ((v >= -10) & (v <= 40)).sum()
        assert np.abs(np.array(got) - want).sum() <= (0 if kind != "float32" else 8), kind
        rows = list(csv.DictReader(io.StringIO(ok("measure", "histogram", "a.nrrd", "--bins", "50", "--range", "-10,40", "--csv").text)))
        below, above = found["histogram"]["below"], found["histogram"]["above"]
        want = [below] * (below > 0) + got + [above] * (above > 0)
        assert [int(r["count"]) for r in rows] == want and int(rows[-1]["cumulative"]) == v.size
        if below:
            assert float(rows[0]["lo"]) == -math.inf and float(rows[0]["hi"]) == -10
        text = ok("measure", "histogram", "a.nrrd", "--bins", "50", "--range", "-10,40").text
        says(text, f"{below} samples below the range, {above} above" if below + above else "histogram")


def test_a_histogram_is_exact_whatever_lies_far_away():
    """One sample at a million leaves 0 of 24433 where fine bins over the whole range are put together."""
    from numpy.lib.format import write_array
    for far, kind in (1e4, "f4"), (1e6, "f4"), (1e9, "f8"), (2**30, "i4"):
        v = np.random.default_rng(1).normal(0, 1 if kind[0] == "f" else 100, (11, 13, 35)).astype(kind)
        scale = 1 if kind[0] == "f" else 100
        v[0, 0, :3] = far, scale, -scale
        with open("far.npy", "wb") as file:
            write_array(file, v)
        for part in (), ("--box", "0:35,0:13,0:11"):
            told = ok("measure", "histogram", "far.npy", "--bins", "10", f"--range={-scale},{scale}", "--json", *part).json["histogram"]
            assert told["counts"] == list(np.histogram(v, 10, (-scale, scale))[0]), (far, kind, part, told)
            assert told["below"] == (v < -scale).sum() and told["above"] == (v > scale).sum()


def test_a_small_joint_histogram_is_a_table_and_bars_are_even():
    v = np.random.default_rng(2).integers(0, 133, (9, 9, 9)).astype("u1")
    np.save("small.npy", v)
    found = ok("measure", "joint", "small.npy", "--bins", 4, "--json").json["joint"]["counts"]
    rows = [line.split()[1:] for line in ok("measure", "joint", "small.npy", "--bins", 4).text.splitlines()[-4:]]
    assert [[int(n) for n in row] for row in rows] == found, (rows, found)
    text = ok("measure", "histogram", "small.npy").text
    ends = [tuple(float(n) for n in m) for m in re.findall(r"^ +(-?[0-9.]+) [.]{2} (-?[0-9.]+) ", text, re.M)]
    widths = [hi - lo for lo, hi in ends]
    assert len(widths) > 8 and max(widths[:-1]) - min(widths[:-1]) < 1e-9 and widths[-1] <= widths[0], text


def test_space_world_of_a_mesh_is_what_it_is():
    write_sphere("ball.nrrd", 20, 7)
    ok("isosurface", "ball.nrrd", "-o", "ball.ply")
    words = "measure", "geodesic", "ball.ply", "--point", "3,10,10", "--point", "16,10,10"
    assert ok(*words, "--space", "world", "--json").json["geodesic"] == ok(*words, "--json").json["geodesic"]
    says(fails(2, *words, "--space", "index"), "--space has no effect")


def joint_by_numpy(values, spacing, n, value_range, gradient_hi):
    parts = np.gradient(values.astype(float), *spacing[::-1])
    length = np.sqrt(sum(p ** 2 for p in parts))
    counts, _, _ = np.histogram2d(length.ravel(), values.astype(float).ravel(), n, ((0, gradient_hi), value_range))
    return length, counts


def test_a_joint_histogram_of_values_and_gradients_is_that_of_numpy():
    spacing = (0.5, 1.5, 2)
    for kind in ("uint8", "int16", "float32"):
        values = noise(kind)
        write("a.nrrd", values, spacing=spacing)
        found = ok("measure", "joint", "a.nrrd", "--bins", "32", "--range", "-20,40", "--json").json
        joint = found["joint"]
        length, counts = joint_by_numpy(values, spacing, 32, (-20, 40), joint["gradients"][1])
        near(found["gradient_max"], length.max(), 1e-12)
        near(found["gradient_mean"], length.mean(), 1e-12)
        assert found["count"] == values.size and joint["beyond"] == values.size - counts.sum()
        assert joint["gradient_unit"] == "1/mm" and np.abs(np.array(joint["counts"]) - counts).sum() <= 4, kind
        rows = list(csv.DictReader(io.StringIO(ok("measure", "joint", "a.nrrd", "--bins", "32", "--range", "-20,40", "--csv").text)))
        assert sum(int(r["count"]) for r in rows) == counts.sum() and len(rows) == (np.array(joint["counts"]) > 0).sum()


def test_a_joint_histogram_of_part_of_a_volume_and_of_whole_numbers():
    values = noise("int16")
    write("a.nrrd", values)
    length, _ = joint_by_numpy(values, (1, 1, 1), 2, (0, 1), 1)
    part = ok("measure", "joint", "a.nrrd", "--threshold", "0,", "--box", "2:20,:,3:9", "--json").json
    inside = np.zeros(values.shape, bool)
    inside[3:9, :, 2:20] = True
    inside &= values >= 0
    assert part["count"] == inside.sum()
    near(part["gradient_max"], length[inside].max(), 1e-12)
    joint = ok("measure", "joint", "a.nrrd", "--json").json["joint"]
    width = (joint["values"][1] - joint["values"][0]) / joint["n_values"]
    assert width == round(width) and joint["n_values"] <= 256 and joint["values"][0] == values.min() - 0.5
    assert np.sum(joint["counts"]) == values.size
    write("ramp.nrrd", np.broadcast_to(np.arange(20, dtype=np.float32), (5, 6, 20)).copy(), spacing=(0.25, 1, 1))
    ramp = ok("measure", "joint", "ramp.nrrd", "--json").json
    assert ramp["gradient_mean"] == 4 and ramp["gradient_max"] == 4
    flat = np.full((3, 3, 3), 7, np.uint8)
    write("flat.nrrd", flat)
    assert ok("measure", "joint", "flat.nrrd", "--json").json["gradient_max"] == 0
    holes = np.ones((5, 5, 5), np.float32)
    holes[2, 2, 2] = np.nan
    write("holes.nrrd", holes)
    found = ok("measure", "joint", "holes.nrrd", "--json").json
    assert found["count"] == 125 - 7 and found["unknown"] == 7


def test_a_joint_histogram_is_drawn():
    write_sphere()
    ok("measure", "joint", "sphere.nrrd", "--iso", "0", "-o", "j.svg")
    with open("j.svg", encoding="utf-8") as file:
        drawn = file.read()
    says(drawn, "length of the gradient, 1/mm", "samples in a bin", "threshold", "<image")
    ok("measure", "joint", "sphere.nrrd", "-o", "j.png")
    from PIL import Image
    pixels = np.asarray(Image.open("j.png").convert("RGB")).astype(int)
    assert pixels.shape == (600, 960, 3)
    # distances have gradients of length 1: their bins are dark and blue at the height of 1, nothing is above
    row = 524 - round(468 * 1 / ok("measure", "joint", "sphere.nrrd", "--json").json["gradient_max"])
    blue = pixels[..., 2] - pixels[..., 0] > 20
    assert blue[row - 8:row + 9, 100:830].any(0).mean() > 0.8 and not blue[400:500, 100:700].any()
    says(fails(2, "measure", "joint", "sphere.nrrd", "--bins", "5000"), "1024")


def test_a_ramp_has_a_flat_histogram_and_its_middle_as_median():
    write("ramp.nrrd", np.broadcast_to(np.arange(256, dtype=np.uint8), (4, 8, 256)).copy())
    found = ok("measure", "histogram", "ramp.nrrd", "--json").json
    assert found["histogram"]["counts"] == [32] * 256 and found["median"] == 127.5
    near(found["entropy"], 8, 1e-12)


def test_samples_that_are_no_number_are_counted_apart():
    values = noise("float32")
    values[0, 0, :3] = math.nan
    values[1, 1, :2] = math.inf
    write("a.nrrd", values)
    found = ok("measure", "statistics", "a.nrrd", "--json").json
    assert (found["nan_count"], found["infinite_count"]) == (3, 2) if "nan_count" in found else False
    good = values[np.isfinite(values)].astype(float)
    near(found["mean"], good.mean(), 1e-12)


def test_statistics_of_an_object_a_label_a_mask_and_a_box():
    values, labels = noise("int16"), noise("uint8", seed=9) % 4
    write("v.nrrd", values)
    write("l.nrrd", labels.astype(np.uint8))
    v = values.astype(float)
    for words, want in ((("--threshold", "0,500"), v[(v >= 0) & (v <= 500)]), (("--mask", "l.nrrd"), v[labels != 0]),
                        (("--box", "3:20,:,5:9"), v[5:9, :, 3:20]),
                        (("--clip", "x:3.5mm..10mm"), v[:, :, 4:11])):
        found = ok("measure", "statistics", "v.nrrd", *words, "--json").json
        assert found["count"] == want.size, words
        near(found["mean"], want.mean(), 1e-9)
        near(found["deviation"], want.std(), 1e-9)
    assert ok("measure", "volume", "l.nrrd", "--label", "2", "--json").json["volume"] == (labels == 2).sum()


def test_the_table_of_labels_is_that_of_numpy():
    labels, values = noise("uint8", seed=9) % 5, noise("float32")
    write("l.nrrd", labels.astype(np.uint8), spacing=(0.5, 1, 2), origin=(10, 0, 0))
    write("v.nrrd", values, spacing=(0.5, 1, 2), origin=(10, 0, 0))
    found = ok("measure", "labels", "l.nrrd", "--values", "v.nrrd", "--json").json
    assert [row["label"] for row in found["labels"]] == [1, 2, 3, 4]
    for row in found["labels"]:
        at = np.argwhere(labels == row["label"])
        v = values[labels == row["label"]].astype(float)
        assert row["count"] == len(at) and row["volume"] == len(at)
        near(row["mean"], v.mean(), 1e-12)
        near(row["deviation"], v.std(), 1e-12)
        assert row["min"] == v.min() and row["max"] == v.max()
        assert row["median"] == np.median(v) and "median_error" not in row  # exact
        near(row["centroid"][0], 10 + 0.5 * at[:, 2].mean(), 1e-12)
        near(row["centroid"][2], 2 * at[:, 0].mean(), 1e-12)
        assert row["box_lo"][0] == 10 + 0.5 * (at[:, 2].min() - 0.5) and row["box_hi"][2] == 2 * (at[:, 0].max() + 0.5)


def test_medians_of_labels_are_exact_however_far_out_a_sample_lies():
    labels = noise("uint8", seed=3) % 4
    labels[0, 0, :2] = 9  # of two samples
    write("l.nrrd", labels.astype(np.uint8))
    for kind in ("uint8", "int16", "int32", "float32", "float64"):
        values = noise(kind, seed=4)
        if kind.startswith("float"):
            values[labels == 1] *= 1e-5
            values[1, 1, 1] = np.nan
        values[2, 2, 2:9] = 120 if kind == "uint8" else 32000 if kind == "int16" else 10**6
        write("v.nrrd", values)
        for row in ok("measure", "labels", "l.nrrd", "--values", "v.nrrd", "--json").json["labels"]:
            v = values[labels == row["label"]].astype(float)
            assert row["median"] == np.nanmedian(v), (kind, row, np.nanmedian(v))


def test_labels_have_areas_and_parts():
    labels = np.zeros((40, 40, 40), np.uint8)
    labels[distance_to(40, (18.2, 19.7, 20.1)) <= 14] = 3
    labels[distance_to(40, (18.2, 19.7, 20.1)) <= 8] = 7
    write("l.nrrd", labels)
    for words in ((), ("--box", ":,:,:21"), ("--clip", "x:10..30", "--clip", "z:3..")):
        found = ok("measure", "labels", "l.nrrd", *words, "--json").json
        for row in found["labels"]:
            alone = ok("measure", "l.nrrd", "--label", row["label"], *words, "--json").json
            for key in ("area", "area_error", "volume", "volume_error", "centroid", "box_lo", "box_hi"):
                assert row[key] == alone[key], (words, key, row[key], alone[key])
    says(ok("measure", "labels", "l.nrrd").text, "mm^2")
    smooth = ok("measure", "labels", "l.nrrd", "--method", "cubes", "--json").json
    counted = ok("measure", "labels", "l.nrrd", "--json").json
    truth = {7: 4 * PI * 64, 3: 4 * PI * (64 + 196)}
    assert smooth["method"] == "cubes" and counted["method"] == "count"
    for found in (smooth, counted):
        for row in found["labels"]:
            assert abs(row["area"] - truth[row["label"]]) <= row["area_error"], row
    half = ok("measure", "labels", "l.nrrd", "--method", "cubes", "--clip", "z:..20.1", "--json").json
    near(half["labels"][1]["area"], truth[7] / 2, 0.03)
    table = list(csv.DictReader(io.StringIO(ok("measure", "labels", "l.nrrd", "--csv").text)))
    near(float(table[1]["area"]), counted["labels"][1]["area"], 1e-9)


def test_masks_and_values_lie_where_the_volume_does():
    values, mask = noise("int16"), (noise("uint8", seed=9) % 4 == 0).astype(np.uint8)
    grid = {"spacing": (0.5, 1, 2), "origin": (10, -3, 0)}
    write("v.nrrd", values, **grid)
    write("m.nrrd", mask, **grid)
    want = ok("measure", "statistics", "v.nrrd", "--mask", "m.nrrd", "--json").json
    assert want["count"] == mask.sum()
    write("rounded.nrrd", mask, spacing=(0.5000001, 1, 1.999999), origin=(10.000001, -3, 1e-7))
    write("um.nrrd", mask, spacing=(500, 1000, 2000), origin=(10000, -3000, 0), unit="um")
    np.save("plain.npy", mask.transpose(2, 1, 0).copy(order="F"))
    np.save("raw.npy", mask)
    mask.tofile("m_29x23x19_uint8.raw")
    for same in ("rounded.nrrd", "um.nrrd", "plain.npy", "raw.npy", "m_29x23x19_uint8.raw"):
        if list(ok("info", same, "--json").json["dims"]) == [29, 23, 19]:
            assert ok("measure", "statistics", "v.nrrd", "--mask", same, "--json").json["mean"] == want["mean"], same
    ok("convert", "m.nrrd", "-o", "m.nii")
    assert ok("measure", "statistics", "v.nrrd", "--mask", "m.nii", "--json").json["mean"] == want["mean"]
    write("half.nrrd", mask, spacing=(0.5, 1, 2), origin=(10.25, -3, 0))
    write("wide.nrrd", mask, spacing=(0.5, 1, 2.5), origin=(10, -3, 0))
    write("cube.nrrd", np.zeros((8, 8, 8), np.uint8))
    write("turned.nrrd", np.zeros((8, 8, 8), np.uint8), spacing=(-1, 1, 1), origin=(7.5, 0, 0))
    for other, parts in (("half.nrrd", ("first sample at 10, -3, 0 mm", "10.25")), ("wide.nrrd", ("0.5 x 1 x 2 mm", "2.5 mm"))):
        for words in (("statistics", "v.nrrd", "--mask", other), ("volume", "v.nrrd", "--mask", other),
                      ("labels", "m.nrrd", "--values", other)):
            says(fails(2, "measure", *words), other, "expected", "found", "resample", *parts)
    says(fails(2, "measure", "volume", "cube.nrrd", "--mask", "turned.nrrd"), "RAS", "LAS", "reorient")


def test_masks_and_values_of_a_part_or_in_another_order_are_found_by_their_places():
    values, marks = noise("int16", (60, 100, 80)), noise("uint8", (60, 100, 80), seed=9) % 5
    write("v.nrrd", values, spacing=(0.5, 1, 2), origin=(10, -3, 0))
    part = np.zeros_like(marks)
    part[4:12, 5:20, 3:25] = marks[4:12, 5:20, 3:25]
    write("part.nrrd", marks[4:12, 5:20, 3:25], spacing=(0.5, 1, 2), origin=(11.5, 2, 8))
    ok("reorient", "part.nrrd", "--order", "SLA", "-o", "turned.nrrd")
    inside = values[part > 0]
    for name in ("part.nrrd", "turned.nrrd"):
        for limit in ((), ("--memory", "4M")):
            got = ok("measure", "statistics", "v.nrrd", "--mask", name, "--json", *limit)
            assert got.json["count"] == inside.size and got.json["median"] == np.median(inside), name
            near(got.json["mean"], inside.mean(), 1e-12)
            says(got.message, f"the mask {name} covers x 3..24, y 5..19, z 4..11 of v.nrrd")
            table = ok("measure", "labels", name, "--values", "v.nrrd", "--json", *limit)
            assert not table.message and [l["label"] for l in table.json["labels"]] == [1, 2, 3, 4]
            for l in table.json["labels"]:
                there = values[part == l["label"]]
                assert (l["count"], l["min"], l["max"], l["median"]) == (there.size, there.min(), there.max(), np.median(there))
                near(l["mean"], there.mean(), 1e-12)
    write("m.nrrd", marks, spacing=(0.5, 1, 2), origin=(10, -3, 0))
    ok("crop", "v.nrrd", "--x", "3..24", "--y", "5..19", "--z", "4..11", "-o", "some.nrrd")
    said = fails(2, "measure", "labels", "m.nrrd", "--values", "some.nrrd")
    says(said, "volume of values some.nrrd", "x 3..24, y 5..19, z 4..11 only", "volvis crop m.nrrd --x 3..24 --y 5..19 --z 4..11 -o OUT")
    ok("crop", *said.split("volvis crop ")[1].split(" -o")[0].split(), "-o", "cropped.nrrd")
    assert ok("measure", "labels", "cropped.nrrd", "--values", "some.nrrd", "--json").json["labels"][0]["median"] == np.median(values[part == 1])
    write("aside.nrrd", marks, spacing=(0.5, 1, 2), origin=(100, -3, 0))
    says(fails(2, "measure", "volume", "v.nrrd", "--mask", "aside.nrrd"), "first sample")


def test_a_mask_goes_where_the_scene_puts_the_volume():
    write_sphere()
    write("m.nrrd", (distance_to(64, (30, 30, 30)) < 9).astype(np.uint8))
    plain = ok("measure", "volume", "sphere.nrrd", "--mask", "m.nrrd", "--json").json
    ok("render", "sphere.nrrd", "-o", "s.png", "--size", "16x16", "--set", "volumes.sphere.place.scale=2,2,2",
       "--set", "volumes.sphere.place.position=5,6,7", "--save-scene", "s.vv.json")
    near(ok("measure", "volume", "s.vv.json", "--mask", "m.nrrd", "--json").json["volume"], 8 * plain["volume"], 1e-9)


def test_set_edits_what_is_measured():
    write_sphere()
    write("other.nrrd", distance_to(64, (31, 31, 31)).astype(np.float32))
    plain = ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--json").json
    twice = ("--set", "volumes.sphere.place.scale=2,2,2")
    near(ok("measure", "volume", "sphere.nrrd", "--iso", "0", *twice, "--json").json["volume"], 8 * plain["volume"], 1e-9)
    ok("render", "sphere.nrrd", "-o", "s.png", "--size", "16x16", "--threshold", "5,", "--save-scene", "s.vv.json")
    for scene in ("s.vv.json", "s.png"):
        found = ok("measure", "volume", scene, *twice, "--set", "volumes.sphere.segmentation.threshold.lo=0", "--json").json
        near(found["volume"], 8 * plain["volume"], 1e-9)
        says(found["object"], "values of 0 or more, as in the scene")
        here = os.getcwd()
        found = ok("measure", "statistics", scene, "--set", f"datasets.sphere.path={here}/other.nrrd", "--threshold", "0,", "--json").json
        assert found["count"] == 64 ** 3
    says(fails(2, "measure", "volume", "s.vv.json", "--set", "volumes.head.place.scale=2,2,2"), "--set", "sphere")
    says(fails(2, "measure", "volume", "s.vv.json", "--store", "a", *twice), "--store", "--set")
    ok("measure", "volume", "s.vv.json", "--store", "a")
    says(volvis("measure", "stored", "s.vv.json", *twice).text, "CHANGED")
    ok("measure", "stored", "s.vv.json", "--update", *twice)
    says(ok("measure", "stored", "s.vv.json").text, "as before")
    near(ok("measure", "volume", "s.vv.json", "--iso", "0", "--json").json["volume"], 8 * plain["volume"], 1e-9)
    write_box("box.stl")
    says(fails(2, "measure", "area", "box.stl", "--set", "unit=mm"), "mesh file")
    assert "--set" in ok("measure", "--help").text and "--set" not in ok("info", "--help").text
    says(fails(2, "info", "sphere.nrrd", "--set", "unit=mm"), "--set changes a World")


def test_an_object_in_brighter_surroundings_is_measured_and_not_they():
    ball = np.clip(20 + 15 * (18 - distance_to(64, (31.3, 32.1, 31.8))), 20, 200)
    write("bright.nrrd", ball.astype(np.uint8))
    write("dark.nrrd", (220 - ball).astype(np.uint8))
    bright = ok("measure", "volume", "bright.nrrd", "--json").json
    dark = ok("measure", "volume", "dark.nrrd", "--json").json
    near(dark["volume"], bright["volume"], 0.06)  # a value of the ramp splits each; which, rounding says
    says(bright["object"], "or more (chosen")
    says(dark["object"], "or less (chosen", "larger values surround the object")
    assert dark["automatic"] and ok("measure", "area", "dark.nrrd", "--json").json["cut_area"] == 0
    says(ok("measure", "distance", "dark.nrrd", "--point", "2,32,32").text, "or more")  # its surface is the same
    says(ok("measure", "volume", "dark.nrrd", "--threshold", "..100").text, "values of 100 or less")


def test_one_thing_is_not_called_several():
    with open("one.off", "w") as file:
        file.write("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    for words in ["measure", "distance", "one.off", "--point", "0,0,1"], ["compare", "one.off", "one.off"], ["info", "one.off"], \
            ["render", "one.off", "-o", "one.png", "--dry-run"]:
        said = ok(*words).text
        says(said, "1 triangle")
        assert not re.search(r"\b1 (triangles|pieces|edges|vertices|planes)\b", said), said
    values = np.full((3, 3, 3), 9, np.uint8)
    values[1, 1, 1] = 1
    write("dot.nrrd", values)
    says(ok("measure", "histogram", "dot.nrrd", "--range", "5..20").text, "1 sample below the range, 0 above")


def test_a_star_and_a_number_set_what_is_in_a_scene():
    write_sphere()
    write("other.nrrd", distance_to(64, (31, 31, 31)).astype(np.float32))
    plain = ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--json").json["volume"]
    both = ("render", "sphere.nrrd", "other.nrrd", "-o", "s.png", "--size", "16x16", "--overwrite", "--save-scene", "s.vv.json", "--set")

    def scales(*words):
        ok(*both, *words)
        with open("s.vv.json", encoding="utf-8") as file:
            return {name: v.get("place", {}).get("scale") for name, v in json.load(file)["volumes"].items()}

    assert scales("volumes.*.place.scale=2,2,2") == {"sphere": [2, 2, 2], "other": [2, 2, 2]}
    assert scales("volumes.1.place.scale=2,2,2") == {"sphere": None, "other": [2, 2, 2]}
    for path in ("volumes.*", "volumes.0"):
        near(ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--set", f"{path}.place.scale=2,2,2", "--json").json["volume"], 8 * plain, 1e-9)
    says(fails(2, *both, "volumes.7.visible=false"), "volumes", "sphere", "other")
    says(fails(2, *both, "volumes.*.visibel=false"), "did you mean 'visible'")
    says(fails(2, *both, "cut_planes.*.on=false"), "there are no cut_planes")
    says(fails(2, *both, "unit.*=mm"), "a star stands for everything in a map or a list")


def test_a_reversed_clip_is_refused():
    write_sphere()
    says(fails(2, "measure", "volume", "sphere.nrrd", "--iso", "0", "--clip", "x:40mm..10mm"), "x:40mm..10mm", "LO above HI")
    says(fails(2, "render", "sphere.nrrd", "-o", "a.png", "--clip", "y:3vox..2vox"), "LO above HI")
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--clip", "x:-5..-2")
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--clip", "x:10..10")


def test_one_of_two_pieces_is_measured_alone():
    a, b = distance_to(48, (14, 24, 24)), distance_to(48, (34, 24, 24))
    write("two.nrrd", (8 - np.minimum(a, b)).astype(np.float32))
    write("one.nrrd", (8 - b).astype(np.float32))
    for method in ("cubes", "count"):
        words = ("--iso", "0", "--method", method, "--json")
        two = ok("measure", "two.nrrd", "--seed", "34,24,24", *words).json
        one = ok("measure", "one.nrrd", *words).json
        assert two["area"] == one["area"] and two["volume"] == one["volume"] and two["centroid"] == one["centroid"]
    says(ok("measure", "two.nrrd", "--iso", "0", "--seed", "34,24,24").text, "6-connected")
    says(fails(2, "measure", "two.nrrd", "--iso", "0", "--seed", "1,1,1"), "not in the object")


def test_halves_of_a_sphere_add_up():
    write_sphere()
    whole = ok("measure", "sphere.nrrd", "--iso", "0", "--json").json
    parts = [ok("measure", "sphere.nrrd", "--iso", "0", "--clip", clip, "--json").json for clip in ("x:..30.3mm", "x:30.3mm..")]
    near(sum(p["volume"] for p in parts), whole["volume"], 1e-9)
    near(sum(p["area"] for p in parts), whole["area"], 1e-9)
    closed = ok("measure", "area", "sphere.nrrd", "--iso", "0", "--clip", "x:..30.3mm", "--closed", "--json").json
    near(closed["cut_area"], PI * (400 - 1), 0.005)
    near(closed["area"], parts[0]["area"] + closed["cut_area"], 1e-9)
    counted = ok("measure", "area", "sphere.nrrd", "--iso", "0", "--box", ":30,:,:", "--method", "count")
    says(counted.text, "cut off")
    counted = ok("measure", "area", "sphere.nrrd", "--iso", "0", "--box", ":30,:,:", "--method", "count", "--json").json
    inside = distance_to(64, (31.3, 32.1, 31.8)) <= 20
    assert counted["cut_area"] == inside[:, :, 29].sum()


def test_what_is_cut_off_of_counts_is_the_faces_where_the_object_goes_on():
    """By numpy: voxels of the part beside voxels of the object that are no part, or beyond the volume."""
    spacing = (0.5, 1, 2)
    values = noise("uint8", (9, 71, 67), seed=4) % 4
    write("a.nrrd", values.astype(np.uint8), spacing=spacing)
    z, y, x = np.indices(values.shape)
    for words, part in (((), x >= 0), (("--box", "3:66,5:60,:8"), (x >= 3) & (x < 66) & (y >= 5) & (y < 60) & (z < 8)),
                        (("--clip", "plane(n=1,2,0 d=40)"), 0.5 * x + 2 * y >= 40 * math.sqrt(5))):
        solid = np.pad(values > 0, 1, mode="edge")
        kept = np.pad((values > 0) & part, 1)
        want = 0
        for axis, face in ((2, 2), (1, 1), (0, 0.5)):
            for step in (1, -1):
                want += face * (kept & np.roll(solid, step, axis) & ~np.roll(kept, step, axis)).sum()
        for more in ((), ("--closed",)):
            found = ok("measure", "area", "a.nrrd", "--threshold", "1,", "--method", "count", *words, *more, "--json").json
            near(found["cut_area"], want, 1e-12)


def test_labels_that_end_with_their_file_are_told_how_to_be_closed():
    write("ends.nrrd", np.ones((4, 4, 4), np.uint8))
    says(ok("measure", "area", "ends.nrrd", "--label", "1").message, "reaches the border", "--closed adds them")
    assert "--closed" not in ok("measure", "area", "ends.nrrd", "--threshold", "1", "--method", "count").message
    assert "--closed" not in ok("measure", "volume", "ends.nrrd", "--label", "1").message, "it has no effect there"
    assert ok("measure", "area", "ends.nrrd", "--label", "1", "--closed", "--json").json["raw_faces"] == 96


def test_a_band_is_what_its_two_surfaces_bound_however_thin_it_is():
    """Balls and what is left of them at the border: of samples alone, bands of a tenth of a voxel have next to none."""
    z, y, x = np.mgrid[:32, :32, :32].astype("f4")
    middle, corner = np.sqrt((x - 15.5) ** 2 + (y - 15.5) ** 2 + (z - 15.5) ** 2), np.sqrt(x * x + y * y + z * z)
    np.save("middle.npy", middle)
    np.save("corner.npy", corner)
    np.save("falling.npy", 100 - corner)
    for hi in 10.1, 10.25, 10.5, 11, 13:
        shell, spheres = 4 / 3 * PI * (hi ** 3 - 1000), 4 * PI * (hi * hi + 100)
        for name, share, band in ("middle", 1, f"10..{hi}"), ("corner", 8, f"10..{hi}"), ("falling", 8, f"{100 - hi}..90"):
            told = ok("measure", f"{name}.npy", "--threshold", band, "--method", "cubes", "--json").json
            assert abs(told["volume"] - shell / share) < told["volume_error"] < 0.1 * shell / share, (name, hi, told)
            assert abs(told["area"] - spheres / share) < told["area_error"] < 0.05 * spheres / share, (name, hi, told)
            ends = (15.5 - hi, 15.5 + hi) if share == 1 else (0, hi)
            assert np.abs(np.array(told["box_lo"] + told["box_hi"]) - np.repeat(ends, 3)).max() < 0.05, (name, hi, told)
            cut = ok("measure", "area", f"{name}.npy", "--threshold", band, "--method", "cubes", "--closed", "--json").json
            quarters = 3 * PI / 4 * (hi * hi - 100) if share == 8 else 0
            assert abs(cut["cut_area"] - quarters) < 0.01 * quarters + 1e-9, (name, hi, cut)
            assert abs(cut["area"] - told["area"] - cut["cut_area"]) < 1e-6
    half = ok("measure", "volume", "middle.npy", "--threshold", "10..10.25", "--clip", "x:15.5..31", "--json").json
    assert abs(half["volume"] - 2 / 3 * PI * (10.25 ** 3 - 1000)) < half["volume_error"], half
    piece = ok("measure", "volume", "middle.npy", "--threshold", "10..10.25", "--seed", "15,15,5", "--json").json
    counted = ok("measure", "volume", "middle.npy", "--threshold", "10..10.25", "--seed", "15,15,5", "--method", "count", "--json").json
    assert abs(piece["volume"] - counted["volume"]) < piece["volume_error"], (piece, counted)


def test_the_ends_of_a_band_are_in_it_whatever_is_stored():
    """Cubes of 10 x 10 x 10 samples of 20, 30 and 40: the value at an end of the band belongs to it."""
    stored = np.zeros((16, 16, 48), "i2")
    for i in range(3):
        stored[3:13, 3:13, 16 * i + 3:16 * i + 13] = 20 + 10 * i
    np.save("cubes.npy", stored)
    for band, cubes in ("20..30", 2), ("30..40", 2), ("20..40", 3), ("40..50", 1):
        told = ok("measure", "volume", "cubes.npy", "--threshold", band, "--method", "cubes", "--json").json
        counted = ok("measure", "volume", "cubes.npy", "--threshold", band, "--method", "count", "--json").json
        assert counted["volume"] == 1000 * cubes
        assert told["volume"] >= 9 ** 3 * cubes and abs(told["volume"] - counted["volume"]) < told["volume_error"], (band, told)


def test_distances_angles_and_profiles():
    write_sphere(spacing=(0.5, 1, 2))
    found = ok("measure", "distance", "sphere.nrrd", "--point", "0,0,0", "--point", "10,20,30", "--json").json
    near(found["distance"], math.dist((0, 0, 0), (5, 20, 60)), 1e-12)
    found = ok("measure", "angle", "sphere.nrrd", "--point", "1,0,0", "--point", "0,0,0", "--point", "0,0,7", "--json").json
    near(found["angle"], 90, 1e-12)
    found = ok("measure", "profile", "sphere.nrrd", "--point", "3,32,32", "--point", "60,32,32", "--samples", "58", "--json").json
    values = (20 - distance_to(64, (31.3, 32.1, 31.8))).astype(np.float32)[32, 32, 3:61]
    assert len(found["profile"]) == 58
    told = [v for _, v in found["profile"]]
    assert (found["min"], found["max"]) == (min(told), max(told)) and found["length_unit"] == "mm"
    near(found["length"], 28.5, 1e-12)
    near(found["mean"], np.mean(told), 1e-12)
    for (d, v), i, want in zip(found["profile"], range(58), values):
        near(d, 0.5 * i, 1e-12) if i else None
        assert abs(v - want) < 1e-5
    says(fails(2, "measure", "angle", "sphere.nrrd", "--point", "1,0,0"), "three times")


def test_the_error_of_a_profile_holds():
    """A wave and a ball, without noise: the truth is the formula at the places of the table."""
    truth = lambda x, y, z: np.sin(x / 1.7 + 0.3) * np.cos(y / 2.3) + 20 - np.sqrt((x - 9.1) ** 2 + (y - 9.9) ** 2 + (z - 11) ** 2)
    spacing = np.array((0.5, 1, 2))
    z, y, x = np.meshgrid(np.arange(13) * 2.0, np.arange(23) * 1.0, np.arange(41) * 0.5, indexing="ij")
    write("v.nrrd", truth(x, y, z), spacing=spacing)
    random, within, n = np.random.default_rng(11), 0, 0
    for _ in range(12):
        ends = [",".join("%.17g" % c for c in random.uniform(0, 1, 3) * (40, 22, 12)) for _ in range(2)]
        words = ("measure", "profile", "v.nrrd", "--point", ends[0], "--point", ends[1], "--samples", "101")
        rows = np.array([[float(c) for c in r.values()] for r in csv.DictReader(io.StringIO(ok(*words, "--csv").text))])
        within += (np.abs(rows[:, 4] - truth(*rows[:, 1:4].T)) <= rows[:, 5] + 1e-7).sum()
        n += len(rows)
        assert (rows[:, 5] >= 0).all() and rows[:, 5].max() < 0.6
        found = ok(*words, "--json").json
        np.testing.assert_allclose(found["profile_error"], rows[:, 5], rtol=1e-8)
        np.testing.assert_allclose([v for _, v in found["profile"]], rows[:, 4], rtol=1e-8)
        says(ok(*words).text, "error")
    assert within >= 0.95 * n, (within, n)
    exact = ok("measure", "profile", "v.nrrd", "--point", "3,7,5", "--point", "35,7,5", "--samples", "33", "--json").json
    assert exact["profile_error"] == [0] * 33
    left = ok("measure", "profile", "v.nrrd", "--point", "-9,7,5", "--point", "35.5,7,5", "--json").json["profile_error"]
    assert left[0] is None and left[-1] > 0


def test_a_scene_gives_its_threshold_and_its_planes():
    write_sphere()
    ok("render", "sphere.nrrd", "-o", "s.png", "--threshold", "0,", "--clip", "x:31.3mm..", "--size", "16x16")
    found = ok("measure", "volume", "s.png", "--json").json
    near(found["volume"], 2 / 3 * PI * 8000, 0.01)
    assert found["threshold_lo"] == 0


def test_a_scene_gives_its_iso_value_whatever_draws_it():
    write_sphere()
    want = ok("measure", "volume", "sphere.nrrd", "--iso", "3", "--json").json["volume"]
    small = ("--size", "16x16", "--overwrite")
    for method in ("raycast", "surface", "reduced", "boxes"):
        scene = f"{method}.vv.json"
        ok("render", "sphere.nrrd", "--method", method, "--iso", "3", "--save-scene", scene, "-o", "s.png", *small)
        for shown in (scene, "s.png"):
            found = ok("measure", "volume", shown, "--json").json
            assert found["volume"] == want and found["threshold_lo"] == 3 and not found["automatic"]
            says(found["object"], "values of 3 or more, as in the scene")
    write("l.nrrd", (distance_to(16, (8, 8, 8)) < 6).astype(np.uint8))
    labels = ("--set", "volumes.l.segmentation.kind=labels")
    ok("render", "l.nrrd", "--method", "surface", "--iso", "0.5", *labels, "--save-scene", "l.vv.json", "-o", "s.png", *small)
    assert "as in the scene" not in ok("measure", "volume", "l.vv.json", "--json").json["object"]


def test_another_method_draws_the_surface_of_the_same_value():
    write_sphere()
    small = ("--size", "16x16", "--overwrite", "-o", "s.png")
    ok("render", "sphere.nrrd", "--method", "raycast", "--iso", "3", "--save-scene", "raycast.vv.json", *small)
    ok("render", "sphere.nrrd", "--method", "surface", "--iso", "3", "--save-scene", "surface.vv.json", *small)
    for before, after in (("raycast", "surface"), ("surface", "raycast"), ("surface", "reduced")):
        changed = ok("render", f"{before}.vv.json", "--method", after, "--save-scene", "s.vv.json", *small)
        says(changed.message, f"stays at 3, the iso-value of method {before}")
        with open("s.vv.json", encoding="utf-8") as file:
            render = json.load(file)["views"]["main"]["render"]
        assert render[after]["iso"] == 3 and (after != "raycast" or render[after]["mode"] == "isosurface")
        says(ok("measure", "volume", "s.vv.json").text, "values of 3 or more, as in the scene")
    # what is set, typed or already there, stays
    ok("render", "surface.vv.json", "--method", "raycast", "--iso", "5", "--save-scene", "s.vv.json", *small)
    changed = ok("render", "s.vv.json", "--method", "surface", "--save-scene", "t.vv.json", *small)
    says(ok("measure", "volume", "t.vv.json").text, "values of 3 or more")
    assert "stays at" not in changed.message
    for more in (("--mode", "maximum"), ("--iso", "5")):
        assert "stays at" not in ok("render", "surface.vv.json", "--method", "raycast", *more, *small).message
    assert "stays at" not in ok("render", "surface.vv.json", "--method", "surface", *small).message


def test_small_figures_keep_their_digits_in_text():
    write_sphere(spacing=(1e-6, 1e-6, 1e-6), unit="m")
    for method in ("cubes", "count"):
        words = ("measure", "sphere.nrrd", "--iso", "0", "--method", method)
        found, text = ok(*words, "--json").json, ok(*words).text
        for key, unit in (("area", "m^2"), ("volume", "m^3")):
            line = next(l for l in text.split("\n") if l.startswith(key)).split()
            assert line[2] == "±" and line[4] == unit
            near(float(line[1]), found[key], 0.01)
            near(float(line[3]), found[f"{key}_error"], 0.05)
    write_sphere()
    says(ok("measure", "volume", "sphere.nrrd", "--iso", "0").text, "33460 ± 150 mm^3")


def decimals(number):
    return len(number.partition(".")[2])


def test_digits_follow_errors_in_text_and_are_all_there_for_programs():
    write_sphere(spacing=(0.3, 0.3, 0.3))
    lines = ok("measure", "box", "sphere.nrrd", "--iso", "0").text.split("\n")
    for at, word in ((0, "centroid"), (2, "box"), (4, "")):
        at += next(i for i, l in enumerate(lines) if l.startswith("centroid"))
        assert lines[at].startswith(word)
        numbers = lines[at].removeprefix(word).replace(" .. ", ", ").replace(" x ", ", ").removesuffix(" mm").strip().split(", ")
        errors = lines[at + 1].replace("±", "").strip().split(", ")
        each = len(numbers) // 3
        assert [decimals(n) for n in numbers] == [decimals(e) for e in errors for _ in range(each)], lines[at]
    # 1, 2, ... n: mean, deviation and what chance leaves of both
    write("n.nrrd", np.arange(1, 1001, dtype=np.float32).reshape(10, 10, 10))
    text = ok("measure", "statistics", "n.nrrd").text
    says(text, "mean          500.5\n", "std error     9.1\n", "deviation     288.7\n")
    table = list(csv.DictReader(io.StringIO(ok("measure", "statistics", "n.nrrd", "--csv").text)))
    assert next(r for r in table if r["quantity"] == "deviation")["value"] == repr(math.sqrt((1000 ** 2 - 1) / 12))
    # two balls as labels: their centres to the digits of their errors, and all of them in the table
    labels = np.where(distance_to(48, (14, 14, 14)) < 9, 1, 0) + np.where(distance_to(48, (34.3, 34.2, 34.1)) < 4, 2, 0)
    write("labels.nrrd", labels.astype(np.uint8), spacing=(0.1, 0.1, 0.1))
    rows = ok("measure", "labels", "labels.nrrd").text.split("\n")
    centre = [0.1 * float(i.mean()) for i in np.nonzero(labels == 2)[::-1]]
    assert rows[2].rstrip().endswith("1.4000, 1.4000, 1.4000") and rows[3].rstrip().endswith("%.3f, %.3f, %.3f" % tuple(centre)), rows
    table = list(csv.DictReader(io.StringIO(ok("measure", "labels", "labels.nrrd", "--csv").text)))
    found = ok("measure", "labels", "labels.nrrd", "--json").json["labels"]
    for row, label in zip(table, found, strict=True):
        assert [float(row[k]) for k in ("x", "y", "z")] == label["centroid"]
        assert float(row["area_error"]) == label["area_error"] and float(row["volume"]) == label["volume"]
    said = ok("measure", "distance", "sphere.nrrd", "--iso", "0", "--point", "1,2,3").text.split("\n")
    error = next(l for l in said if l.startswith("distance")).split()[3]
    nearest = next(l for l in said if l.startswith("nearest"))[8:].strip().split(", ")
    assert [decimals(n) for n in nearest] == [decimals(error)] * 3


def test_box_and_centroid_have_errors_everywhere():
    write_sphere()
    for what, method in (("box", "cubes"), ("box", "count"), ("summary", "cubes")):
        words = ("measure", what, "sphere.nrrd", "--iso", "0", "--method", method)
        found = ok(*words, "--json").json
        errors = {"centroid": "centroid_error", "box_lo": "box_error", "box_hi": "box_error", "box_size": "box_size_error"}
        rows = {r["quantity"]: r for r in csv.DictReader(io.StringIO(ok(*words, "--csv").text))}
        ok(*words, "--store", f"study.vv.json:{what}_{method}")
        with open("study.vv.json", encoding="utf-8") as file:
            kept = {f["name"]: f for f in json.load(file)["measurements"][f"{what}_{method}"]["figures"]}
        for key, error in errors.items():
            for a in range(3):
                name = f"{key}_{'xyz'[a]}"
                assert float(rows[name]["error"]) == kept[name]["error"] == found[error][a] > 0, name
        for a, want in enumerate((31.3, 32.1, 31.8)):
            assert abs(found["centroid"][a] - want) <= found["centroid_error"][a]
            assert abs(found["box_size"][a] - 40) <= found["box_size_error"][a]
        text = ok("measure", "stored", "study.vv.json", f"{what}_{method}", env={"COLUMNS": "200"}).text
        for key in errors:
            line = next(l for l in text.split("\n") if l.split()[:1] == [key])
            assert line.count("±") == 3 and line.endswith("mm"), line
        says(ok(*words).text, "40.0 mm" if method == "count" else " x ", "±")
    write_box("box.stl")
    rows = {r["quantity"]: r for r in csv.DictReader(io.StringIO(ok("measure", "box", "box.stl", "--csv").text))}
    assert float(rows["centroid_x"]["error"]) == ok("measure", "box", "box.stl", "--json").json["centroid_error"][0]


def test_the_table_of_labels_has_errors_and_units():
    write("l.nrrd", (distance_to(20, (9, 9, 9)) < 6).astype(np.uint8), spacing=(0.5, 0.5, 0.5))
    words = ("measure", "labels", "l.nrrd", "--values", "l.nrrd")
    found = ok(*words, "--json").json["labels"][0]
    row, = csv.DictReader(io.StringIO(ok(*words, "--csv").text))
    assert (row["unit"], row["area_unit"], row["volume_unit"], row["value_unit"]) == ("mm", "mm^2", "mm^3", "")
    near(float(row["area_error"]), found["area_error"], 1e-5)
    head, line = (l for l in ok(*words, env={"COLUMNS": "200"}).text.split("\n") if l.strip() and "nrrd" not in l)
    assert head.split()[:6] == ["label", "samples", "mm^3", "error", "mm^2", "error"]
    for at, key in ((2, "volume"), (3, "volume_error"), (4, "area"), (5, "area_error")):
        near(float(line.split()[at]), found[key], 0.05)
    for at, key in ((2, "volume"), (4, "area")):  # as other kinds of measurement print them
        one = ok("measure", key, "l.nrrd", "--label", "1").text
        says(one, f"{line.split()[at]} ± {line.split()[at + 1]} mm")
    ok(*words, "--store", "study.vv.json:a")
    with open("study.vv.json", encoding="utf-8") as file:
        kept = {f["name"]: f for f in json.load(file)["measurements"]["a"]["figures"]}
    assert kept["label_1_area"]["error"] == found["area_error"] and kept["label_1_volume"]["error"] == found["volume_error"]


def test_lengths_of_meshes_have_the_unit_that_is_said():
    write_box("a.stl")
    write_box("b.stl", at=4.0)
    for unit, scale in (("mm", 1), ("0.5cm", 0.5)):
        found = ok("measure", "a.stl", "--input-unit", unit, "--json").json
        near(found["volume"], 8 * scale ** 3, 1e-6)
        near(found["area"], 24 * scale ** 2, 1e-6)
        assert found["unit"] == unit[-2:] and found["volume_unit"] == unit[-2:] + "^3"
        near(ok("measure", "distance", "a.stl", "b.stl", "--input-unit", unit, "--json").json["distance"], math.sqrt(12) * scale, 1e-6)
        found = ok("measure", "distance", "a.stl", "--point", "-1,1,1", "--input-unit", unit, "--json").json
        assert found["unit"] == unit[-2:]
    says(ok("measure", "geodesic", "a.stl", "--point", "0,0,0", "--point", "2,0,0", "--input-unit", "mm").text, "mm")
    says(fails(2, "measure", "a.stl", "--input-unit", "furlong"), "--input-unit", "furlong")
    write_sphere()
    says(fails(2, "measure", "volume", "sphere.nrrd", "--iso", "0", "--input-unit", "mm"), "--input-unit", "volume")


def test_samples_that_are_no_number_are_told_by_every_method():
    values = (20 - distance_to(64, (31.3, 32.1, 31.8))).astype(np.float32)
    values[30:33, 30:34, 30:35] = np.nan
    write("v.nrrd", values)
    bad = np.isnan(values)
    cells = np.zeros((63, 63, 63), bool)
    for at in np.ndindex(2, 2, 2):
        cells |= bad[at[0]:at[0] + 63, at[1]:at[1] + 63, at[2]:at[2] + 63]
    some = np.zeros_like(cells)
    for at in np.ndindex(2, 2, 2):
        some |= values[at[0]:at[0] + 63, at[1]:at[1] + 63, at[2]:at[2] + 63] >= 0
    for method in ("cubes", "count"):
        words = ("measure", "volume", "v.nrrd", "--iso", "0", "--method", method)
        assert ok(*words, "--json").json["unknown_samples"] == bad.sum() == 60
        says(ok(*words).message, "60 samples are NaN", "outside")
        says(ok(*words, "--box", ":,:,0:20").message, "60 samples of the whole volume")
    assert ok("measure", "volume", "v.nrrd", "--iso", "0", "--json").json["unknown_cells"] == (cells & some).sum()
    write_sphere()
    assert "unknown_samples" not in ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--json").json
    write("none.nrrd", np.full((3, 3, 3), np.nan, np.float32))
    text = ok("measure", "statistics", "none.nrrd").text
    assert "nan" not in text.replace("none.nrrd", "") and text.count("none") >= 8
    assert ok("measure", "statistics", "none.nrrd", "--json").json["entropy"] is None


def test_a_triangle_twice_leaves_no_hole():
    with open("twice.off", "w", encoding="ascii") as file:
        file.write("OFF\n4 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n3 1 2 3\n")
    text = ok("info", "twice.off", env={"COLUMNS": "200"}).text
    says(text, "no: 3 edges of three or more triangles")
    assert "0 edges" not in text


def test_a_time_step_that_nobody_chose_is_told():
    steps = np.stack([(20 - distance_to(24, (12, 12, 12)) - i) for i in range(3)]).astype(np.float32)
    with open("t.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: float\ndimension: 4\nsizes: 24 24 24 3\nkinds: space space space time\n"
                   b"spacings: 1 1 1 1\nencoding: raw\nendian: little\n\n" + steps.tobytes())
    says(ok("measure", "volume", "t.nrrd", "--iso", "12").message, "the first of 3 time steps", "FILE@N")
    for words in (("t.nrrd@0",), ("t.nrrd", "--frame", "1")):
        assert "time steps" not in ok("measure", "volume", *words, "--iso", "12").message


def test_a_profile_between_one_place_says_so():
    write_sphere()
    profile = ("measure", "profile", "sphere.nrrd", "--point", "1,2,3", "--point")
    says(ok(*profile, "1,2,3").message, "the same", "no length")
    assert "no length" not in ok(*profile, "1,2,4").message


def test_large_whole_numbers_are_numbers():
    write_sphere()
    for typed in ("9223372036854775808", "-99999999999999999999"):
        ok("render", "sphere.nrrd", "--iso", typed, "-o", "a.png", "--size", "8x8", "--overwrite")
    says(fails(2, "render", "sphere.nrrd", "--iso", "9223372036854775808x", "-o", "b.png"), "number")


def test_plots_are_drawn_with_their_marks():
    write_sphere()
    ok("measure", "histogram", "sphere.nrrd", "--threshold", "0,10", "--log", "-o", "h.svg")
    with open("h.svg", encoding="utf-8") as file:
        drawn = file.read()
    says(drawn, "<svg", "median", "threshold", "samples", "value")
    ok("measure", "profile", "sphere.nrrd", "--point", "3,32,32", "--point", "60,32,32", "-o", "p.svg")
    with open("p.svg", encoding="utf-8") as file:
        says(file.read(), "distance, mm")
    drawn = volvis("measure", "histogram", "sphere.nrrd", "-o", "h.png")
    assert drawn.code == 0 or "font" in drawn.message.lower(), drawn.message
    says(fails(2, "measure", "area", "sphere.nrrd", "-o", "a.svg"), "histograms and profiles")


def test_plots_are_images_too_with_and_without_letters():
    write_sphere()
    profile = ("measure", "profile", "sphere.nrrd", "--point", "3,32,32", "--point", "60,32,32")
    for name, head in (("h.png", b"\x89PNG"), ("h.jpg", b"\xff\xd8")):
        for words in (("measure", "histogram", "sphere.nrrd"), profile):
            without = ok(*words, "-o", name, "--overwrite", env={"VOLVIS_FONT": "/nowhere.ttf"})
            says(without.message, "no lettering")
            with open(name, "rb") as file:
                assert file.read(4).startswith(head)


def test_the_suffix_says_what_is_written():
    write_sphere()
    words = ("measure", "area", "sphere.nrrd", "--iso", "0")
    says(ok(*words, "-o", "a.json").message, "a.json")
    ok(*words, "-o", "a.csv")
    ok(*words, "-o", "a.txt")
    with open("a.json", encoding="utf-8") as file:
        assert json.load(file) == ok(*words, "--json").json
    with open("a.csv", encoding="utf-8") as file:
        assert file.read() == ok(*words, "--csv").text
    with open("a.txt", encoding="utf-8") as file:
        assert file.read() == ok(*words).text
    says(fails(2, *words, "-o", "a.doc"), ".json, .csv or .txt")
    says(fails(2, "measure", "histogram", "sphere.nrrd", "-o", "a.doc"), ".svg")
    says(fails(2, *words, "-o", "b.json", "--csv"), "suffix")
    says(fails(2, *words, "-o", "b.csv", "--json"), "suffix")
    assert not os.path.exists("a.doc") and not os.path.exists("b.json")


def test_options_that_would_change_nothing_are_errors():
    write_sphere()
    write_box("a.stl")
    write_box("b.stl", at=5.0)
    for words in (("--clip", "x:1mm.."), ("--box", ":,:,1:2"), ("--iso", "1"), ("--threshold", "1,2"), ("--seed", "1,1,1"),
                  ("--label", "1"), ("--method", "count"), ("--point", "1,1,1")):
        says(fails(2, "measure", "a.stl", *words), words[0], "a mesh")
    says(fails(2, "measure", "distance", "a.stl", "b.stl", "--point", "1,1,1"), "two meshes")
    for words in (("--iso", "0"), ("--threshold", "0,5")):
        says(fails(2, "measure", "histogram", "sphere.nrrd", *words), words[0])
    for words in (("area", "--samples", "5"), ("area", "--point", "1,1,1"), ("labels", "--label", "1"), ("box", "--bins", "9"),
                  ("histogram", "--log", "--csv"), ("statistics", "--method", "count"), ("distance", "--box", ":,:,:")):
        says(fails(2, "measure", words[0], "sphere.nrrd", *words[1:]), words[1])
    says(fails(2, "measure", "sphere.nrrd", "--json", "--csv"), "one form")


def test_a_seed_alone_takes_the_chosen_object():
    write_sphere()
    seeded = ("sphere.nrrd", "--seed", "31,32,32", "--json")
    threshold = ok("measure", "volume", *seeded).json["threshold_lo"]
    want = (np.float32(20) - distance_to(64, (31.3, 32.1, 31.8)).astype(np.float32) >= threshold).sum()
    for kind in ("statistics", "histogram"):
        assert abs(ok("measure", kind, *seeded).json["count"] - want) <= 2


def test_bars_are_as_long_as_counts_or_their_logarithms():
    write("a.nrrd", np.repeat(np.arange(4, dtype=np.uint8), (1000, 100, 10, 614)).reshape(4, 431, 1))
    def lengths(*words):
        text = ok("measure", "histogram", "a.nrrd", *words).text
        says(text, "by the logarithm of the count" if words else "(bars by the count)")
        return [line.count("#") for line in text.splitlines() if " .. " in line]
    plain, logarithmic = lengths(), lengths("--log")
    assert plain[0] == max(plain) == logarithmic[0] == max(logarithmic)
    for i, count in enumerate((1000, 100, 10, 614)):
        assert abs(plain[i] - plain[0] * count / 1000) <= 0.5
        assert abs(logarithmic[i] - plain[0] * math.log1p(count) / math.log1p(1000)) <= 0.5
    says(fails(2, "measure", "histogram", "a.nrrd", "--log", "--json"), "--log", "no numbers")


def test_names_of_marks_keep_apart_and_the_subset_is_told():
    """Values whose percentiles lie in one place, and thresholds beside them."""
    values = np.zeros((20, 20, 20), np.float32)
    values[0, 0, 0] = 1000
    values[:, :, 10:] = 0.5
    write("a.nrrd", values)
    write("m.nrrd", np.ones((20, 20, 20), np.uint8))
    for words in (("--threshold", "0.2,0.7"), ("--threshold", "998,999.5"), ()):
        ok("measure", "histogram", "a.nrrd", "-o", "h.svg", *words)
        with open("h.svg", encoding="utf-8") as file:
            text = file.read()
        found = re.findall(r'<text x="([-0-9.]+)" y="([-0-9.]+)"[^>]*fill="#[^>]*>(1 %|median|99 %|threshold)<', text)
        places = sorted((float(x), len(name)) for x, _, name in found)
        assert len(places) == 3 + 2 * bool(words), (words, places)
        assert len({y for _, y, _ in found}) == 1
        for (x, n), (y, m) in zip(places, places[1:]):
            assert y - x >= 3.6 * (n + m), (words, places)
        assert places[0][0] > 3.6 * places[0][1] and places[-1][0] < 960 - 3.6 * places[-1][1]
    for words, want in ((("--mask", "m.nrrd"), "where m.nrrd is not 0"), (("--box", ":,2:9,:"), "in box of samples :,2:9,:"),
                        (("--clip", "x:2..", "--label", "0"), "label 0; in 1 cut plane")):
        for kind in ("histogram", "joint"):
            ok("measure", kind, "a.nrrd", "-o", "h.svg", *words)
            with open("h.svg", encoding="utf-8") as file:
                says(file.read(), f">{want}<")


def test_a_dry_run_measures_nothing():
    write_sphere()
    write_box("a.stl")
    for file in ("sphere.nrrd", "a.stl"):
        text = ok("measure", "area", file, "--dry-run").text
        says(text, "reads", file, "measures", "area")
        assert "mm^2" not in text
    found = ok("measure", "sphere.nrrd", "--dry-run", "--json").json
    assert found["dry_run"] and "area" not in found
    ok("measure", "histogram", "sphere.nrrd", "-o", "dry.svg", "--dry-run")
    assert not os.path.exists("dry.svg")


def test_one_triangle_is_no_triangles():
    with open("one.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    says(ok("measure", "distance", "one.ply", "--point", "0,0,3").text, "1 triangle\n")
    says(ok("measure", "summary", "one.ply").text, "1 triangle, open")


def test_distances_are_of_parts_and_of_labels_too():
    write_sphere()
    sphere = ("distance", "sphere.nrrd", "--iso", "0", "--point", "31.3,32.1,60")
    near(ok("measure", *sphere, "--json").json["distance"], 60 - 51.8, 1e-3)
    for words in (("--box", ":,:,:33"), ("--clip", "z:..32mm")): # what is left ends in a circle in the plane z = 32
        found = ok("measure", *sphere, *words, "--json").json
        near(found["distance"], math.hypot(28, math.sqrt(400 - 0.04)), 2e-3)
        assert abs(found["nearest"][2] - 32) < 1e-5
    says(ok("measure", *sphere, "--box", ":,:,:33").text, "in box of samples :,:,:33")
    says(fails(2, "measure", *sphere, "--box", ":,:,:3"), "nothing of the surface", "box of samples")
    ok("render", "sphere.nrrd", "-o", "s.png", "--size", "16x16", "--clip", "z:..32mm", "--save-scene", "s.vv.json")
    near(ok("measure", "distance", "s.vv.json", *sphere[2:], "--json").json["distance"], found["distance"], 1e-9)
    random = np.random.default_rng(3)
    within = []
    for i in range(12): # two balls as labels
        radius, middle = random.uniform(3, 6, 2), random.uniform(7, 8, (2, 3))
        middle[1] += random.uniform(15, 17, 3) * np.eye(3)[i % 3]
        at = np.moveaxis(np.indices((25, 25, 25)), 0, -1)[..., ::-1]
        inside = [np.linalg.norm(at - m, axis=-1) <= r for r, m in zip(radius, middle)]
        write("l.nrrd", (inside[0] + 2 * inside[1]).astype(np.uint8), spacing=(0.7, 0.7, 0.7))
        found = ok("measure", "distance", "l.nrrd", "l.nrrd", "--label", "1", "--other-label", "2", "--json").json
        within.append(abs(found["distance"] - 0.7 * (math.dist(*middle) - radius.sum())) <= found["distance_error"])
    assert sum(within) >= 11, within
    near(ok("measure", "distance", "l.nrrd", "--label", "1", "--point", "20,20,20", "--json").json["distance"],
         0.7 * (math.dist(middle[0], (20, 20, 20)) - radius[0]), 0.03)
    assert "label" in volvis("measure", "distance", "l.nrrd", "--label", "9", "--point", "1,1,1").message
    ok("measure", "distance", "l.nrrd", "l.nrrd", "--label", "1", "--other-label", "2", "--store", "d.vv.json:apart")
    says(ok("measure", "stored", "d.vv.json").text, "as before")


def test_what_is_empty_is_called_so():
    write("l.nrrd", np.ones((4, 4, 4), np.uint8))
    for kind in ("volume", "box", "statistics"):
        says(ok("measure", kind, "l.nrrd", "--label", "5").message, "there is no label 5")
    says(ok("measure", "box", "l.nrrd", "--label", "5").text, "empty")
    assert ok("measure", "l.nrrd", "--label", "5").message.count("there is no label 5") == 1
    assert "empty" not in ok("measure", "volume", "l.nrrd", "--label", "1").message
    with open("none.ply", "w", encoding="ascii") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 0\nproperty list uchar int vertex_indices\nend_header\n")
    text = ok("measure", "box", "none.ply").text
    says(text, "empty")
    assert "inf" not in text
    assert ok("measure", "box", "none.ply", "--json").json["box_lo"] == [None] * 3


def test_every_example_of_the_manual_runs():
    write("head.nrrd", np.clip(230 - 12 * distance_to(64, (31, 32, 30)), 0, 255).astype(np.uint8))
    write("labels.nrrd", (distance_to(64, (31, 32, 30)) // 10).astype(np.uint8))
    with open(PAGE, encoding="utf-8") as file:
        lines = [line.strip() for line in file if line.startswith("volvis measure")]
    assert len(lines) >= 8
    for line in lines:
        ok(*shlex.split(line)[1:])


def test_meshes_have_area_volume_and_distances():
    write_box("a.stl")
    write_box("b.stl", at=5.0)
    found = ok("measure", "a.stl", "--json").json
    near(found["area"], 24, 1e-6)
    near(found["volume"], 8, 1e-6)
    assert found["closed"] and found["box_size"] == [2, 2, 2] and found["centroid"] == [1, 1, 1]
    apart = ok("measure", "distance", "a.stl", "b.stl", "--json").json
    near(apart["distance"], 3 * math.sqrt(3), 1e-6)
    near(apart["hausdorff"], 5 * math.sqrt(3), 1e-6)
    point = ok("measure", "distance", "a.stl", "--point", "1,1,4", "--json").json
    near(point["distance"], 2, 1e-9)
    assert point["nearest"] == [1, 1, 2] and point["signed_distance"] == point["distance"]
    says(fails(2, "measure", "distance", "a.stl"), "once", "second surface")
    says(fails(2, "measure", "histogram", "a.stl"), "is a mesh")


def within_error(found, key, truth, times=3):
    assert abs(found[key] - truth) <= times * found[key + "_error"], (key, found[key], truth, found[key + "_error"])


def mesh_scene(*meshes):
    ok("render", *meshes, "-o", "m.png", "--size", "16x16", "--overwrite", "--save-scene", "m.vv.json")
    return "m.vv.json"


def test_meshes_of_a_scene_are_measured_where_it_places_them():
    """A box of 2 x 2 x 2 at 1, 1, 1, scaled, turned and moved: sides 4, 6 and 8."""
    write_box("box.stl", at=1.0)
    scene = mesh_scene("box.stl")
    place = ("--set", "volumes.box.place.scale=2,3,4", "--set", "volumes.box.place.position=5,6,7")
    for words in (place, (*place, "--set", "volumes.box.place.rotation=30,40,50")):
        for source in (scene, "m.png"):
            for kind in ("area", "volume", "summary"):
                found = ok("measure", *(() if kind == "summary" else (kind,)), source, *words, "--json").json
                for key, want, unit in (("area", 208, "units^2"), ("volume", 192, "units^3")):
                    if kind in (key, "summary"):
                        assert abs(found[key] - want) <= found[key + "_error"] < 1e-3 * want and found[key + "_unit"] == unit
    assert ok("measure", "box", scene, *place, "--json").json["box_lo"] == [7, 9, 11]
    found = ok("measure", "volume", scene, *place, "--json").json
    row = next(csv.DictReader(io.StringIO(ok("measure", "volume", scene, *place, "--csv").text)))
    assert float(row["value"]) == found["volume"] and float(row["error"]) == found["volume_error"] and row["unit"] == "units^3"
    says(ok("measure", "volume", scene, *place).text, "192.00", "±", "units^3", "where the scene places it")
    says(ok("measure", "volume", scene, "--dry-run").text, "a scene of meshes")


def test_lengths_of_a_mesh_are_told_in_the_unit_of_the_scene():
    write_box("box.stl")
    ok("convert", "box.stl", "-o", "box.ply", "--input-unit", "mm")
    scene = mesh_scene("box.ply")
    found = ok("measure", scene, "--set", "unit=cm", "--json").json
    near(found["area"], 0.24, 1e-6)
    near(found["volume"], 0.008, 1e-6)
    assert found["area_unit"] == "cm^2" and found["volume_unit"] == "cm^3"


def test_several_meshes_of_a_scene_are_told_each_and_together():
    write_box("a.stl", at=0.0)
    write_box("b.stl", at=5.0, size=3.0)
    scene = mesh_scene("a.stl", "b.stl")
    found = ok("measure", scene, "--set", "volumes.a.place.scale=1,1,2", "--json").json
    want = {"a": (40, 16), "b": (54, 27)}
    assert [m["name"] for m in found["meshes"]] == ["a", "b"]
    for mesh in (*found["meshes"], {**found, "name": "all"}):
        area, volume = want.get(mesh["name"], (94, 43))
        assert abs(mesh["area"] - area) <= mesh["area_error"] and abs(mesh["volume"] - volume) <= mesh["volume_error"]
    for got, middle in zip(found["centroid"], ((16 * m + 27 * 6.5) / 43 for m in (1, 1, 2))):
        near(got, middle, 1e-6)
    assert found["box_lo"] == [0, 0, 0] and found["box_hi"] == [8, 8, 8] and found["triangles"] == 24
    rows = {r["quantity"]: float(r["value"]) for r in csv.DictReader(io.StringIO(ok("measure", "area", scene, "--csv").text))}
    assert rows.keys() == {"a_area", "b_area", "area"} and abs(rows["area"] - 78) < 1e-3
    says(ok("measure", "area", scene).text, "shown", "together", "2 meshes", "counts twice")
    near(ok("measure", "volume", scene, "--set", "volumes.b.visible=false", "--json").json["volume"], 8, 1e-6)
    ok("measure", "volume", scene, "--store", "all")
    says(ok("measure", "stored", scene).text, "as before", "b_volume", "2 meshes of the scene")


def test_cut_meshes_of_a_scene_have_their_cut_off_part_taken_away():
    write_box("box.stl")
    words = (mesh_scene("box.stl"), "--set", 'cut_planes=[{"normal": [1, 0, 0], "offset": 1}]',
             "--set", "volumes.box.place.scale=2,1,1", "--json")
    near(ok("measure", "volume", *words).json["volume"], 12, 1e-6)  # 3 of 4 along x
    near(ok("measure", "area", *words).json["area"], 4 + 4 * 6, 1e-6)
    near(ok("measure", "area", "--closed", *words).json["area"], 8 + 4 * 6, 1e-6)


def test_places_on_meshes_of_a_scene_are_those_of_its_world():
    write_box("box.stl")  # from 0 to 2
    scene = mesh_scene("box.stl")
    moved = ("--set", "volumes.box.place.scale=-3,1,1", "--set", "volumes.box.place.position=10,0,0", "--json")  # x from 4 to 10
    points = lambda *places: [word for place in places for word in ("--point", place)]
    found = ok("measure", "distance", scene, *points("0,1,1"), *moved).json
    near(found["distance"], 4, 1e-6)
    near(found["signed_distance"], 4, 1e-6)  # outside, though it is mirrored
    assert found["nearest"] == [4, 1, 1]
    near(ok("measure", "distance", scene, *points("5,1,1"), *moved).json["signed_distance"], -1, 1e-6)
    near(ok("measure", "geodesic", scene, *points("5,0,1", "5,1,2"), *moved).json["geodesic"], 2, 1e-6)  # over an edge
    near(ok("measure", "distance", scene, *points("4,0,0", "10,0,0", "10,2,0"), *moved).json["distance"], 8, 1e-9)
    near(ok("measure", "angle", scene, *points("4,0,0", "10,0,0", "10,2,0"), *moved).json["angle"], 90, 1e-9)
    cut = ("--set", 'cut_planes=[{"normal": [1, 0, 0], "offset": 6}]')
    near(ok("measure", "distance", scene, *points("0,1,1"), *cut, *moved).json["distance"], (36 + 1) ** 0.5, 1e-6)  # its walls, without a lid
    # of a file in its own space
    near(ok("measure", "distance", "box.stl", *points("0,0,0", "3,4,0"), "--json").json["distance"], 5, 1e-9)
    near(ok("measure", "angle", "box.stl", *points("1,0,0", "0,0,0", "0,3,0"), "--json").json["angle"], 90, 1e-9)


def test_lengths_of_a_scene_are_in_its_unit():
    write_sphere("ball.nrrd", 32, 10.0, (15.5, 15.5, 15.5))
    write("half.nrrd", (distance_to(32, (15.5, 15.5, 15.5)) < 8).astype(np.uint8))
    ok("measure", "volume", "ball.nrrd", "--iso", "0", "--store", "s.vv.json:all")
    in_cm = ("--set", "unit=cm", "--json")
    plain = ok("measure", "volume", "s.vv.json", "--iso", "0", "--json").json
    found = ok("measure", "volume", "s.vv.json", "--iso", "0", *in_cm).json
    assert (plain["volume_unit"], found["volume_unit"]) == ("mm^3", "cm^3"), (plain, found)
    near(found["volume"], plain["volume"] / 1000, 1e-9)
    near(ok("measure", "distance", "s.vv.json", "--space", "world", "--point", "0,0,0", "--point", "0.3,0.4,0", *in_cm).json["distance"], 0.5, 1e-9)
    near(ok("measure", "point", "s.vv.json", "--space", "world", "--point", "1.6,1.5,1.5", *in_cm).json["value"], ok("measure", "point", "ball.nrrd", "--space", "world", "--point", "16,15,15", "--json").json["value"], 1e-9)
    cut = ("--set", 'cut_planes=[{"normal": [1, 0, 0], "offset": 1.55}]')
    near(ok("measure", "volume", "s.vv.json", "--iso", "0", *cut, *in_cm).json["volume"], plain["volume"] / 2000, 1e-6)
    moved = ("--set", "volumes.ball.place.position=5,0,0")
    near(ok("measure", "volume", "s.vv.json", "--mask", "half.nrrd", *moved, *in_cm).json["volume"], ok("measure", "volume", "half.nrrd", "--label", "1", "--method", "count", "--json").json["volume"] / 1000, 1e-9)


def test_what_has_no_effect_is_refused_of_stored_measurements_too():
    write_labels()
    ok("measure", "labels", "organs.seg.nrrd", "--store", "s.vv.json:all")
    for setting, word in (('region={"kind": "ellipsoid", "center": [9, 9, 9], "size": [5, 5, 5]}', "region"), ("seed=[9, 9, 9]", "seed"), ("iso=1", "iso")):
        done = fails(2, "measure", "stored", "s.vv.json", "all", "--set", f"measurements.all.{setting}")
        says(done, f"'{word}' has no effect on the labels of", "leave it out")


def test_numbers_of_labels_have_no_mean():
    write_labels()
    found = ok("measure", "statistics", "organs.seg.nrrd", "--json").json
    assert "mean" not in found and "deviation" not in found and "percentiles" not in found and found["count"] == 24 ** 3, found
    says(ok("measure", "histogram", "organs.seg.nrrd", "-o", "h.svg").message, "no mean", "'labels' measures each")
    says(fails(2, "measure", "joint", "organs.seg.nrrd"), "have no gradient")
    write_blocks()  # which look like labels, and are shown as such, unless somebody says otherwise
    found = ok("measure", "statistics", "blocks.nrrd")
    assert "mean" not in found.text.replace("no mean", ""), found.text
    says(found.message, "look like labels", "segmentation.kind is transfer")
    amounts = ("--set", "volumes.blocks.segmentation.kind=transfer", "--json")
    assert ok("measure", "statistics", "blocks.nrrd", *amounts).json["mean"] > 0
    write("half.nrrd", (distance_to(24, (11, 11, 11)) < 8).astype(np.uint8))
    assert "mean" in ok("measure", "statistics", "half.nrrd", "--json").json
    assert "mean" not in ok("measure", "statistics", "half.nrrd", "--set", "volumes.half.segmentation.kind=labels", "--json").json
    at = [ok("measure", "point", "blocks.nrrd", "--point", place, "--json").json["value"] for place in ("8,8,8", "8.4,8.4,8.4", "8.6,8.4,8.4", "9,8,8")]
    assert at[0] == at[1] and at[2] == at[3], at  # of the nearest sample


def test_what_meshes_of_a_scene_do_not_have_is_refused_in_a_sentence():
    write_box("box.stl")
    write_sphere()
    scene = mesh_scene("box.stl")
    for kind in ("profile", "histogram", "statistics", "labels"):
        says(fails(2, "measure", kind, scene), "shows meshes", "area, volume, box, distance, angle and geodesic", f"no {kind}")
    says(fails(2, "measure", "distance", scene), "distance to what?", "--point")
    says(fails(2, "measure", "geodesic", scene), "needs --point X,Y,Z twice")
    says(fails(2, "measure", "area", scene, "--iso", "3"), "--iso", "a scene of meshes", "omit it")
    both = mesh_scene("box.stl", "sphere.nrrd")
    says(fails(2, "measure", "area", both), "volumes.sphere", "--set volumes.sphere.visible=false")
    near(ok("measure", "area", both, "--set", "volumes.sphere.visible=false", "--json").json["area"], 24, 1e-6)
    with open("box.stl", encoding="ascii") as file:
        text = file.read()
    with open("open.stl", "w", encoding="ascii") as file:
        file.write(text[:text.index("facet")] + text[text.index("facet", text.index("endfacet") + 9):])
    scene = mesh_scene("open.stl")
    says(fails(2, "measure", "volume", scene), "volumes.open", "open")
    near(ok("measure", "area", scene, "--json").json["area"], 22, 1e-6)


def test_distances_of_places_to_surfaces_of_volumes_and_meshes():
    write_sphere(spacing=(0.5, 0.5, 0.5))
    ok("isosurface", "sphere.nrrd", "--iso", "0", "-o", "sphere.ply")
    middle = (15.65, 16.05, 15.9)
    for place in ((1, 2, 3), (16, 16, 24), (30, 15, 15)):
        truth = math.dist(place, middle) - 10
        words = ("--point", ",".join(map(str, place)), "--json")
        volume = ok("measure", "distance", "sphere.nrrd", "--iso", "0", "--space", "world", *words).json
        mesh = ok("measure", "distance", "sphere.ply", *words).json
        near(volume["distance"], abs(truth), 0.02)
        within_error(volume, "distance", abs(truth))
        assert abs(volume["signed_distance"] - truth) < 0.02 and volume["unit"] == "mm"
        near(mesh["distance"], volume["distance"], 1e-5)
        assert volume["surface"].startswith("values of 0")
    by_index = ok("measure", "distance", "sphere.nrrd", "--iso", "0", "--point", "60,30,30", "--json").json
    near(by_index["distance"], abs(math.dist((30, 15, 15), middle) - 10), 0.02)
    says(fails(2, "measure", "distance", "sphere.nrrd", "--iso", "99", "--point", "1,1,1"), "no surface")
    write("labels.nrrd", noise("uint8") % 3)
    says(fails(2, "measure", "distance", "sphere.nrrd", "--point", "1,1,1", "--point", "2,1,1", "--iso", "0"), "--iso")


def test_distances_of_two_surfaces_of_volumes_are_those_of_spheres():
    write_sphere(n=37, radius=14.0, middle=(17.3, 18.1, 17.8), spacing=(0.5, 0.5, 0.5))
    concentric = ok("measure", "distance", "sphere.nrrd", "sphere.nrrd", "--iso", "0", "--other-iso", "4", "--json").json
    for key in ("distance", "hausdorff", "a_to_b_mean", "b_to_a_rms", "a_to_b_max"):
        near(concentric[key], 2, 0.01)
        within_error(concentric, key, 2)
    assert concentric["surface_b"] == "values of 4 or more"
    write("other.nrrd", (5 - distance_to(17, (8, 7, 6))).astype(np.float32), origin=(40, 0, 0))
    apart = ok("measure", "distance", "sphere.nrrd", "other.nrrd", "--iso", "0", "--json").json
    between = math.dist((8.65, 9.05, 8.9), (48, 7, 6))
    near(apart["distance"], between - 12, 0.002)
    near(apart["a_to_b_max"], between + 7 - 5, 0.002)
    ok("isosurface", "other.nrrd", "--iso", "0", "-o", "other.ply")
    near(ok("measure", "distance", "sphere.nrrd", "other.ply", "--iso", "0", "--json").json["distance"], apart["distance"], 1e-5)
    says(fails(2, "measure", "distance", "sphere.nrrd", "other.ply", "--iso", "0", "--point", "1,1,1"), "two surfaces")


def test_the_way_along_a_surface_is_a_great_circle():
    write_sphere(spacing=(0.5, 0.5, 0.5))
    ok("isosurface", "sphere.nrrd", "--iso", "0", "-o", "sphere.ply")
    x, y, z = 15.65, 16.05, 15.9
    for other, truth in (((x, y + 10, z), PI / 2 * 10), ((x - 7.0710678, y + 7.0710678, z), PI * 7.5)):
        words = ("--point", f"{x + 10},{y},{z}", "--point", ",".join(map(str, other)), "--json")
        found = ok("measure", "geodesic", "sphere.nrrd", "--iso", "0", "--space", "world", *words).json
        near(found["geodesic"], truth, 0.003)
        within_error(found, "geodesic", truth)
        near(found["straight"], math.dist((x + 10, y, z), other), 0.003)
        assert found["shortest"] and found["geodesic_unit"] == "mm"
        length = sum(math.dist(a, b) for a, b in zip(found["path"], found["path"][1:]))
        near(length, found["geodesic"], 1e-9)
        near(ok("measure", "geodesic", "sphere.ply", *words).json["geodesic"], found["geodesic"], 1e-5)
    write_box("a.stl")
    over = ok("measure", "geodesic", "a.stl", "--point", "0,0.5,1", "--point", "2,0.5,1", "--json").json
    near(over["geodesic"], 3, 1e-6)
    says(fails(2, "measure", "geodesic", "a.stl", "--point", "0,0,0"), "twice")
    says(fails(2, "measure", "geodesic", "a.stl", "--iso", "3"), "--iso")


def test_a_turned_triangle_is_told_by_measure_and_info_alike():
    write_box("a.stl")
    with open("a.stl", encoding="ascii") as file:
        lines = file.read().split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith("vertex"))
    lines[at], lines[at + 1] = lines[at + 1], lines[at]
    with open("turned.stl", "w", encoding="ascii") as file:
        file.write("\n".join(lines))
    found = ok("measure", "turned.stl", "--json").json
    assert not found["closed"] and found["turned_edges"] == 3 and "volume" not in found
    near(found["area"], 24, 1e-6)
    assert not ok("info", "turned.stl", "--json").json["closed"]
    says(fails(2, "measure", "volume", "turned.stl"), "flipped", "3 edges", "no holes")
    says(ok("measure", "turned.stl").text, "turned triangles")
    with open("open.stl", "w", encoding="ascii") as file:
        file.write("\n".join(lines[:1] + lines[8:]))
    says(fails(2, "measure", "volume", "open.stl"), "open")


def test_a_mesh_may_come_through_a_pipe():
    write_box("a.stl")
    with open("a.stl", "rb") as file:
        near(ok("measure", "area", "-", "--json", stdin=file.read()).json["area"], 24, 1e-6)


def test_the_mesh_of_a_volume_is_as_large_as_the_volume_says():
    write_sphere()
    ok("isosurface", "sphere.nrrd", "--iso", "0", "-o", "sphere.ply")
    mesh, volume = ok("measure", "sphere.ply", "--json").json, ok("measure", "sphere.nrrd", "--iso", "0", "--json").json
    near(mesh["area"], volume["area"], 1e-5)
    near(mesh["volume"], volume["volume"], 1e-5)


def test_data_without_two_kinds_of_values_are_told():
    write("constant.nrrd", np.full((5, 5, 5), 7, np.uint8))
    says(ok("measure", "constant.nrrd").text, "all samples are equal: nothing is separated")
    write("nothing.nrrd", np.full((5, 5, 5), np.nan, np.float32))
    says(ok("measure", "volume", "nothing.nrrd").text, "no sample is a number: nothing is separated")
    says(fails(2, "measure", "histogram", "nothing.nrrd", "-o", "h.svg"), "nothing to plot")
    says(fails(2, "measure", "histogram", "constant.nrrd", "--range", "100,200", "-o", "h.svg"), "nothing to plot", "--range")
    write("slice.nrrd", np.arange(20, dtype=np.uint8).reshape(1, 4, 5))
    says(ok("measure", "slice.nrrd").message, "one sample thick", "--method count")
    found = ok("measure", "slice.nrrd", "--iso", "10", "--method", "count", "--json").json
    assert found["volume"] == 10


def test_the_piece_that_values_are_of_is_named():
    write_sphere()
    for kind in ("statistics", "histogram"):
        words = ("measure", kind, "sphere.nrrd", "--iso", "0", "--seed", "31,32,32")
        assert ok(*words, "--json").json["seed"] == [31, 32, 32]
        says(ok(*words).text, "the piece around the seed")


def test_percentiles_have_as_many_digits_as_tell_them_apart():
    write("a.nrrd", (1e6 + np.linspace(-1, 1, 1000)).reshape(10, 10, 10))
    line = next(l for l in ok("measure", "statistics", "a.nrrd", env={"COLUMNS": "200"}).text.split("\n") if l.startswith("percentiles"))
    shown = [float(part.split()[0]) for part in line.split(":")[1:]]
    for value, want in zip(shown, (-0.998, -0.98, -0.5, 0.5, 0.98, 0.998)):
        assert abs(value - 1e6 - want) < 0.01, line


def test_a_profile_that_leaves_the_volume_says_so():
    write_sphere()
    says(ok("measure", "profile", "sphere.nrrd", "--point", "0,9,9", "--point", "90,9,9").message, "outside the volume")


def test_other_words_for_what_is_measured_are_understood():
    write_sphere()
    for word, want in (("hist", "histogram"), ("dist", "distance"), ("stats", "statistics"), ("centroid", "box"), ("hausdorff", "distance")):
        says(fails(2, "measure", word, "sphere.nrrd"), f"did you mean '{want}'")


def test_wrong_words_are_told():
    write_sphere()
    says(fails(2, "measure", "aera", "sphere.nrrd"), "did you mean 'area'")
    says(fails(2, "measure", "area"), "of which file")
    says(fails(2, "measure", "sphere.nrrd", "--iso", "x"), "--iso")
    says(fails(2, "measure", "sphere.nrrd", "--threshold", "three"), "LO..HI")
    one, open_ended = (ok("measure", "volume", "sphere.nrrd", "--threshold", t, "--json").json for t in ("3", "3.."))
    assert one["volume"] == open_ended["volume"], (one, open_ended)
    says(fails(2, "measure", "sphere.nrrd", "--threshold", "5,3"), "LO is above HI")
    says(fails(2, "measure", "sphere.nrrd", "--iso", "1", "--label", "2"), "one of them")
    says(fails(2, "measure", "sphere.nrrd", "--box", "1:2"), "three ranges")
    says(fails(2, "measure", "sphere.nrrd", "--seed", "99,1,1", "--iso", "0"), "outside")


def test_options_are_the_properties_that_scenes_keep():
    write_sphere()
    options = {o.get("option", o["name"]): o for o in ok("help", "measure", "--json").json["verbs"][0]["options"]["measurement"]}
    kept = ok("schema").json["$defs"]["measurement"]["properties"]
    assert {o["name"] for o in options.values()} < set(kept) and {"threshold", "point", "channel", "bins"} < set(options)
    for no_option in ("what", "title", "file", "other", "figures", "threshold_hi", "cut_planes"):
        assert no_option in kept and no_option not in options
        says(fails(2, "measure", "sphere.nrrd", f"--{no_option.replace('_', '-')}=1"), "has no option")
    words = ("measure", "profile", "sphere.nrrd", "--point", "1,2,3", "--point", ".5,+30,62.", "--samples", "5")
    ok(*words, "--store", "a.vv.json:line")
    ok("measure", "statistics", "sphere.nrrd", "--threshold", "5..", "--threshold", "..7", "--store", "a.vv.json:some")
    with open("a.vv.json", encoding="utf-8") as file:
        stored = json.load(file)["measurements"]
    assert stored["line"]["points"] == [[1, 2, 3], [0.5, 30, 62]] and stored["line"]["samples"] == 5
    assert stored["some"]["threshold_hi"] == 7 and "threshold_lo" not in stored["some"]
    for option, typed, wanted in (("--seed", "1,2", "X,Y,Z"), ("--point", "1,x,2", "X,Y,Z"), ("--range", "1..x", "LO..HI"),
                                  ("--threshold", "a..b", "LO..HI"), ("--threshold", "5..1", "exchange"), ("--iso", "x", "number")):
        says(fails(2, "measure", "histogram", "sphere.nrrd", option, typed), f"{option}: ", wanted, f"'{typed}'")


main()
