"""Values go out as numbers that other programs read, whatever scale the stored numbers had: every format that is written,
from every type that has a scale, read by somebody else."""
import os
import re

from harness import Skip, main, ok, says, volvis

try:
    import h5py
    import mrcfile
    import nibabel as nib
    import numpy as np
    import tifffile
    import vtk
    import zarr
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    np = None

SHAPE = (7, 5, 3)  # x, y, z

# stored type, scale, offset, range of stored numbers, and the type that must come out
CASES = [
    ("u1", 1, -1024, (0, 255), "i2"),
    ("u1", 2, 0, (0, 100), "u1"),
    ("i2", 1, -1024, (128, 2191), "i2"),
    ("i2", 1, -1024, (1024, 1200), "u1"),
    ("i2", -1, 0, (-32768, 32767), "i4"),
    ("i2", 0.5, 0, (-100, 100), "f4"),
    ("i2", 2.0219, 0, (0, 32767), "f4"),
    ("u2", 1, 32768, (0, 65535), "u4"),
    ("u2", 1e-4, 1e6, (0, 65535), "f8"),
    ("i4", 1, -1, (-2**31, 2**31 - 1), "i8"),
    ("i4", 3, 1, (-1000, 1000), "i2"),
    ("i4", 0.25, 0, (-2**31, 2**31 - 1), "f8"),
    ("u4", 1, -1, (1, 2**32 - 1), "u4"),
    ("f4", 0.5, 0, (-3, 3), "f4"),
    ("f4", 1, -273.15, (200, 350), "f4"),
    ("f4", 0.5, 10, (-3, 3), "f8"),
    ("f8", 0.5, 10, (-3, 3), "f8"),
]


def need_all():
    if np is None:
        raise Skip("one of numpy, nibabel, h5py, mrcfile, tifffile, vtk, zarr is not there")


def scaled_file(case, path="in.nii"):
    """A file of stored numbers with a scale, and the values of its samples by x, y, z."""
    kind, scale, offset, (lo, hi), _ = case
    random = np.random.default_rng(5)
    if kind[0] == "f":
        stored = random.uniform(lo, hi, SHAPE)
    else:
        stored = random.integers(lo, hi, SHAPE, endpoint=True)
    stored = stored.astype(kind)
    stored[0, 0, 0], stored[-1, -1, -1] = lo, hi
    header = nib.Nifti1Header()
    header.set_data_dtype(kind)
    header.set_data_shape(SHAPE)
    header.set_sform(np.diag([1, 2, 3, 1]), 1)
    header.set_xyzt_units("mm")
    header["scl_slope"], header["scl_inter"], header["vox_offset"], header["magic"] = scale, offset, 352, b"n+1"
    with open(path, "wb") as file:
        file.write(header.binaryblock + bytes(4) + stored.tobytes(order="F"))
    # what the header says is in single precision
    return stored.astype("f8") * float(header["scl_slope"]) + float(header["scl_inter"])


def read_nrrd(path):
    with open(path, "rb") as file:
        head, data = file.read().split(b"\n\n", 1)
    kind = re.search(rb"type: (\w+)", head).group(1).decode()
    kind = {"float": "f4", "double": "f8"}.get(kind, kind)
    return np.frombuffer(data, kind).reshape(SHAPE, order="F")


def read_vtk(reader, path):
    reader.SetFileName(path)
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(SHAPE, order="F")


def read_hdf5(path):
    found = []
    with h5py.File(path) as file:
        file.visititems(lambda _, item: found.append(item[()].T) if isinstance(item, h5py.Dataset) and item.ndim == 3 else None)
    return found[0]


def read_mrc(path):
    with mrcfile.open(path, permissive=True) as file:
        return np.array(file.data).T


READERS = {
    "nrrd": read_nrrd,
    "mha": lambda path: read_vtk(vtk.vtkMetaImageReader(), path),
    "vti": lambda path: read_vtk(vtk.vtkXMLImageDataReader(), path),
    "tif": lambda path: tifffile.imread(path).T,
    "ome.tif": lambda path: tifffile.imread(path).T,
    "ome.zarr": lambda path: np.squeeze(zarr.open(path, "r")["0"][:]).T,
    "h5": read_hdf5,
    "mrc": read_mrc,
    "npy": lambda path: np.load(path).T,
}
NO_SUCH_TYPE = {"mha": "i8", "mrc": "i8", "ome.tif": "i8"}  # of the format, or of its reader here


def same_values(got, want, kind, what):
    """Exactly, but for what single precision rounds."""
    got = got.astype("f8")
    assert got.shape == want.shape, (what, got.shape)
    error = np.abs(got - want).max()
    assert error <= (np.abs(want).max() * 2.0**-24 if kind == "f4" else 0), (what, error)


def test_the_line_tells_the_type_in_the_file():
    if not np:
        raise Skip("no python3-numpy")
    for code, expected in (("f8", "f32"), ("u2", "u16"), ("u1", "i8")):
        np.save("in.npy", np.arange(60).reshape(3, 4, 5).astype(code))
        result = ok("convert", "in.npy", "-o", "out.mrc", "--json", "--overwrite")
        assert result.json["type"] == ok("info", "out.mrc", "--json").json["type"] == expected, (code, result.json)


def test_every_format_has_the_values_that_its_other_readers_take():
    need_all()
    for case in CASES:
        want = scaled_file(case)
        for suffix, read in READERS.items():
            output = f"out.{suffix}"
            result = volvis("convert", "in.nii", "-o", output, "--overwrite")
            if case[4] in NO_SUCH_TYPE.get(suffix, ""):
                continue
            assert result.code == 0, (case, suffix, result.message)
            got = read(output)
            if suffix == "mrc":
                same_values(got, want, "f4" if got.dtype.kind == "f" else case[4], (case, suffix))
                continue
            assert got.dtype.newbyteorder("=") == np.dtype(case[4]), (case, suffix, got.dtype)
            same_values(got, want, case[4], (case, suffix))


def test_raw_samples_are_values_and_volvis_reads_them_back():
    need_all()
    for case in CASES:
        want = scaled_file(case)
        for suffix in ("raw", "vvh", "nrrd", "h5", "mha"):
            result = volvis("convert", "in.nii", "-o", f"out.{suffix}", "--overwrite")
            assert result.code == 0 or suffix == "vvh", result.message
            if suffix == "vvh" and result.code != 0:
                continue
            if suffix == "raw":
                same_values(np.fromfile("out.raw", case[4]).reshape(SHAPE, order="F"), want, case[4], case)
                continue
            ok("convert", f"out.{suffix}", "-o", "again.npy", "--type", "f64", "--overwrite")
            same_values(np.load("again.npy").T, want, case[4], (case, suffix))


def test_nifti_keeps_the_stored_numbers_and_their_scale():
    need_all()
    for case in CASES:
        want = scaled_file(case)
        ok("convert", "in.nii", "-o", "out.nii", "--overwrite")
        image = nib.load("out.nii")
        assert image.get_data_dtype() == np.dtype(case[0]), case
        assert np.array_equal(image.get_fdata(), want), case


def test_stored_numbers_go_out_where_they_are_asked_for():
    need_all()
    for case in CASES:
        want = scaled_file(case)
        for suffix in ("nrrd", "h5", "ome.zarr", "vti", "mha", "tif"):
            result = volvis("convert", "in.nii", "-o", f"out.{suffix}", "--stored", "--overwrite")
            if result.code != 0:
                continue
            if suffix == "nrrd":
                assert read_nrrd("out.nrrd").dtype == np.dtype(case[0])
            info = ok("info", f"out.{suffix}", "--json").json
            assert info["type"] == {"u": "u", "i": "i", "f": "f"}[case[0][0]] + str(8 * int(case[0][1])), (case, suffix)
            ok("convert", f"out.{suffix}", "-o", "again.npy", "--type", "f64", "--overwrite")
            assert np.allclose(np.load("again.npy").T, want, rtol=1e-12, atol=0), (case, suffix)


def test_a_type_that_is_asked_for_with_values_kept_is_that_of_the_numbers():
    need_all()
    scaled_file(CASES[2])
    want = ok("rescale", "in.nii", "-o", "want.nrrd", "--keep-values", "--to", "0,255")
    says(want.text, "f32, the values of")
    for suffix, tells in (("nrrd", True), ("mha", True), ("nii", False)):
        made = ok("rescale", "in.nii", "-o", f"out.{suffix}", "--type", "u8", "--keep-values")
        assert ("may not know" in made.message) == tells, made.message
        assert ok("info", f"out.{suffix}", "--json").json["type"] == "u8"
    assert read_nrrd("out.nrrd").dtype == np.uint8
    assert ok("rescale", "in.nii", "-o", "plain.nrrd", "--type", "u8").message == ""


def test_operations_write_values_too():
    need_all()
    want = scaled_file(CASES[2])
    ok("flip", "in.nii", "-o", "out.nrrd", "--axes", "x")
    same_values(read_nrrd("out.nrrd"), want[::-1], "i2", "flip")
    ok("crop", "in.nii", "-o", "out.npy", "--x", "1:4")
    same_values(np.load("out.npy").T, want[1:4], "i2", "crop")


def test_what_is_written_is_told():
    need_all()
    scaled_file(CASES[2])
    says(ok("convert", "in.nii", "-o", "out.nrrd").text, "7 x 5 x 3 i16, the values of i16 - 1024;")
    assert "values of" not in ok("convert", "in.nii", "-o", "out.nii").text
    assert ok("convert", "in.nii", "-o", "o.nrrd", "--json").json["type"] == "i16"
    scaled_file(CASES[5])
    says(ok("convert", "in.nii", "-o", "out.nrrd", "--overwrite", "--dry-run").text, "smallest type")
    says(ok("convert", "in.nii", "-o", "out.nrrd", "--overwrite").text, "f32, the values of i16 * 0.5;")
    says(volvis("convert", "in.nii", "-o", "s.npy", "--stored").message, "scale of values")


def test_time_steps_share_a_type():
    need_all()
    header = nib.Nifti1Header()
    header.set_data_dtype("i2")
    header.set_data_shape((4, 3, 2, 2))
    header["scl_slope"], header["scl_inter"], header["vox_offset"], header["magic"] = 1, 5, 352, b"n+1"
    stored = np.zeros((4, 3, 2, 2), "i2")
    stored[..., 1] = 300
    with open("in.nii", "wb") as file:
        file.write(header.binaryblock + bytes(4) + stored.tobytes(order="F"))
    ok("convert", "in.nii", "-o", "out.npy")
    got = np.load("out.npy")
    assert got.dtype == np.dtype("u2") and set(got.ravel()) == {5, 305}, got


def test_what_is_streamed_and_what_comes_by_a_pipe_is_the_same():
    need_all()
    random = np.random.default_rng(3)
    stored = random.integers(0, 3000, (256, 160, 160)).astype("i2")
    header = nib.Nifti1Header()
    header.set_data_dtype("i2")
    header.set_data_shape(stored.shape)
    header["scl_slope"], header["scl_inter"], header["vox_offset"], header["magic"] = 1, -1024, 352, b"n+1"
    with open("in.nii", "wb") as file:
        file.write(header.binaryblock + bytes(4) + stored.tobytes(order="F"))
    want = stored.astype("i4") - 1024
    for words in (("in.nii",), ("-",)):
        data = open("in.nii", "rb").read() if words == ("-",) else b""
        result = ok("convert", *words, "-o", "out.npy", "--memory", "24MiB", "--overwrite", "--json", stdin=data)
        got = np.load("out.npy").T
        assert got.dtype == np.dtype("i2") and np.array_equal(got, want), words
        assert result.json["streamed"] or words == ("in.nii",), words


def test_ct_of_a_scanner_is_in_hounsfield_units():
    need_all()
    folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 3, "shared", "data", "formats", "dicom", "single")
    if not os.path.isdir(folder):
        raise Skip("shared data is not there")
    ok("convert", f"{folder}:1", "-o", "ct.tif")
    got = tifffile.imread("ct.tif")
    assert (got.min(), got.max()) == (-896, 1167), (got.min(), got.max())


main()
