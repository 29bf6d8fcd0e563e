"""Structure sets (RTSTRUCT), made by pydicom; truth is the even-odd rule, point by point, in numpy."""
from harness import fails, main, ok, says
from test_dicom import image, need, save, series, volume

try:
    import nibabel
    import numpy
    import pydicom
    from pydicom.dataset import Dataset
    from pydicom.sequence import Sequence
except ImportError:
    pass  # need() says so


def item(**values):
    d = Dataset()
    for key, value in values.items():
        setattr(d, key, value)
    return d


def contour(points, kind="CLOSED_PLANAR"):
    data = [f"{v:.6f}"[:16] for p in points for v in p] if not isinstance(points[0], str) else points
    return item(ContourGeometricType=kind, NumberOfContourPoints=len(data) // 3, ContourData=data)


def structures(rois, drawn_on=None, undefined=False, **more):
    """rois: (number, name, colour, kind, contours)."""
    d = image(numpy.zeros((2, 2), "|u1"), Modality="RTSTRUCT", SeriesInstanceUID="1.2.77", SeriesNumber=77, **more)
    for name in ("PixelData", "Rows", "Columns", "BitsAllocated", "PixelSpacing", "SliceThickness"):
        delattr(d, name)
    d.StructureSetLabel = "Plan A"
    if drawn_on:
        d.ReferencedFrameOfReferenceSequence = [item(FrameOfReferenceUID="1.2.5", RTReferencedStudySequence=[item(
            RTReferencedSeriesSequence=[item(SeriesInstanceUID=drawn_on)])])]
    d.StructureSetROISequence = Sequence([item(ROINumber=r[0], ROIName=r[1]) for r in rois])
    d.ROIContourSequence = Sequence([item(ROIDisplayColor=list(r[2]), ReferencedROINumber=r[0],
                                          ContourSequence=Sequence([*r[4]])) for r in rois if r[4] is not None])
    d.RTROIObservationsSequence = Sequence([item(ReferencedROINumber=r[0], RTROIInterpretedType=r[3]) for r in rois])
    if undefined:
        d["ROIContourSequence"].is_undefined_length = True
        for i in d.ROIContourSequence:
            i.is_undefined_length_sequence_item = True
    return d


def star(seed, centre, radius, n=17):
    """A ragged polygon about a place: n x 2."""
    random = numpy.random.default_rng(seed)
    angle = numpy.sort(random.uniform(0, 2 * numpy.pi, n))
    r = radius * random.uniform(0.5, 1, n)
    return numpy.stack([centre[0] + r * numpy.cos(angle), centre[1] + r * numpy.sin(angle)], 1)


def inside(x, y, polygon):
    out = numpy.zeros(numpy.broadcast(x, y).shape, bool)
    for (x0, y0), (x1, y1) in zip(polygon, numpy.roll(polygon, -1, 0)):
        if y0 != y1:
            out ^= ((y0 <= y) != (y1 <= y)) & (x > x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return out


def read(path):
    ok("convert", path, "-o", "read.nii", "--overwrite")
    out = nibabel.load("read.nii")
    return numpy.asanyarray(out.dataobj).T, out.affine


def area(polygon):
    x, y = polygon.T
    return abs(numpy.dot(x, numpy.roll(y, -1)) - numpy.dot(y, numpy.roll(x, -1))) / 2


RED, GREEN = (255, 0, 0), (0, 128, 255)


def test_contours_get_the_grid_of_the_images_on_which_they_were_drawn():
    need()
    turn = numpy.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]) @ numpy.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])
    for row, column, normal in ((numpy.eye(3)), turn.T):
        samples = volume((30, 24, 7))
        origin = numpy.array([-10.0, 20, 30])
        series("s", samples, row, column, normal * 2.5, origin, names=[f"i{k}" for k in range(7)])

        def place(polygon, k):
            return [origin + row * x + column * y + normal * 2.5 * k for x, y in polygon]
        # in mm of the plane; columns are 0.75 mm apart, rows 0.5 mm
        a = {k: [star(k, (11, 6), 5), star(50 + k, (11, 6), 2)] for k in (1, 2, 3)}  # the second is a hole, more or less
        b = {k: [star(90 + k, (3, 3), 2.5)] for k in (4, 5)}
        for path, undefined in (("rs.dcm", False), ("s/rs.dcm", True)):
            rois = [(3, "Liver", RED, "ORGAN", [contour(place(p, k)) for k in a for p in a[k]]),
                    (8, "PTV", GREEN, "PTV", [contour(place(p, k)) for k in b for p in b[k]]),
                    (9, "Nothing", RED, "", None)]
            save(structures(rois, "1.2.3", undefined), path, implicit=undefined)
        x, y = numpy.meshgrid(numpy.arange(30) * 0.75, numpy.arange(24) * 0.5)
        want = numpy.zeros((7, 24, 30), int)
        for number, planes in ((3, a), (8, b)):
            for k, polygons in planes.items():
                want[k][numpy.logical_xor.reduce([inside(x, y, p) for p in polygons])] = number
        for path in ("s/rs.dcm", "s:77"):
            got, affine = read(path)
            assert (got != want).sum() == 0, ((got != want).sum(), (got > 0).sum())
            assert numpy.allclose(affine, read("s:1.2.3")[1], atol=1e-4)
        info = ok("info", "s/rs.dcm", "--json").json
        says(info["metadata"]["grid"], "7 images of 30 x 24", "on which the contours were drawn")
        assert info["meaning"] == "label"
        assert [(l["value"], l["name"], l["color"]) for l in info["labels"] if l["value"]] == [
            (3, "Liver", "#ff0000"), (8, "PTV", "#0080ff"), (9, "Nothing", None)]
        assert info["metadata"]["ROI 3"] == "Liver, ORGAN, 6 CLOSED_PLANAR, #ff0000"
        says(info["metadata"]["ROI 9"], "no contours")
        assert ok("info", "s", "--json").json["type"] == "i16"  # the images are what is read of the folder


def test_a_tilted_gantry_and_islands_in_holes():
    need()
    row, column, step = numpy.eye(3)[0], numpy.array([0, 0.96, -0.28]), numpy.array([0, 0, 2.5])  # 16 degrees off
    origin = numpy.array([-10.0, 20, 30])
    series("s", volume((30, 24, 6)), row, column, step, origin, names=[f"i{k}" for k in range(6)])
    # three and four in one another, and two that cross: what an odd number of them holds is inside
    rings = {k: [star(7 * k + n, (11, 6), r) for n, r in enumerate((6, 4.5, 3, 1.5)[:2 + k])] for k in (1, 2)}
    rings[4] = [star(40, (9, 6), 4), star(41, (12, 6), 4)]
    points = [contour([origin + row * x + column * y + step * k for x, y in p]) for k in rings for p in rings[k]]
    save(structures([(5, "Ring", RED, "ORGAN", points)], "1.2.3"), "s/rs.dcm")
    x, y = numpy.meshgrid(numpy.arange(30) * 0.75, numpy.arange(24) * 0.5)
    want = numpy.zeros((6, 24, 30), int)
    for k, polygons in rings.items():
        want[k][numpy.logical_xor.reduce([inside(x, y, p) for p in polygons])] = 5
    got, affine = read("s/rs.dcm")
    assert want[1:5:3].any() and numpy.array_equal(got, want)
    assert numpy.allclose(affine[:3, 2], step, atol=1e-5) and numpy.allclose(affine, read("s:1.2.3")[1], atol=1e-4)
    # without the images the planes are the contours' own: the volume is the area times the distance of planes
    save(structures([(5, "Block", RED, "", [contour([origin + row * x + column * y + step * k for x, y in
                                                     ((0, 0), (12, 0), (12, 9), (0, 9))]) for k in range(5)])]), "own.dcm")
    got, affine = read("own.dcm")
    voxel = abs(numpy.linalg.det(affine[:3, :3]))
    assert abs((got == 5).sum() * voxel - 12 * 9 * 5 * 2.5 * 0.96) < 0.02 * 12 * 9 * 5 * 2.5


def test_contours_alone_get_a_grid_of_their_own():
    need()
    polygon = star(7, (40, -20), 30, 60)
    planes = [2.5 * k for k in range(12)]
    rois = [(1, "Cylinder", RED, "ORGAN", [contour([(x, y, z) for x, y in polygon]) for z in planes])]
    save(structures(rois), "own.dcm")
    got, affine = read("own.dcm")
    voxel = abs(numpy.linalg.det(affine[:3, :3]))
    assert got.shape[0] == 12 and abs(affine[2, 2] - 2.5) < 1e-5 and abs(affine[2, 3]) < 1e-5
    want = area(polygon) * 12 * 2.5
    assert abs((got == 1).sum() * voxel - want) < 0.01 * want
    j, i = numpy.mgrid[:got.shape[1], :got.shape[2]]
    x, y = -(affine[0, 0] * i + affine[0, 3]), -(affine[1, 1] * j + affine[1, 3])
    assert (got[5] != inside(x, y, polygon)).sum() <= 2  # affines of NIfTI have 7 digits
    says(ok("info", "own.dcm", "--json").json["metadata"]["grid"], "of the contours themselves")
    ok("isosurface", "own.dcm", "-o", "own.ply")
    says(ok("info", "own.ply").text, "Cylinder")


def test_regions_that_overlap_lie_in_layers():
    need()
    square = [(0, 0), (20, 0), (20, 20), (0, 20)]
    small = [(5, 5), (9, 5), (9, 9), (5, 9)]
    rois = [(n, name, RED, "ORGAN", [contour([(*p, z) for p in shape]) for z in (0, 3, 6)])
            for n, name, shape in ((1, "Body", square), (2, "PTV", small))]
    save(structures(rois), "over.dcm")
    says(ok("info", "over.dcm").message, "its ROIs overlap and lie in 2 layers")
    got, affine = read("over.dcm:layer1")
    assert abs((got == 2).sum() * abs(numpy.linalg.det(affine[:3, :3])) - 16 * 9) < 1e-3
    info = ok("info", "over.dcm", "--json").json
    assert [p["about"] for p in info["parts"]] == ["1 ROI: Body", "1 ROI: PTV"]
    says(info["metadata"]["ROI 2"], "PTV, ORGAN, 3 CLOSED_PLANAR")


def test_small_contours_alone_have_samples_that_are_not_far_smaller_than_slices_are_thick():
    need()
    for radius, step, most in ((6, 2.5, 16), (1, 2.5, 100), (40, 3, 16), (0.5, 0.1, 16)):
        outlines = [star(k, (3, -4), radius, 60) for k in range(4)]
        save(structures([(1, "Lens", RED, "ORGAN", [contour([(x, y, step * k) for x, y in p])
                                                     for k, p in enumerate(outlines)])]), "small.dcm")
        got, affine = read("small.dcm")
        spacing = abs(affine[0, 0])
        assert step / most <= spacing <= min(1, 2 * radius / 25), (radius, spacing)
        assert max(got.shape) <= 512, got.shape
        want = sum(area(p) for p in outlines)
        assert abs((got > 0).sum() * spacing**2 / want - 1) < 0.05, (radius, spacing)
        says(ok("info", "small.dcm", "--json").json["metadata"]["grid"], f"{spacing:g} x {spacing:g} x {step:g} mm")


def test_holes_and_keyholes_and_wide_gaps():
    need()
    outer, hole = [(0, 0), (10, 0), (10, 10), (0, 10)], [(3, 3), (7, 3), (7, 7), (3, 7)]
    keyhole = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 0), (3, 3), (3, 7), (7, 7), (7, 3), (3, 3)]
    z = (0, 5, 10, 30, 35, 40)
    for shapes in ([outer, hole], [keyhole]):
        rois = [(1, "Ring", RED, "", [contour([(*p, at) for p in shape]) for at in z for shape in shapes])]
        save(structures(rois), "ring.dcm")
        got, affine = read("ring.dcm")
        assert [bool(plane.any()) for plane in got] == [True] * 3 + [False] * 3 + [True] * 3
        assert abs((got[0] == 1).sum() * abs(affine[0, 0] * affine[1, 1]) - 84) < 1e-3
    # every second slice: what lies between is filled
    series("s", volume((16, 16, 9)), step=(0, 0, 2), origin=(0, 0, 0))
    save(structures([(1, "Alternate", RED, "", [contour([(*p, at) for p in outer]) for at in (0, 4, 8)])], "1.2.3"), "s/rs")
    assert [bool(plane.any()) for plane in read("s/rs")[0]] == [True] * 5 + [False] * 4


def test_what_cannot_be_drawn_is_told():
    need()
    square = [(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0)]
    good = [contour([(x, y, z) for x, y, _ in square]) for z in (0, 2, 4)]
    bad = [contour([(1, 1, 1)], "POINT"), contour(["1"] * 10), contour(["nan"] * 9), contour(square[:2]),
           contour(["9999999"] * 9), contour([(0, 0, 0), (9, 0, 9), (9, 9, 9)]), good[0]]
    save(structures([(0, "x" * 60, RED, "ORGAN", good + bad), (0, "again", RED, "", None)]), "bad.dcm")
    info = ok("info", "bad.dcm")
    says(info.message, "not closed", "not a multiple of 3", "not numbers", "fewer than 3 points", "a kilometre", "cross the slices",
         "appear twice", "more than one ROI with number 0", "order of the ROIs")
    assert (read("bad.dcm")[0] == 1).any(axis=(1, 2)).all()
    save(structures([(1, "Isocentre", RED, "ISOCENTER", [bad[0]])]), "points.dcm")
    says(fails(3, "info", "points.dcm"), "structure set", "without closed contours")


def test_every_way_of_writing_elements_is_read():
    need()
    d = structures([(1, "R", RED, "", [contour([(x, y, z) for x, y in ((0, 0), (9, 0), (9, 9))]) for z in (0, 2)])])
    for name, syntax in (("big", pydicom.uid.ExplicitVRBigEndian), ("deflated", pydicom.uid.DeflatedExplicitVRLittleEndian)):
        d.file_meta.MediaStorageSOPInstanceUID, d.file_meta.TransferSyntaxUID = d.SOPInstanceUID, syntax
        d.is_little_endian, d.is_implicit_VR = name != "big", False
        d.save_as(f"{name}.dcm", write_like_original=False)
        assert ok("info", f"{name}.dcm", "--json").json["metadata"]["ROI 1"] == "R, 2 CLOSED_PLANAR, #ff0000"
        assert read(f"{name}.dcm")[0].shape[0] == 2


def test_several_structure_sets_are_parts():
    need()
    for n in (1, 2):
        rois = [(n, f"R{n}", RED, "", [contour([(x, y, z) for x, y in ((0, 0), (9, 0), (9, 9))]) for z in (0, 2)])]
        d = structures(rois)
        d.SeriesNumber, d.SeriesInstanceUID = n, f"1.2.{n}"
        save(d, f"sets/{n}")
    parts = ok("info", "sets", "--json").json["parts"]
    assert [(p["name"], p["about"]) for p in parts] == [(str(n), "structure set of 1 ROIs, Plan A") for n in (1, 2)]
    assert read("sets:2")[0].max() == 2


if __name__ == "__main__":
    main()
