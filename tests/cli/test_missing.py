"""What stands for no value: as --missing says, as files declare it, and as it is found."""
import json

import numpy as np
from PIL import Image

from harness import fails, main, ok, says


def plume(missing, kind="f4", more=None):
    """Temperatures in a ball, and around it what stands for no value; of `more` in half of that."""
    line = np.linspace(-1, 1, 32)
    z, y, x = np.meshgrid(line, line, line, indexing="ij")
    t = 290 + 25 * np.exp(-4 * ((x - 0.2) ** 2 + y * y + z * z)) + np.random.default_rng(5).normal(0, 0.3, x.shape)
    outside = x * x + y * y + z * z > 0.8
    t = np.where(outside & (x > 0) & (more is not None), missing if more is None else more, np.where(outside, missing, t))
    return np.round(t).astype(kind) if np.dtype(kind).kind in "iu" else t.astype(kind)


def save(name, *what):
    np.save(name, plume(*what))
    return name


def figures(*words):
    found = ok("measure", "statistics", *words, "--json").json
    return {key: found[key] for key in ("count", "min", "max", "mean", "deviation") if key in found}


def test_named_values_are_in_no_figure_and_no_picture():
    nan, step = save("nan.npy", np.nan), save("step.npy", 310.5)  # among the others: only a person knows it
    assert figures(step, "--missing", "310.5") == figures(nan) != figures(step)
    volume = [ok("measure", "volume", *words, "--iso", "300", "--json").json["volume"]
              for words in ([nan], [step, "--missing", "310.5"], [step, "--missing=[12,310.5]"], [step])]
    assert volume[0] == volume[1] == volume[2] != volume[3]
    rows = [ok("info", *words, "--stats", "--json").json["channels"][0] for words in ([nan], [step, "--missing", "310.5"])]
    assert rows[0] == rows[1]
    pictures = []
    for words in ([nan], [step, "--missing", "310.5"]):
        ok("render", *words, "-o", "a.png", "--overwrite", "--size", "64x64", "--save-scene", "s.vv.json")
        pictures.append(np.asarray(Image.open("a.png")))
    assert np.array_equal(*pictures)
    with open("s.vv.json", encoding="utf-8") as file:
        assert json.load(file)["volumes"]["step"]["missing"] == [310.5]
    assert figures("s.vv.json") == figures(nan)  # the scene says it to all who read its data
    assert figures("s.vv.json", "--missing", "none") == figures(step)


def test_what_is_written_has_nan_where_values_are_named():
    whole, nan = save("i.npy", 7, "i2"), plume(np.nan)
    wanted = np.where(np.isnan(nan), np.nan, plume(7, "i2"))
    for name, words in (("f.npy", []), ("g.npy", ["--type", "f64"])):
        ok("convert", whole, "-o", name, "--missing", "7", *words)
        found = np.load(name)
        assert found.dtype == ("f8" if words else "f4") and np.array_equal(found, wanted, equal_nan=True)
    says(ok("info", whole, "--missing", "7").text, "missing", "7, as was said, read as NaN")
    ok("median", whole, "-o", "h.npy", "--missing", "7")
    assert np.nanmin(np.load("h.npy")) > 280
    large = np.tile(plume(7, "i2"), (6, 3, 3))
    np.save("large.npy", large)
    assert ok("convert", "large.npy", "-o", "p.npy", "--missing", "7", "--memory", "6M", "--json").json["streamed"]
    assert np.array_equal(np.load("p.npy"), np.where(large == 7, np.nan, large), equal_nan=True)


def test_none_keeps_a_fill():
    fill = save("fill.npy", -9999)
    says(ok("measure", "volume", fill, "--iso", "300").message, "left out")
    for words in (["measure", "volume", fill, "--iso", "300"], ["rescale", fill, "-o", "r.npy", "--type", "u8"],
                  ["convert", fill, "-o", "c.npy", "--type", "u8", "--percentile", "1..99", "--overwrite"],
                  ["isosurface", fill, "-o", "s.ply", "--iso", "300", "--overwrite"],
                  ["render", fill, "-o", "s.png", "--size", "16x16"]):
        said = ok(*words, "--missing", "none").message
        assert "left out" not in said, (words, said)
    assert np.load("r.npy").max() == 255 and np.median(np.load("r.npy")) == 0
    assert "fill" not in ok("info", fill, "--stats", "--missing", "none", "--json").json["channels"][0]


def test_missing_is_refused_where_it_means_nothing():
    fill = save("fill.npy", -9999)
    says(fails(2, "info", fill, "--missing", "x"), "--missing", "expected numbers", "-9999", "found 'x'")
    fails(2, "render", fill, "-o", "a.png", "--missing", "1,")
    ok("isosurface", fill, "-o", "a.ply", "--iso", "300")
    for words in (["convert", "a.ply", "-o", "a.stl"], ["render", "a.ply", "-o", "a.png"], ["measure", "area", "a.ply"]):
        says(fails(2, *words, "--missing", "3"), "missing", "mesh")
    labels = np.arange(8, dtype="u1").repeat(64).reshape(8, 8, 8)
    with open("labels.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\nmeaning:=label\n\n" + labels.tobytes())
    ok("convert", "labels.nrrd", "-o", "labels.seg.nrrd")
    says(fails(2, "convert", "labels.seg.nrrd", "-o", "x.npy", "--missing", "3"), "labels", "stands for no value")
    says(fails(2, "render", "labels.seg.nrrd", "-o", "x.png", "--missing", "3"), "--missing", "labels")


def test_several_fills_are_all_found():
    nan = save("nan.npy", np.nan)
    wanted = ok("measure", "volume", nan, "--json").json["volume"]
    for one, other, kind in ((-9999, 9999, "f4"), (-999, -9999, "f4"), (1e20, -1e20, "f8"), (np.nan, -999, "f4"),
                             (-32768, 32767, "i2"), (1e20, 9999, "f8")):
        two = save("two.npy", one, kind, other)
        found = ok("info", two, "--stats", "--json").json["channels"][0]
        values = sorted(fill["value"] for fill in found["fills"])
        assert np.allclose(values, sorted(v for v in (one, other) if v == v), rtol=1e-6), (one, other, values)
        shares = [np.mean(plume(one, kind, other)[~np.isnan(plume(one, kind, other))] == np.dtype(kind).type(v)) for v in values]
        assert np.allclose(sorted(f["share"] for f in found["fills"]), sorted(shares)), (found["fills"], shares)
        volume = ok("measure", "volume", two, "--json")
        assert kind == "i2" or abs(volume.json["volume"] / wanted - 1) < 1e-5, (one, other)
        said = ok("render", two, "-o", "a.png", "--overwrite", "--size", "32x32").message
        says(said, "taken as missing and left out", "far from all others (28" if kind != "i2" else "(289 to")
    data = plume(-9999, "f4", 9999)
    data[0, 0, :3] = 5000  # values between: the upper one may be one of them
    np.save("two.npy", data)
    found = ok("info", "two.npy", "--stats", "--json").json["channels"][0]
    assert "fills" not in found, found


def test_previews_show_values_and_not_their_fill():
    def preview(name, *words):
        ok("info", name, "--preview", "-o", "p.png", "--size", "300x100", "--overwrite", *words)
        return np.asarray(Image.open("p.png").convert("L")).astype(int)

    wanted = preview(save("nan.npy", np.nan))
    assert wanted.max() > 200
    for fill, more, kind in ((-9999, None, "f4"), (1e20, None, "f4"), (-9999, 9999, "f4"), (-32768, None, "i2")):
        found = preview(save("fill.npy", fill, kind, more))
        if kind == "i2":
            np.save("nan.npy", np.where(plume(fill, kind) == fill, np.nan, plume(fill, kind)).astype("f4"))
            wanted = preview("nan.npy")
        assert np.abs(found - wanted).max() <= 2, (fill, np.abs(found - wanted).max())
    assert np.abs(preview("fill.npy", "--missing", "none") - wanted).max() > 100


def test_rescale_warns_where_few_values_remain():
    data = np.random.default_rng(1).uniform(0, 1000, (20, 20, 20)).astype("f4")
    np.save("d.npy", data)
    for words, left in ((["--from", "0..100000"], 4), (["--to", "0..5"], 6), (["--from", "0..1", "--to", "0..1", "--no-clamp"], None),
                        (["--from", "0..1000"], None), ([], None), (["--percentile", "1..99", "--to", "0..3"], 4)):
        said = ok("rescale", "d.npy", "-o", "r.npy", "--overwrite", "--type", "u8" if words[-1:] != ["--no-clamp"] else "u16",
                  *words).message
        assert ("are rounded to" in said) == (left is not None), (words, said)
        if left:
            says(said, f"are rounded to {left} of the numbers of u8", "or more were different")
            assert len(np.unique(np.load("r.npy"))) == left, words
    said = ok("convert", "d.npy", "-o", "r.npy", "--overwrite", "--type", "u8", "--range", "0..1e6").message
    says(said, "are rounded to 1 of the numbers of u8", "--range")
    assert said.count("are rounded") == 1


main()
