"""What is seen with all defaults, in numbers: how much of the picture is covered, and in which colours."""
import os

import numpy as np
from PIL import Image

from harness import Skip, main, ok, says

SHARED = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../../shared/data"))


def ball(n=40, radius=0.5):
    line = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(line, line, line, indexing="ij")
    return np.clip((radius + 0.1 - np.sqrt(x * x + y * y + z * z)) / 0.2, 0, 1)


def noise(n=48, sigma=2.0):
    """Gaussian, smoothed, of deviation 1."""
    z = np.random.default_rng(1).normal(size=(n, n, n))
    k = np.fft.fftfreq(n)
    pass_ = np.exp(-2 * (np.pi * sigma * k) ** 2)
    z = np.fft.ifftn(np.fft.fftn(z) * pass_[:, None, None] * pass_[None, :, None] * pass_[None, None, :]).real
    return (z / z.std()).astype("f4")


def seen(data, *words):
    """Of the picture: the share that is nearly opaque, and of what is seen at all the shares that are red and blue."""
    if not isinstance(data, str):
        np.save("a.npy", data)
        data = "a.npy"
    ok("render", data, "-o", "a.png", "--overwrite", "--size", "96x96", "--background", "transparent", *words)
    rgba = np.asarray(Image.open("a.png").convert("RGBA")).astype(float)
    alpha = rgba[..., 3] / 255
    there = alpha > 0.15
    red, blue = rgba[..., 0] > rgba[..., 2] + 25, rgba[..., 2] > rgba[..., 0] + 25
    total = max(there.sum(), 1)
    return np.mean(alpha > 0.8), (red & there).sum() / total, (blue & there).sum() / total, np.mean(there)


def close_to(one, other, slack=0.02):
    assert abs(one[0] - other[0]) < slack and abs(one[3] - other[3]) < slack, (one, other)


def test_an_object_in_bright_surroundings_is_seen_like_one_in_dark_ones():
    data = (250 * ball()).astype("u1")
    dark = seen(data)
    assert 0.05 < dark[0] < 0.4, dark
    close_to(seen(255 - data), dark)
    close_to(seen((255 - data).astype("f4") * 1e-3 - 5), dark)
    close_to(seen((255 - data.astype("i2")) * 100), dark)


def test_real_data_with_their_values_turned_round():
    for name, dims in (("fuel_64x64x64_u8.raw", (64, 64, 64)), ("neghip_64x64x64_u8.raw", (64, 64, 64))):
        path = os.path.join(SHARED, "volumes", name)
        if not os.path.exists(path):
            raise Skip("no shared data")
        data = np.fromfile(path, "u1").reshape(dims)
        close_to(seen(255 - data), seen(data), 0.06)


def test_noise_in_a_background_above_the_values_of_most_samples():
    rng = np.random.default_rng(2)
    data = 24000 + 300 * rng.normal(size=(40,) * 3) + 8000 * ball()
    data.flat[rng.choice(data.size, 60, replace=False)] = -1000  # a tail that reaches far down
    share = seen(data.astype("i2"))
    assert 0.05 < share[0] < 0.4 and share[3] < 0.45, share


def test_dead_samples_far_below_do_not_make_a_block():
    data = 1000 + 1000 * ball()
    clean = seen(data.astype("i2"))
    dead = data.copy()
    dead.flat[np.random.default_rng(3).choice(data.size, 13, replace=False)] = -32768  # 0.02 %
    padded = data.copy()
    padded[0, 0, :13] = -32768
    for broken in (dead.astype("i2"), dead.astype("f4"), padded.astype("i2"), padded.astype("i4")):
        close_to(seen(broken), clean, 0.03)
    few = (100 + 100 * ball())  # few values, all in two or three bins beside the dead ones
    few.flat[:13] = -32768
    close_to(seen(few.astype("i2")), clean, 0.03)


def test_maps_of_both_signs_show_both_and_nothing_of_zero():
    z = noise()
    line = np.linspace(-1, 1, len(z))
    r2 = line[:, None, None] ** 2 + line[None, :, None] ** 2 + line[None, None, :] ** 2
    thresholded = np.where(np.abs(z) < 2.5, 0, z).astype("f4")
    uneven = np.where(z > 2.2, z, np.where(z < -2.9, z, 0)).astype("f4")
    outside = np.where(r2 > 0.8, np.nan, z).astype("f4")
    masked = np.where(r2 > 0.8, np.nan, thresholded).astype("f4")
    for data in (z, thresholded, uneven, outside, masked):
        opaque, red, blue, there = seen(data)
        assert red > 0.1 and blue > 0.1 and opaque < 0.35, (opaque, red, blue, there)


def test_maps_that_were_cut_far_from_zero_have_full_colors():
    line = np.linspace(-1, 1, 48)
    z, y, x = np.meshgrid(line, line, line, indexing="ij")
    t = 9 * np.exp(-((x - 0.4) ** 2 + y * y + z * z) / 0.05) - 8 * np.exp(-((x + 0.4) ** 2 + y * y + z * z) / 0.05)
    opaque, red, blue, there = seen(np.where(np.abs(t) < 4, 0, t).astype("f4"))
    rgba = np.asarray(Image.open("a.png").convert("RGBA")).astype(float)
    colour = (rgba[..., :3].max(axis=-1) - rgba[..., :3].min(axis=-1))[rgba[..., 3] > 128]
    assert colour.mean() > 78 and opaque > 0.05 and red > 0.3 and blue > 0.3, (colour.mean(), opaque, red, blue, there)


def test_maps_without_positive_values_are_blue():
    z = noise()
    for data in (np.minimum(z, 0), -np.abs(z), np.where(z > -2.5, 0, z).astype("f4")):
        opaque, red, blue, there = seen(data)
        assert red < 0.01 and blue > 0.5 and opaque < 0.4 and there > 0.02, (opaque, red, blue, there)


def test_a_diverging_map_leaves_zero_clear():
    z = noise()
    one_sided = np.where(z < 0, z / 8, z).astype("f4")
    flat = np.where(np.abs(z) < 1, z / 100, 0).astype("f4")
    for data, words in ((z, ["--range=-4..4"]), (one_sided, ["--range=-4..4"]), (one_sided, [])):
        opaque, red, blue, there = seen(data, "--tf", "coolwarm", *words)
        assert opaque < 0.5 and there > 0.02 and red > 0.1, (words, opaque, red, blue, there)
    assert seen(flat, "--tf", "coolwarm", "--range=-4..4")[3] == 0
    assert seen(z, "--tf", "coolwarm", "--range", "0..4")[3] > 0.02  # not about zero: as ever


def plume(outside, missing):
    """Temperatures in a ball, and what stands for no value."""
    line = np.linspace(-1, 1, 40)
    z, y, x = np.meshgrid(line, line, line, indexing="ij")
    t = 290 + 25 * np.exp(-4 * ((x - 0.2) ** 2 + y * y + z * z)) + np.random.default_rng(5).normal(0, 0.3, x.shape)
    return np.where(outside(x, y, z), missing, t)


def outer(x, y, z):
    return x * x + y * y + z * z > 0.8


def pictures(name, data, *words):
    """In 3-D and of a slice, and what was said."""
    np.save(name, data)
    out = []
    for more in ([], ["--slice", "coronal"]):
        said = ok("render", name, "-o", "m.png", "--overwrite", "--size", "64x64", *more, *words).message
        out.append(np.asarray(Image.open("m.png").convert("RGB")).astype(int))
    return *out, said


def test_a_fill_that_nobody_declares_is_seen_as_if_it_were_nan():
    wanted = pictures("nan.npy", plume(outer, np.nan).astype("f4"))
    for fill, kind in ((-9999, "f4"), (1e20, "f4"), (-1e30, "f8"), (9.969209968386869e36, "f4"), (-999, "f8"),
                       (-12345678, "f8"), (np.finfo("f4").max, "f4")):
        found = pictures("fill.npy", plume(outer, fill).astype(kind))
        for one, other in zip(found[:2], wanted):
            assert np.abs(one - other).max() < 12, (fill, np.abs(one - other).max())
        says(found[2], "% of the samples are", "left out", "volumes.fill.missing=[]")
    one, other = (pictures(name, plume(outer, fill).astype("f4"), "--percentile", "20..99")[0]
                  for name, fill in (("nan.npy", np.nan), ("fill.npy", -9999)))
    assert np.abs(one - other).max() < 12
    stored = np.round(10 * plume(outer, np.nan))
    wanted = pictures("nan.npy", stored.astype("f4"))
    for fill, kind in ((-32768, "i2"), (65535, "u2"), (-2147483648, "i4"), (4294967295, "u4")):
        found = pictures("fill.npy", np.where(np.isnan(stored), fill, stored).astype(kind))
        for one, other in zip(found[:2], wanted):
            assert np.abs(one - other).max() < 12, (fill, np.abs(one - other).max())


def test_values_that_only_look_like_a_fill_stay():
    line = np.linspace(-1, 1, 40)
    z, y, x = np.meshgrid(line, line, line, indexing="ij")
    r, grain = np.sqrt(x * x + y * y + z * z), np.random.default_rng(6).normal(size=(40,) * 3)
    ct = np.where(r < 0.6, 40, -1000) + np.where(r < 0.3, 900, 0) + 20 * grain
    cases = {"ct.npy": np.where(x * x + y * y > 0.95, -2000, np.clip(ct, -1024, 3071)).astype("i2"),
             "zero.npy": np.where(r > 0.6, 0, 1000 + 5 * grain).astype("i2"),
             "air.npy": np.where(r > 0.6, -1000, 40 + 5 * grain).astype("f4"),
             "mask.npy": np.where(r > 0.6, 0, 65535).astype("u2"),
             "levels.npy": np.where(r > 0.8, 65535, np.floor(10 * r)).astype("u2"),
             "saturated.npy": np.clip(np.where(r < 0.5, 9e4, 2e4 * (1 - r)), 0, 65535).astype("u2"),
             "nines.npy": np.where(r > 0.8, -999, 2000 * r).astype("f4")}
    for name, data in cases.items():
        np.save(name, data)
        said = ok("render", name, "-o", "c.png", "--overwrite", "--size", "16x16").message
        assert "left out" not in said, (name, said)


def test_what_is_missing_is_what_somebody_says():
    data = plume(outer, -9999).astype("f4")
    wanted = pictures("nan.npy", plume(outer, np.nan).astype("f4"))
    named = pictures("fill.npy", data, "--set", "volumes.fill.missing=[-9999]")
    assert all(np.abs(a - b).max() < 12 for a, b in zip(named[:2], wanted)) and "left out" not in named[2]
    for words in (["--set", "volumes.fill.missing=[]"], ["--range=-9999..320"]):
        whole = pictures("fill.npy", data, *words)
        assert "left out" not in whole[2] and np.abs(whole[0] - wanted[0]).max() > 50, words
    step = plume(outer, 300.5).astype("f4")  # among the others: only a person knows it
    named = pictures("fill.npy", step, "--set", "volumes.fill.missing=[300.5]")
    assert all(np.abs(a - b).max() < 12 for a, b in zip(named[:2], wanted))


def test_chosen_values_are_those_of_data_without_the_fill():
    np.save("nan.npy", plume(outer, np.nan).astype("f4"))
    wanted = ok("measure", "volume", "nan.npy", "--json").json
    for fill in (-9999, 1e20):
        np.save("fill.npy", plume(outer, fill).astype("f4"))
        found = ok("measure", "volume", "fill.npy", "--json")
        says(found.message, "far from all others", "left out")
        assert found.json["volume"] == wanted["volume"], fill
        row = ok("info", "fill.npy", "--stats", "--json").json["channels"][0]
        assert row["fill"] == fill or abs(row["fill"] / fill - 1) < 1e-6, row
        assert abs(row["fill_share"] - np.isnan(plume(outer, np.nan)).mean()) < 1e-9
        says(ok("info", "fill.npy", "--stats").text, "far from all others", "pictures leave it out")
        found = ok("isosurface", "fill.npy", "-o", "a.ply", "--overwrite")
        says(found.text + found.message, "left out", f'surface at {wanted["threshold_lo"]:.6g}')


def test_no_surface_is_between_a_fill_and_values():
    def surface(name, *words):
        found = ok("isosurface", name, "-o", "s.obj", "--overwrite", *words)
        with open("s.obj", encoding="ascii") as file:
            lines = file.read().split("\n")
        return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], "f8"), found.message

    np.save("nan.npy", plume(outer, np.nan).astype("f4"))
    values = ["--iso", "300"]
    wanted = [surface("nan.npy", *words)[0] for words in ([], values)]
    volume = ok("measure", "volume", "nan.npy", *values, "--json").json["volume"]
    for fill in (-9999, 1e20):
        np.save("fill.npy", plume(outer, fill).astype("f4"))
        for words, want in zip(([], values), wanted):
            found, said = surface("fill.npy", *words)
            says(said, "far from all others", "left out; missing none keeps them")
            assert said.count("left out") - said.count("not numbers") == 1, said
            assert found.shape == want.shape and np.abs(found - want).max() < 1e-4, (fill, words, len(found), len(want))
        found = ok("measure", "volume", "fill.npy", *values, "--json")
        says(found.message, "left out")
        assert found.json["volume"] == volume, (fill, found.json, volume)
        assert ok("measure", "area", "fill.npy", *values, "--json").json["area"] == \
            ok("measure", "area", "nan.npy", *values, "--json").json["area"]
    border, said = surface("fill.npy", "--iso", "1000")  # who asks for the border of the fill gets it
    whole = surface("fill.npy", *values, "--missing", "[]")
    assert len(border) > 1000 and len(whole[0]) > len(wanted[1]) + 1000 and "left out" not in said
    np.save("step.npy", plume(outer, 310.0).astype("f4"))  # among the others: only a person knows it
    found, said = surface("step.npy", *values, "--missing", "310,999")
    assert found.shape == wanted[1].shape and np.abs(found - wanted[1]).max() < 1e-4


def test_a_window_that_nobody_gives_leaves_the_fill_out():
    def slices(name, *words):
        said = ok("convert", name, "-o", "s/slice_%03d.png", "--overwrite", *words).message
        return np.stack([np.asarray(Image.open(f"s/slice_{k:03d}.png")) for k in range(40)]), said

    stored = np.round(10 * plume(outer, np.nan))
    np.save("nan.npy", stored.astype("f4"))
    for words in (["--type", "u8", "--percentile", "1..99"], ["--type", "u16", "--percentile", "0..100"]):
        wanted, said = slices("nan.npy", *words)
        assert "left out" not in said and wanted.max() == (255 if "u8" in words else 65535)
        for fill, kind in ((-9999, "f4"), (1e20, "f4"), (65535, "u2"), (-32768, "i2")):
            np.save("fill.npy", np.where(np.isnan(stored), fill, stored).astype(kind))
            found, said = slices("fill.npy", *words)
            says(said, "far from all others", "left out of the window")
            assert np.array_equal(found, wanted), (fill, words)
    ok("rescale", "fill.npy", "-o", "f.nrrd", "--type", "f32", "--overwrite")
    ok("rescale", "nan.npy", "-o", "n.nrrd", "--overwrite")
    with open("f.nrrd", "rb") as one, open("n.nrrd", "rb") as other:
        a, b = (np.frombuffer(file.read().split(b"\n\n", 1)[1], "<f4") for file in (one, other))
    assert np.array_equal(np.isnan(a), np.isnan(b)) and np.nanmax(np.abs(a - b)) < 1e-6
    given, said = slices("fill.npy", "--type", "u8", "--range=-32768..3200")  # a window that somebody gives is that
    assert "left out" not in said and given.max() == 255 and given[20, 20, 20] > 200


def middle_of(*words):
    """The colour in the middle of a picture, and how bright the object beside the segments is."""
    ok("render", *words, "-o", "v.png", "--overwrite", "--size", "64x64")
    rgb = np.asarray(Image.open("v.png").convert("RGB")).astype(int)
    return rgb[32, 32], rgb[18:22, 30:34].mean()


def test_segments_are_seen_in_what_they_were_found_in():
    data = 30 + 1000 * ball(radius=0.8)
    np.save("ct.npy", data.astype("i2"))
    seg = np.zeros((40, 40, 40), "u1")
    seg[14:26, 14:26, 14:26] = 6  # green
    np.save("seg.npy", seg)
    labels = ["--set", "volumes.seg.segmentation.kind=labels"]
    alone, _ = middle_of("seg.npy", *labels)
    for order in (["ct.npy", "seg.npy"], ["seg.npy", "ct.npy"]):
        both, beside = middle_of(*order, *labels)
        assert np.abs(both - alone).max() < 60 and beside > 25, (both, alone, beside)
    hidden, _ = middle_of("ct.npy")
    for more in (["--set", "volumes.ct.segmentation.transfer.opacity_scale=1"], ["--tf", "ct=skin"]):
        whole, _ = middle_of("ct.npy", "seg.npy", *labels, *more)
        assert np.abs(whole - alone).max() > 60, (more, whole, alone)
    assert np.abs(hidden - middle_of("ct.npy", "seg.npy", *labels, "--set", "volumes.seg.visible=false")[0]).max() < 3


def slice_of(*words):
    ok("render", *words, "-o", "s.png", "--overwrite", "--size", "64x64", "--slice", "axial")
    return np.asarray(Image.open("s.png").convert("RGB")).astype(int)


def test_zero_of_an_overlay_in_slices_is_clear():
    signed = np.zeros((40, 40, 40), "f4")
    signed[:, :, 20:] = 3.5
    signed[:, :20, 20:] = -3.5
    np.save("head.npy", (60 + 150 * ball()).astype("u1"))
    np.save("map.npy", signed)
    alone = slice_of("head.npy")
    for words in ([], ["--tf", "map=coolwarm", "--range", "map=-4..4"]):
        both = slice_of("head.npy", "map.npy", *words)
        changed = np.abs(both - alone).max(axis=2) > 6
        assert not changed[:, :28].any() and changed[8:56, 36:56].all(), words
        red, blue = both[..., 0] > both[..., 2] + 20, both[..., 2] > both[..., 0] + 20
        assert red[:, 36:56].mean() > 0.3 and blue[:, 36:56].mean() > 0.3, words
    single = slice_of("map.npy")
    assert (single[8:56, 8:56].min() > 0) and single[32, 12].min() > 150  # zero of a single volume is drawn


def test_slices_of_few_values_below_zero_have_zero_in_the_middle():
    data = np.zeros((24, 24, 24), "f4")
    data[11:13, 10:13, 10:13] = -3  # more than a thousandth, and fewer
    few = np.zeros((40, 40, 40), "f4")
    few[19:21, 18:21, 18:21] = -3
    for values in (data, few):
        np.save("low.npy", values)
        picture = slice_of("low.npy").reshape(-1, 3)
        grey = np.abs(picture - picture[:, :1]).max(axis=1) < 12
        assert (grey & (picture[:, 0] > 150)).mean() > 0.8 and (picture[:, 2] > picture[:, 0] + 60).any()


def test_an_option_after_several_inputs_says_for_which_it_is():
    np.save("head.npy", (60 + 150 * ball()).astype("u1"))
    np.save("act.npy", (8 * ball(radius=0.3)).astype("f4"))
    to = ["-o", "o.png", "--overwrite", "--size", "32x32"]
    said = ok("render", "head.npy", "act.npy", "--tf", "hot", "--range", "2..6", *to).message
    says(said, "--tf hot is for all 2 volumes", "--tf act=hot is for the last alone", "--range act=2..6")
    for words in (["head.npy", "act.npy", "--tf", "act=hot"], ["--tf", "hot", "head.npy", "act.npy"],
                  ["head.npy", "--tf", "bone", "act.npy", "--tf", "hot"], ["act.npy", "--tf", "hot"]):
        assert "note:" not in ok("render", *words, *to).message, words


main()
