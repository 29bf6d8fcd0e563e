"""What the CF conventions say of numbers is obeyed wherever it is written: arrays of Zarr as xarray writes them, and
variables of netCDF. Truth: the conventions by hand, in doubles."""
import base64
import itertools
import struct
import numpy
import zarr3
from harness import Skip, main, ok, says

try:
    import h5py
    import zarr
except ImportError:
    h5py = zarr = None

BYTES = [{"name": "bytes", "configuration": {"endian": "little"}}]
FILL = -32767


def need():
    if zarr is None:
        raise Skip("the zarr and h5py packages of Python are missing: skipped")


def read(name):
    ok("convert", name, "-o", "out.npy", "--overwrite")
    return numpy.load("out.npy")


def same(name, want):
    ours = read(name)
    assert ours.dtype == want.dtype, f"{name}: {ours.dtype}, not {want.dtype}"
    assert numpy.array_equal(ours.reshape(want.shape), want, equal_nan=want.dtype.kind == "f"), f"{name}: {ours} not {want}"


def packed(kind="<i2"):
    data = (numpy.indices((4, 5, 6)).sum(0) * 7 + 3).astype(kind)
    data[1, 2, 3] = data[3, 4, 5] = FILL
    return data


def write_2(name, data, attributes, fill=None, chunks=(2, 5, 4), write=True):
    array = zarr.open(name, mode="w", shape=data.shape, chunks=chunks, dtype=data.dtype, fill_value=fill)
    array.attrs.update({"_ARRAY_DIMENSIONS": ["depth", "lat", "lon"], **attributes})
    if write:
        array[:] = data


def write_3(name, data, attributes, fill=0):
    zarr3.write_array(name, data, (2, 5, 4), BYTES, fill=fill, attributes=attributes, names=["depth", "lat", "lon"])


def test_packed_integers_of_zarr_are_values_and_their_fill_is_none():
    need()
    scale = {"scale_factor": 0.01, "add_offset": 5.0, "units": "degC"}
    data = packed()
    want = numpy.where(data == FILL, numpy.nan, data.astype("f8") * 0.01 + 5).astype("f4")
    write_2("a.zarr", data, {**scale, "_FillValue": FILL})
    write_2("b.zarr", data, scale, fill=FILL)  # as xarray does it: the fill of the array
    write_2("c.zarr", data.astype(">i2"), {**scale, "missing_value": FILL})
    write_2("d.zarr", numpy.asfortranarray(data), {**scale, "_FillValue": [FILL]})
    write_3("e.zarr", data, {**scale, "_FillValue": FILL})
    for name in "abcde":
        same(f"{name}.zarr", want)
        said = ok("info", f"{name}.zarr", "--stats", "--json").json
        assert said["value_unit"] == "degC" and said["value_scale"] == 1 and said["value_offset"] == 0, said
        says(str(said["metadata"]), "stored as i16, read as f32: -32767 as stored is NaN")
    assert ok("convert", "a.zarr", "-o", "part.npy", "--x", "3:6", "--z", "1:2")
    assert numpy.array_equal(numpy.load("part.npy").ravel(), want[1:2, :, 3:6].ravel(), equal_nan=True)


def test_chunks_of_zarr_that_are_not_stored_are_none():
    need()
    data = numpy.full((4, 5, 6), FILL, "<i2")
    write_2("empty.zarr", data, {"scale_factor": 0.5}, fill=FILL, write=False)
    part = zarr.open("empty.zarr", mode="r+")
    part[:2, :, :4] = data[:2, :, :4] = 8
    same("empty.zarr", numpy.where(data == FILL, numpy.nan, data * 0.5).astype("f4"))


def test_floats_of_zarr_lose_what_stands_for_none():
    need()
    for kind in ("<f2", "<f4", ">f4", "<f8"):
        data = numpy.linspace(-3, 9, 120).reshape(4, 5, 6).astype(kind)
        data[0, 1, 2] = -999
        told = "f8" if kind == "<f8" else "f4"
        want = numpy.where(data == -999, numpy.nan, data).astype(told)
        write_2("f.zarr", data, {"_FillValue": -999.0})
        same("f.zarr", want)
        write_2("f.zarr", data, {"_FillValue": "NaN", "missing_value": -999})
        same("f.zarr", want)
        ends = data[1, 0, 0], data[3, 0, 0]
        write_2("f.zarr", data, {"valid_range": [float(e) for e in ends]})
        same("f.zarr", numpy.where((data < ends[0]) | (data > ends[1]), numpy.nan, data).astype(told))
    data = data.astype("<f4")
    write_3("g.zarr", data, {"_FillValue": base64.b64encode(struct.pack("<d", -999)).decode()})
    same("g.zarr", numpy.where(data == -999, numpy.nan, data).astype("f4"))


def test_integers_of_zarr_that_need_no_floats_stay():
    need()
    data = packed()
    for more, fill in (({"flag_values": [1, 2], "_FillValue": FILL}, None), ({"flag_meanings": "land sea", "_FillValue": 10}, None),
                       ({"_FillValue": 0}, None), ({}, 0), ({"valid_range": [-32768, 32767]}, None)):
        write_2("i.zarr", data, more, fill=fill)
        same("i.zarr", data)
    write_2("i.zarr", data, {"scale_factor": 0.5, "add_offset": 2})
    said = ok("info", "i.zarr", "--json").json
    assert (said["type"], said["value_scale"], said["value_offset"]) == ("i16", 0.5, 2), said
    zarr.array(data, store=zarr.DirectoryStore("plain.zarr"), fill_value=10)  # not of xarray: only for chunks that are missing
    same("plain.zarr", data)


def test_axes_of_zarr_have_the_names_that_xarray_gives_them():
    need()
    data = numpy.arange(60, dtype="u1").reshape(3, 4, 5)
    for names, frames, dims in ((["time", "lat", "lon"], 3, [5, 4, 1]), (["lon", "lat", "depth"], 1, [3, 4, 5]),
                                (["a", "b", "c"], 1, [5, 4, 3])):
        write_2("n.zarr", data, {"_ARRAY_DIMENSIONS": names})
        said = ok("info", "n.zarr", "--json").json
        assert (said["frames"], said["dims"]) == (frames, dims), (names, said)


def coordinates(group, data, names, lines):
    """An array in a group of Zarr with its coordinates beside it, as xarray writes them: lines: name to values and attributes."""
    top = zarr.open_group(group, mode="w")
    top.array("v", data, chunks=tuple(max(1, n // 2) for n in data.shape)).attrs["_ARRAY_DIMENSIONS"] = names
    for name, (at, attributes) in lines.items():
        top.array(name, numpy.asarray(at), chunks=3).attrs.update({"_ARRAY_DIMENSIONS": [name], **attributes})
    result = ok("info", f"{group}/:v", "--json")
    return result.json, result.message


def test_coordinates_of_zarr_place_its_samples():
    need()
    data = numpy.arange(4 * 6 * 5, dtype="f4").reshape(4, 6, 5)
    z, y, x = 10 + 2.5 * numpy.arange(4), 50 - 0.25 * numpy.arange(6), -3 + 0.5 * numpy.arange(5)
    metres = {"units": "m"}
    for kind in ("f8", "f4"):
        said, message = coordinates("g.zarr", data, ["z", "y", "x"], {
            "z": (z.astype(kind), metres), "y": (y.astype(kind), metres), "x": (x.astype(kind), metres)})
        assert said["spacing"] == [0.5, 0.25, 2.5] and said["origin"] == [-3, 50, 10] and said["unit"] == "m", said
        assert said["metadata"]["coordinates of y"] == "50 .. 48.75 m" and "warning" not in message
    assert ok("measure", "profile", "g.zarr/:v", "--point", "-3,50,10", "--point", "-1,48.75,17.5", "--space", "world",
              "--samples", "2", "--json").json["profile"][1][1] == 119  # y falls
    said, _ = coordinates("d.zarr", data[0], ["lat", "lon"], {
        "lat": ((4 * (y * 4)).astype("i2"), {"units": "degrees_north", "scale_factor": 0.0625}),
        "lon": (x, {"units": "degrees_east"})})
    assert said["spacing"][:2] == [0.5, 0.25] and said["unit"] == "deg" and said["origin"][:2] == [-3, 50], said
    said, _ = coordinates("t.zarr", data, ["time", "lat", "lon"], {"time": ([0, 6, 12, 18], {"units": "hours since 2000-01-01"})})
    assert said["frames"] == 4 and said["frame_step"] == 6 and said["spacing"] == [1, 1, 1], said


def test_coordinates_of_zarr_that_are_no_grid_are_told():
    need()
    data = numpy.zeros((4, 6, 5), "f4")
    lines = {"z": (numpy.arange(4.0), {"units": "m"}), "y": (numpy.arange(6.0), {"units": "m"}),
             "x": (numpy.arange(5.0), {"units": "m"})}
    said, message = coordinates("u.zarr", data, ["z", "y", "x"], {**lines, "z": ([0, 1, 4, 9.0], {"units": "m"})})
    says(message, "its coordinates along z are uneven (0 .. 9 m); shown as if they were even")
    assert said["spacing"] == [1, 1, 3], said
    said, message = coordinates("w.zarr", data, ["z", "y", "x"], {**lines, "z": ([0, 1, 0, 1.0], {"units": "m"})})
    says(message, "along z are neither ascending nor descending")
    said, message = coordinates("m.zarr", data, ["z", "y", "x"], {**lines, "x": (numpy.arange(5.0), {"units": "degrees_east"})})
    says(message, "its axes have different units (x: deg, y: m, z: m); shown in equal steps")
    assert said["spacing"] == [1, 1, 1] and said["unit"] == "voxels", said
    said, message = coordinates("s.zarr", data, ["z", "y", "x"], {**lines, "x": (numpy.arange(4.0), {})})  # too short: none
    says(message, "different units")


def variables(name, data, attributes):
    """The same in netCDF, in both ways of laying samples out, and in Zarr."""
    for chunks in (None, (2, 3, 4)):
        with h5py.File(f"{name}.nc", "w") as file:
            place = file.create_dataset("v", data=data, chunks=chunks, compression="gzip" if chunks else None)
            for key, value in attributes.items():
                place.attrs[key] = value
        yield f"{name}.nc"
    write_2(f"{name}.zarr", data, {k: v.tolist() if hasattr(v, "tolist") else v for k, v in attributes.items()})
    yield f"{name}.zarr"


def test_unsigned_says_how_bits_are_meant():
    need()
    rng = numpy.random.default_rng(8)
    for (kind, meant), order in itertools.product((("i1", "u1"), ("i2", "u2"), ("i4", "u4"), ("u1", "i1")), "<>"):
        data = rng.integers(numpy.iinfo(kind).min, numpy.iinfo(kind).max, (4, 5, 6), endpoint=True).astype(order + kind)
        values = data.astype(kind).view(meant)
        says_so = {"_Unsigned": "true" if kind[0] == "i" else "false"}
        for name in variables("u", data, says_so):
            same(name, values)
        fill, top = data[1, 2, 3].astype(kind), values.astype("f8").max()
        for name in variables("u", data, {**says_so, "_FillValue": fill, "scale_factor": 0.5}):
            told = "f8" if kind == "i4" else "f4"
            want = numpy.where(data == fill, numpy.nan, values.astype("f8") * 0.5).astype(told)
            same(name, want)
        if meant == "u1":  # the end of the range is written with the file's sign as well
            ends = numpy.array([10, -56], "i1")
            for name in variables("u", data, {**says_so, "valid_range": ends}):
                same(name, numpy.where((values < 10) | (values > 200), numpy.nan, values).astype("f4"))
        assert top > 0


main()
