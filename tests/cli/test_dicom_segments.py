"""DICOM segmentations, made by pydicom and read again by it and numpy, frame by frame."""
import csv
import io
import itertools
from harness import fails, main, ok, says, volvis
from test_dicom import image, need, save, series, volume

try:
    import nibabel
    import numpy
    import pydicom
    from pydicom.dataset import Dataset
    from pydicom.sequence import Sequence
except ImportError:
    pass  # need() says so

LIVER = (45252, 40092, 42148)  # scaled CIELab
NAMES = ("Liver", "Spleen", "Left kidney")


def code(value, scheme, meaning, **inside):
    c = Dataset()
    c.CodeValue, c.CodingSchemeDesignator, c.CodeMeaning = value, scheme, meaning
    for name, sequence in inside.items():
        setattr(c, name, sequence)
    return Sequence([c])


def described(number, name, lab=LIVER):
    s = Dataset()
    s.SegmentNumber, s.SegmentLabel, s.SegmentAlgorithmType = number, name, "MANUAL"
    s.SegmentedPropertyCategoryCodeSequence = code("85756007", "SCT", "Tissue")
    s.SegmentedPropertyTypeCodeSequence = code(str(1000 + number), "SCT", f"The {name}")
    if lab:
        s.RecommendedDisplayCIELabValue = list(lab)
    return s


def segmentation(frames, kind="BINARY", numbers=(1, 2), between=2.5, placed=True, labs=(LIVER,) * 3, **more):
    """frames: (number of the segment, slice, samples [y, x])."""
    planes = numpy.stack([f[2] for f in frames])
    d = image(planes.astype("<u2" if planes.max() > 255 else "|u1"), Modality="SEG", SegmentationType=kind, **more)
    del d.PixelSpacing, d.SliceThickness
    d.NumberOfFrames = len(frames)
    if kind == "BINARY":
        d.BitsAllocated, d.BitsStored, d.HighBit = 1, 1, 0
        bits = numpy.packbits(planes.astype("|u1").ravel(), bitorder="little").tobytes()
        d.PixelData = bits + bytes(len(bits) % 2)
    elif kind == "FRACTIONAL":
        d.SegmentationFractionalType, d.MaximumFractionalValue = "PROBABILITY", 200
    d.SegmentSequence = Sequence([described(n, name, lab) for n, name, lab in zip(numbers, NAMES, labs)])
    shared, plane, measures = Dataset(), Dataset(), Dataset()
    plane.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    measures.PixelSpacing, measures.SliceThickness = [0.5, 0.75], 9
    if between:
        measures.SpacingBetweenSlices = between
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = Sequence([plane]), Sequence([measures])
    d.SharedFunctionalGroupsSequence = Sequence([shared])
    groups = []
    for number, k, _ in frames:
        group, place, segment = Dataset(), Dataset(), Dataset()
        if placed:
            place.ImagePositionPatient = [-10, 20, 30 + 2.5 * k]
            group.PlanePositionSequence = Sequence([place])
        if number:
            segment.ReferencedSegmentNumber = number
            group.SegmentIdentificationSequence = Sequence([segment])
        groups.append(group)
    d.PerFrameFunctionalGroupsSequence = Sequence(groups)
    return d


def planes(seed, n=1, shape=(7, 5)):
    """n random masks, none of them empty."""
    masks = numpy.random.default_rng(seed).integers(0, 2, (n, *shape)).astype("|u1")
    masks[:, 0, 0] = 1
    return masks


def apart(seed, n):
    """Two segments in n slices that share no sample."""
    a, b = planes(seed, n), planes(seed + 1, n)
    return a, b & ~a & 1


def by_numpy(path, paint):
    """[z, y, x] as pydicom and numpy have it: each frame to where it says, by paint(whole slice, number, frame)."""
    d = pydicom.dcmread(path)
    pixels = d.pixel_array.reshape(-1, d.Rows, d.Columns)
    groups = d.PerFrameFunctionalGroupsSequence
    z = [float(g.PlanePositionSequence[0].ImagePositionPatient[2]) for g in groups]
    step = float(d.SharedFunctionalGroupsSequence[0].PixelMeasuresSequence[0].get("SpacingBetweenSlices", 2.5))
    out = numpy.zeros((round((max(z) - min(z)) / step) + 1, d.Rows, d.Columns))
    for frame, at, group in zip(pixels, z, groups):
        segment = group.get("SegmentIdentificationSequence")
        paint(out[round((at - min(z)) / step)], int(segment[0].ReferencedSegmentNumber) if segment else 0, frame)
    return out


def labels(out, number, frame):
    out[frame > 0] = number


def read(path):
    ok("convert", path, "-o", "read.nii")
    out = nibabel.load("read.nii")
    return numpy.asanyarray(out.dataobj).T, out.affine


def test_segments_that_share_slices_become_labels_with_names_colours_and_codes():
    need()
    a, b = apart(1, 4)
    frames = [(2, 2 + k, b[k]) for k in (3, 0, 2, 1)] + [(1, k, planes(9)[0] if k < 2 else a[k - 2]) for k in range(6)]
    save(segmentation(frames), "two.dcm")
    got, affine = read("two.dcm")
    want = by_numpy("two.dcm", labels)
    assert want.shape == (6, 7, 5) and numpy.array_equal(got, want)
    assert numpy.allclose(affine, [[-0.75, 0, 0, 10], [0, -0.5, 0, -20], [0, 0, 2.5, 30], [0, 0, 0, 1]])
    info = ok("info", "two.dcm", "--stats", "--json").json
    assert info["meaning"] == "label" and info["type"] == "u8" and info["parts"] == [] and info["warnings"] == []
    assert [(l["value"], l["name"], l["count"]) for l in info["labels"]] == [
        (0, None, (want == 0).sum()), (1, "Liver", (want == 1).sum()), (2, "Spleen", (want == 2).sum())]
    assert info["metadata"]["segment 2 category"] == "Tissue (85756007, SCT)"
    assert info["metadata"]["segment 2 type"] == "The Spleen (1002, SCT)"
    says(ok("measure", "volume", "two.dcm", "--label", "2").text, "mm^3")
    for name, number in (("spleen", 2), ("segment1", 1)):
        assert numpy.array_equal(read(f"two.dcm:{name}")[0], number * (want == number))
        assert [(p["name"], p["chosen"]) for p in ok("info", f"two.dcm:{name}", "--json").json["parts"]] == [(f"segment{number}", True)]
    says(fails(2, "info", "two.dcm:pancreas"), "has no part 'pancreas'", "lists its segments")


def test_a_segmentation_of_a_part_of_its_scan_is_measured_with_it():
    need()
    scan = volume(dims=(9, 12, 8), seed=3)
    series("scan", scan, origin=(-10 - 2 * 0.75, 20 - 3 * 0.5, 30 - 2.5), step=(0, 0, 2.5))  # two columns, three rows, a slice more
    a, b = apart(1, 4)
    save(segmentation([(n, k, m[k]) for n, m in ((1, a), (2, b)) for k in range(4)]), "seg.dcm")
    there = scan[1:5, 3:10, 2:7]
    table = ok("measure", "labels", "seg.dcm", "--values", "scan", "--json").json["labels"]
    for row, name, mask in zip(table, NAMES, (a, b), strict=False):
        values = there[mask > 0]
        assert (row["name"], row["count"]) == (name, values.size)
        assert (row["min"], row["max"], row["median"]) == (values.min(), values.max(), numpy.median(values))
        assert abs(row["mean"] - values.mean()) < 1e-9
    rows = list(csv.DictReader(io.StringIO(ok("measure", "labels", "seg.dcm", "--csv").text)))
    assert [(r["label"], r["count"], r["name"]) for r in rows] == [("1", str(a.sum()), "Liver"), ("2", str(b.sum()), "Spleen")]
    d = segmentation([(1, k, a[k]) for k in range(4)], numbers=(1,))
    d.SegmentSequence[0].SegmentLabel = 'left, "upper" part'
    save(d, "odd.dcm")
    assert [r["name"] for r in csv.DictReader(io.StringIO(ok("measure", "labels", "odd.dcm", "--csv").text))] == ['left, "upper" part']
    values = there[(a | b) > 0]
    got = ok("measure", "statistics", "scan", "--mask", "seg.dcm", "--json").json
    assert got["count"] == values.size and abs(got["mean"] - values.mean()) < 1e-9


def test_codes_of_segments_are_those_of_their_labels():
    need()
    a, b = apart(1, 2)
    d = segmentation([(1, 0, a[0]), (2, 0, b[0])])
    first = d.SegmentSequence[0]
    left = code("7771000", "SCT", "Left")
    left.append(code("24028007", "SCT", "Right")[0])  # the first counts
    first.SegmentedPropertyTypeCodeSequence = code("64033007", "SCT", "Kidney",
                                                   SegmentedPropertyTypeModifierCodeSequence=left)
    first.AnatomicRegionSequence = code("818981001", "SCT", "Abdomen",
                                        AnatomicRegionModifierSequence=code("1", "99X", "Upper"))
    save(d, "codes.dcm")
    info = ok("info", "codes.dcm", "--json").json
    assert info["labels"][0]["codes"] == {
        "category": {"scheme": "SCT", "value": "85756007", "meaning": "Tissue"},
        "type": {"scheme": "SCT", "value": "64033007", "meaning": "Kidney"},
        "type_modifier": {"scheme": "SCT", "value": "7771000", "meaning": "Left"},
        "region": {"scheme": "SCT", "value": "818981001", "meaning": "Abdomen"},
        "region_modifier": {"scheme": "99X", "value": "1", "meaning": "Upper"}}
    assert sorted(info["labels"][1]["codes"]) == ["category", "type"]
    assert info["metadata"]["segment 1 region"] == "Abdomen (818981001, SCT)"
    says(ok("info", "codes.dcm").text, "Liver  [Tissue, Kidney, Left, Abdomen, Upper]")


def test_colours_are_lab_under_d50():
    need()
    # sRGB by Lindbloom's matrices of D50, by hand: white, black, and the red, green and blue of a screen
    known = {"#ffffff": (100, 0, 0), "#000000": (0, 0, 0), "#ff0000": (54.29, 80.81, 69.89),
             "#00ff00": (87.82, -79.29, 80.99), "#0000ff": (29.57, 68.30, -112.03)}
    for want, (l, a, b) in known.items():
        lab = [round(l / 100 * 65535), round((a + 128) / 255 * 65535), round((b + 128) / 255 * 65535)]
        save(segmentation([(1, 0, planes(1)[0])], numbers=(1,), labs=(lab,)), "c.dcm")
        got = ok("info", "c.dcm", "--json").json["labels"][0]["color"]
        near = [abs(int(got[i:i + 2], 16) - int(want[i:i + 2], 16)) for i in (1, 3, 5)]
        assert max(near) <= 1, (got, want)
    save(segmentation([(1, 0, planes(1)[0])], numbers=(1,), labs=(None,)), "c.dcm")
    assert ok("info", "c.dcm", "--json").json["labels"][0]["color"] is None


def test_slices_that_no_segment_has_are_empty_and_no_fault():
    need()
    a = planes(3, 4)
    for between in (2.5, None):
        save(segmentation([(1, 9, a[0]), (2, 0, a[1]), (1, 1, a[2]), (2, 4, a[3])], between=between), "gaps.dcm")
        got, affine = read("gaps.dcm")
        want = by_numpy("gaps.dcm", labels)
        assert want.shape[0] == 10 and numpy.array_equal(got, want) and affine[2, 2] == 2.5
        assert ok("info", "gaps.dcm", "--stats", "--json").json["warnings"] == []


def test_numbers_of_segments_may_be_large_and_have_holes():
    need()
    a, b = apart(4, 3)
    frames = [(300, k, a[k]) for k in range(3)] + [(7, k, b[k]) for k in range(3)]
    save(segmentation(frames, numbers=(300, 7)), "large.dcm")
    assert numpy.array_equal(read("large.dcm")[0], by_numpy("large.dcm", labels))
    info = ok("info", "large.dcm", "--json").json
    assert info["type"] == "u16" and [(l["value"], l["name"]) for l in info["labels"]] == [(7, "Spleen"), (300, "Liver")]


def test_segments_that_overlap_lie_in_layers():
    need()
    a, b = apart(5, 3)
    both = a | b  # overlaps the two others, which do not overlap each other
    masks = {1: a, 2: both, 3: b}
    frames = [(n, k, masks[n][k]) for n, k in itertools.product(masks, range(3))]
    save(segmentation(frames, numbers=(1, 2, 3)), "over.dcm")
    says(ok("info", "over.dcm").message, "overlap", "2 layers", "layer0 is read, FILE:layer1")
    parts = ok("info", "over.dcm", "--json").json["parts"]
    assert [(p["name"], p["about"], p["chosen"]) for p in parts] == [
        ("layer0", "2 segments: Liver, Left kidney", True), ("layer1", "1 segment: Spleen", False)]
    assert numpy.array_equal(read("over.dcm:layer0")[0], a + 3 * b)
    assert numpy.array_equal(read("over.dcm:layer1")[0], 2 * both)
    assert [l["name"] for l in ok("info", "over.dcm:layer1", "--json").json["labels"]] == ["Spleen"]
    says(fails(2, "info", "over.dcm:layer7"), "'layer7'", "layer0 to layer1")
    for label, name, n in ((1, "liver", a.sum()), (2, "Spleen", both.sum()), (3, "segment3", b.sum())):
        alone, _ = read(f"over.dcm:{name}")
        assert numpy.array_equal(alone, label * masks[label])
        assert [l["value"] for l in ok("info", f"over.dcm:{name}", "--json").json["labels"]] == [label]
        assert ok("measure", "volume", f"over.dcm:{name}", "--json").json["volume"] / 0.9375 == n
    for words in (("measure", "volume", "over.dcm", "--label", "2"), ("isosurface", "over.dcm", "--label", "1,2", "-o", "a.stl"),
                  ("measure", "distance", "over.dcm", "over.dcm", "--label", "1", "--other-label", "2")):
        result = volvis(*words)
        says(result.message, "the label 2 (Spleen) lies in another layer", "give over.dcm:layer1")
        assert result.code == 2
    says(fails(2, "measure", "volume", "over.dcm:layer1", "--label", "3"), "(Left kidney)", "give over.dcm:layer0")
    for label in ("3", "left KIDNEY"):
        assert ok("measure", "volume", "over.dcm", "--label", label, "--json").json["volume"] / 0.9375 == b.sum()
    for words in (("measure", "volume", "over.dcm", "--label", "spleen"), ("isosurface", "over.dcm", "--label", "liver,Spleen", "-o", "a.stl")):
        says(volvis(*words).message, "the label 2 (Spleen) lies in another layer", "give over.dcm:layer1")
    ok("isosurface", "over.dcm", "--label", "liver,Left kidney", "-o", "names.stl")
    ok("isosurface", "over.dcm", "--label", "1,3", "-o", "numbers.stl")
    with open("names.stl", "rb") as one, open("numbers.stl", "rb") as other:
        assert one.read() == other.read()
    says(volvis("isosurface", "over.dcm", "--label", "left kidny", "-o", "a.stl").message, "there is no label 'left kidny'; did you mean 'Left kidney'")
    assert ok("measure", "volume", "over.dcm", "--label", "3", "--json").json["volume"] / 0.9375 == b.sum()


def test_a_part_of_slices_is_read_by_itself():
    need()
    a, b = apart(6, 4)
    frames = [(n, k, m[k]) for n, m in ((1, a), (2, b)) for k in range(4)]
    save(segmentation(frames), "two.dcm")
    want = by_numpy("two.dcm", labels)
    ok("crop", "two.dcm", "-o", "part.nii", "--x", "1:4", "--y", "2:6", "--z", "1:3")
    assert numpy.array_equal(numpy.asanyarray(nibabel.load("part.nii").dataobj).T, want[1:3, 2:6, 1:4])


def test_fractions_are_a_part_for_each_segment():
    need()
    values = numpy.random.default_rng(7).integers(0, 201, (6, 7, 5))
    frames = [(1 + i // 3, [0, 1, 4][i % 3] + i // 3, values[i]) for i in range(6)]
    save(segmentation(frames, kind="FRACTIONAL"), "f.dcm")
    info = ok("info", "f.dcm", "--json")
    says(info.message, "fractions of 2 segments", "segment1 is read", "FILE:segment2")
    assert [p["name"] for p in info.json["parts"]] == ["segment1", "segment2"] and info.json["meaning"] == "scalar"
    assert info.json["channels"][0]["name"] == "Liver"
    for part, number in (("segment1", 1), ("segment2", 2), ("spleen", 2)):
        def fractions(out, of, frame):
            if of == number:
                out[:] = frame / 200
        got, affine = read(f"f.dcm:{part}")
        want = by_numpy("f.dcm", fractions)
        assert want.shape[0] == 6 and numpy.allclose(got, want, atol=1e-6) and affine[2, 2] == 2.5, part


def test_a_label_map_has_its_samples():
    need()
    values = numpy.random.default_rng(8).integers(0, 3, (3, 7, 5)) * 150
    frames = [(0, [4, 0, 1][k], values[k]) for k in range(3)]
    save(segmentation(frames, kind="LABELMAP", numbers=(150, 300)), "map.dcm")

    def copy(out, number, frame):
        out[:] = frame
    want = by_numpy("map.dcm", copy)
    assert want.shape[0] == 5 and numpy.array_equal(read("map.dcm")[0], want)
    info = ok("info", "map.dcm", "--json").json
    assert info["type"] == "u16" and info["meaning"] == "label"
    assert [(l["value"], l["name"]) for l in info["labels"]] == [(150, "Liver"), (300, "Spleen")]


def test_frames_without_places_are_in_order_where_that_can_be():
    need()
    a, b = apart(9, 3)
    frames = [(1, 0, a[0]), (1, 0, a[1]), (2, 0, b[0]), (2, 0, b[1]), (1, 0, a[2]), (2, 0, b[2])]
    save(segmentation(frames, placed=False), "un.dcm")
    ok("convert", "un.dcm", "-o", "un.npy")
    assert numpy.array_equal(numpy.load("un.npy").squeeze(), a + 2 * b)
    save(segmentation(frames[:-1], placed=False), "un.dcm")
    says(fails(3, "info", "un.dcm"), "do not give their positions")


def test_odd_segmentations_are_told():
    need()
    a = planes(10, 2)
    save(segmentation([(0, 0, a[0]), (1, 1, a[1])]), "no.dcm")
    says(fails(3, "info", "no.dcm"), "frame 1 does not say which segment it is of")
    save(segmentation([(0, 0, a[0])], numbers=(5,)), "one.dcm")  # there is only one
    assert numpy.array_equal(read("one.dcm")[0][0], 5 * a[0])
    save(segmentation([(1, 0, a[0]), (1, 0, a[1])]), "twice.dcm")
    says(ok("info", "twice.dcm").message, "1 frame lies at the same position as another of the same segment")
    cut = segmentation([(1, k, a[0]) for k in range(40)])
    save(cut, "cut.dcm")
    with open("cut.dcm", "rb") as file:
        data = file.read()
    with open("cut.dcm", "wb") as file:
        file.write(data[:-60])
    result = volvis("info", "cut.dcm", "--stats")
    assert result.code == 7, result.message
    says(result.message, "cut short")


def test_segmentations_beside_their_images_are_parts_and_not_chosen():
    need()
    a = planes(11, 8)
    for k in range(3):
        save(image(numpy.zeros((7, 5), "<i2"), ImagePositionPatient=[-10, 20, 30 + 2.5 * k], SeriesNumber=2,
                   ImageOrientationPatient=[1, 0, 0, 0, 1, 0]), f"s/{k}")
    frames = [(1 + i // 4, i % 4, a[i]) for i in range(8)]
    save(segmentation(frames, SeriesNumber=9, SeriesInstanceUID="1.2.9"), "s/seg")
    info = ok("info", "s", "--json").json
    assert info["type"] == "i16" and [p["name"] for p in info["parts"]] == ["2", "9"]
    parts = ok("info", "s:9", "--json").json["parts"]
    assert [(p["name"], p["chosen"]) for p in parts] == [("2", False), ("9", False), ("9/layer0", True), ("9/layer1", False)]
    assert numpy.array_equal(read("s:9/layer1")[0], 2 * a[4:])


if __name__ == "__main__":
    main()
