"""Filters of values, against NumPy and scikit-image: all types, missing values, scales, little memory."""
from harness import Skip, fails, main, ok, says, write_labels

try:
    import numpy as np
except ImportError:
    np = None

KINDS = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
SHAPES = ((5, 7, 11), (1, 9, 1))


def need_numpy():
    if np is None:
        raise Skip("NumPy is not there")


def samples(kind, shape=(5, 7, 11), seed=3, holes=True):
    data = np.random.default_rng(seed).normal(60, 20, shape).clip(0, 127).astype(kind)
    if holes and data.dtype.kind == "f":
        data[0, shape[1] // 2, shape[2] // 3] = np.nan
    return data


def result(*words):
    """Of the verb on a.npy."""
    ok(words[0], "a.npy", "-o", "b.npy", "--overwrite", *words[1:])
    return np.load("b.npy")


def same(got, want, what):
    assert got.dtype == want.dtype and np.array_equal(got, want, equal_nan=got.dtype.kind == "f"), what


def test_clamping_is_that_of_numpy():
    need_numpy()
    for kind in KINDS:
        for shape in SHAPES:
            data = samples(kind, shape)
            np.save("a.npy", data)
            same(result("clamp", "--range", "40..70"), np.clip(data, np.array(40, kind), np.array(70, kind)), kind)
            same(result("clamp", "--range", "40.."), np.where(data < 40, np.array(40, kind), data), kind)
            want = np.where(data < 40, 1, np.where(data > 70, 99, data)).astype(kind)
            same(result("clamp", "--range", "40..70", "--below", "1", "--above", "99"), want, kind)


def test_clamping_keeps_all_digits_and_ends_inside_the_range():
    need_numpy()
    large = np.array([[[-5, 0, 2**62 + 1, 2**63 - 1]]], "i8")
    np.save("a.npy", large)
    same(result("clamp", "--range", "0.."), np.maximum(large, 0), "i8")
    np.save("a.npy", np.arange(9, dtype="u1").reshape(1, 1, 9))
    same(result("clamp", "--range", "1.2..6.7"), np.arange(9).clip(2, 6).astype("u1").reshape(1, 1, 9), "between")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy", "--range", "300.."), "u8")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy", "--range", "1..2", "--above", "300"), "0 to 255")
    says(fails(2, "clamp", "a.npy", "-o", "x.npy"), "range is needed")


def write_scaled(path, data):
    """Stored numbers that mean 100 - 2 v."""
    with open(path, "wb") as file:
        file.write((f"NRRD0005\ntype: int16\ndimension: 3\nsizes: {data.shape[2]} {data.shape[1]} {data.shape[0]}\n"
                    "encoding: raw\nendian: little\nvolvis value scale:=-2\nvolvis value offset:=100\n\n").encode())
        file.write(data.tobytes())


def test_values_are_meant_and_not_stored_numbers():
    need_numpy()
    data = samples("i2")
    write_scaled("s.nrrd", data)
    if ok("info", "s.nrrd", "--json").json.get("value_scale") != -2:
        raise Skip("the scale is written otherwise")
    ok("clamp", "s.nrrd", "-o", "c.npy", "--overwrite", "--range", "-60..20")
    assert (np.load("c.npy") == (100 - 2.0 * data).clip(-60, 20)).all()
    mask = samples("u1", seed=5) > 60
    np.save("m.npy", mask.astype("u1"))
    ok("mask", "s.nrrd", "m.npy", "-o", "c.npy", "--overwrite", "--fill", "-40")
    assert (np.load("c.npy") == np.where(mask, 100 - 2.0 * data, -40)).all()


def test_masks_keep_what_they_mark():
    need_numpy()
    for kind in KINDS:
        for shape in SHAPES:
            data, mask = samples(kind, shape), (samples(kind, shape, 9) // 30).astype(kind)
            there = np.nan_to_num(mask.astype("f8")) != 0
            np.save("a.npy", data)
            np.save("m.npy", mask)
            same(result("mask", "mask=m.npy"), np.where(there, data, 0).astype(kind), kind)
            same(result("mask", "m.npy", "--invert", "--fill", "7"), np.where(there, 7, data).astype(kind), kind)
            two = np.isin(np.nan_to_num(mask), [1, 3])
            same(result("mask", "m.npy", "--label", "1,3"), np.where(two, data, 0).astype(kind), kind)


def test_masks_name_labels_as_their_file_does():
    need_numpy()
    write_labels("organs.seg.nrrd")
    ok("convert", "organs.seg.nrrd", "-o", "l.npy", "--overwrite")
    labels = np.load("l.npy")
    ok("calc", "100+i", "organs.seg.nrrd", "-o", "v.nrrd", "--overwrite")
    ok("mask", "v.nrrd", "mask=organs.seg.nrrd", "--label", "left kidney", "-o", "c.npy", "--overwrite")
    want = np.where(labels == 7, 100 + np.arange(24)[None, None, :], 0)
    assert (np.load("c.npy") == want).all()
    says(fails(2, "mask", "v.nrrd", "mask=organs.seg.nrrd", "--label", "left kidnei", "-o", "x.npy"), "left kidney")
    np.save("small.npy", samples("u1"))
    says(fails(2, "mask", "v.nrrd", "small.npy", "-o", "x.npy"), "resample it first")
    says(fails(2, "mask", "v.nrrd", "-o", "x.npy"), "mask")


def in_little_memory(name, *words, kind="f4", memory="14M"):
    np.save("a.npy", samples(kind, (120, 120, 121)))
    np.save("m.npy", samples(kind, (120, 120, 121), 9) // 60)
    ok(name, "a.npy", "-o", "whole.npy", "--overwrite", *words)
    ok(name, "a.npy", "-o", "parts.npy", "--overwrite", "--memory", memory, *words)
    assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read(), name


def test_clamp_and_mask_in_little_memory_are_the_same():
    need_numpy()
    in_little_memory("clamp", "--range", "40..70")
    in_little_memory("mask", "mask=m.npy")


def merged(*words):
    ok("merge", *words, "-o", "b.nrrd", "--overwrite")
    ok("convert", "b.nrrd", "-o", "b.npy", "--overwrite")
    return np.load("b.npy")


def test_merging_gives_the_channels_one_after_the_other():
    need_numpy()
    both = {("u1", "u1"): "u1", ("u1", "i1"): "i2", ("u2", "u1"): "u2", ("i4", "u4"): "i8", ("u8", "i8"): "f8", ("u2", "f4"): "f4",
            ("i4", "f4"): "f8", ("f8", "f8"): "f8"}
    for (a, b), kind in both.items():
        np.save("p.npy", samples(a))
        np.save("q.npy", samples(b, seed=5))
        for word in ("p", "q"):  # as volumes, which .npy files do not tell from others
            ok("convert", word + ".npy", "-o", word + ".nrrd", "--overwrite")
        got = merged("p.nrrd", "q.nrrd", "p.nrrd")
        want = np.stack([samples(a), samples(b, seed=5), samples(a)], -1).astype(kind)
        same(got.reshape(want.shape), want, (a, b))
    large = np.array([[[2**63 - 1, -(2**63), 2**60 + 1]]], "i8")
    np.save("p.npy", large)
    np.save("q.npy", np.array([[[2**32 - 1, 0, 5]]], "u4"))
    got = merged("p.npy", "q.npy").reshape(3, 2)
    assert (got[:, 0] == large.ravel()).all() and (got[:, 1] == [2**32 - 1, 0, 5]).all()


def test_merged_channels_have_the_names_that_inputs_were_given():
    need_numpy()
    np.save("p.npy", samples("u1"))
    merged("ct=p.npy", "pet=p.npy")
    said = ok("info", "b.nrrd", "--json").json
    assert [c["name"] for c in said["channels"]] == ["ct", "pet"], said
    assert ok("channel", "b.nrrd", "-o", "c.npy", "--overwrite", "--channel", "pet")
    says(fails(2, "merge", "p.npy", "p.npy", "--names", "a,b,c", "-o", "x.nrrd"), "expected 2")
    says(fails(2, "merge", "p.npy", "-o", "x.nrrd"), "merge")
    np.save("small.npy", samples("u1", (1, 2, 3)))
    says(fails(2, "merge", "p.npy", "small.npy", "-o", "x.nrrd"), "resample it first")


def test_merging_in_little_memory_is_the_same():
    need_numpy()
    in_little_memory("merge", "m.npy", memory="20M")


main()
