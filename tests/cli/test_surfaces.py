"""volvis isosurface, simplify and smooth: against closed forms, and of real data against VTK's contours."""
import math
import os
import sys
from harness import Skip, fails, main, ok, says, volvis, write_ball, write_blocks, write_cells, write_nrrd, write_samples

import numpy as np

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(sys.argv[0]))))
VOLUMES = os.path.join(os.environ.get("VOLVIS_SHARED", os.path.join(SOURCE, "..", "shared")), "data", "volumes")

# file, value, box: sharp and soft ones, with and without noise, of different types and spacings. Of the head, whose noise
# is the same everywhere, a part: the whole has 2.7 million triangles.
REAL = [("lobster_301x324x56_u8.nhdr", 40.5, None), ("engine_256x256x256_u8.nhdr", 120.5, None), ("tooth.nhdr", 600.5, None),
        ("hydrogen.vti", 0.1, None), ("neghip_64x64x64_u8.raw", 100.5, None), ("fuel_64x64x64_u8.raw", 60.5, None),
        ("nucleon_41x41x41_u8.raw", 80.5, None), ("MR_Gd.nii.gz", 60.5, None),
        ("mra_head_256x256x256_u8.nhdr", 99.5, ("80:177", "84:173", "86:169"))]


TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4", "ushort": "<u2"}


def read_ply(path):
    """Places and triangles of what VolVis writes: binary, little endian, floats or doubles first."""
    with open(path, "rb") as file:
        assert file.readline() == b"ply\n"
        fields, element, n = {b"vertex": [], b"face": []}, None, {}
        while (line := file.readline().split()) != [b"end_header"]:
            if line[0] == b"element":
                element = line[1]
                n[element] = int(line[2])
            elif line[0] == b"property" and line[1] == b"list":
                fields[element] += [("n", "u1"), ("v", "<u4", 3)]
            elif line[0] == b"property":
                fields[element].append((line[2].decode(), TYPES[line[1].decode()]))
        vertex = np.frombuffer(file.read(n[b"vertex"] * np.dtype(fields[b"vertex"]).itemsize), fields[b"vertex"])
        face = np.frombuffer(file.read(n[b"face"] * np.dtype(fields[b"face"]).itemsize), fields[b"face"])
    assert (face["n"] == 3).all()
    return np.stack([vertex[a].astype("f8") for a in "xyz"], 1), face["v"].astype("i8"), vertex


def area(places, triangles):
    x, y, z = (np.ascontiguousarray(axis)[triangles.T] for axis in places.T)
    (ux, uy, uz), (vx, vy, vz) = ((a[1] - a[0] for a in (x, y, z)), (a[2] - a[0] for a in (x, y, z)))
    return float(np.sqrt((uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2).sum() / 2)


def volume(places, triangles):
    places = places - places.mean(0)
    a, b, c = (places[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6)


def surface(*words):
    ok("isosurface", *words, "-o", "out.ply", "--overwrite")
    return read_ply("out.ply")


def write_distance(path, n, radius, spacing=(1, 1, 1)):
    z, y, x = (axis - (n - 1) / 2 for axis in np.ogrid[:n, :n, :n])
    away = np.sqrt((x * spacing[0]) ** 2 + (y * spacing[1]) ** 2 + (z * spacing[2]) ** 2)
    write_samples(path, (n, n, n), (radius - away).astype("<f4").tobytes(), spacing, "float")


def test_a_sphere_has_the_area_and_volume_that_it_should():
    write_distance("ball.nrrd", 26, 10)
    places, triangles, vertex = surface("ball.nrrd", "--iso", 0)
    assert abs(area(places, triangles) / (400 * math.pi) - 1 + 0.00314) < 0.0002
    assert abs(volume(places, triangles) / (4000 / 3 * math.pi) - 1 + 0.00596) < 0.0003
    out = places - 12.5
    normals = np.stack([vertex[a] for a in ("nx", "ny", "nz")], 1)
    cosines = (out * normals).sum(1) / np.linalg.norm(out, axis=1)
    assert cosines.min() > math.cos(math.radians(3)), "normals point outwards"


def test_spacing_stretches_the_surface():
    write_distance("long.nrrd", 26, 8, (1, 0.8, 1.25))
    places, triangles, _ = surface("long.nrrd", "--iso", 0)
    assert abs(area(places, triangles) / (256 * math.pi) - 1) < 0.01
    assert abs(np.linalg.norm(places - [12.5, 10, 15.625], axis=1) - 8).max() < 0.05


def test_a_value_is_chosen_where_none_is_given_and_labels_say_why_not():
    write_ball("a.nrrd", 24)
    places, triangles, _ = surface("a.nrrd")
    assert len(triangles) > 1000 and volume(places, triangles) > 100
    told = ok("isosurface", "a.nrrd", "-o", "found.ply")
    says(told.text, "surface at", "splits the histogram")
    told = ok("isosurface", "a.nrrd", "-o", "found.ply", "--overwrite", "--json").json
    same, _, _ = surface("a.nrrd", "--iso", repr(told["values"][0]))
    assert told["value_found"] and np.array_equal(same, places), told
    told = ok("isosurface", "a.nrrd", "-o", "two.ply", "--iso", "60,180")
    assert "surface at 60, 180;" in told.text and "splits" not in told.text, told.text


def test_a_value_or_label_that_is_given_twice_is_taken_once():
    write_distance("a.nrrd", 14, 5)
    once = ok("isosurface", "a.nrrd", "-o", "once.ply", "--iso", "1,0", "--json")
    twice = ok("isosurface", "a.nrrd", "-o", "twice.ply", "--iso", "1,0,1,1", "--json")
    assert once.message == "" and twice.message.count("the value 1 is given more than once") == 1, twice.message
    assert twice.json["values"] == [1, 0] and twice.json["triangles"] == once.json["triangles"]
    with open("once.ply", "rb") as a, open("twice.ply", "rb") as b:
        assert a.read() == b.read()
    ok("isosurface", "a.nrrd", "-o", "seed.ply", "--iso", "1,1", "--seed", "6,6,6")
    write_nrrd("labels.nrrd", (8, 8, 8), lambda x, y, z: 3 * (2 <= x < 6 and 2 <= y < 6 and 2 <= z < 6))
    told = ok("isosurface", "labels.nrrd", "-o", "label.ply", "--label", "3,3", "--json")
    assert told.json["parts"] == 1
    says(told.message, "the label 3 is given more than once")


def test_ids_that_pictures_show_as_labels_have_a_surface_each():
    write_blocks()
    says(ok("isosurface", "blocks.nrrd", "-o", "all.ply").message, "looks like labels", "'iso'")
    ok("isosurface", "blocks.nrrd", "-o", "named.ply", "--label", ",".join(str(1000 * i) for i in range(1, 28)))
    triangles = [ok("info", name, "--json").json["triangles"] for name in ("all.ply", "named.ply")]
    assert triangles[0] == triangles[1], triangles
    assert "labels" not in ok("isosurface", "blocks.nrrd", "-o", "value.ply", "--iso", "500").message
    says(ok("isosurface", "blocks.nrrd", "-o", "dry.ply", "--dry-run", env={"COLUMNS": "200"}).text, "looks like labels", "not estimated")
    ok("convert", "blocks.nrrd", "-o", "deep.nrrd", "--type", "u16")
    ok("resample", "deep.nrrd", "-o", "deep.nrrd", "--dims", "64,64,150", "--interpolation", "nearest", "--overwrite")
    seen = [ok("isosurface", "deep.nrrd", "-o", "deep.ply", "--overwrite", *words, env={"COLUMNS": "200"}) for words in ((), ("--dry-run",))]
    assert ("looks like labels" in seen[0].message) == ("looks like labels" in seen[1].text), seen[1].text
    assert "not estimated" not in ok("isosurface", "blocks.nrrd", "-o", "dry.ply", "--dry-run", "--iso", "500").text
    assert ok("info", "value.ply", "--json").json["triangles"] < triangles[0] / 2


def test_what_looks_like_labels_or_colours_is_told():
    write_nrrd("few.nrrd", (12, 12, 12), lambda x, y, z: (x > 2) * (x < 9) * (y > 2) * (z > 2) * (3 + 4 * (x > 5)))
    write_ball("ball.nrrd", 24)
    says(ok("isosurface", "few.nrrd", "-o", "few.ply").message, "few.nrrd: has only 3 different values", "'label'")
    assert ok("isosurface", "few.nrrd", "-o", "few.ply", "--overwrite", "--label", "3,7").message == ""
    assert ok("isosurface", "ball.nrrd", "-o", "ball.ply").message == ""
    write_cells("two.nrrd")
    says(ok("isosurface", "two.nrrd", "-o", "two.ply").message, "2 channels", "'channel'")
    assert ok("isosurface", "two.nrrd", "-o", "two.ply", "--overwrite", "--component", 1).message == ""


def test_a_dry_run_estimates_triangles_and_memory_and_writes_nothing():
    write_distance("a.nrrd", 90, 30)
    for words in (["--iso", 0], ["--iso", "0,10"], []):
        planned = ok("isosurface", "a.nrrd", "-o", "dry.ply", "--dry-run", "--json", *words).json
        made = ok("isosurface", "a.nrrd", "-o", "made.ply", "--overwrite", "--json", *words).json
        assert planned["dry_run"] and planned["layers_examined"] < planned["layers"] == 89
        assert abs(planned["triangles_estimate"] / made["triangles"] - 1) < 0.1, (planned, made)
        assert abs(planned["memory_bytes"] / made["peak_bytes"] - 1) < 0.3, (planned, made)
        assert planned["value_found"] == made["value_found"]
    told = ok("isosurface", "a.nrrd", "-o", "dry.ply", "--dry-run", "--iso", 0, "--pieces", 1).text
    says(told, "reads", "90 x 90 x 90 f32", "makes", "about", "less what is left out", "estimate from 32 of 89 layers", "needs")
    assert not os.path.exists("dry.ply")


def test_a_dry_run_counts_all_layers_of_few_slices_and_says_where_it_does_not_know():
    dry = ["-o", "dry.ply", "--dry-run"]
    write_distance("small.nrrd", 12, 4)
    planned = ok("isosurface", "small.nrrd", *dry, "--iso", 0, "--json").json
    made = ok("isosurface", "small.nrrd", "-o", "small.ply", "--iso", 0, "--json").json
    assert planned["layers_examined"] == planned["layers"] == 11
    assert abs(planned["triangles_estimate"] - made["triangles"]) <= 0.05 * made["triangles"]
    for z in 1, 2:
        write_nrrd("flat.nrrd", (6, 5, z), lambda x, y, z: 10 * x, kind="float", code="f")
        planned = ok("isosurface", "flat.nrrd", *dry, "--iso", 25, "--json").json
        assert planned["layers_examined"] == z - 1 and planned["triangles_estimate"] == 8 * (z - 1), planned
    write_nrrd("holes.nrrd", (9, 9, 9), lambda x, y, z: math.nan if x == 4 else z, kind="float", code="f")
    told = ok("isosurface", "holes.nrrd", *dry, "--iso", 3.5, "--json")
    assert told.json["triangles_estimate"] == 2 * 6 * 8 and told.message == "", told.message
    write_nrrd("labels.nrrd", (8, 8, 8), lambda x, y, z: 3 * (2 <= x < 6))
    says(ok("isosurface", "labels.nrrd", *dry, "--label", 3).text, "not estimated", "labels")
    ok("render", "small.nrrd", "-o", "small.png", "--size", "16x16")
    says(ok("isosurface", "small.png", *dry).text, "not estimated", "a scene")
    with open("small.nrrd", "rb") as file:
        says(ok("isosurface", "-", *dry, stdin=file.read()).text, "not estimated", "a pipe")
    fails(2, "isosurface", "small.nrrd", *dry, "--component", 3)
    says(ok("simplify", "small.ply", "-o", "dry.ply", "--share", "10%", "--dry-run").text, "reads", "small.ply", "makes")
    assert not os.path.exists("dry.ply")


def test_several_values_are_parts():
    write_ball("a.nrrd", 24)
    ok("isosurface", "a.nrrd", "-o", "two.stl", "--iso", "60,180", "--encoding", "ascii")
    with open("two.stl", encoding="ascii") as file:
        names = [line.split()[1] for line in file if line.startswith("solid")]
    assert names == ["60", "180"], names


def test_a_seed_counts_samples_or_is_a_place_in_the_world():
    def value(x, y, z):
        return max(8 - math.dist((x, y, z), (11, 12, 12)), 5 - math.dist((x, y, z), (31, 12, 12)))
    write_nrrd("fine.nrrd", (42, 25, 25), value, kind="float", code="f", spacing=(0.5, 0.5, 0.5))
    by_index, _, _ = surface("fine.nrrd", "--iso", 0, "--seed", "31,12,17")
    by_length, _, _ = surface("fine.nrrd", "--iso", 0, "--seed", "15.5,6,8.5", "--space", "world")
    assert len(by_index) == len(by_length) and (by_index == by_length).all() and by_index[:, 0].min() > 12
    found = ok("measure", "area", "fine.nrrd", "--iso", "0", "--seed", "31,12,15", "--json").json
    assert abs(found["area"] / (4 * math.pi * 2.5**2) - 1) < 0.02
    says(fails(2, "isosurface", "fine.nrrd", "-o", "a.ply", "--iso", "0", "--seed", "50,12,12"), "outside", "space world")


def test_the_border_is_open_or_capped():
    write_nrrd("slab.nrrd", (8, 8, 8), lambda x, y, z: 200)
    assert ok("isosurface", "slab.nrrd", "-o", "none.ply", "--iso", 100, "--json").json["triangles"] == 0
    places, triangles, _ = surface("slab.nrrd", "--iso", 100, "--cap")
    assert abs(volume(places, triangles) - 7**3) < 0.02 and abs(area(places, triangles) - 6 * 49) < 0.02


def two_balls(path):
    def value(x, y, z):
        return max(8 - math.dist((x, y, z), (11, 12, 12)), 5 - math.dist((x, y, z), (31, 12, 12)))
    write_nrrd(path, (42, 25, 25), value, kind="float", code="f")


def test_pieces_by_size_and_by_seed():
    two_balls("two.nrrd")
    both, _, _ = surface("two.nrrd", "--iso", 0)
    large, triangles, _ = surface("two.nrrd", "--iso", 0, "--pieces", 1)
    assert large[:, 0].max() < 20 and abs(volume(large, triangles) / (512 * 4 / 3 * math.pi) - 1) < 0.02
    small, _, _ = surface("two.nrrd", "--iso", 0, "--seed", "31,12,17")
    assert small[:, 0].min() > 25 and len(small) + len(large) == len(both)
    by_length, _, _ = surface("two.nrrd", "--iso", 0, "--seed", "31,12,17", "--space", "world")
    assert (by_length == small).all()
    none, _, _ = surface("two.nrrd", "--iso", 0, "--least", 1e6, "--by", "volume")
    assert len(none) == 0
    fails(2, "isosurface", "two.nrrd", "-o", "a.ply", "--iso", "0,1", "--seed", "0,0,0")


def test_labels_share_their_borders():
    write_nrrd("map.nrrd", (20, 14, 14), lambda x, y, z: (1 if x < 10 else 2) if math.dist((x, y, z), (9.5, 6.5, 6.5)) < 6 else 0)
    places, triangles, _ = surface("map.nrrd", "--label", "1,2")
    assert abs(volume(places, triangles) / (864 * math.pi / 3) - 1) < 0.06
    one, its, _ = surface("map.nrrd", "--label", 1, "--smoothing", 0.5)
    assert one[:, 0].max() < 10.1 and abs(volume(one, its) / (432 * math.pi / 3) - 1) < 0.05
    fails(2, "isosurface", "map.nrrd", "-o", "a.ply", "--label", 9)


def test_a_second_input_gives_its_values():
    write_distance("ball.nrrd", 26, 10)
    write_nrrd("x.nrrd", (26, 26, 26), lambda x, y, z: x, kind="float", code="f")
    places, _, vertex = surface("ball.nrrd", "x.nrrd", "--iso", 0)
    name = [n for n in vertex.dtype.names if n not in ("x", "y", "z", "nx", "ny", "nz")][0]
    assert abs(vertex[name] - places[:, 0]).max() < 1e-4
    write_nrrd("part.nrrd", (13, 26, 26), lambda x, y, z: x, kind="float", code="f")
    said = ok("isosurface", "ball.nrrd", "part.nrrd", "-o", "part.ply", "--iso", 0).message
    outside = sum(places[:, 0] > 12)
    says(said, f"{outside} of {len(places)} vertices lie outside", "NaN")


def test_fewer_triangles_and_no_steps_for_the_same_body():
    write_distance("ball.nrrd", 30, 12)
    places, triangles, _ = surface("ball.nrrd", "--iso", 0)
    ok("simplify", "out.ply", "-o", "less.ply", "--triangles", 800)
    less, fewer, _ = read_ply("less.ply")
    assert len(fewer) <= 800 and abs(volume(less, fewer) / volume(places, triangles) - 1) < 0.02
    ok("simplify", "out.ply", "-o", "share.ply", "--share", "10%")
    assert len(read_ply("share.ply")[1]) <= len(triangles) / 10 + 1
    ok("smooth", "out.ply", "-o", "smooth.ply", "--iterations", 10)
    smooth, same, _ = read_ply("smooth.ply")
    assert len(same) == len(triangles) and abs(volume(smooth, same) / volume(places, triangles) - 1) < 1e-4


def vtk_smoothed(path, iterations, pass_band):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader, smooth = vtk.vtkPLYReader(), vtk.vtkWindowedSincPolyDataFilter()
    reader.SetFileName(path)
    smooth.SetInputConnection(reader.GetOutputPort())
    smooth.SetNumberOfIterations(iterations)
    smooth.SetPassBand(pass_band)
    smooth.NormalizeCoordinatesOn()
    smooth.Update()
    return vtk_to_numpy(smooth.GetOutput().GetPoints().GetData()).astype("f8")


def test_smooth_takes_out_what_vtk_takes_out():
    """A ball with noise: what is left of it is no rougher than what VTK's windowed sinc leaves, and the volume is kept."""
    try:
        import vtk  # noqa: F401
    except ImportError as missing:
        raise Skip("no vtk") from missing
    noise = np.random.default_rng(5).normal(0, 0.3, (34, 34, 34))
    write_nrrd("noisy.nrrd", (34, 34, 34), lambda x, y, z: 11 - math.dist((x, y, z), (16.5,) * 3) + noise[z, y, x],
               kind="float", code="f")
    rough, triangles, _ = surface("noisy.nrrd", "--iso", 0, "--pieces", 1)
    radii = lambda p: np.linalg.norm(p - 16.5, axis=1)
    for iterations, band in (20, 0.1), (100, 0.05), (50, 0.3):
        ok("smooth", "out.ply", "-o", "smooth.ply", "--overwrite", "--iterations", iterations, "--pass-band", band)
        ours, theirs = read_ply("smooth.ply")[0], vtk_smoothed("out.ply", iterations, band)
        assert abs(volume(ours, triangles) / volume(rough, triangles) - 1) < 1e-4
        assert np.std(radii(ours)) < 1.1 * np.std(radii(theirs)) < np.std(radii(rough))
        assert np.linalg.norm(ours - theirs, axis=1).mean() < 0.25
        assert area(ours, triangles) < area(rough, triangles)


def test_the_error_of_simplify_is_kept_and_no_piece_vanishes():
    centers = [(8 + 16 * i, 8 + 16 * j, 8) for i in range(3) for j in range(3)]
    def value(x, y, z):
        return max(1.7 + 0.6 * k - math.dist((x, y, z), c) for k, c in enumerate(centers))
    write_nrrd("balls.nrrd", (48, 48, 17), value, kind="float", code="f")
    surface("balls.nrrd", "--iso", 0)
    for error in 0.1, 1, 5:
        told = ok("simplify", "out.ply", "-o", "less.ply", "--overwrite", "--error", error, "--json").json
        assert told["distance"] + told["distance_error"] <= error, told
        assert told["pieces_before"] == 9 and told["pieces_dropped"] == 0, told
        assert ok("info", "less.ply", "--json").json["pieces"] == 9
        whole, less = read_ply("out.ply"), read_ply("less.ply")
        for c in centers:
            assert (np.linalg.norm(less[0] - c, axis=1) < 8).any()
        assert len(less[1]) < len(whole[1])
    told = ok("simplify", "out.ply", "-o", "few.ply", "--triangles", 60, "--json").json
    assert told["pieces_after"] == ok("info", "few.ply", "--json").json["pieces"] == 9 - told["pieces_dropped"], told
    farthest = hausdorff("out.ply", "few.ply")
    assert told["distance"] <= farthest + 1e-6 and farthest <= told["distance"] + told["distance_error"] + 1e-6, told
    ok("convert", "out.ply", "-o", "soup.stl")
    told = ok("simplify", "soup.stl", "-o", "less.stl", "--error", 1, "--json").json
    assert told["pieces_before"] == 9 and told["triangles"] < 0.7 * len(read_ply("out.ply")[1]), told
    says(ok("simplify", "out.ply", "-o", "less.ply", "--overwrite", "--error", 1).text, "at most", "from what it was")


def test_simplify_keeps_its_error_at_pieces_that_have_no_area_or_lie_back_to_back():
    """A ball; and far from it a point, a line, two triangles back to back, and a fin of two on a tetrahedron."""
    write_nrrd("ball.nrrd", (20, 20, 20), lambda x, y, z: 8 - math.dist((x, y, z), (9.5,) * 3), kind="float", code="f")
    places, triangles, _ = surface("ball.nrrd", "--iso", 0)
    soup = [[places[v] for v in t] for t in triangles]
    a, b, c, d, fin = (40, 0, 0), (43, 0, 0), (40, 3, 0), (40, 0, 3), (49, -4, -4)
    soup += [[(30, 0, 0)] * 3, [(30, 9, 0), (30, 9, 0), (33, 9, 0)], [a, b, fin], [b, a, fin], [a, c, b], [a, b, d], [a, d, c], [b, c, d],
             [(60, 0, 0), (64, 0, 0), (60, 4, 0)], [(60, 4, 0), (64, 0, 0), (60, 0, 0)]]
    with open("soup.stl", "w", encoding="ascii") as file:
        file.write("solid soup\n")
        for t in soup:
            file.write("facet normal 0 0 0\nouter loop\n")
            for p in t:
                file.write("vertex %.9g %.9g %.9g\n" % tuple(p))
            file.write("endloop\nendfacet\n")
        file.write("endsolid\n")
    for error in 0.1, 0.5, 2:
        told = ok("simplify", "soup.stl", "-o", "less.stl", "--overwrite", "--error", error, "--json")
        assert "more than the error" not in told.message and told.json["pieces_dropped"] == 0, (told.message, told.json)
        assert told.json["distance"] + told.json["distance_error"] <= error, told.json
        assert hausdorff("soup.stl", "less.stl") <= error + 1e-6
        assert told.json["triangles"] < len(soup) * 0.7, told.json


def hausdorff(a, b):
    return ok("measure", "distance", a, b, "--json").json["hausdorff"]


def test_simplify_tells_how_far_it_went_and_of_which_pieces():
    """Of balls between which there is noise: specks vanish, and what is far from all that is left counts."""
    noise = np.random.default_rng(7).uniform(-1, 1, (36, 36, 36))
    write_nrrd("specks.nrrd", (36, 36, 36), lambda x, y, z: 9 - math.dist((x, y, z), (17.5,) * 3) + 6 * noise[z, y, x],
               kind="float", code="f")
    places, _, _ = surface("specks.nrrd", "--iso", 0)
    before = ok("info", "out.ply", "--json").json["pieces"]
    for share in "5%", "1%":
        told = ok("simplify", "out.ply", "-o", "less.ply", "--overwrite", "--share", share, "--json").json
        after = ok("info", "less.ply", "--json").json["pieces"]
        assert told["pieces_before"] == before and told["pieces_after"] == after, (before, after, told)
        assert told["pieces_dropped"] >= before - after
        less = read_ply("less.ply")[0]
        far = max(np.linalg.norm(less - p, axis=1).min() for p in places[::37])
        assert told["distance"] + told["distance_error"] > far / 2, (far, told)
        assert abs(told["distance"] - hausdorff("out.ply", "less.ply")) <= told["distance_error"] + 1e-3
    says(ok("simplify", "out.ply", "-o", "less.ply", "--overwrite", "--share", "1%").text, f"{before} pieces became {after}")


def test_where_the_surface_would_move_too_far_it_alone_keeps_its_triangles():
    """With less of the quadric error everywhere, until the farthest place is near enough, 5140 and 3442 of 7328 would be left."""
    noise = np.random.default_rng(3).uniform(-0.45, 0.45, (40, 40, 40))
    write_nrrd("noisy.nrrd", (40, 40, 40), lambda x, y, z: 13 - math.dist((x, y, z), (19.5,) * 3) + noise[z, y, x],
               kind="float", code="f")
    surface("noisy.nrrd", "--iso", 0)
    for error, most in (0.1, 4900), (0.3, 2900), (1, 420):
        told = ok("simplify", "out.ply", "-o", "less.ply", "--overwrite", "--error", error, "--json")
        apart = ok("measure", "distance", "out.ply", "less.ply", "--json").json
        assert told.message == "" and told.json["triangles"] < most, told.json
        assert told.json["distance"] + told.json["distance_error"] <= error + 1e-12, told.json
        assert told.json["distance"] * 0.99 < apart["hausdorff"] <= error, (apart, told.json)


def test_a_scene_is_cut_as_its_picture_is():
    write_distance("ball.nrrd", 26, 10)
    for name in "scene.vv.json", "picture.png":
        ok("render", "ball.nrrd", "-o", "picture.png", "--overwrite", "--save-scene", "scene.vv.json", "--method", "surface",
           "--size", "32x32", "--iso", 0, "--clip", "z:12.5mm..", "--clip", "plane(n=1,1,0 d=17.677669529663689mm)")
        places, triangles, _ = surface(name, "--cap")
        told = ok("isosurface", name, "-o", "open.ply", "--overwrite", "--json").json
        assert told["cut_planes"] == 2 and told["values"] == [0], told
        assert abs(volume(places, triangles) / (1000 * math.pi / 3) - 1) < 0.01, volume(places, triangles)
        assert places[:, 2].min() > 12.4999 and (places[:, 0] + places[:, 1]).min() > 24.999
        closed = ok("info", "out.ply", "--json").json
        assert closed["closed"] and closed["pieces"] == 1, closed
        assert not ok("info", "open.ply", "--json").json["closed"]
    says(ok("isosurface", "scene.vv.json", "-o", "open.ply", "--overwrite").text, "surface at 0, as in the scene, cut by 2 planes")


def test_a_scene_decides_the_solid_and_its_place():
    write_distance("ball.nrrd", 26, 10)
    ok("render", "ball.nrrd", "-o", "a.png", "--save-scene", "shell.vv.json", "--size", "32x32", "--threshold", "0,4",
       "--set", "volumes.ball.place.position=[100,0,0]", "--clip", "z:12.5mm..")
    places, triangles, _ = surface("shell.vv.json", "--cap")
    assert abs(volume(places, triangles) / ((1000 - 216) * math.pi * 2 / 3) - 1) < 0.01, volume(places, triangles)
    assert abs(places[:, 0].mean() - 112.5) < 0.1 and ok("info", "out.ply", "--json").json["closed"]
    says(ok("isosurface", "shell.vv.json", "-o", "a.ply").text, "surface at 0 to 4, as in the scene")
    other, _, _ = surface("shell.vv.json", "--iso", 2)
    assert abs(np.linalg.norm(other - [112.5, 12.5, 12.5], axis=1) - 8).max() < 0.05, "what is typed counts"
    for cut in "z:12.5mm..", "x:12.5mm..":
        ok("render", "ball.nrrd", "-o", "c.png", "--overwrite", "--size", "32x32", "--threshold", "0,4", "--method", "surface",
           "--clip", cut)
        places, triangles, _ = surface("c.png", "--cap")
        assert abs(volume(places, triangles) / ((1000 - 216) * math.pi * 2 / 3) - 1) < 0.01, "both ends are kept"
        assert ok("info", "out.ply", "--json").json["closed"]
    ok("render", "ball.nrrd", "-o", "b.png", "--save-scene", "cloud.vv.json", "--size", "32x32")
    says(ok("isosurface", "cloud.vv.json", "-o", "a.ply", "--overwrite").text, "since the scene shows a cloud")


def parts_of(path):
    return {part["name"]: [round(c, 2) for c in part["color"]] for part in ok("info", path, "--json").json["parts"]}


def test_parts_have_the_names_and_colours_of_labels():
    header = ('NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 20 14 14\nencoding: raw\n'
              'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n'
              'Segment0_ID:=a\nSegment0_Name:=left kidney\nSegment0_Color:=1 0 0\nSegment0_LabelValue:=7\nSegment0_Layer:=0\n'
              'Segment1_ID:=b\nSegment1_Name:=liver\nSegment1_Color:=0 1 0\nSegment1_LabelValue:=2\nSegment1_Layer:=0\n\n')
    def label(x, y, z):
        return (7 if x < 8 else 2 if x < 12 else 3) if math.dist((x, y, z), (9.5, 6.5, 6.5)) < 6 else 0
    with open("organs.seg.nrrd", "wb") as file:
        file.write(header.encode() + bytes(label(x, y, z) for z in range(14) for y in range(14) for x in range(20)))
    for suffix in "obj", "glb", "vtp", "ply":
        ok("isosurface", "organs.seg.nrrd", "-o", "all." + suffix)
        parts = parts_of("all." + suffix)
        named = list(parts) if suffix != "ply" else ["liver", "label 3", "left kidney"]
        assert sorted(named) == ["label 3", "left kidney", "liver"], (suffix, parts)
        colors = list(parts.values())
        assert [1, 0, 0, 1] in colors and [0, 1, 0, 1] in colors and len(colors) == 3, (suffix, parts)
    ok("isosurface", "organs.seg.nrrd", "-o", "one.glb", "--label", 7)
    assert parts_of("one.glb") == {"left kidney": [1, 0, 0, 1]}
    ok("render", "organs.seg.nrrd", "-o", "a.png", "--save-scene", "organs.vv.json", "--size", "32x32", "--set",
       'volumes.organs.segmentation.labels.table=[[2,0,1,0,0],[7,0,0,1,1]]', "--clip", "z:6.5mm..")
    ok("isosurface", "organs.vv.json", "-o", "seen.glb", "--cap")
    parts = parts_of("seen.glb")
    assert parts["left kidney"] == [0, 0, 1, 1] and "liver" not in parts and "label 3" in parts, parts
    assert ok("info", "seen.glb", "--json").json["closed"]


def test_what_is_wrong_is_said():
    write_ball("a.nrrd", 16)
    ok("isosurface", "a.nrrd", "-o", "a.ply")
    says(fails(2, "isosurface", "a.nrrd", "-o", "a.nrrd2"), "suffix")
    says(fails(2, "isosurface", "a.nrrd", "-o", "b.ply", "--component", 3), "channel 3")
    says(fails(2, "isosurface", "a.nrrd", "-o", "b.ply", "--iso", "high"), "--iso")
    says(fails(3, "simplify", "a.nrrd", "-o", "b.ply"), "mesh", "volvis isosurface a.nrrd")
    says(fails(3, "smooth", "a.nrrd", "-o", "b.ply"), "volvis isosurface a.nrrd")
    says(fails(3, "isosurface", "a.ply", "-o", "b.ply"), "a.ply", "simplify", "convert")
    says(fails(2, "isosurface", "a.nrrd", "-o", "-"), "--output-format")
    empty = volvis("isosurface", "a.nrrd", "-o", "b.ply", "--iso", 1000)
    assert empty.code == 0 and "warning: isosurface: the mesh is empty: the samples range from" in empty.message, empty.message
    assert "samples range from" in ok("isosurface", "a.nrrd", "-o", "b.ply", "--iso", -1, "--overwrite", "--json").json["warnings"][0]
    assert ok("isosurface", "a.nrrd", "-o", "b.ply", "--overwrite", "--json").json["warnings"] == []
    says(fails(2, "isosurface", "a.nrrd", "-o", "c.ply", "--iso", "60,180", "--pieces", 1), "one value")
    write_nrrd("flat.nrrd", (8, 8, 1), lambda x, y, z: 10 * x)
    flat = volvis("isosurface", "flat.nrrd", "-o", "flat.ply", "--iso", 35, "--cap")
    assert flat.code == 0 and "8 x 8 x 1 samples have no cells" in flat.message, flat.message
    told = ok("info", "flat.ply")
    assert "no: there is no triangle" in told.text and not ok("info", "flat.ply", "--json").json["closed"], told.text
    write_nrrd("same.nrrd", (8, 8, 8), lambda x, y, z: 7)
    assert "all samples have the value 7" in volvis("isosurface", "same.nrrd", "-o", "same.ply", "--iso", 7).message


def samples_of(path):
    """[z, y, x], by way of a conversion that other tests look at."""
    ok("convert", path, "-o", "same.npy", "--type", "f32", "--overwrite")
    samples = np.load("same.npy")
    return np.ascontiguousarray(samples if samples.flags["C_CONTIGUOUS"] else samples.T)


def vtk_contour(samples, value):
    """Places, in samples, and triangles of VTK's Flying Edges."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    image = vtk.vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(samples).ravel()))
    contour = vtk.vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, value)
    contour.ComputeNormalsOff()
    contour.Update()
    out = contour.GetOutput()
    return vtk_to_numpy(out.GetPoints().GetData()).astype("f8"), vtk_to_numpy(out.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def distance(places, others, triangles):
    """Of the farthest place from another surface: from its vertices, and where that is far, from its triangles."""
    import vtk
    from scipy.spatial import cKDTree
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    near = cKDTree(others, balanced_tree=False, compact_nodes=False).query(places, distance_upper_bound=0.1)[0]
    far = np.flatnonzero(near == np.inf)
    if len(far) == 0:
        return near.max()
    mesh, points, cells, locator = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkStaticCellLocator()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(others)))
    cells.SetData(3, numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles, "i8").ravel()))
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    at, cell, which, square = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
    for i in far:
        locator.FindClosestPoint(places[i], at, cell, which, square)
        near[i] = math.sqrt(square.get())
    return near.max()


def finer(samples, factor):
    """The same trilinear function at more places."""
    for axis in range(3):
        n = samples.shape[axis]
        x = np.arange((n - 1) * factor + 1) / factor
        i = np.minimum(x.astype(int), n - 2)
        t = (x - i).astype("f4").reshape([-1 if a == axis else 1 for a in range(3)])
        samples = np.take(samples, i, axis) * (1 - t) + np.take(samples, i + 1, axis) * t
    return samples


def crop(path, name, ranges):
    ok("crop", path, "-o", name, "--overwrite", "--x", ranges[0], "--y", ranges[1], "--z", ranges[2])


def errors_of_area(path, value, spacing):
    """Ours and VTK's, against the surface of the trilinear function, in the middle of a volume."""
    dims = ok("info", path, "--json").json["dims"]
    crop(path, "middle.nrrd", [f"{max(0, n // 2 - 32)}:{min(n, n // 2 + 33)}" for n in dims])
    samples, spacing = samples_of("middle.nrrd"), np.array(spacing)
    def area_at(factor):
        places, triangles = vtk_contour(finer(samples, factor), value)
        return area(places / factor * spacing, triangles)
    truth = (16 * area_at(4) - 4 * area_at(2)) / 12  # errors fall with the square
    ours = area(*surface("middle.nrrd", "--iso", repr(float(value)))[:2])
    return abs(ours / truth - 1), abs(area_at(1) / truth - 1)


def compare_with_vtk(path, value):
    info = ok("info", path, "--json").json
    theirs, others = vtk_contour(samples_of(path), value)
    axes = np.array(info["directions"], "f8") * np.array(info["spacing"], "f8")[:, None]
    theirs = theirs @ axes + np.array(info["origin"], "f8")
    voxel = min(info["spacing"])
    for topology, most in (("apart", 0.1), ("decided", 0.87)):  # VTK's choice; and elsewhere in the same cell
        ours, triangles, _ = surface(path, "--iso", value, "--topology", topology)
        far = max(distance(ours / voxel, theirs / voxel, others), distance(theirs / voxel, ours / voxel, triangles))
        difference = abs(area(ours, triangles) / area(theirs, others) - 1)
        print(f"     {os.path.basename(path)}, {topology}: {len(triangles)} triangles, area {difference:.1e}, {far:.3f} voxels")
        assert far < most, (path, topology, far)
    if difference > 0.001:  # noise and thin parts: faces with two meanings decide, and VTK does not ask the function
        mine, its = errors_of_area(path, value, info["spacing"])
        print(f"     {os.path.basename(path)}: area wrong by {mine:.2e}, VTK's by {its:.2e}")
        assert mine < 1.1 * its + 0.001, (path, mine, its)


def test_surfaces_of_real_data_are_those_of_vtk():
    try:
        import scipy
        import vtk
    except ImportError:
        raise Skip("VTK or scipy is missing")
    files = [(os.path.join(VOLUMES, name), value, box) for name, value, box in REAL]
    files = [file for file in files if os.path.exists(file[0])]
    if not files:
        raise Skip(f"no {VOLUMES}")
    for path, value, box in files:
        if box:
            name = os.path.splitext(os.path.basename(path))[0] + ".part.nrrd"
            crop(path, name, box)
            path = name
        compare_with_vtk(path, value)


main()
