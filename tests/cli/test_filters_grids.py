"""Filters that change the grid, against NumPy and SciPy: odd sizes, all types, oblique places, little memory."""
from harness import Skip, fails, main, ok, says

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None

KINDS = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
NAMES = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "u4": "uint32", "i4": "int32", "u8": "uint64",
         "i8": "int64", "f4": "float", "f8": "double"}


def need_scipy():
    if np is None:
        raise Skip("SciPy is not there")


def samples(kind, shape, seed=3):
    data = np.random.default_rng(seed).normal(60, 20, shape).clip(0, 127)
    return data.astype(kind)


def write(path, data, directions=((1, 0, 0), (0, 1, 0), (0, 0, 1)), origin=(0, 0, 0), unit="mm"):
    """data[z, y, x] with the step along x, y, z as rows of `directions`."""
    steps = " ".join("(%.17g,%.17g,%.17g)" % tuple(d) for d in directions)
    header = (f"NRRD0005\ntype: {NAMES[data.dtype.str[1:]]}\ndimension: 3\nspace: right-anterior-superior\n"
              f"sizes: {data.shape[2]} {data.shape[1]} {data.shape[0]}\nspace directions: {steps}\n"
              f"space origin: (%.17g,%.17g,%.17g)\nspace units: \"{unit}\" \"{unit}\" \"{unit}\"\nencoding: raw\n"
              "endian: little\n\n" % tuple(origin))
    with open(path, "wb") as file:
        file.write(header.encode() + data.tobytes())


def read(path):
    """Samples of what volvis wrote, as numpy has them."""
    ok("convert", path, "-o", "read.npy", "--overwrite")
    return np.load("read.npy")


SKEW = ((0.4, 0.3, 0.1), (-0.3, 0.5, 0.2), (0.1, -0.2, 0.7))


def places(shape, directions, origin):
    z, y, x = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    return np.einsum("a...,ab->b...", np.stack([x, y, z]), np.array(directions, float)) + np.reshape(origin, (3, 1, 1, 1))


def indices(world, directions, origin):
    """Where places lie among samples, as z, y, x."""
    back = np.linalg.inv(np.array(directions, float))
    return np.einsum("a...,ab->b...", world - np.reshape(origin, (3, 1, 1, 1)), back)[::-1]


def test_resampling_onto_another_grid_is_that_of_scipy():
    need_scipy()
    for kind in KINDS:
        data = samples(kind, (9, 13, 17))
        write("a.nrrd", data, ((0.5, 0, 0), (0, -0.5, 0), (0, 0, 1)), (1, 7, 0))
        onto_shape, onto_origin = (11, 12, 15), (0.3, 1.2, 0.4)
        write("b.nrrd", samples("u1", onto_shape), [[0.7 * v for v in d] for d in SKEW], onto_origin)
        steps = [[0.7 * v for v in d] for d in SKEW]
        at = indices(places(onto_shape, steps, onto_origin), ((0.5, 0, 0), (0, -0.5, 0), (0, 0, 1)), (1, 7, 0))
        inside = np.all([(a > -0.5) & (a < n - 0.5) for a, n in zip(at, data.shape)], axis=0)
        assert inside.sum() > 200 and (~inside).sum() > 200, inside.sum()
        for name, order in (("nearest", 0), ("linear", 1)):
            ok("resample", "a.nrrd", "onto=b.nrrd", "-o", "c.nrrd", "--overwrite", "--interpolation", name, "--fill", "5")
            got = read("c.nrrd")
            assert got.dtype == data.dtype and got.shape == onto_shape
            if order:
                want = ndimage.map_coordinates(data.astype("f8"), at, order=1, mode="nearest")
            else:
                z, y, x = (np.floor(a + 0.5).clip(0, n - 1).astype(int) for a, n in zip(at, data.shape))
                want = data[z, y, x].astype("f8")
            want = np.where(inside, want, 5)
            room = 0.5001 if got.dtype.kind != "f" and order else 1e-4
            assert np.abs(got.astype("f8") - want).max() <= room, (kind, name)


def kernel(name, x):
    x = np.abs(x)
    if name == "linear":
        return np.maximum(1 - x, 0)
    if name == "cubic":  # Keys 1981
        return np.where(x < 1, (1.5 * x - 2.5) * x * x + 1, np.where(x < 2, ((-0.5 * x + 2.5) * x - 4) * x + 2, 0))
    return np.where(x < 3, np.sinc(x) * np.sinc(x / 3), 0)


def weights(name, old, new):
    """Of old samples, for each new one; beyond the ends values rise as they did."""
    step = old / new
    at, width = ((np.arange(new) + 0.5) * step - 0.5).clip(0, old - 1), max(step, 1)
    if name == "nearest":
        return np.eye(old)[np.floor((np.arange(new) + 0.5) * step).astype(int).clip(0, old - 1)]
    far = int(3 * width) + 2
    wide = kernel(name, (np.arange(-far, old + far) - at[:, None]) / width)
    out = wide[:, far : far + old].copy()
    for k in range(1, far + 1) if name != "linear" or width > 1 else ():
        for end, mirrored, w in ((0, min(k, old - 1), wide[:, far - k]), (old - 1, max(old - 1 - k, 0), wide[:, far + old - 1 + k])):
            out[:, end] += 2 * w if name != "linear" else 0
            out[:, mirrored] -= w if name != "linear" else 0
    return out / out.sum(1, keepdims=True)


def test_resampling_to_a_size_is_its_formula():
    need_scipy()
    for number, kind in enumerate(KINDS):
        for name in ("nearest", "linear", "cubic", "lanczos"):
            for shape, size in (((9, 13, 17), (14, 6, 17)), ((1, 11, 8), (1, 5, 19)), ((7, 1, 1), (3, 1, 1)))[number % 2 :]:
                data = samples(kind, shape)
                np.save("a.npy", data)
                ok("resample", "a.npy", "-o", "b.npy", "--overwrite", "--size", "%d,%d,%d" % size[::-1], "--interpolation", name)
                want = data.astype("f8")
                for axis in range(3):
                    want = np.moveaxis(np.tensordot(weights(name, shape[axis], size[axis]), want, (1, axis)), 0, axis)
                got = np.load("b.npy").reshape(size)
                if data.dtype.kind != "f":
                    want = want.clip(np.iinfo(kind).min, np.iinfo(kind).max)
                room = 1e-4 if data.dtype.kind == "f" else 0.5 + 1e-6
                assert got.dtype == data.dtype and np.abs(got - want).max() <= room, (kind, name, shape, np.abs(got - want).max())


def test_kernels_are_those_of_pillow():
    need_scipy()
    try:
        from PIL import Image
    except ImportError as error:
        raise Skip("Pillow is not there") from error
    plane = np.random.default_rng(2).normal(0, 50, (37, 53)).astype("f4")
    np.save("a.npy", plane[None])
    for name, filter_of in (("linear", Image.BILINEAR), ("cubic", Image.BICUBIC), ("lanczos", Image.LANCZOS)):
        for size in (19, 23), (90, 71), (31, 120):
            ok("resample", "a.npy", "-o", "b.npy", "--overwrite", "--size", "%d,%d,1" % size, "--interpolation", name)
            far = np.abs(np.load("b.npy")[0] - np.asarray(Image.fromarray(plane).resize(size, filter_of)))
            ends = [3 + int(np.ceil(3 * max(n / o, 1))) for n, o in zip(size[::-1], plane.shape)]  # it cuts kernels there
            assert far[ends[0] : -ends[0], ends[1] : -ends[1]].max() < 2e-3, (name, size, far.max())


def test_what_is_missing_makes_what_it_has_a_part_in_missing():
    need_scipy()
    data = samples("f4", (1, 9, 11))
    data[0, 4, 5] = np.nan
    np.save("a.npy", data)
    ok("resample", "a.npy", "-o", "b.npy", "--overwrite", "--size", "22,9,1")
    assert np.isnan(np.load("b.npy")).sum() == 4 and np.isnan(np.load("b.npy"))[0, 4, 9:13].all()


def test_without_a_fill_integers_are_0_outside_and_floats_missing():
    need_scipy()
    for kind in ("u2", "f4"):
        write("a.nrrd", samples(kind, (4, 5, 6)) + 1)
        write("b.nrrd", samples("u1", (4, 5, 9)))
        ok("resample", "a.nrrd", "onto=b.nrrd", "-o", "c.nrrd", "--overwrite")
        got = read("c.nrrd")
        assert (got[..., :6] == samples(kind, (4, 5, 6)) + 1).all()
        assert (np.isnan(got[..., 6:]) if kind == "f4" else got[..., 6:] == 0).all()


def test_resampling_in_little_memory_is_the_same():
    need_scipy()
    write("a.nrrd", samples("f4", (120, 121, 119)))
    write("b.nrrd", samples("u1", (110, 100, 120)), ((0.99, 0.1, 0), (-0.1, 0.99, 0), (0, 0.05, 1)), (-3, 2, 1.5))
    write("c.nrrd", samples("u1", (110, 100, 120)), ((0.9, 0, 0), (0, -1.1, 0), (0, 0, 1.2)), (-3, 100, 1.5))
    for onto in ("b.nrrd", "c.nrrd"):
        for name in ("linear", "lanczos"):
            words = ("resample", "a.nrrd", "onto=" + onto, "--interpolation", name, "--overwrite", "-o")
            ok(*words, "whole.nrrd")
            ok(*words, "parts.nrrd", "--memory", "20M")
            assert open("whole.nrrd", "rb").read() == open("parts.nrrd", "rb").read(), (onto, name)


def test_other_grids_are_told_to_be_resampled_and_then_go():
    need_scipy()
    write("a.nrrd", samples("f4", (4, 5, 6)))
    write("b.nrrd", samples("f4", (8, 10, 12)), ((0.5, 0, 0), (0, 0.5, 0), (0, 0, 0.5)))
    says(fails(2, "calc", "a-b", "a.nrrd", "b.nrrd", "-o", "x.nrrd"), "resample it first", "onto=")
    ok("resample", "b.nrrd", "onto=a.nrrd", "-o", "c.nrrd", "--overwrite")
    ok("calc", "a-b", "a.nrrd", "b=c.nrrd", "-o", "x.nrrd", "--overwrite")
    assert read("x.nrrd").shape == (4, 5, 6)
    ok("resample", "a.nrrd", "-o", "d.nrrd", "--size", "12,10,8")
    assert read("d.nrrd").shape == (8, 10, 12)


def test_one_grid_is_enough_for_all_time_steps():
    need_scipy()
    steps = np.random.default_rng(1).normal(0, 1, (3, 4, 5, 6)).astype("f4")
    np.save("t.npy", steps)
    np.save("many.npy", steps[:2])
    ok("resample", "t.npy", "onto=many.npy", "-o", "u.npy")
    assert (np.load("u.npy") == steps).all()


def test_padding_is_that_of_numpy():
    need_scipy()
    modes = {"value": dict(mode="constant", constant_values=7), "nearest": dict(mode="edge"), "mirror": dict(mode="reflect"),
             "wrap": {}}  # older NumPy errs where more is added than there is
    for kind in KINDS:
        for shape in ((3, 5, 7), (1, 4, 1)):
            data = samples(kind, shape)
            np.save("a.npy", data)
            for name, how in modes.items():
                value = ("--value", "7") if name == "value" else ()
                ok("pad", "a.npy", "-o", "b.npy", "--overwrite", "--x", "2,9", "--y", "0,3", "--z", "4", "--border", name, *value)
                sides = ((4, 4), (0, 3), (2, 9))
                want = np.pad(data, sides, **how) if how else data[np.ix_(*(
                    np.arange(-before, n + behind) % n for n, (before, behind) in zip(shape, sides)))]
                got = np.load("b.npy")
                assert got.dtype == want.dtype and (got == want).all(), (kind, shape, name)


def test_padding_keeps_places_and_takes_lengths_and_sizes():
    need_scipy()
    write("a.nrrd", samples("i2", (4, 5, 6)), [[2 * v for v in d] for d in SKEW], (10, 20, 30))
    ok("pad", "a.nrrd", "-o", "b.nrrd", "--size", "9,8,4", "--border", "nearest")
    ok("crop", "b.nrrd", "-o", "c.nrrd", "--x", "1..6", "--y", "1..5")
    ok("convert", "a.nrrd", "-o", "d.nrrd")
    assert read("b.nrrd").shape == (4, 8, 9)
    said, was = ok("info", "c.nrrd", "--json").json, ok("info", "d.nrrd", "--json").json
    assert said["dims"] == was["dims"] and np.allclose(said["origin"], was["origin"]), (said["origin"], was["origin"])
    assert (read("c.nrrd") == read("a.nrrd")).all()
    write("e.nrrd", samples("i2", (4, 5, 6)), ((0.5, 0, 0), (0, 1, 0), (0, 0, 2)))
    ok("pad", "e.nrrd", "-o", "f.nrrd", "--all", "2mm")
    assert read("f.nrrd").shape == (6, 9, 14)
    says(fails(2, "pad", "e.nrrd", "-o", "x.nrrd", "--size", "3,9,9"), "at least 6")
    says(fails(2, "pad", "e.nrrd", "-o", "x.nrrd", "--x", "2.5"), "whole number")
    says(fails(2, "pad", "e.nrrd", "-o", "x.nrrd", "--x", "1", "--value", "1e6"), "i16", "32767")


def test_padding_in_little_memory_is_the_same():
    need_scipy()
    write("a.nrrd", samples("f4", (120, 121, 119)))
    for border in ("value", "nearest", "mirror", "wrap"):
        words = ("pad", "a.nrrd", "--all", "5,8", "--border", border, "--overwrite", "-o")
        ok(*words, "whole.nrrd")
        ok(*words, "parts.nrrd", "--memory", "16M")
        assert open("whole.nrrd", "rb").read() == open("parts.nrrd", "rb").read(), border


def projected(data, axis, method, thick, sliding):
    n = data.shape[axis]
    slabs = [(max(k - thick // 2, 0), min(k - thick // 2 + thick, n)) for k in range(n)] if sliding else \
            [(k, min(k + thick, n)) for k in range(0, n, thick)]
    name = {"maximum": "max", "minimum": "min", "deviation": "std"}.get(method, method)
    how = getattr(np, ("nan" if data.dtype.kind == "f" else "") + name)
    slices = [how(np.take(data, range(lo, hi), axis).astype(data.dtype if name in ("max", "min") else "f8"), axis=axis)
              for lo, hi in slabs]
    return np.stack(slices, axis)


def test_projections_are_those_of_numpy():
    need_scipy()
    ways = [(axis, method, *slab) for axis in range(3) for slab in ((99, False), (4, False), (3, True))
            for method in ("maximum", "minimum", "mean", "sum", "deviation", "median")]
    for number, kind in enumerate(KINDS):
        data = samples(kind, (6, 7, 9))
        if kind in ("u8", "i8"):
            data[2] += np.array(2**60 + 1, kind)
        if data.dtype.kind == "f":
            data[1:3, 4, 5] = np.nan
        np.save("a.npy", data)
        for axis, method, thick, sliding in ways[number % 5 :: 5]:  # each way with two types
            words = ("--slab", thick) * (thick < 99) + ("--sliding",) * sliding
            ok("project", "a.npy", "-o", "b.npy", "--overwrite", "--axis", "zyx"[axis], "--method", method, *words)
            got, want = np.load("b.npy"), projected(data, axis, method, thick, sliding)
            kept, what = method in ("maximum", "minimum", "median"), (kind, axis, method, thick)
            assert not kept or got.dtype == data.dtype, (kind, got.dtype)
            got = got.reshape(want.shape)  # a short x has a channel beside it
            if method in ("maximum", "minimum"):
                assert np.array_equal(got, want), what
            elif kind in ("u8", "i8"):  # doubles
                room = 0.01 * 2**60 if method == "deviation" else 0.5
                assert np.allclose(got.astype("f8"), want, rtol=1e-12, atol=room), what
            else:
                room = 0.5 if method == "median" and data.dtype.kind != "f" else 1e-5 * max(1, np.abs(want).max())
                assert np.abs(got.astype("f8") - want).max() <= room, what


def test_projections_lie_in_the_middle_of_their_slabs():
    need_scipy()
    data = samples("f4", (9, 5, 6))
    write("a.nrrd", data, SKEW, (10, 20, 30))
    ok("project", "a.nrrd", "-o", "b.nrrd", "--method", "mean")
    said = ok("info", "b.nrrd", "--json").json
    assert said["dims"] == [6, 5, 1] and np.allclose(said["origin"], np.array([10, 20, 30]) + 4 * np.array(SKEW[2])), said
    ok("project", "a.nrrd", "-o", "c.nrrd", "--slab", "3")
    said = ok("info", "c.nrrd", "--json").json
    assert said["dims"] == [6, 5, 3] and np.allclose(said["origin"], np.array([10, 20, 30]) + np.array(SKEW[2])), said
    assert np.allclose(said["spacing"][2], 3 * np.linalg.norm(SKEW[2])), said
    says(fails(2, "project", "a.nrrd", "-o", "x.nrrd", "--sliding"), "--slab")
    says(fails(2, "project", "a.nrrd", "-o", "x.nrrd", "--slab", "0"), "less than one")


def test_projecting_in_little_memory_is_the_same():
    need_scipy()
    write("a.nrrd", samples("f4", (100, 101, 99)))
    for axis in "xyz":
        for method in ("mean", "median"):
            words = ("project", "a.nrrd", "--axis", axis, "--method", method, "--overwrite", "-o")
            ok(*words, "whole.nrrd")
            ok(*words, "parts.nrrd", "--memory", "14M")
            assert open("whole.nrrd", "rb").read() == open("parts.nrrd", "rb").read(), (axis, method)


main()
