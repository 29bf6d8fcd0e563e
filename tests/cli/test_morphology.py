"""Morphology against SciPy's: an independent program's result on odd sizes, all types, amounts and labels."""
from harness import Skip, fails, main, ok

try:
    import nibabel
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None

SHAPES = (((7, 11, 131), (1, 1, 1)), ((9, 14, 21), (3, 2, 1)), ((1, 17, 19), (2, 4, 0)), ((5, 6, 37), (18, 1, 2)))


def need_scipy():
    if np is None:
        raise Skip("SciPy or nibabel is not there")


def samples(kind, shape):
    random = np.random.default_rng(11)
    if np.dtype(kind).kind == "f":
        return random.normal(0, 100, shape).astype(kind)
    ends = np.iinfo(kind)
    return random.integers(ends.min, ends.max, shape, dtype=kind, endpoint=True)


def element(shape, radius, volume):
    """Of radii along x, y, z, as an array with axes z, y, x."""
    r = [0 if n == 1 else r for r, n in zip(radius[::-1], volume)]
    away = np.meshgrid(*(np.arange(-a, a + 1) for a in r), indexing="ij")
    if shape == "box":
        return np.ones_like(away[0], bool)
    if shape == "cross":
        return sum(a != 0 for a in away) <= 1
    return sum((a / max(n, 1)) ** 2 for a, n in zip(away, r)) <= 1 + 1e-9


def run(verb, data, *words):
    np.save("a.npy", data)
    ok(verb, "a.npy", "-o", "b.npy", "--overwrite", *words)
    return np.load("b.npy")


def extreme(data, footprint, greatest):
    """Beyond the border nothing counts: SciPy takes what is no better there."""
    ends = (-np.inf, np.inf) if data.dtype.kind == "f" else (np.iinfo(data.dtype).min, np.iinfo(data.dtype).max)
    if data.dtype.itemsize == 8 and data.dtype.kind != "f":  # SciPy reckons in doubles: by hand
        out = data.copy()
        padded = np.pad(data, [(n // 2, n // 2) for n in footprint.shape], constant_values=ends[0 if greatest else 1])
        for at in np.argwhere(footprint):
            part = padded[tuple(slice(a, a + n) for a, n in zip(at, data.shape))]
            out = np.maximum(out, part) if greatest else np.minimum(out, part)
        return out
    filter_of = ndimage.maximum_filter if greatest else ndimage.minimum_filter
    return filter_of(data, footprint=footprint, mode="constant", cval=ends[0 if greatest else 1])


def test_amounts_are_those_of_scipy():
    need_scipy()
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"):
        for number, (shape, radius) in enumerate(SHAPES):
            data = samples(kind, shape)
            name = ("ball", "box", "cross")[number % 3]
            footprint = element(name, radius, shape)
            words = ("--radius-voxels", "%d,%d,%d" % radius, "--shape", name)
            large = extreme(data, footprint, True)
            small = extreme(data, footprint, False)
            for verb, want in (("dilate", large), ("erode", small), ("open", extreme(small, footprint, True)),
                               ("close", extreme(large, footprint, False))):
                got = run(verb, data, *words)
                assert got.dtype == data.dtype and (got == want).all(), (verb, kind, shape, radius, name)


def test_top_hat_is_that_of_scipy():
    need_scipy()
    for kind in ("u1", "u2", "i2", "f4"):
        data = samples(kind, (9, 14, 21)) // 4
        footprint = element("ball", (2, 2, 2), data.shape)
        opened = extreme(extreme(data, footprint, False), footprint, True)
        closed = extreme(extreme(data, footprint, True), footprint, False)
        words = ("--radius-voxels", "2,2,2")
        assert (run("top-hat", data, *words) == data - opened).all(), kind
        assert (run("top-hat", data, "--dark", *words) == closed - data).all(), kind


def blobs(shape, labels):
    """Balls, some of which touch, some with holes."""
    random = np.random.default_rng(5)
    out = np.zeros(shape, "u2")
    grid = np.indices(shape)
    for number in range(labels):
        middle = [random.uniform(0, n) for n in shape]
        away = sum((g - m) ** 2 for g, m in zip(grid, middle)) ** 0.5
        out[(away < random.uniform(3, 9)) & (out == 0)] = 3 + 7 * number
    out[random.uniform(size=shape) < 0.03] = 0
    return out


def labels_by(verb, data, *words):
    image = nibabel.Nifti1Image(data.T, np.eye(4))
    image.header.set_intent("label")
    nibabel.save(image, "a.nii")
    ok(verb, "a.nii", "-o", "b.nii", "--overwrite", *words)
    return np.asarray(nibabel.load("b.nii").dataobj).T


def test_labels_are_those_of_scipy():
    need_scipy()
    data = blobs((29, 35, 140), 20)
    ids = [n for n in np.unique(data) if n]
    footprint = element("ball", (3, 3, 3), data.shape)
    words = ("--radius-voxels", "3,3,3")
    near = np.stack([ndimage.distance_transform_edt(data != n) for n in ids])
    want = np.where(near.min(0) <= 3, np.array(ids)[near.argmin(0)], 0)
    assert (labels_by("dilate", data, *words) == np.where(data, data, want)).all()
    kept = {n: ndimage.binary_erosion(data == n, footprint, border_value=1) for n in ids}
    assert (labels_by("erode", data, *words) == sum(n * kept[n] for n in ids)).all()
    opened = sum(n * ndimage.binary_dilation(kept[n], footprint) for n in ids)
    assert (labels_by("open", data, *words) == opened).all()
    want = data.copy()
    for n in ids:
        closed = ndimage.binary_erosion(ndimage.binary_dilation(data == n, footprint), footprint, border_value=1)
        want[closed & (want == 0)] = n
    assert (labels_by("close", data, *words) == want).all()
    one = ids[3]
    grown = ndimage.binary_dilation(data == one, footprint) & (data == 0)
    assert (labels_by("dilate", data, "--label", str(one), *words) == np.where(grown, one, data)).all()


def test_in_little_memory_it_is_the_same():
    need_scipy()
    np.save("a.npy", samples("f4", (120, 120, 120)))
    for verb in ("dilate", "close", "top-hat"):
        ok(verb, "a.npy", "-o", "whole.npy", "--overwrite", "--radius", "2")
        ok(verb, "a.npy", "-o", "parts.npy", "--overwrite", "--radius", "2", "--memory", "12M")
        assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read(), verb


def test_amounts_that_may_be_labels_are_told():
    """Two labels that touch: as amounts the larger one grows over the other, as labels neither."""
    need_scipy()
    data = np.zeros((12, 14, 16), "u1")
    data[2:10, 2:12, 2:8] = 3
    data[2:10, 2:12, 8:14] = 5
    advice = "taken as amounts"
    for kind in ("u1", "i2", "i4"):
        np.save("a.npy", data.astype(kind))
        for verb in ("dilate", "erode", "open", "close"):
            said = ok(verb, "a.npy", "-o", "b.npy", "--overwrite").message
            assert said.count(advice) == 1 and "convert FILE -o labels.seg.nrrd" in said, said
    ok("convert", "a.npy", "-o", "a.seg.nrrd")
    assert advice not in ok("erode", "a.seg.nrrd", "-o", "b.seg.nrrd", "--label", "3").message
    rng = np.random.default_rng(4)
    for other in ((data == 3) * 255, rng.integers(0, 5, data.shape), rng.normal(90, 30, data.shape).clip(0, 255), data * 100.5):
        np.save("a.npy", other.astype("f4" if other.dtype.kind == "f" and other.max() > 255 else "u1"))
        assert advice not in ok("erode", "a.npy", "-o", "b.npy", "--overwrite").message


def test_what_makes_no_sense_is_refused_in_words():
    need_scipy()
    np.save("a.npy", samples("u1", (5, 5, 300)))
    assert "too large" in fails(2, "dilate", "a.npy", "-o", "b.npy", "--radius", "120")
    assert "convert FILE -o labels.seg.nrrd" in fails(2, "dilate", "a.npy", "-o", "b.npy", "--label", "3")
    assert "ball" in fails(2, "dilate", "a.npy", "-o", "b.npy", "--shape", "bal")


main()
