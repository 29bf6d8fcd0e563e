"""DICOM folders and files, made by pydicom and GDCM and checked by them, numpy and nibabel."""
import itertools
import json
import os
import random
import shutil
import warnings
from harness import Skip, fails, main, ok, says, volvis

warnings.simplefilter("ignore")
SHARED = os.environ.get("VOLVIS_SHARED", os.path.join(os.path.dirname(__file__), "..", "..", "..", "shared"))
DATA = os.path.abspath(os.path.join(SHARED, "data", "formats", "dicom"))

try:
    import numpy
    import pydicom
    from pydicom.dataset import Dataset, FileMetaDataset
    from pydicom.sequence import Sequence
    from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid
except ImportError:
    pydicom = None
try:
    import nibabel
except ImportError:
    nibabel = None


def need():
    if not pydicom:
        raise Skip("no python3-pydicom")
    if not nibabel:
        raise Skip("no python3-nibabel")


def need_data():
    need()
    if not os.path.isdir(DATA):
        raise Skip(f"no real data in {DATA}")


def image(samples, **more):
    """A data set of one image; samples: rows x columns, or with frames in front."""
    d = Dataset()
    d.file_meta = FileMetaDataset()
    d.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d.file_meta.MediaStorageSOPClassUID = d.SOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    d.SOPInstanceUID = generate_uid()
    d.SeriesInstanceUID = "1.2.3"
    d.Modality = "CT"
    d.PatientName = "Secret^Name"
    d.PatientID = "4711"
    d.SamplesPerPixel = 1
    d.PhotometricInterpretation = "MONOCHROME2"
    d.Rows, d.Columns = samples.shape[-2:]
    d.BitsAllocated = d.BitsStored = 8 * samples.dtype.itemsize
    d.HighBit = d.BitsStored - 1
    d.PixelRepresentation = int(samples.dtype.kind == "i")
    d.PixelSpacing = [0.5, 0.75]
    d.SliceThickness = 9
    d.PixelData = samples.tobytes()
    for key, value in more.items():
        setattr(d, key, value)
    return d


def save(d, path, implicit=False):
    d.file_meta.MediaStorageSOPInstanceUID = d.SOPInstanceUID
    if implicit:
        d.file_meta.TransferSyntaxUID = ImplicitVRLittleEndian
    d.is_little_endian, d.is_implicit_VR = True, implicit
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    d.save_as(path, write_like_original=False)


def volume(dims=(5, 7, 4), kind="<i2", seed=1):
    """Samples as [z, y, x]."""
    nx, ny, nz = dims
    values = numpy.random.default_rng(seed).integers(-1000 if kind[1] == "i" else 0, 1000, (nz, ny, nx))
    return values.astype(kind)


def series(folder, samples, row=(1, 0, 0), column=(0, 1, 0), step=(0, 0, 2), origin=(-10, 20, 30), names=None, skip=(),
           **more):
    """One file a slice, names shuffled against the places."""
    names = names or random.Random(7).sample(range(1000, 9999), len(samples))
    for k, plane in enumerate(samples):
        if k in skip:
            continue
        at = [o + k * s for o, s in zip(origin, step)]
        save(image(plane, ImagePositionPatient=at, ImageOrientationPatient=[*row, *column], InstanceNumber=k + 1, **more),
             f"{folder}/{names[k]}.dcm")


def read(path, *words):
    """Values as [z, y, x] (or [t, z, y, x]), the affine, the info: through NIfTI, by nibabel."""
    ok("convert", path, "-o", "read.nii", *words)
    out = nibabel.load("read.nii")
    data = numpy.asanyarray(out.dataobj)
    return data.T, out.affine, ok("info", path, "--json").json


def expect_affine(affine, row, column, step, origin, spacing=(0.5, 0.75)):
    """What the file says, LPS, is what we say, RAS."""
    lps = numpy.diag([-1, -1, 1, 1.0])
    want = numpy.eye(4)
    want[:3, 0] = numpy.array(row) * spacing[1]
    want[:3, 1] = numpy.array(column) * spacing[0]
    want[:3, 2] = step
    want[:3, 3] = origin
    assert numpy.allclose(affine, lps @ want, atol=2e-4), f"{affine} is not {lps @ want}"


def test_slices_are_sorted_by_place_and_not_by_name():
    need()
    samples = volume()
    series("s", samples)
    got, affine, info = read("s")
    assert numpy.array_equal(got, samples)
    expect_affine(affine, (1, 0, 0), (0, 1, 0), (0, 0, 2), (-10, 20, 30))
    assert info["unit"] == "mm" and info["space"] == "RAS" and info["warnings"] == []
    assert "Secret" not in str(info) and "4711" not in str(info)


def test_every_orientation_is_right():
    need()
    samples = volume((3, 4, 5))
    axes = numpy.eye(3)
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            row, column, normal = (axes[a] * s for a, s in zip(order, signs))
            shutil.rmtree("s", ignore_errors=True)
            series("s", samples, row, column, normal * 2.5)
            got, affine, _ = read("s")
            upwards = numpy.dot(numpy.cross(row, column), normal) > 0
            assert numpy.array_equal(got, samples if upwards else samples[::-1])
            step = normal * 2.5 if upwards else normal * -2.5
            origin = numpy.array((-10, 20, 30)) + (0 if upwards else normal * 2.5 * 4)
            expect_affine(affine, row, column, step, origin)


def test_a_tilted_gantry_shears_the_grid():
    need()
    samples = volume()
    series("s", samples, step=(0, 0.6, 2))
    info = ok("info", "s", "--json").json
    assert numpy.allclose(numpy.array(info["directions"][2]) * info["spacing"][2], (0, -0.6, 2), atol=1e-4)
    says(info["metadata"]["tilt"], "16.7 degrees")


def test_missing_slices_are_filled_and_told():
    need()
    samples = volume((5, 7, 9))
    series("s", samples, skip=(3, 6))
    result = volvis("convert", "s", "-o", "o.nii")
    assert result.code == 7, result.message
    says(result.message, "2 of 9 slices are missing")
    assert result.message.count("missing") == 1, result.message
    got = numpy.asanyarray(nibabel.load("o.nii").dataobj).T
    want = samples.copy()
    want[[3, 6]] = 0
    assert numpy.array_equal(got, want)


def test_uneven_slices_are_told():
    need()
    samples = volume((5, 7, 4))
    for k, z in enumerate((0, 2, 4.7, 6)):
        save(image(samples[k], ImagePositionPatient=[0, 0, z], ImageOrientationPatient=[1, 0, 0, 0, 1, 0]), f"s/{k}")
    info = ok("info", "s", "--json").json
    says(info["warnings"][0], "1.3 to 2.7 mm apart")
    assert info["dims"] == [5, 7, 4] and abs(info["spacing"][2] - 2) < 1e-9


def test_copies_are_left_out():
    need()
    samples = volume()
    series("s", samples)
    os.makedirs("s/again")
    first = sorted(f for f in os.listdir("s") if f.endswith(".dcm"))[0]
    shutil.copy(f"s/{first}", "s/again/copy")
    got, _, info = read("s")
    assert numpy.array_equal(got, samples)
    says(info["warnings"][0], "1 image lies at the same position as another")


def test_of_several_series_the_largest_is_read_and_the_others_are_told():
    need()
    one, two = volume(seed=1), volume((4, 4, 3), seed=2)
    series("s/a", two, SeriesNumber=3, SeriesDescription="Scout")
    series("s/b", one, SeriesNumber=5, SeriesDescription="Soft")
    result = ok("info", "s", "--json")
    says(result.message, "holds 2 series; the largest is read, 5 (4 images of 5 x 7", "Soft", "others are 3: name one as s:3")
    assert numpy.array_equal(read("s")[0], one) and len(result.json["parts"]) == 2
    assert numpy.array_equal(read("s:3")[0], two)


def test_several_series_of_one_size_want_a_choice():
    need()
    one, two = volume(seed=1), volume(seed=2)
    series("s/a", one, SeriesNumber=3, SeriesDescription="Bone thin", SeriesInstanceUID="1.2.3")
    series("s/b", two, SeriesNumber=5, SeriesDescription="Soft", SeriesInstanceUID="1.2.4")
    with open("s/readme.txt", "w") as file:
        file.write("not an image")
    said = fails(2, "convert", "s", "-o", "no.nii")
    says(said, "2 series", "s:3", "Bone thin", "Soft", "4 images of 5 x 7")
    listed = ok("info", "s", "--json")  # which refuses no folder
    says(listed.message, "holds 2 series, and none is named; this is 3", "others are 5", "s:3")
    assert [(p["name"], p["chosen"]) for p in listed.json["parts"]] == [("3", True), ("5", False)]
    for part, samples in (("3", one), ("Bone thin", one), ("1.2.3", one), ("5", two), ("soft", two), ("1.2.4", two)):
        assert numpy.array_equal(read(f"s:{part}")[0], samples)
    info = ok("info", "s:5", "--json").json
    says(info["metadata"]["files that are not DICOM"], "readme.txt")
    says(fails(2, "info", "s:7"), "'7'", "Soft")


def test_a_scout_is_a_part_of_its_own():
    need()
    series("s", volume(), SeriesNumber=2)
    save(image(volume((8, 8, 1))[0], SeriesNumber=2, ImagePositionPatient=[0, 0, 0],
               ImageOrientationPatient=[0, 1, 0, 0, 0, -1]), "s/scout")
    says(ok("info", "s").message, "others are 2.2")
    assert ok("info", "s:2", "--json").json["dims"] == [5, 7, 4]


def test_time_steps_are_frames():
    need()
    samples = numpy.stack([volume(seed=s) for s in range(3)])
    for t, k in itertools.product(range(3), range(4)):
        save(image(samples[t, k], ImagePositionPatient=[0, 0, 2 * k], ImageOrientationPatient=[1, 0, 0, 0, 1, 0],
                   TriggerTime=100 * (2 - t), InstanceNumber=t * 4 + k + 1), f"s/{t}{k}")
    got, _, info = read("s")
    assert numpy.array_equal(got, samples[::-1])
    assert info["frames"] == 3 and info["frame_step"] == 100 and info["frame_unit"] == "ms"
    says(info["metadata"]["frames"], "TriggerTime")


def test_positions_in_time_have_a_step():
    need()
    samples = numpy.stack([volume(seed=s) for s in range(3)])
    cases = (({"TemporalResolution": 40}, (40, "ms")), ({"TriggerTime": lambda t: 35.5 * t}, (35.5, "ms")),
             ({"AcquisitionTime": lambda t: f"1000{2 * t:02d}"}, (2, "s")),
             ({"ContentTime": lambda t: f"1000{3 * t:02d}.5"}, (3, "s")), ({}, (0, "")))
    for said, step in cases:
        shutil.rmtree("s", ignore_errors=True)
        for t, k in itertools.product(range(3), range(4)):
            more = {key: value(t) if callable(value) else value for key, value in said.items()}
            save(image(samples[t, k], ImagePositionPatient=[0, 0, 2 * k], ImageOrientationPatient=[1, 0, 0, 0, 1, 0],
                       TemporalPositionIdentifier=t + 1, InstanceNumber=k * 3 + t + 1, **more), f"s/{t}{k}")
        info = ok("info", "s", "--json").json
        assert info["frames"] == 3 and (info["frame_step"], info["frame_unit"]) == step, (said, info["frame_step"])
        says(info["metadata"]["frames"], "TemporalPositionIdentifier")


def test_one_slope_keeps_what_is_stored_and_many_make_floats():
    need()
    samples = volume(kind="<u2")
    series("s", samples, RescaleSlope=2, RescaleIntercept=-1024, RescaleType="HU")
    info = ok("info", "s", "--json").json
    assert info["type"] == "u16" and info["value_scale"] == 2 and info["value_offset"] == -1024
    assert info["value_unit"] == "HU"
    for k, plane in enumerate(samples):
        save(image(plane, ImagePositionPatient=[0, 0, k], ImageOrientationPatient=[1, 0, 0, 0, 1, 0], Units="BQML",
                   RescaleSlope=k + 0.5, RescaleIntercept=0), f"p/{k}")
    got, _, info = read("p")
    assert info["type"] == "f32" and info["value_unit"] == "Bq/ml"
    assert numpy.allclose(got, samples * (numpy.arange(4) + 0.5)[:, None, None])


def test_emission_is_seen_as_the_largest_on_each_ray_whatever_its_unit():
    """The terms of DICOM for units (C.8.9.1.1.3), as everybody writes them; PT is shown as its readers do."""
    need()
    for term, unit in (("BQML", "Bq/ml"), ("GML", "g/ml"), ("CNTS", "counts"), ("PROPCNTS", "PROPCNTS"), ("NONE", ""), (None, "")):
        shutil.rmtree("s", ignore_errors=True)
        series("s", volume(kind="<u2"), Modality="PT", **({"Units": term} if term else {}))
        assert ok("info", "s", "--json").json["value_unit"] == unit, term
        ok("render", "s", "-o", "a.png", "--overwrite", "--size", "8", "--save-scene", "s.vv.json")
        with open("s.vv.json") as file:
            assert json.load(file)["views"]["main"]["render"]["raycast"]["mode"] == "maximum", term
    shutil.rmtree("s")
    series("s", volume(kind="<u2"), Modality="MR")
    said = ok("render", "s", "-o", "a.png", "--overwrite", "--size", "8", "-v").message
    assert 'mode = "maximum"' not in said, said


def test_padding_is_kept_and_told():
    need()
    samples = volume()
    samples[0, 0, :3] = -2000
    more = {"RescaleSlope": 1, "RescaleIntercept": -1024, "RescaleType": "HU", "PixelPaddingValue": -2000}
    series("s", samples, **more)
    says(ok("info", "s").text, "-2000 as stored (-3024 HU): no measurement; left out of pictures", "where it lies apart", "-3024 to")
    got, _, info = read("s")
    assert info["metadata"]["PixelPaddingValue"] == "-2000" and numpy.array_equal(got, samples - 1024)
    series("t", samples, PixelPaddingRangeLimit=-1990, **more)
    says(ok("info", "t").text, "-2000 to -1990 as stored: no measurement")


def test_padding_that_lies_apart_is_left_out():
    need()
    samples = volume((24, 24, 6))
    j, i = numpy.mgrid[:24, :24]
    outside = (i - 11.5) ** 2 + (j - 11.5) ** 2 > 120
    more = {"RescaleSlope": 1, "RescaleIntercept": -24, "RescaleType": "HU"}

    def fills(folder, padding, limit=None, says_it=True):
        data = samples.copy()
        data[:, outside] = padding
        if limit is not None:
            data[:, 0, ::2] = limit
        declared = {"PixelPaddingValue": padding} if says_it else {}
        if limit is not None:
            declared["PixelPaddingRangeLimit"] = limit
        series(folder, data, **declared, **more)
        return ok("info", folder, "--stats", "--json").json["channels"][0].get("fills", [])

    found = fills("a", -2000)  # a circle, as scanners have it: nobody would know it by the number alone
    assert len(found) == 1 and found[0]["value"] == -2024 and found[0]["declared"], found
    assert abs(found[0]["share"] - outside.mean()) < 1e-9
    assert not fills("b", -2000, says_it=False) and not fills("c", -1001), "padding beside values is one of them"
    found = fills("d", -2000, -1990)
    assert len(found) == 1 and abs(found[0]["share"] - outside.mean()) < 1e-9, found
    says(ok("render", "a", "-o", "a.png", "--size", "16x16").message, "-2024, padding as the file says",
         "apart from all others (-1024 to", "left out")
    assert "left out" not in ok("render", "a", "-o", "b.png", "--size", "16x16", "--missing", "none").message
    ok("convert", "a", "-o", "rest.npy", "--missing=-2024")  # values, in HU
    want = ok("measure", "volume", "rest.npy", "--json").json["threshold_lo"]
    assert ok("measure", "volume", "a", "--json").json["threshold_lo"] == want
    ok("rescale", "a", "-o", "r.npy", "--type", "u8")
    got = numpy.load("r.npy")
    assert (got[:, outside] == 0).all() and numpy.unique(got).size > 200
    with_limit = ok("convert", "d", "-o", "x.npy", "--memory", "4M", "--type", "u8", "--percentile", "0..100")
    says(with_limit.message, "padding as the file says")


def test_every_number_of_bits_is_read():
    need()
    for kind in ("|u1", "|i1", "<u2", "<i2", "<u4", "<i4"):
        samples = volume(kind=kind)
        series("s" + kind[1:], samples)
        got, _, info = read("s" + kind[1:])
        assert numpy.array_equal(got, samples) and info["type"] == kind[1] + str(8 * int(kind[2]))
    samples = volume(kind="<i2")
    series("m", (samples & 0xfff | 0x5000).astype("<u2"), BitsStored=12, HighBit=11, PixelRepresentation=1)
    assert numpy.array_equal(read("m")[0], samples)


def test_a_file_without_a_preamble_is_read():
    need()
    d = image(volume()[0], ImagePositionPatient=[0, 0, 0], ImageOrientationPatient=[1, 0, 0, 0, 1, 0])
    d.is_little_endian, d.is_implicit_VR = True, True
    del d.file_meta
    d.save_as("bare", write_like_original=True)
    assert numpy.array_equal(read("bare")[0][0], volume()[0])


def enhanced(samples, step=2, undefined=False, slopes=None):
    """One file whose frames say where they lie: frame k of samples at k * step, in reverse."""
    d = image(samples[0])
    del d.PixelSpacing, d.SliceThickness
    d.NumberOfFrames, d.PixelData = len(samples), samples[::-1].tobytes()
    shared, plane, measures = Dataset(), Dataset(), Dataset()
    plane.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    measures.PixelSpacing, measures.SliceThickness = [0.5, 0.75], 9
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = Sequence([plane]), Sequence([measures])
    d.SharedFunctionalGroupsSequence = Sequence([shared])
    frames = []
    for k in reversed(range(len(samples))):
        frame, place, values, decoy = Dataset(), Dataset(), Dataset(), Dataset()
        place.ImagePositionPatient = [-10, 20, 30 + k * step]
        frame.PlanePositionSequence = Sequence([place])
        values.RescaleSlope, values.RescaleIntercept, values.RescaleType = slopes[k] if slopes else 3, -7, "US"
        frame.PixelValueTransformationSequence = Sequence([values])
        decoy.ImagePositionPatient = [99, 99, 99]
        frame.ReferencedImageSequence = Sequence([decoy])
        frame.is_undefined_length_sequence_item = undefined
        frames.append(frame)
    d.PerFrameFunctionalGroupsSequence = Sequence(frames)
    d["PerFrameFunctionalGroupsSequence"].is_undefined_length = undefined
    return d


def test_frames_that_say_where_they_lie_are_slices():
    need()
    samples = volume()
    for implicit, undefined in itertools.product((False, True), repeat=2):
        save(enhanced(samples, undefined=undefined), "e.dcm", implicit)
        got, affine, info = read("e.dcm")
        assert info["value_scale"] == 3 and info["value_offset"] == -7
        assert numpy.allclose(got, samples * 3.0 - 7) and numpy.array_equal(as_npy("e.dcm"), samples)
        expect_affine(affine, (1, 0, 0), (0, 1, 0), (0, 0, 2), (-10, 20, 30))
    save(enhanced(samples, slopes=[1, 2, 3, 4]), "e.dcm")
    got, _, info = read("e.dcm")
    assert info["type"] == "f32"
    assert numpy.allclose(got, samples * numpy.arange(1.0, 5)[:, None, None] - 7)


def test_a_dose_has_slices_by_offset():
    need()
    samples = volume(kind="<u4")
    d = image(samples, NumberOfFrames=4, GridFrameOffsetVector=[0, 2.5, 5, 7.5], DoseGridScaling=0.001, DoseUnits="GY",
              ImagePositionPatient=[1, 2, 3], ImageOrientationPatient=[1, 0, 0, 0, 1, 0])
    save(d, "dose.dcm")
    got, affine, info = read("dose.dcm")
    assert numpy.allclose(got, samples * 0.001) and numpy.array_equal(as_npy("dose.dcm"), samples)
    assert info["value_unit"] == "Gy" and info["value_scale"] == 0.001 and info["dims"] == [5, 7, 4]
    expect_affine(affine, (1, 0, 0), (0, 1, 0), (0, 0, 2.5), (1, 2, 3))


def as_npy(path):
    ok("convert", path, "-o", "read.npy", "--stored")
    return numpy.load("read.npy").squeeze()


def color(samples, photometric="RGB", planar=0):
    d = image(samples[..., 0], PhotometricInterpretation=photometric, PlanarConfiguration=planar)
    d.SamplesPerPixel = 3
    d.PixelData = (samples.transpose(2, 0, 1) if planar else samples).tobytes()
    return d


def colors(seed=3):
    i, j = numpy.mgrid[0:40, 0:48]
    return numpy.stack([i * 6, j * 5, (i + j) * 2], -1).astype("u1")


def test_colours_are_rgb():
    need()
    samples = colors()
    for planar in (0, 1):
        save(color(samples, planar=planar), "c.dcm")
        assert numpy.array_equal(as_npy("c.dcm"), samples)
        assert ok("info", "c.dcm", "--json").json["meaning"] == "RGB"
    y, cb, cr = (samples[..., c].astype(float) for c in range(3))
    want = numpy.stack([y + 1.402 * (cr - 128), y - 0.344136 * (cb - 128) - 0.714136 * (cr - 128), y + 1.772 * (cb - 128)], -1)
    save(color(samples, "YBR_FULL"), "y.dcm")
    assert numpy.abs(as_npy("y.dcm") - numpy.clip(want, 0, 255)).max() <= 0.51
    half = samples.copy()
    half[:, 1::2, 1:] = half[:, ::2, 1:]
    d = color(half, "YBR_FULL_422")
    d.PixelData = b"".join(bytes([a[0], b[0], a[1], a[2]]) for row in half for a, b in zip(row[::2], row[1::2]))
    save(d, "h.dcm")
    save(color(half, "YBR_FULL"), "w.dcm")
    assert numpy.array_equal(as_npy("h.dcm"), as_npy("w.dcm"))


def pack(source, target, syntax):
    """The same image in another transfer syntax, by GDCM."""
    try:
        import gdcm
    except ImportError:
        raise Skip("no python3-gdcm") from None
    reader, change, writer = gdcm.ImageReader(), gdcm.ImageChangeTransferSyntax(), gdcm.ImageWriter()
    reader.SetFileName(source)
    assert reader.Read()
    change.SetTransferSyntax(gdcm.TransferSyntax(getattr(gdcm.TransferSyntax, syntax)))
    change.SetInput(reader.GetImage())
    assert change.Change(), syntax
    writer.SetFileName(target)
    writer.SetFile(reader.GetFile())
    writer.SetImage(change.GetOutput())
    assert writer.Write()


def smooth(kind):
    i, j, k = numpy.mgrid[0:40, 0:48, 0:3]
    return ((i * 7 + j * 3 + k * 50) % 200 - (100 if kind[1] == "i" else 0)).astype(kind).transpose(2, 0, 1)


def test_packed_pixels_are_what_was_packed():
    need()
    place = {"ImageOrientationPatient": [1, 0, 0, 0, 1, 0]}
    for kind in ("|u1", "<u2", "<i2"):
        samples = smooth(kind)
        for syntax in ("RLELossless", "JPEGLosslessProcess14_1", "JPEGLSLossless", "JPEG2000Lossless", "ExplicitVRBigEndian",
                       "DeflatedExplicitVRLittleEndian"):
            if kind == "<i2" and syntax.startswith("JPEGLS"):
                continue  # GDCM writes no negative numbers there
            shutil.rmtree("p", ignore_errors=True)
            os.mkdir("p")
            for k, plane in enumerate(samples):
                save(image(plane, ImagePositionPatient=[0, 0, k], **place), "plain.dcm")
                pack("plain.dcm", f"p/{k}", syntax)
            assert numpy.array_equal(read("p")[0], samples), (kind, syntax)
    for syntax in ("RLELossless", "JPEGLosslessProcess14_1", "JPEGLSLossless", "JPEG2000Lossless"):
        save(color(colors()), "plain.dcm")
        pack("plain.dcm", "c.dcm", syntax)
        assert numpy.array_equal(as_npy("c.dcm"), colors()), syntax


def test_lossy_pixels_are_what_gdcm_makes_of_them():
    need()
    save(image(smooth("|u1")[0]), "plain.dcm")
    save(color(colors()), "rgb.dcm")
    for source, syntax in itertools.product(("plain.dcm", "rgb.dcm"), ("JPEGBaselineProcess1", "JPEG2000")):
        pack(source, "l.dcm", syntax)
        assert numpy.array_equal(as_npy("l.dcm"), pydicom.dcmread("l.dcm").pixel_array), (source, syntax)


def test_a_jpeg_of_luma_and_chroma_is_rgb():
    need()
    import io
    from PIL import Image
    from pydicom.encaps import encapsulate
    out = io.BytesIO()
    Image.fromarray(colors()).save(out, "JPEG", quality=95)
    d = color(colors(), "YBR_FULL_422")
    d.file_meta.TransferSyntaxUID = pydicom.uid.JPEGBaseline8Bit
    d.PixelData = encapsulate([out.getvalue()])
    d["PixelData"].is_undefined_length = True
    save(d, "l.dcm")
    want = numpy.asarray(Image.open(io.BytesIO(out.getvalue())), int)
    assert numpy.abs(as_npy("l.dcm").astype(int) - want).max() <= 3


def test_many_packed_frames_are_told_apart():
    need()
    samples = smooth("<u2")
    for syntax in ("RLELossless", "JPEGLosslessProcess14_1", "JPEGLSLossless", "JPEG2000Lossless"):
        d = image(samples, NumberOfFrames=3, FrameTime=40)
        save(d, "plain.dcm")
        pack("plain.dcm", "m.dcm", syntax)
        assert numpy.array_equal(as_npy("m.dcm"), samples), syntax


def test_pieces_of_frames_are_joined():
    need()
    from pydicom.encaps import encapsulate, generate_pixel_data_frame
    samples = smooth("<u2")
    save(image(samples, NumberOfFrames=3), "plain.dcm")
    pack("plain.dcm", "m.dcm", "JPEGLosslessProcess14_1")
    d = pydicom.dcmread("m.dcm")
    frames = list(generate_pixel_data_frame(d.PixelData, 3))
    for has_table in (True, False):
        d.PixelData = encapsulate(frames, fragments_per_frame=3, has_bot=has_table)
        d["PixelData"].is_undefined_length = True
        d.save_as("f.dcm", write_like_original=False)
        assert numpy.array_equal(as_npy("f.dcm"), samples)


def test_bits_are_labels():
    need()
    bits = numpy.random.default_rng(5).integers(0, 2, (3, 5, 7)).astype("u1")
    d = image(bits, NumberOfFrames=3, BitsAllocated=1, BitsStored=1, HighBit=0)
    d.PixelData = numpy.packbits(bits.ravel(), bitorder="little").tobytes()
    save(d, "b.dcm")
    assert numpy.array_equal(as_npy("b.dcm"), bits)


def test_boxes_of_volumes_are_read():
    need()
    samples = volume((9, 8, 6))
    series("s", samples)
    d = image(samples, NumberOfFrames=6, ImagePositionPatient=[0, 0, 0])
    save(d, "m.dcm")
    for path in ("s", "m.dcm"):
        ok("crop", path, "-o", "c.npy", "--x", "2:7", "--y", "1:6", "--z", "3:5")
        assert numpy.array_equal(numpy.load("c.npy"), samples[3:5, 1:6, 2:7]), path


def real(path):
    d = pydicom.dcmread(os.path.join(DATA, path), force=True)
    return d, d.pixel_array


def test_real_files_have_the_samples_that_pydicom_reads():
    need_data()
    for name in ("CT_small", "MR_small", "MR_small_RLE", "MR_small_bigendian", "MR_small_implicit", "JPEG2000",
                 "JPEG-lossy", "rtdose"):
        _, want = real(f"single/{name}.dcm")
        ok("convert", f"{DATA}/single/{name}.dcm", "-o", "o.nrrd")
        ok("convert", f"{DATA}/single/{name}.dcm", "-o", "o.npy", "--stored")
        assert numpy.array_equal(numpy.load("o.npy").squeeze(), want), name


def test_a_real_series_lies_where_its_files_say():
    need_data()
    files = []
    for name in os.listdir(os.path.join(DATA, "mr_brain_20")):
        with open(os.path.join(DATA, "mr_brain_20", name), "rb") as file:  # behind the pixels are zeros, 15000 empty elements
            files.append(pydicom.filereader.read_partial(file, stop_when=lambda tag, *_: tag == 0))
    orientation = numpy.array(files[0].ImageOrientationPatient, float)
    normal = numpy.cross(orientation[:3], orientation[3:])
    files.sort(key=lambda d: numpy.dot(numpy.array(d.ImagePositionPatient, float), normal))
    got, affine, info = read(os.path.join(DATA, "mr_brain_20"))
    assert numpy.array_equal(got, numpy.stack([d.pixel_array for d in files]))
    ends = [numpy.array(d.ImagePositionPatient, float) for d in (files[0], files[-1])]
    spacing = [float(s) for s in files[0].PixelSpacing]
    expect_affine(affine, orientation[:3], orientation[3:], (ends[1] - ends[0]) / 19, ends[0], spacing)


def test_a_beating_heart_is_a_row_of_frames():
    need_data()
    path = os.path.join(DATA, "MR-MONO2-8-16x-heart.dcm")
    want = pydicom.dcmread(path).pixel_array
    got, _, info = read(path)
    assert info["frames"] == 16 and abs(info["frame_step"] - 69.47) < 1e-9 and info["frame_unit"] == "ms"
    assert numpy.array_equal(got[:, 0], want)


def test_what_is_cut_short_is_told():
    need_data()
    result = volvis("info", "--stats", f"{DATA}/single/MR_truncated.dcm")
    assert result.code == 7, result.message
    says(result.message, "cut short")
    says(fails(3, "info", f"{DATA}/single/no_meta.dcm"), "no DICM")


if __name__ == "__main__":
    main()
