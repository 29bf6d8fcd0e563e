"""volvis info: several inputs, containers, what a header says in words, names that a terminal would obey."""
import gzip
import os
import shutil
import struct
import zlib
from harness import Skip, fails, ok, says, volvis, main, write_ball, write_box, write_cells, write_nrrd

try:
    import h5py
    import nibabel
    import numpy
    import tifffile
except ImportError:
    numpy = None


def need():
    if not numpy:
        raise Skip("no python3-numpy, -nibabel or -h5py")


def row(text, label):
    """The line of a label."""
    lines = [line for line in text.splitlines() if line.startswith(label + " ")]
    assert len(lines) == 1, f"{label!r} in {text}"
    return lines[0][len(label):].strip()


def test_several_inputs_have_a_block_each():
    write_ball("head.nrrd", 8)
    write_box("box.ply")
    text = ok("info", "head.nrrd", "box.ply").text
    blocks = text.split("\n\n")
    assert blocks[0].startswith("head.nrrd\nformat") and blocks[1].startswith("box.ply\nformat")
    alone = ok("info", "head.nrrd", "--json").json
    several = ok("info", "head.nrrd", "box.ply", "--json").json
    assert isinstance(alone, dict) and several[0] == alone and several[1]["file"] == "box.ply" and len(several) == 2
    assert several[1] == ok("info", "box.ply", "--json").json


def test_of_several_inputs_those_that_fail_are_told_and_the_others_shown():
    write_ball("head.nrrd", 8)
    result = volvis("info", "none.nrrd", "head.nrrd", "gone.nrrd")
    assert result.code == 3 and result.text.startswith("head.nrrd\n")
    says(result.message, "none.nrrd", "gone.nrrd")
    result = volvis("info", "none.nrrd", "head.nrrd", "--json")
    assert result.code == 3
    assert result.json[0]["file"] == "none.nrrd" and "none.nrrd" in result.json[0]["error"]["message"]
    assert result.json[1]["dims"] == [8, 8, 8]


def test_missing_values_of_packed_integers_are_told():
    need()
    with h5py.File("packed.nc", "w") as f:
        f["t"] = numpy.array([[[0, 100], [-32767, 3000]]] * 2, "<i2")
        f["t"].attrs.update({"_FillValue": numpy.int16(-32767), "scale_factor": 0.01, "add_offset": 5.0})
    text = ok("info", "packed.nc").text
    assert row(text, "missing") == "stored as i16, read as f32: -32767 as stored is NaN"
    assert row(text, "range") == "5 to 35, mean 15.3333; 2 samples are not finite", row(text, "range")


def test_a_file_of_several_data_sets_lists_them():
    need()
    with h5py.File("two.h5", "w") as f:
        f["a"] = numpy.zeros((2, 3, 4), "<f4")
        f["g/b"] = numpy.ones((5, 6, 7), "<u2")
    result = ok("info", "two.h5", "--json")
    assert [p["name"].strip("/") for p in result.json["parts"]] == ["a", "g/b"]
    says(result.message, "holds 2 data sets, and none is named")
    says(result.json["parts"][0]["about"], "4 x 3 x 2 f32")
    says(result.json["parts"][1]["about"], "7 x 6 x 5 u16")
    says(fails(2, "convert", "two.h5", "-o", "x.nrrd"), "holds 2 data sets; choose one")


def folder_of(name, *volumes):
    os.makedirs(name)
    for volume in volumes:
        write_nrrd(f"{name}/{volume}.nrrd", (4, 5, 6), lambda x, y, z: x + 10 * y)
    return name


def write_png(path, width=30, height=20):
    rows = b"".join(b"\0" + bytes(3 * width) for _ in range(height))
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def parts(path):
    return {p["name"]: p["about"] for p in ok("info", path, "--json").json["parts"]}


def test_a_folder_of_several_data_sets_lists_them():
    folder_of("many", "one", "two", "three")
    write_box("many/mesh.ply")
    result = ok("info", "many", "--json")
    about = "4 x 5 x 6 u8, nrrd"
    assert [(p["name"], p["about"], p["chosen"]) for p in result.json["parts"]] == [
        ("one.nrrd", about, True), ("three.nrrd", about, False), ("two.nrrd", about, False)]
    assert result.json["file"] == "many"
    says(result.message, "one of 3 data sets", "name one as 'many/one.nrrd'")
    says(ok("info", "many").text, f"parts         one.nrrd: {about} (this one)\n")
    says(fails(3, "convert", "many", "-o", "x.npy"), "several data sets: 'one.nrrd', 'three.nrrd', 'two.nrrd'")
    for part in ("many/two.nrrd", "many:two.nrrd"):
        ok("convert", part, "-o", "x.npy", "--overwrite")


def test_stacks_in_a_folder_are_volumes_and_no_slices():
    need()
    os.makedirs("stacks")
    data = numpy.arange(60, dtype="u1").reshape(3, 4, 5)
    for at, name in enumerate("ab"):
        tifffile.imwrite(f"stacks/img3d_{name}.tif", data + at, photometric="minisblack", bigtiff=at == 1, byteorder="<>"[at])
    assert parts("stacks") == {f"img3d_{name}.tif": "5 x 4 x 3 u8, tiff" for name in "ab"}
    says(fails(3, "convert", "stacks", "-o", "x.npy"), "several data sets: 'img3d_a.tif', 'img3d_b.tif'")
    ok("convert", "stacks:img3d_b.tif", "-o", "stack.npy")
    assert numpy.array_equal(numpy.load("stack.npy"), data + 1)
    os.remove("stacks/img3d_a.tif")
    ok("convert", "stacks", "-o", "stack.npy", "--overwrite")
    assert numpy.array_equal(numpy.load("stack.npy"), data + 1)
    os.makedirs("times")
    for t in range(2):  # here a number varies: a series, as ever
        tifffile.imwrite(f"times/img_{t}.tif", data + t, photometric="minisblack")
    said = ok("info", "times", "--json").json
    assert (said["format"], said["frames"], said["dims"]) == ("slices", 2, [5, 4, 3]), said


def test_folders_that_are_volumes_are_listed():
    need()
    write_nrrd("v.nrrd", (4, 5, 6), lambda x, y, z: x)
    os.makedirs("zarrs")
    ok("convert", "v.nrrd", "-o", "zarrs/v.zarr")
    ok("convert", "v.nrrd", "-o", "zarrs/w.ome.zarr")
    said = ok("info", "zarrs", "--json").json
    assert said["folders"] == ["v.zarr", "w.ome.zarr"] and said["format"] == "folder", said
    says(ok("info", "zarrs").text, "folder of volumes that are folders", "to read it: zarrs/w.ome.zarr")
    shutil.copy("v.nrrd", "zarrs/one.nrrd")
    said = ok("info", "zarrs", "--json").json
    assert said["folders"] == ["v.zarr", "w.ome.zarr"] and said["format"] == "nrrd", said
    write_box("zarrs/box.ply")
    says(ok("info", "zarrs").text, "box.ply: ply", "v.zarr: a volume")
    os.makedirs("nothing")
    says(fails(3, "info", "nothing"), "is a folder without files")


def test_a_folder_of_files_that_the_import_program_reads_tells_the_same():
    need()
    os.makedirs("h5")
    for name in "ab":
        with h5py.File(f"h5/{name}.h5", "w") as f:
            f["v"] = numpy.zeros((2, 3, 4), "<f4")
    for words in ["info", "h5"], ["info", "h5", "--safe"]:
        assert ok(*words).message.count("one of 2 data sets") == 1, words
        assert [p["name"] for p in ok(*words, "--json").json["parts"]] == ["a.h5", "b.h5"]


def test_a_folder_with_one_volume_is_that_volume():
    folder_of("alone", "head")
    with open("alone/notes.txt", "w") as file:
        file.write("nothing")
    ok("render", "alone", "-o", "shot.png", "--size", "40x40")
    ok("convert", "alone", "-o", "alone.npy")
    assert not ok("info", "alone", "--json").json["parts"]
    os.rename("shot.png", "alone/shot.png")  # with a scene inside: nobody's slice
    ok("convert", "alone", "-o", "alone.npy", "--overwrite")
    folder_of("pair", "head")
    write_png("pair/desk.png")
    assert ok("info", "pair", "--json").json["dims"] == [4, 5, 6]
    assert parts("pair") == {"head.nrrd": "4 x 5 x 6 u8, nrrd", "desk.png": "30 x 20 x 1 x 3 u8, slices"}
    assert ok("info", "pair:desk.png", "--json").json["dims"] == [30, 20, 1]
    ok("convert", "pair", "-o", "pair.npy")
    os.makedirs("header")
    with open("header/h.mhd", "w") as file:
        file.write("ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = h.raw\n")
    with open("header/h.raw", "wb") as file:
        file.write(bytes(8))
    assert ok("info", "header", "--json").json["format"] == "metaimage"


def write_arrays(path, active=""):
    numbers = " ".join(str(i) for i in range(2 * 3 * 4))
    arrays = "".join(f'<DataArray type="Float32" Name="{name}" format="ascii">{numbers}</DataArray>' for name in "abc")
    with open(path, "w") as file:
        file.write('<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageData WholeExtent="0 1 0 2 0 3" '
                   'Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 1 0 2 0 3"><PointData' + active + ">" + arrays +
                   "</PointData></Piece></ImageData></VTKFile>")


def test_parts_have_a_type_and_dims_of_which_x_is_first():
    need()
    volume = numpy.arange(24.0).reshape(2, 3, 4)
    numpy.savez("list.npz", a=volume.astype("i2"), b=numpy.asfortranarray(volume.astype("f2")), c=numpy.arange(9))
    assert parts("list.npz") == {"a": "4 x 3 x 2 i16", "b": "4 x 3 x 2 f16", "c": "9 i64"}
    for name in "ab":
        dims = ok("info", f"list.npz:{name}", "--json").json["dims"]
        says(parts("list.npz")[name], " x ".join(str(n) for n in dims))


def test_of_several_arrays_the_one_that_is_taken_and_the_others_are_told():
    need()
    volume = numpy.arange(24.0).reshape(2, 3, 4)
    numpy.savez("all.npz", a=volume, b=-volume, c=volume)
    numpy.savez("one.npz", data=volume, affine=numpy.eye(4), labels=numpy.arange(9))
    write_arrays("all.vti")
    write_arrays("active.vti", ' Scalars="b"')
    for name, chosen, others, other in (("all.npz", "a", "b and c", "b"), ("all.vti", "a", "b and c", "b"),
                                        ("active.vti", "b", "a and c", "a")):
        told = f"holds 3 arrays, and none is named; this is {chosen}. There are {others} too, named as {name}:{other}"
        said = ok("convert", name, "-o", "x.nrrd", "--overwrite").message
        assert said.count(told) == 1, said
        assert ok("info", name, "--json").json["warnings"] == [told]
        assert not ok("info", f"{name}:c", "--json").json["warnings"]
        says(fails(2, "info", f"{name}:q"), "has no array 'q'; there are a, b and c")
    assert not ok("info", "one.npz", "--json").json["warnings"]  # a matrix and a list are no volumes
    says(fails(2, "info", "all.npz:c@1"), "there is no time step 1: it holds one volume")
    says(fails(2, "info", "all.npz:"), "no part is named after ':'")


def write_dicom(path, k):
    """A slice of 6 x 5 samples, at the height k; the least that a reader takes: explicit, little-endian."""
    def element(group, number, code, data):
        data += (b"\0" if code in ("UI", "OW") else b" ") * (len(data) % 2)
        size = struct.pack("<HI", 0, len(data)) if code == "OW" else struct.pack("<H", len(data))
        return struct.pack("<HH", group, number) + code.encode() + size + data
    def short(number, value):
        return element(0x28, number, "US", struct.pack("<H", value))
    meta = element(2, 0x10, "UI", b"1.2.840.10008.1.2.1")
    with open(path, "wb") as file:
        file.write(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta +
                   element(8, 0x16, "UI", b"1.2.840.10008.5.1.4.1.1.2") + element(8, 0x18, "UI", b"1.2.3.%d" % k) +
                   element(8, 0x60, "CS", b"CT") + element(0x20, 0xd, "UI", b"1.2.3") + element(0x20, 0xe, "UI", b"1.2.4") +
                   element(0x20, 0x11, "IS", b"7") + element(0x20, 0x13, "IS", b"%d" % k) +
                   element(0x20, 0x32, "DS", b"0\\0\\%d" % k) + element(0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0") +
                   short(2, 1) + element(0x28, 4, "CS", b"MONOCHROME2") + short(0x10, 5) + short(0x11, 6) +
                   element(0x28, 0x30, "DS", b"1\\1") + short(0x100, 16) + short(0x101, 16) + short(0x102, 15) +
                   short(0x103, 0) + element(0x7fe0, 0x10, "OW", struct.pack("<30H", *range(30))))


def dicom_of(name, n):
    os.makedirs(name, exist_ok=True)
    for k in range(n):
        write_dicom(f"{name}/im{k}.dcm", k)


def several(folder, *sets):
    """It holds these, all of which `info` lists, the first is described; nothing else chooses among them."""
    assert list(parts(folder)) == list(sets), parts(folder)
    said = fails(3, "convert", folder, "-o", "x.npy", "--overwrite")
    says(said, "several data sets", f"name one of them, as {folder}:{sets[0]}", *(f"'{one}'" for one in sets))
    for one in sets:
        ok("convert", f"{folder}:{one}", "-o", "x.npy", "--overwrite")


def test_pictures_beside_a_volume_are_another_data_set():
    folder_of("figures", "head")
    for i in 1, 2:
        write_png(f"figures/figure{i}.png")
    several("figures", "head.nrrd", "slices")
    says(fails(3, "render", "figures", "-o", "x.png"), "'slices' (2 pictures)", "figures:head.nrrd or figures:slices")
    assert ok("info", "figures:head.nrrd", "--json").json["dims"] == [4, 5, 6]
    assert ok("info", "figures:slices", "--json").json["dims"] == [30, 20, 2]
    os.makedirs("stack")
    for i in range(40):  # more than are looked into
        write_png(f"stack/s{i}.png", 3, 2)
    with open("stack/readme.txt", "w") as file:
        file.write("nothing")
    ok("convert", "stack", "-o", "x.npy", "--overwrite")
    write_nrrd("stack/one.nrrd", (4, 5, 6), lambda x, y, z: x)
    several("stack", "one.nrrd", "slices")


def test_many_pictures_that_volvis_made_are_no_data_set():
    folder_of("film", "head")
    ok("render", "film/head.nrrd", "-o", "f.png", "--size", "16x16")
    for i in range(40):
        os.link("f.png", f"film/f{i:02d}.png")
    assert ok("info", "film", "--json").json["dims"] == [4, 5, 6]


def test_dicom_files_beside_a_volume_are_another_data_set():
    dicom_of("scan", 3)
    for name, text in (("readme.txt", "nothing"), ("x.json", "{}"), ("viewer.dat", "junk"), ("index.xml", "<a/>")):
        with open(f"scan/{name}", "w") as file:
            file.write(text)
    assert ok("info", "scan", "--json").json["dims"] == [6, 5, 3]  # what is no volume changes nothing
    ok("convert", "scan", "-o", "x.npy", "--overwrite")
    assert ok("info", "scan:dicom", "--json").json["dims"] == ok("info", "scan:dicom:7", "--json").json["dims"] == [6, 5, 3]
    write_nrrd("scan/x.nrrd", (4, 5, 6), lambda x, y, z: x)
    several("scan", "x.nrrd", "dicom")
    assert ok("info", "scan:x.nrrd", "--json").json["dims"] == [4, 5, 6]
    assert ok("info", "scan:7", "--json").json["dims"] == [6, 5, 3]  # as without the volume
    says(fails(3, "convert", "scan:y.nrrd", "-o", "x.npy", "--overwrite"), "several data sets", "'x.nrrd'")
    folder_of("one", "a", "b", "c", "d", "e")
    dicom_of("one", 1)  # one file among many
    several("one", "a.nrrd", "b.nrrd", "c.nrrd", "d.nrrd", "e.nrrd", "dicom")


def test_dicom_files_called_as_volumes_are_are_dicom():
    os.makedirs("ge")
    for k in range(5):
        write_dicom(f"ge/i{k}.img", k)
    assert ok("info", "ge", "--json").json["dims"] == [6, 5, 5]


def test_time_steps_and_pictures_are_two_data_sets():
    os.makedirs("run")
    for i in range(3):
        write_nrrd(f"run/t_{i}.nrrd", (4, 5, 6), lambda x, y, z: i)
        write_png(f"run/p{i}.png")
    several("run", "t_{t}.nrrd", "slices")
    assert ok("info", "run:t_1.nrrd", "--json").json["frames"] == 1
    os.remove("run/p0.png")  # fewer than the steps
    assert ok("info", "run", "--json").json["frames"] == 3
    ok("convert", "run", "-o", "x.npy", "--overwrite")


def test_meshes_of_a_folder_are_listed_and_named():
    os.makedirs("meshes")
    for name in "ab":
        write_box(f"meshes/{name}.ply")
    said = ok("info", "meshes", "--json").json
    assert said["format"] == "folder" and said["meshes"] == [{"name": "a.ply", "format": "ply"}, {"name": "b.ply", "format": "ply"}]
    says(ok("info", "meshes").text, "meshes        a.ply: ply\n", "b.ply: ply\n")
    assert ok("info", "meshes:b.ply", "--json").json["triangles"] == ok("info", "meshes/b.ply", "--json").json["triangles"]
    says(fails(3, "render", "meshes", "-o", "x.png"), "meshes", "as meshes/a.ply")
    write_nrrd("meshes/v.nrrd", (4, 5, 6), lambda x, y, z: x)
    said = ok("info", "meshes", "--json").json
    assert said["dims"] == [4, 5, 6] and len(said["meshes"]) == 2
    ok("convert", "meshes", "-o", "x.npy", "--overwrite")
    os.makedirs("outer/inner")
    os.link("meshes/v.nrrd", "outer/inner/v.nrrd")
    says(fails(3, "info", "outer"), "its folders hold some", "outer/inner/v.nrrd")


def test_volumes_are_called_what_a_scene_with_all_of_them_calls_them():
    folder_of("a", "x", "y")
    folder_of("b", "x")
    write_cells("b/y.nrrd")
    files = ["a/x.nrrd", "b/x.nrrd", "b/y.nrrd", "a/y.nrrd"]
    said = ok("info", *files, "--json").json
    assert [one["volume"] for one in said] == ["x", "x_2", "y_0", "y"]
    says(ok("info", *files).text, "volumes.x\n", "volumes.x_2\n", "volumes.y_0 and so on\n")
    ok("render", *files[:2], "-o", "both.png", "--size", "40x40")
    assert ok("info", "both.png", "--json").json["volumes"] == ["x", "x_2"]


def test_oblique_data_say_their_angle_and_matrix():
    need()
    angle = numpy.radians(20)
    c, s = numpy.cos(angle), numpy.sin(angle)
    affine = numpy.array([[2 * c, -s, 0, 5], [2 * s, c, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1.0]])
    nibabel.save(nibabel.Nifti1Image(numpy.zeros((2, 3, 4), "u1"), affine), "o.nii")
    text = ok("info", "o.nii").text
    says(row(text, "tilt"), "20.00 degrees")
    lines = text.splitlines()
    first = [i for i, line in enumerate(lines) if line.startswith("to world")][0]
    got = [[float(v) for v in line.replace("to world", "").split()] for line in lines[first:first + 3]]
    assert numpy.allclose(got, affine[:3], atol=1e-4)
    write_ball("straight.nrrd", 8)
    assert "tilt" not in ok("info", "straight.nrrd").text and "to world" not in ok("info", "straight.nrrd").text


def test_range_mean_and_the_name_in_a_scene():
    write_nrrd("8_annotation.nrrd", (4, 5, 6), lambda x, y, z: x + 10)
    text = ok("info", "8_annotation.nrrd").text
    assert row(text, "range") == "10 to 13, mean 11.5"
    assert row(text, "in a scene") == "volumes.v8_annotation"
    assert ok("info", "8_annotation.nrrd", "--json").json["volume"] == "v8_annotation"
    ok("render", "8_annotation.nrrd", "-o", "a.png", "--size", "8x8", "--set", "volumes.v8_annotation.visible=true")


def test_whole_numbers_are_told_with_all_their_digits():
    write_nrrd("ids.nrrd", (4, 5, 6), lambda x, y, z: 3000000001 * (x == 3) + 5 * y, kind="uint32", code="I")
    assert row(ok("info", "ids.nrrd").text, "range").startswith("0 to 3000000021, mean 7.5")
    assert row(ok("info", "ids.nrrd", "--stats").text, "range") == "0 to 3000000021"


def test_a_scale_is_told_as_a_formula_without_idle_parts():
    write_nrrd("plain.nrrd", (4, 5, 6), lambda x, y, z: x)
    for scale, offset, want in ((1, -1024, "stored - 1024"), (0.5, 0, "stored * 0.5"), (2, 3, "stored * 2 + 3")):
        with open("plain.nrrd", "rb") as file:
            header, samples = file.read().split(b"\n\n", 1)
        with open("scaled.nrrd", "wb") as file:
            file.write(header + b"\nvolvis value scale:=%g\nvolvis value offset:=%g\n\n" % (scale, offset) + samples)
        assert row(ok("info", "scaled.nrrd").text, "values") == want, want


def test_large_data_are_looked_at_only_when_asked():
    with open("large.raw", "wb") as file:
        file.truncate(512 * 512 * 512)
    says(row(ok("info", "large.raw", "--raw", "512x512x512,u8").text, "range"), "were not looked at; --stats does")


def test_a_packed_file_that_is_cut_short_is_told():
    need()
    values = numpy.random.default_rng(1).integers(0, 256, (64, 64, 64)).astype("u1")
    nibabel.save(nibabel.Nifti1Image(values, numpy.eye(4)), "cut.nii.gz")
    os.truncate("cut.nii.gz", os.path.getsize("cut.nii.gz") * 4 // 5)
    result = volvis("info", "cut.nii.gz")
    assert result.code == 7, result.message
    says(result.text + result.message, "cut short")


def test_the_header_of_a_file_that_lacks_most_of_its_samples_is_told():
    need()
    values = numpy.random.default_rng(2).integers(0, 999, (20, 20, 20)).astype("i2")
    nibabel.save(nibabel.Nifti1Image(values, numpy.eye(4)), "w.nii")
    for name in ("w.nii.gz", "w.mha", "w.nrrd", "w.npy", "w.tif", "w.vti", "w.mrc"):
        ok("convert", "w.nii", "-o", name, "--overwrite")
    for name in ("w.nii", "w.nii.gz", "w.mha", "w.nrrd", "w.npy", "w.tif", "w.vti", "w.mrc"):
        os.truncate(name, os.path.getsize(name) // 3)
        said = volvis("info", name)
        assert said.code == 3 and "20 x 20 x 20 i16" in said.text, (name, said.message)
        says(said.text, "samples cannot be read")
        assert said.message.count("cut short") == 1, said.message
        for more in (("--stats",), ("--preview", "-o", "p.png"), ("--json", "--stats")):
            assert volvis("info", name, *more).code == 3, (name, more)
        seen = volvis("info", name, "--json").json
        assert seen["dims"] == [20, 20, 20] and sum("cut short" in text for text in seen["warnings"]) == 1
        says(fails(3, "convert", name, "-o", "x.npy"), "cut short")  # what needs samples says the same
    assert volvis("info", "w.nii", "w.mha").text.count("samples cannot be read") == 2


def test_more_bytes_than_a_layout_needs_are_told_of_packed_files_too():
    for name, opened in (("m.raw", open), ("m.raw.gz", gzip.open)):
        with opened(name, "wb") as file:
            file.write(bytes(1000 + 8))
        says(ok("convert", name, "--raw", "10x10x10,u8", "-o", "o.nrrd", "--overwrite").message, "bytes")
        with opened(name, "wb") as file:
            file.write(bytes(1000))
        assert "are they right" not in ok("convert", name, "--raw", "10x10x10,u8", "-o", "o.nrrd", "--overwrite").message


def test_spacings_that_no_picture_can_have_are_told_by_info_as_by_render():
    for spacings, is_fine in (("1e30 1 1", False), ("1 1e-90 1", False), ("1 1 1e-30", False), ("1 1 1000", True)):
        with open("far.nrrd", "wb") as file:
            file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: {spacings}\nencoding: raw\n\n".encode())
            file.write(bytes(range(8)))
        told = ok("info", "far.nrrd", "--json")
        picture = volvis("render", "far.nrrd", "-o", "far.png", "--size", "16x16", "--overwrite")
        assert (picture.code == 0) == is_fine == (not told.json["warnings"]), (spacings, picture.message, told.json["warnings"])
        if not is_fine:
            says(told.message, "times as large along one axis as along another")
            says(picture.message, "times as large along one axis as along another")


def test_spacings_whose_squares_and_volumes_are_no_numbers_are_refused_with_the_spacing():
    for spacings, sentence in (("1e-320 1 1", "along x is 9.99989e-321"), ("1 1e-300 1", "along y is 1e-300"),
                               ("1e308 1 1", "1e+308"), ("1e120 1e120 1e120", "1e+120"), ("1e-101 1e-101 1e-101", "along x is 1e-101")):
        with open("far.nrrd", "wb") as file:
            file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: {spacings}\nencoding: raw\n\n".encode())
            file.write(bytes(range(8)))
        for words in (("info", "far.nrrd"), ("render", "far.nrrd", "-o", "far.png")):
            said = fails(3, *words)
            says(said, sentence, "damaged")
            assert "determinant" not in said and "scale" not in said and "inf times" not in said, said


def test_text_goes_into_no_picture_file():
    write_ball("head.nrrd", 8)
    says(fails(2, "info", "head.nrrd", "-o", "head.PNG"), "head.PNG", "--preview")
    assert not os.path.exists("head.PNG")
    ok("info", "head.nrrd", "-o", "head.txt")
    ok("info", "head.nrrd", "-o", "head.png", "--preview")
    says(fails(2, "info", "head.nrrd", "head.nrrd", "-o", "two.png", "--preview"), "one input")


def test_names_that_a_terminal_would_obey_are_masked():
    name = "a\033[31m\nb.nrrd"
    write_ball(name, 8)
    write_box("c\033]0;x\007.ply")
    runs = [("info", name), ("info", name, "c\033]0;x\007.ply"), ("info", "c\033]0;x\007.ply"),
            ("measure", "volume", name, "--threshold", "80,"), ("convert", name, "-o", "d\033[1m.nrrd"),
            ("convert", "c\033]0;x\007.ply", "-o", "e\033[1m.stl"), ("gaussian", name, "-o", "f\033[1m.nrrd", "--sigma", "1"),
            ("isosurface", name, "-o", "g\033[1m.ply", "--iso", "80"), ("info", name, "-o", "h\033.txt"),
            ("render", name, "-o", "i\033.png", "--size", "8x8"), ("pick", name, "--pixel", "4,4", "--size", "8x8"),
            ("compare", name, name), ("info", name, "-v", "--stats")]
    for words in runs:
        result = volvis(*words)
        assert result.code in (0, 6), (words, result.message)
        for said in (result.text, result.message):
            assert not any(c < " " and c != "\n" or c == "\x7f" for c in said), (words, said)
        assert "\nb.nrrd" not in result.text, (words, result.text)


def test_units_that_a_terminal_would_obey_are_masked():
    header = ("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 6 6 6\nspace dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
              'space units: "m\x1bm" "m\x1bm" "m\x1bm"\nsample units: "H\x1b[31mU"\nencoding: raw\n\n')
    with open("units.nrrd", "wb") as file:
        file.write(header.encode() + bytes(200 * (i % 6 > 2 and i // 6 % 6 > 2 and i > 107) for i in range(216)))
    for words in (("info",), ("measure", "statistics"), ("measure", "labels"), ("measure", "volume", "--threshold", "9.."),
                  ("isosurface", "-o", "a.ply", "--overwrite", "--iso", "9"), ("convert", "-o", "a.tif", "--overwrite")):
        run = ok(*words[:1], *words[1:2] * (words[0] == "measure"), "units.nrrd", *words[1 + (words[0] == "measure"):])
        assert "\x1b" not in run.text + run.message, words


def test_damaged_samples_have_one_exit_code():
    numpy.save("whole.npy", numpy.arange(8000, dtype="f4").reshape(20, 20, 20))
    with open("whole.npy", "rb") as whole, open("cut.npy", "wb") as cut:
        cut.write(whole.read()[:24000])
    assert [volvis("info", "cut.npy", *more).code for more in ((), ("--json",), ("--stats",), ("--stats", "--json"))] == [7] * 4
    assert [volvis("info", "whole.npy", *more).code for more in ((), ("--json",))] == [0] * 2


if __name__ == "__main__":
    main()
