"""What the header of a NIfTI file says comes out again when VolVis makes a NIfTI file of it; the truth is nibabel's."""
import struct

import numpy as np
from harness import Skip, fails, main, ok, says, write_nrrd

try:
    import nibabel as nib
except ImportError:
    nib = None

TURN = np.array([[0.8, -0.6, 0, -20], [0.6, 0.8, 0, 5], [0, 0, 1.5, 7], [0, 0, 0, 1]]) @ np.diag([2, 2.5, 1, 1])
MNI = np.array([[-2.0, 0, 0, 90], [0, 2.5, 0, -126], [0, 0, 1.5, -72], [0, 0, 0, 1]])


def need_nibabel():
    if nib is None:
        raise Skip("nibabel is missing: skipped")


def write(name, shape=(6, 5, 4), kind=None, dtype="i2", sform=(MNI, 4), qform=(MNI, 2), **fields):
    need_nibabel()
    data = np.arange(np.prod(shape)).reshape(shape).astype(dtype)
    image = (kind or nib.Nifti1Image)(data, None, dtype=dtype)
    image.header["descrip"] = b"SPM{T_[262.0]} - contrast 3"
    image.header["aux_file"] = b"design.mat"
    image.header.set_xyzt_units("mm", "sec")
    for key, value in fields.items():
        image.header[key] = value
    image.header.set_sform(*sform)
    image.header.set_qform(*qform)
    image = (kind or nib.Nifti1Image)(data, None, image.header)
    image.header.extensions.append(nib.nifti1.Nifti1Extension(44, b'{"SpectrometerFrequency": [123.2]}'))
    image.header.extensions.append(nib.nifti1.Nifti1Extension(6, bytes(range(1, 200))))
    nib.save(image, name)
    return nib.load(name)


def after(verb, *words, name="in.nii"):
    ok(verb, name, *words, "-o", "out.nii", "--overwrite")
    return nib.load("out.nii")


def same_text(a, b):
    assert bytes(a["descrip"]) == bytes(b["descrip"]), (a["descrip"], b["descrip"])
    assert bytes(a["aux_file"]) == bytes(b["aux_file"])
    assert a.get_xyzt_units() == b.get_xyzt_units()
    assert [(e.get_code(), e.get_content()) for e in a.extensions] == [(e.get_code(), e.get_content()) for e in b.extensions]


def test_codes_of_spaces_texts_and_extensions_stay():
    for kind in (None, nib and nib.Nifti2Image):
        a = write("in.nii", kind=kind)
        for words in (["convert"], ["crop", "--x", "1:4"], ["gaussian", "--sigma", "2"], ["reorient", "--to", "RAS"],
                      ["resample", "--spacing", "3"], ["flip", "--axes", "x"]):
            b = after(*words)
            assert (b.header["sform_code"], b.header["qform_code"]) == (4, 2), words
            assert np.allclose(b.get_sform(), b.get_qform(), atol=1e-4), words
            same_text(a.header, b.header)
            assert b.header["sizeof_hdr"] == a.header["sizeof_hdr"], words
        assert np.array_equal(after("convert").get_fdata(), a.get_fdata())


def test_every_pair_of_codes_stays():
    for s, q in ((0, 0), (0, 1), (0, 5), (1, 0), (2, 3), (3, 2), (4, 1), (5, 4)):
        write("in.nii", sform=(MNI, s), qform=(MNI, q))
        b = after("convert")
        assert (b.header["sform_code"], b.header["qform_code"]) == (s, q), (s, q)
        if s or q:
            assert np.allclose(b.affine, MNI, atol=1e-4)


def test_a_file_that_says_no_place_stays_one_until_it_is_moved():
    a = write("in.nii", sform=(None, 0), qform=(None, 0), pixdim=[1, 2, 2.5, 1.5, 0, 0, 0, 0])
    assert np.allclose(after("convert").affine, a.affine)
    b = after("crop", "--x", "1:4")
    assert b.header["sform_code"] == 2 and np.allclose(b.affine[:3, 3], (2, 0, 0)), b.affine


def test_two_places_stay_two_also_where_the_samples_move():
    a = write("in.nii", sform=(MNI, 4), qform=(TURN, 1))
    for words, index in ((["convert"], np.eye(4)), (["crop", "--x", "1:4", "--z", "2:3"], [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]),
                         (["flip", "--axes", "x"], None)):
        b = after(*words)
        assert (b.header["sform_code"], b.header["qform_code"]) == (4, 1), words
        index = np.linalg.inv(a.get_sform()) @ b.get_sform() if index is None else index
        assert np.allclose(b.get_sform(), a.get_sform() @ index, atol=1e-4), words
        assert np.allclose(b.get_qform(), a.get_qform() @ index, atol=1e-3), words


def test_intents_and_windows_stay_until_the_values_are_others():
    fields = dict(intent_code=3, intent_p1=262, intent_name=b"T", cal_min=-3, cal_max=8.5)
    a = write("in.nii", dtype="f4", **fields)
    for words in (["convert"], ["crop", "--x", "1:4"], ["reorient", "--to", "RAS"]):
        b = after(*words)
        assert b.header.get_intent() == a.header.get_intent() == ("t test", (262.0,), "T"), words
        assert (b.header["cal_min"], b.header["cal_max"]) == (-3, 8.5)
    b = after("rescale", "--from", "0,100", "--to", "0,1")
    assert b.header["intent_code"] == 0 and b.header["cal_max"] == 0
    write("in.nii", shape=(4, 4, 4, 1, 3), dtype="f4", intent_code=1006)
    assert after("convert").header["intent_code"] == 1006
    assert after("channel", "--components", "0").header["intent_code"] == 0


def test_time_and_the_order_of_slices_stay():
    fields = dict(pixdim=[1, 2, 2.5, 1.5, 3.25, 0, 0, 0], toffset=10, slice_code=3, slice_start=1, slice_end=2, slice_duration=0.5)
    for shape in ((6, 5, 4), (6, 5, 4, 3)):
        a = write("in.nii", shape=shape, **fields)
        a.header.set_dim_info(0, 1, 2)
        nib.save(a, "in.nii")
        b = after("convert").header
        for key in ("toffset", "slice_code", "slice_start", "slice_end", "slice_duration", "dim_info"):
            assert b[key] == a.header[key], key
        assert b["pixdim"][4] == 3.25 and b.get_xyzt_units() == ("mm", "sec")
        b = after("crop", "--z", "1:3").header
        assert [int(b[key]) for key in ("slice_code", "slice_start", "slice_end")] == [3, 0, 1]
        assert b["slice_duration"] == 0.5 and b.get_dim_info() == (0, 1, 2)
    b = after("convert", name="in.nii@2").header
    assert b["toffset"] == 16.5 and b["pixdim"][4] == 3.25 and b["dim"][0] == 3
    for unit in ("msec", "usec", "hz", "ppm", "rads"):
        a = write("in.nii")
        a.header.set_xyzt_units("mm", unit)
        nib.save(a, "in.nii")
        assert after("convert").header.get_xyzt_units() == ("mm", unit)


def test_the_order_of_slices_goes_where_the_slices_go():
    def slices(*words):
        b = after(*words).header
        return [int(b[key]) for key in ("slice_code", "slice_start", "slice_end")], b["slice_duration"], b.get_dim_info()

    a = write("in.nii", shape=(6, 5, 8), slice_code=3, slice_start=1, slice_end=6, slice_duration=0.5)
    a.header.set_dim_info(0, 1, 2)
    nib.save(a, "in.nii")
    for words in (["crop", "--x", "1:4"], ["flip", "--axes", "x"], ["gaussian", "--sigma", "1"]):
        assert slices(*words) == ([3, 1, 6], 0.5, (0, 1, 2)), words
    assert slices("reorient", "--order", "x,y,-z") == ([4, 1, 6], 0.5, (0, 1, 2))
    assert slices("reorient", "--order", "z,x,y") == ([3, 1, 6], 0.5, (1, 2, 0))
    assert slices("crop", "--z", "1:8") == ([3, 0, 5], 0.5, (0, 1, 2))
    for words in (["crop", "--z", "2:8"], ["resample", "--spacing", "3"]):
        says(ok(words[0], "in.nii", *words[1:], "-o", "out.nii", "--overwrite").message, "slice_code")
        assert nib.load("out.nii").header["slice_code"] == 0
    a.header["slice_code"] = 1
    nib.save(a, "in.nii")
    assert slices("crop", "--z", "2:8") == ([1, 0, 4], 0.5, (0, 1, 2))


def scaled_labels(name, code):
    need_nibabel()
    data = np.zeros((6, 5, 4), np.uint8)
    data[1:3, 1:4, 1:3] = 3
    data[4, 1:3] = 7
    image = nib.Nifti1Image(data, np.eye(4))
    image.header.set_slope_inter(2, 10)
    image.header["intent_code"] = code
    nib.save(image, name)
    with open(name, "r+b") as file:  # nibabel drops the scale of what it writes
        file.seek(112)
        file.write(struct.pack("<ff", 2, 10))
        file.seek(352)
        file.write(data.tobytes("F"))
    return data


def test_labels_are_the_numbers_that_are_stored():
    data = scaled_labels("ls.nii", 1002)
    want = {int(v): int((data == v).sum()) for v in np.unique(data)}
    seen = ok("info", "ls.nii", "--stats", "--json").json
    assert "times 2" in seen["warnings"][0] and (seen["min"], seen["max"]) == (0, 7), seen
    rows = ok("measure", "labels", "ls.nii", "--json").json["labels"]
    assert {row["label"]: row["count"] for row in rows} == {3: want[3], 7: want[7]}
    assert ok("measure", "volume", "ls.nii", "--label", "7", "--json").json["volume"] == want[7]
    for name in ("ls.seg.nrrd", "ls.nrrd", "ls2.nii"):
        ok("convert", "ls.nii", "-o", name)
        rows = ok("measure", "labels", name, "--json").json["labels"]
        assert {row["label"]: row["count"] for row in rows} == {3: want[3], 7: want[7]}, name


def test_amounts_with_a_scale_are_no_labels():
    data = scaled_labels("amounts.nii", 0)
    says(fails(2, "measure", "labels", "amounts.nii"), "times 2, plus 10", "--type i32")
    says(fails(2, "convert", "amounts.nii", "-o", "amounts.seg.nrrd"), "times 2, plus 10", "amounts")
    ok("convert", "amounts.nii", "-o", "values.nii", "--type", "i32")
    rows = ok("measure", "labels", "values.nii", "--json").json["labels"]
    values = 2 * data.astype(int) + 10
    assert {row["label"]: row["count"] for row in rows} == {int(v): int((values == v).sum()) for v in np.unique(values)}


def test_the_import_program_hands_it_on():
    a = write("in.nii")
    b = after("convert", "--safe")
    assert b.header["sform_code"] == 4
    same_text(a.header, b.header)


def test_what_other_formats_cannot_keep_is_said():
    write("in.nii", intent_code=3, slice_code=3, slice_end=3)
    for name in ("lost.mha", "lost.tif", "lost.vti"):
        said = ok("convert", "in.nii", "-o", name).message
        says(said, "sform_code 4 (MNI152)", "intent_code 3", "descrip 'SPM{T_[262.0]} - contrast 3'", "'design.mat'", "slices")
        assert said.count("NIfTI header") == 1, said
    for name in ("kept.nii.gz", "kept.nrrd", "kept.h5"):
        assert "NIfTI header" not in ok("convert", "in.nii", "-o", name).message
    plain = nib.Nifti1Image(np.zeros((4, 4, 4), np.uint8), np.eye(4))
    plain.set_sform(np.eye(4), 1)
    nib.save(plain, "plain.nii")
    assert ok("convert", "plain.nii", "-o", "plain.nrrd").message.count("cannot keep") == 0


def test_other_formats_lend_nothing():
    write("in.nii")
    ok("convert", "in.nii", "-o", "a.mha")
    b = after("convert", name="a.mha")
    assert b.header["sform_code"] == 1 and bytes(b.header["descrip"]).startswith(b"VolVis")
    assert not b.header.extensions


WAYS = ("way.nrrd", "way.nhdr", "way.h5")
SAID = ("sform_code", "qform_code", "intent_code", "intent_p1", "descrip", "aux_file", "cal_min", "cal_max", "toffset", "dim_info",
        "slice_code", "slice_start", "slice_end", "slice_duration", "xyzt_units")


def test_nrrd_and_hdf5_bring_back_what_the_header_said():
    fields = dict(intent_code=3, intent_p1=262.5, intent_name=b"T", cal_min=-3, cal_max=8.5, toffset=10, slice_code=3,
                  slice_start=1, slice_end=2, slice_duration=0.5, pixdim=[1, 2, 2.5, 1.5, 3.25, 0, 0, 0])
    for shape in ((6, 5, 4), (6, 5, 4, 3)):
        for kind in (None, nib and nib.Nifti2Image):
            a = write("in.nii", shape=shape, kind=kind, dtype="f4", sform=(MNI, 4), qform=(TURN, 1), **fields)
            a.header.set_dim_info(0, 1, 2)
            nib.save(a, "in.nii")
            for name in WAYS:
                ok("convert", "in.nii", "-o", name, "--overwrite")
                b = after("convert", name=name)
                for key in SAID:
                    assert np.array_equal(a.header[key], b.header[key]), (name, key, a.header[key], b.header[key])
                assert b.header["sizeof_hdr"] == a.header["sizeof_hdr"] and b.header["pixdim"][4] == 3.25, name
                assert np.allclose(a.get_sform(), b.get_sform(), atol=1e-4), name
                assert np.allclose(a.get_qform(), b.get_qform(), atol=1e-3), name
                assert np.array_equal(a.get_fdata(), b.get_fdata()), name


def test_what_is_done_on_the_way_counts():
    a = write("in.nii", sform=(MNI, 4), qform=(TURN, 1), intent_code=3, cal_max=9, slice_code=1, slice_end=3)
    a.header.set_dim_info(0, 1, 2)
    nib.save(a, "in.nii")
    straight = {words: after(*words) for words in (("crop", "--x", "1:4", "--z", "2:4"), ("flip", "--axes", "x"),
                                                   ("rescale", "--from", "0,100", "--to", "0,1"))}
    for name in WAYS:
        for words, c in straight.items():
            ok(words[0], "in.nii", *words[1:], "-o", name, "--overwrite")  # on the way there
            b = after("convert", name=name)
            ok("convert", "in.nii", "-o", name, "--overwrite")  # and on the way back
            for b in b, after(*words, name=name):
                for key in SAID:
                    assert np.array_equal(c.header[key], b.header[key]), (name, words, key, c.header[key], b.header[key])
                assert np.allclose(c.get_qform(), b.get_qform(), atol=1e-3), (name, words)
    ok("convert", "in.nii", "-o", "one.nrrd")
    ok("crop", "one.nrrd", "--x", "1:4", "--z", "2:4", "-o", "two.nrrd")
    b, c = after("convert", name="two.nrrd"), straight[("crop", "--x", "1:4", "--z", "2:4")]
    assert b.header["sform_code"] == 4 and b.header["slice_end"] == c.header["slice_end"] == 1
    with open("two.nrrd", "rb") as file:
        assert file.read(4096).count(b"nifti sform_code:=4\n") == 1


def test_words_of_a_header_are_not_believed_blindly():
    write("in.nii")
    ok("convert", "in.nii", "-o", "a.nrrd")
    with open("a.nrrd", "rb") as file:
        header, _, samples = file.read().partition(b"\n\n")
    lines = b"nifti sform_code:=70000\nnifti qform_code:=x\nnifti intent_p1:=nan\nnifti cal_max:=1e999\nnifti what:=1\nnifti descrip:=" + b"y" * 300
    with open("b.nrrd", "wb") as file:
        file.write(header + b"\n" + lines + b"\n\n" + samples)
    b = after("convert", name="b.nrrd").header
    assert b["sform_code"] == 4 and b["cal_max"] == 0 and len(bytes(b["descrip"]).rstrip(b"\0")) <= 80


LENGTHS = {"A": 1e-10, "cm": 1e-2, "in": 0.0254, "km": 1e3, "mm": 1e-3, "um": 1e-6}


def write_length(unit):
    write_nrrd("a.nrrd", (3, 4, 5), lambda x, y, z: x + 10 * y, spacing=(2, 2.5, 40), unit=unit)


def back_to_nrrd(name):
    ok("convert", name, "-o", "back.nrrd", "--overwrite")
    return ok("info", "back.nrrd", "--json").json


def test_lengths_of_any_unit_are_right_for_others():
    need_nibabel()
    metres = {"meter": 1, "mm": 1e-3, "micron": 1e-6}
    for unit, factor in LENGTHS.items():
        write_length(unit)
        for name in ("a.nii", "b.nii.gz"):
            ok("convert", "a.nrrd", "-o", name, "--overwrite")
            image = nib.load(name)
            steps = np.diag(image.affine)[:3] * metres[image.header.get_xyzt_units()[0]]
            assert np.allclose(steps, np.array((2, 2.5, 40)) * factor, rtol=1e-6), unit
            assert np.allclose(image.header.get_zooms(), np.diag(image.affine)[:3], rtol=1e-6)
            again = back_to_nrrd(name)
            assert np.allclose(again["spacing"], (2, 2.5, 40), rtol=1e-6) and again["unit"] == unit, again
        ok("convert", "b.nii.gz", "-o", "c.nii", "--overwrite")
        assert np.allclose(nib.load("c.nii").affine, image.affine, rtol=1e-6), unit


def test_metaimage_has_lengths_in_millimetres():
    """ITK passes over DistanceUnits: who reads it and who does not must find the same lengths."""
    for unit, factor in LENGTHS.items():
        write_length(unit)
        ok("convert", "a.nrrd", "-o", "a.mhd", "--overwrite")
        keys = dict(line.split(" = ", 1) for line in open("a.mhd").read().splitlines())
        assert keys["DistanceUnits"] == "mm", keys
        steps = np.array(keys["ElementSpacing"].split(), float) * 1e-3
        assert np.allclose(steps, np.array((2, 2.5, 40)) * factor, rtol=1e-12), (unit, keys)
        again = back_to_nrrd("a.mhd")
        assert np.allclose(again["spacing"], (2, 2.5, 40)) and again["unit"] == unit


def test_a_unit_that_nobody_knows_is_told():
    write_length("parsec")
    for name in ("a.nii", "a.mha"):
        says(ok("convert", "a.nrrd", "-o", name).message, "'parsec' is not a known unit of length", "take them for mm")


def write_channels(window):
    with open("a.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 2 2\nkinds: list domain domain domain\nencoding: raw\n")
        file.write(b"volvis channel 0 window:=10 200\n" if window else b"volvis channel 0 name:=nuclei\n")
        file.write(b"\n" + bytes(range(16)))


def test_the_range_to_be_shown_is_kept_and_the_warning_says_what_is_lost():
    need_nibabel()
    write_channels(window=True)
    said = ok("convert", "a.nrrd", "--channel", "0", "-o", "a.nii").message
    assert "cannot keep" not in said, said
    header = nib.load("a.nii").header
    assert (header["cal_min"], header["cal_max"]) == (10, 200)
    says(ok("convert", "a.nrrd", "--channel", "0", "-o", "a.mha").message, "cannot keep the range of values to be shown;")
    write_channels(window=False)
    says(ok("convert", "a.nrrd", "--channel", "0", "-o", "b.nii").message, "cannot keep names and colours of channels;")


def light(v):
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def test_slices_and_previews_are_shown_with_the_window_of_the_file():
    need_nibabel()
    image = nib.Nifti1Image(np.broadcast_to(np.arange(16, dtype="i2")[:, None, None] * 100, (16, 16, 16)), np.eye(4))
    image.header["cal_min"], image.header["cal_max"] = 300, 900
    nib.save(image, "window.nii")
    seen = ok("info", "window.nii", "--json", "--preview", "-o", "window.png", "--size", "48x16", "--overwrite").json
    assert seen["channels"][0]["window"] == [300, 900], seen
    says(ok("info", "window.nii").text, "window 300 to 900")
    ok("render", "window.nii", "-o", "window.pfm", "--slice", "axial", "--size", "16x16", "--overwrite",
       "--set", "views.main.camera.height=16")
    with open("window.pfm", "rb") as file:
        pixels = np.frombuffer(file.read()[-16 * 16 * 12:], "<f4").reshape(16, 16, 3)
    there = light(np.clip((np.arange(16) * 100 - 300) / 600, 0, 1))[::-1]  # right is left
    assert np.abs(pixels - there[None, :, None]).max() < 2e-3, pixels[8, :, 0]
    for name, lost in (("w.nrrd", False), ("w.nii.gz", False), ("w.mha", True)):
        said = ok("convert", "window.nii", "-o", name, "--overwrite").message
        assert ("cannot keep the range of values to be shown;" in said) == lost and "names" not in said, said
    assert ok("info", "w.nrrd", "--json").json["channels"][0]["window"] == [300, 900]
    assert nib.load("w.nii.gz").header["cal_max"] == 900
    labels = nib.Nifti1Image(np.ones((4, 4, 4), "u1"), np.eye(4))
    labels.header["cal_max"], labels.header["intent_code"] = 1, 1002
    nib.save(labels, "labels.nii")
    assert ok("info", "labels.nii", "--json").json["channels"] == []


main()
