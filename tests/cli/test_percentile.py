"""Windows by percentile: against numpy's, however far out a few samples lie, and over all time steps."""
import struct
from harness import Skip, fails, main, ok, says

try:
    import numpy as np
except ImportError:
    np = None


def need_numpy():
    if np is None:
        raise Skip("numpy is not there")


def samples(kind, outlier):
    """50 x 40 x 30 samples, the last of them far out."""
    random = np.random.default_rng(7)
    data = random.normal(100, 300, (30, 40, 50)) if np.dtype(kind).kind == "f" else random.integers(0, 100, (30, 40, 50))
    data = data.astype(kind)
    if outlier is not None:
        data[-1, -1, -1] = outlier
    return data


def same_window(data, output, percents):
    lo, hi = np.percentile(data.astype("f8"), percents)
    want = np.clip((data.astype("f8") - lo) / (hi - lo), 0, 1)
    error = np.abs(np.load(output) - want).max()
    assert error < 1e-9, (data.dtype, percents, error)


def test_percentiles_are_those_of_numpy():
    need_numpy()
    for kind, outlier in (("f4", None), ("f4", 1e30), ("f4", -1e6), ("f8", 1e300), ("i4", 2**31 - 1), ("i4", -2**31),
                          ("u4", 2**32 - 1), ("i8", 2**52), ("u2", 65535), ("i2", -32768), ("u1", 255), ("i1", -128)):
        data = samples(kind, outlier)
        np.save("a.npy", data)
        for percents in ((1, 99), (0.05, 73.1)):
            ok("convert", "a.npy", "-o", "b.npy", "--type", "f64", "--percentile", "%g,%g" % percents)
            same_window(data, "b.npy", percents)
            ok("convert", "a.npy", "-o", "c.npy", "--type", "f64", "--percentile", "%g,%g" % percents, "--threads", "1")
            assert open("b.npy", "rb").read() == open("c.npy", "rb").read()


def test_percentiles_of_what_memory_does_not_hold():
    need_numpy()
    data = samples("f4", 1e30)
    data = np.concatenate([data] * 20)
    np.save("a.npy", data)
    answer = ok("convert", "a.npy", "-o", "b.npy", "--type", "f64", "--percentile", "1,99", "--memory", "12M", "--json")
    assert answer.json["streamed"]
    same_window(data, "b.npy", (1, 99))


def test_percentiles_of_info_are_those_of_numpy():
    need_numpy()
    for kind in ("u1", "i2", "u2", "i4", "u4", "i8", "f4", "f8"):
        data = samples(kind, None)
        np.save("a.npy", data)
        for name, value in ok("info", "a.npy", "--stats", "--json").json["percentiles"].items():
            want = np.percentile(data.astype("f8"), float(name))
            assert abs(value - want) <= 1e-12 * abs(want), (kind, name, value, want)


def test_statistics_see_past_outliers():
    need_numpy()
    for kind, outlier in (("f4", 1e30), ("f8", 1e6), ("i4", 2**31 - 1)):
        data = samples(kind, outlier)
        np.save("a.npy", data)
        answer = ok("info", "a.npy", "--stats", "--json").json
        assert answer["max"] == float(data.max())
        for name, value in answer["percentiles"].items():
            want = np.percentile(data.astype("f8"), float(name))
            assert abs(value - want) <= 1e-9 * abs(want), (kind, name, value, want)
        counts = answer["histogram"]["counts"]
        assert sum(counts) == data.size and max(counts) < data.size / 20


def test_time_steps_share_one_window():
    need_numpy()
    header = "NRRD0004\ntype: float\ndimension: 4\nsizes: 20 20 20 3\nkinds: domain domain domain time\n" \
             "endian: little\nencoding: raw\n\n"
    data = np.random.default_rng(3).normal(size=(3, 20, 20, 20)) * np.array([1, 5, 30]).reshape(3, 1, 1, 1)
    data = data.astype("<f4")
    with open("film.nrrd", "wb") as file:
        file.write(header.encode() + data.tobytes())
    for options, (lo, hi) in ((("--percentile", "1,99"), np.percentile(data.astype("f8"), (1, 99))),
                              (("--percentile", "0,100"), (data.min(), data.max()))):
        ok("convert", "film.nrrd", "-o", "b.nrrd", "--type", "f64", *options)
        raw = open("b.nrrd", "rb").read()[-data.size * 8:]
        got = np.frombuffer(raw, "<f8").reshape(data.shape)
        assert np.abs(got - np.clip((data.astype("f8") - lo) / (hi - lo), 0, 1)).max() < 1e-6, options
    ok("rescale", "film.nrrd", "-o", "c.nrrd", "--type", "f64")
    assert open("c.nrrd", "rb").read()[-data.size * 8:] == raw
    refusal = fails(2, "convert", "film.nrrd", "-o", "d.nrrd", "--type", "u8")
    says(refusal, "--range %g..%g" % (data.min(), data.max()))


def test_equal_percentiles_leave_a_window():
    need_numpy()
    data = np.zeros((20, 20, 20), "u1")
    data[3, 3, :] = 200
    np.save("a.npy", data)
    result = ok("convert", "a.npy", "-o", "b.npy", "--type", "f64", "--percentile", "1,99")
    says(result.message, "are both 0; the window is 0 to 200")
    assert np.load("b.npy").max() == 1


def test_samples_that_are_no_numbers_are_counted():
    need_numpy()
    data = np.zeros((8, 8, 8), "f4")
    data[0, 0, :3] = np.nan, np.inf, -np.inf
    np.save("a.npy", data)
    says(ok("convert", "a.npy", "-o", "b.npy", "--type", "u8").message, "3 samples are NaN or infinite")


def test_fractions_that_become_a_few_whole_numbers_are_told():
    need_numpy()
    np.save("f.npy", np.linspace(0, 0.965, 1000, dtype="f4").reshape(10, 10, 10))
    said = ok("convert", "f.npy", "-o", "f8.npy", "--type", "u8").message
    says(said, "values from 0 to 0.965 are rounded to 2 of the numbers of u8", "--range 0..0.965 spreads them")
    assert sorted(set(np.load("f8.npy").ravel())) == [0, 1]
    said = ok("convert", "f.npy", "-o", "g8.npy", "--type", "u8", "--range", "0..0.965").message
    assert "rounded" not in said and len(set(np.load("g8.npy").ravel())) == 256, said
    for kind, data in (("i16", np.linspace(-60, 60, 1000)), ("u8", np.arange(1000) % 50), ("u16", np.linspace(0, 500, 1000))):
        np.save("f.npy", data.astype("f4").reshape(10, 10, 10))  # no fractions, or a tenth of all values stays
        assert "rounded" not in ok("convert", "f.npy", "-o", "h.npy", "--type", kind, "--overwrite").message, kind
    packed = np.arange(1000, dtype="<i2").reshape(10, 10, 10)  # 0 to 0.0999, as integers with a scale
    header = bytearray(352)
    for at, form, *values in ((0, "i", 348), (40, "8h", 3, 10, 10, 10, 1, 1, 1, 1), (70, "2h", 4, 16), (76, "8f", *[1] * 8),
                              (108, "2f", 352, 1e-4), (344, "4s", b"n+1")):
        struct.pack_into("<" + form, header, at, *values)
    with open("p.nii", "wb") as file:
        file.write(header + packed.tobytes())
    says(ok("convert", "p.nii", "-o", "p8.npy", "--type", "u8").message, "are rounded to 1 of the numbers of u8")


main()
