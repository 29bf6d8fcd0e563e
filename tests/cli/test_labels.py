"""Operations that make labels, against SciPy: an independent program's result on odd sizes and all types."""
from harness import Skip, main, ok, volvis

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None

SHAPES = (7, 11, 131), (19, 23, 1), (1, 37, 41), (16, 24, 64)
KINDS = "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"


def need_scipy():
    if np is None:
        raise Skip("SciPy is not there")


def blobs(shape, seed=3):
    return ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), 1.3) * 500


def made(verb, data, *options):
    np.save("a.npy", data)
    ok(verb, "a.npy", "-o", "b.npy", "--overwrite", *options)
    return np.load("b.npy")


def by_size(labels, n):
    """SciPy's labels numbered as ours: the largest first, of equal ones the first."""
    sizes = np.bincount(labels.ravel(), minlength=n + 1)[1:]
    rank = np.zeros(n + 1, "u4")
    rank[1 + np.lexsort((np.arange(n), -sizes))] = np.arange(1, n + 1)
    return rank[labels]


def test_threshold_is_a_comparison():
    need_scipy()
    for kind in KINDS:
        data = (np.abs(blobs(SHAPES[0])) % 100 if kind[0] == "u" or kind == "i1" else blobs(SHAPES[0])).astype(kind)
        for lo, hi in ((10, 60), (-30.5, 30.5), (50, None), (None, 20)):
            span = "--range=%s..%s" % ("" if lo is None else lo, "" if hi is None else hi)
            want = (data >= (-np.inf if lo is None else lo)) & (data <= (np.inf if hi is None else hi))
            got = made("threshold", data, span)
            assert got.dtype == "u1" and (got == want).all(), (kind, span)


def otsu(counts, values):
    """By Otsu's formula: the variance between two classes at each value."""
    n, s = np.cumsum(counts), np.cumsum(counts * values)
    with np.errstate(divide="ignore", invalid="ignore"):
        between = n * (n[-1] - n) * (s / n - (s[-1] - s) / (n[-1] - n)) ** 2
    return values[np.nanargmax(between[:-1])]


def test_otsu_is_its_formula():
    need_scipy()
    for kind in "u1", "i1", "u2", "i2", "i4", "u8":
        signed = blobs((16, 24, 64)) / 12
        data = (np.abs(signed) ** 1.5 if kind[0] == "u" else signed).clip(-120, 250).astype(kind)
        values, counts = np.unique(data, return_counts=True)
        want = data > otsu(counts.astype("f8"), values.astype("f8"))
        assert (made("threshold", data, "--method", "otsu") == want).all(), kind
        assert (made("threshold", data, "--method", "mean") == (data > data.mean())).all(), kind


def test_otsu_of_reals_is_within_a_bin():
    need_scipy()
    data = np.concatenate([np.random.default_rng(1).normal(m, 1, 40000) for m in (0, 10)]).astype("f4")
    data = np.random.default_rng(2).permutation(data).reshape(20, 40, 100)
    data[0, 0, :4] = np.nan
    values = np.sort(data[np.isfinite(data)].astype("f8"))
    bound = otsu(np.ones(values.size), values)
    np.save("a.npy", data)
    told = ok("threshold", "a.npy", "-o", "b.npy", "--overwrite", "--method", "otsu", "--json").json["thresholds"]
    gap = values[values > bound][0] - bound
    assert abs(told[0] - bound) < gap + (values[-1] - values[0]) / 32768, (told, bound)
    assert (np.load("b.npy")[0, 0, :4] == 0).all()


def test_limits_are_those_of_scikit_image():
    need_scipy()
    try:
        from skimage import filters
    except ImportError as error:
        raise Skip("scikit-image is not there") from error
    data = np.concatenate([np.random.default_rng(1).normal(m, 9, 9000) for m in (40, 110, 180)]).clip(0, 255).astype("u1").reshape(27, 25, 40)
    assert (made("threshold", data, "--method", "otsu") == (data > filters.threshold_otsu(data))).all()
    for classes in 3, 4:
        limits = filters.threshold_multiotsu(data, classes, nbins=256)
        assert (made("threshold", data, "--method", "multi-otsu", "--classes", str(classes)) == np.digitize(data, limits, right=True)).all()
    assert (made("threshold", data, "--method", "li") == (data > filters.threshold_li(data, tolerance=1e-4))).mean() > 0.999
    want = filters.apply_hysteresis_threshold(data, 119.5, 200.5)
    assert (made("threshold", data, "--method", "hysteresis", "--range", "120..", "--strong", "201..", "--connectivity", "6") == want).all()


def test_hysteresis_keeps_what_has_a_strong_value():
    need_scipy()
    for shape in SHAPES:
        data = blobs(shape).astype("f4")
        for axes, connectivity in (1, 6), (2, 18), (3, 26):
            labels, n = ndimage.label(data >= 20, ndimage.generate_binary_structure(3, axes))
            strong = np.unique(labels[data >= 90])
            want = np.isin(labels, strong[strong > 0])
            got = made("threshold", data, "--method", "hysteresis", "--range", "20..", "--strong", "90..",
                       "--connectivity", str(connectivity))
            assert (got == want).all(), (shape, connectivity)


def test_threshold_in_little_memory_is_the_same():
    need_scipy()
    data = np.tile(blobs((40, 60, 60)).astype("f4"), (3, 2, 2))
    for options in (["--range", "0.."], ["--method", "multi-otsu", "--classes", "4"]):
        np.save("a.npy", data)
        ok("threshold", "a.npy", "-o", "whole.npy", "--overwrite", *options)
        ok("threshold", "a.npy", "-o", "parts.npy", "--overwrite", "--memory", "10M", *options)
        assert open("whole.npy", "rb").read() == open("parts.npy", "rb").read()
    result = volvis("threshold", "a.npy", "-o", "c.npy", "--memory", "4M", "--method", "hysteresis", "--range", "0..",
                    "--strong", "1..")
    assert result.code != 0 and "memory" in result.message, result.message


def test_components_are_those_of_scipy():
    need_scipy()
    for shape in SHAPES:
        for t, kind in enumerate(KINDS):
            data = (blobs(shape, t) > 10 * (t % 4)).astype(kind)
            for axes, connectivity in (1, 6), (2, 18), (3, 26):
                labels, n = ndimage.label(data, ndimage.generate_binary_structure(3, axes))
                got = made("components", data, "--merge", "--connectivity", str(connectivity))
                assert got.dtype == "u4" and (got == by_size(labels, n)).all(), (shape, kind, connectivity)


def test_components_of_each_label_are_those_of_scipy():
    need_scipy()
    data = np.digitize(blobs((17, 29, 70)), [-60, -10, 10, 60]).astype("i2")
    labels, n = np.zeros(data.shape, "i8"), 0
    for value in np.unique(data[data != 0]):
        own, count = ndimage.label(data == value)
        labels[own > 0] = own[own > 0] + n
        n += count
    first = np.full(n + 1, data.size)  # SciPy's in the order of their first voxels
    np.minimum.at(first, labels.ravel(), np.arange(data.size))
    order = np.zeros(n + 1, "i8")
    order[1 + np.argsort(first[1:])] = np.arange(1, n + 1)
    assert (made("components", data) == by_size(order[labels], n)).all()


def test_components_tell_how_many_and_names_of_other_labels_are_gone():
    need_scipy()
    data = np.zeros((4, 5, 6), "u1")
    data[0, 0, :3] = data[2, 2, 2] = 1
    np.save("a.npy", data)
    told = ok("components", "a.npy", "-o", "b.npy", "--overwrite", "--json", "--min-size", "2").json
    assert told["parts"] == 1 and told["parts_found"] == 2 and told["largest_voxels"] == [3], told
    line = ok("components", "a.npy", "-o", "b.npy", "--overwrite").text
    assert "2 parts, the largest of 3 and 1 voxels" in line, line
    ok("convert", "a.npy", "-o", "named.seg.nrrd", "--overwrite")
    ok("components", "named.seg.nrrd", "-o", "parts.seg.nrrd", "--overwrite")
    names = [s["name"] for s in ok("info", "parts.seg.nrrd", "--json").json.get("labels", []) if s.get("name")]
    assert len(names) == len(set(names)), names



def filled(data, axes):
    """Holes become what they touch at most faces, of several the least."""
    out = data.copy()
    holes, n = ndimage.label(data == 0, ndimage.generate_binary_structure(3, axes))
    wide = np.pad(data, 1)
    for hole in range(1, n + 1):
        where = holes == hole
        ends = [np.r_[where.any(tuple(set(range(3)) - {a})).nonzero()[0]] for a in range(3)]
        if any(e[0] == 0 or e[-1] == size - 1 for e, size in zip(ends, data.shape) if size > 1):
            continue
        faces = np.concatenate([np.roll(wide, s, a)[1:-1, 1:-1, 1:-1][where] for a in range(3) for s in (1, -1)])
        values, counts = np.unique(faces[faces != 0], return_counts=True)
        out[where] = values[np.argmax(counts)]
    return out


def test_holes_are_filled_with_what_is_around_them():
    need_scipy()
    for t, kind in enumerate(KINDS[:8]):
        for axes, connectivity in (1, 6), (2, 18), (3, 26):
            data = (np.digitize(blobs((13, 17, 21), t), [-150, 20, 60]) - 1).astype(kind)
            data[np.abs(blobs(data.shape, t + 9)) > 120] = 0
            assert (made("fill-holes", data, "--connectivity", str(connectivity)) == filled(data, axes)).all(), kind


def test_holes_of_a_mask_are_those_of_scipy():
    need_scipy()
    data = np.abs(blobs((30, 41, 50))) < 60
    want = ndimage.binary_fill_holes(data)
    assert (made("fill-holes", data.astype("u1")) == want).all() and (want != data).any()
    want = np.stack([ndimage.binary_fill_holes(s) for s in data])  # NumPy's first axis is z
    assert (made("fill-holes", data.astype("u1"), "--slices", "axial") == want).all()
    want = np.stack([ndimage.binary_fill_holes(data[:, j]) for j in range(41)], 1)
    assert (made("fill-holes", data.astype("u2"), "--slices", "coronal") == want).all()
    want = np.stack([ndimage.binary_fill_holes(data[:, :, i]) for i in range(50)], 2)
    assert (made("fill-holes", data.astype("i8"), "--slices", "x") == want).all()


def test_an_image_has_holes_too_and_large_ones_may_stay():
    need_scipy()
    data = np.zeros((1, 20, 20), "u1")
    data[0, 2:18, 2:18] = 3
    data[0, 4:6, 4:6] = data[0, 8:15, 8:15] = 0
    assert (made("fill-holes", data) == 3).sum() == 256
    assert (made("fill-holes", data, "--max-size", "4") == 3).sum() == 256 - 49
    assert ok("fill-holes", "a.npy", "-o", "b.npy", "--overwrite", "--json").json["holes"] == 2
    result = volvis("fill-holes", "a.npy", "-o", "b.npy", "--overwrite", "--max-size", "4mm")
    assert result.code == 2 and "2.5mm3" in result.message, result.message



def test_distances_are_those_of_scipy():
    need_scipy()
    for t, shape in enumerate(SHAPES):
        data = (blobs(shape, t) > 40).astype(KINDS[t])
        data.flat[::7] *= 3
        outside, inside = ndimage.distance_transform_edt(data == 0), ndimage.distance_transform_edt(data != 0)
        for options, want in (([], outside), (["--side", "inside"], inside), (["--side", "both"], outside - inside),
                              (["--of", "3"], ndimage.distance_transform_edt(data != 3)),
                              (["--range", "1..2"], ndimage.distance_transform_edt((data < 1) | (data > 2)))):
            got = made("distance", data, *options)
            assert got.dtype == "f4" and np.abs(got - want).max() <= 1e-6 * np.abs(want).max(), (shape, options)


def test_distances_are_lengths():
    need_scipy()
    data = (blobs((14, 23, 31)) > 60).astype("u1")
    data.tofile("a.raw")
    ok("convert", "a.raw", "-o", "a.nrrd", "--raw", "31x23x14,u8,spacing=0.5x1.25x3")
    told = ok("distance", "a.nrrd", "-o", "b.npy", "--overwrite", "--json").json
    want = ndimage.distance_transform_edt(data == 0, sampling=(3, 1.25, 0.5))
    assert np.abs(np.load("b.npy") - want).max() < 1e-5 and told["object_voxels"] == data.sum(), told
    result = volvis("distance", "a.nrrd", "-o", "c.npy", "--range", "7")
    assert result.code == 0 and "infinite" in result.message and np.isinf(np.load("c.npy")).all(), result.message



def test_a_part_grows_as_far_as_scipy_says():
    need_scipy()
    for t, shape in enumerate(SHAPES):
        data = blobs(shape, t).astype("f4")
        seeds = [(a % shape[2], a // shape[2] % shape[1], a // shape[2] // shape[1]) for a in (data.argmax(), 5)]
        words = ",".join(str(c) for seed in seeds for c in seed)
        for axes, connectivity in (1, 6), (2, 18), (3, 26):
            labels, _ = ndimage.label(data >= 15.5, ndimage.generate_binary_structure(3, axes))
            found = [labels[z, y, x] for x, y, z in seeds if labels[z, y, x]]
            got = made("grow", data, "--seed", words, "--range", "15.5..", "--connectivity", str(connectivity))
            assert (got == np.isin(labels, found)).all(), (shape, connectivity)
        x, y, z = seeds[0]
        near = data[max(z - 2, 0):z + 3, max(y - 2, 0):y + 3, max(x - 2, 0):x + 3].astype("f8")
        lo, hi = near.mean() - 1.5 * near.std(ddof=1), max(near.mean() + 1.5 * near.std(ddof=1), data[z, y, x])
        labels, _ = ndimage.label((data >= lo) & (data <= hi))
        got = made("grow", data, "--seed", f"{x},{y},{z}", "--deviations", "1.5", "--radius", "2")
        assert (got == (labels == labels[z, y, x])).all(), shape


main()
