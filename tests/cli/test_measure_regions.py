"""Regions that are drawn: boxes, ellipses, polygons and ellipsoids in frames of their own, against NumPy and formulas."""
import json
import numpy as np
from PIL import Image
from harness import Skip, fails, main, ok, says, volvis
from measure_inputs import near, noise, write

TYPES = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64")
TURNED = np.array([(0.62, 0.31, -0.1), (-0.4, 1.1, 0.3), (0.2, -0.5, 1.7)])
SHEARED = np.array([(0.8, 0, 0), (0.4, 1.0, 0), (-0.2, 0.3, 0.9)])
ORIGIN = np.array((-7.3, 4.1, 2.2))


def words(**region):
    given = []
    for name, value in region.items():
        for one in value if name == "vertex" else (value,):
            given += ["--" + name, one if isinstance(one, str) else ",".join(repr(float(v)) for v in np.atleast_1d(one))]
    return given


def places(shape, steps, origin):
    """The centres of samples [z, y, x], in the world."""
    z, y, x = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    return np.stack([x, y, z], -1) @ np.asarray(steps) + origin


def axes_of(normal, right):
    normal = np.array(normal) / np.linalg.norm(normal)
    right = np.array(right) - np.dot(right, normal) * normal
    right /= np.linalg.norm(right)
    return np.array((right, np.cross(normal, right), normal))


def winds_around(points, corners):
    """By the sum of the angles under which the sides are seen: another method than counting crossings."""
    total = np.zeros(points.shape[:-1])
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        u, v = a - points, b - points
        total += np.arctan2(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0], (u * v).sum(-1))
    return np.abs(total) > np.pi


def shoelace(corners):
    x, y = corners.T
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def inside(kind, local, half, corners=None):
    in_slab = np.abs(local[..., 2]) < half[2]
    if kind == "box":
        return (np.abs(local) < half).all(-1)
    if kind == "ellipse":
        return in_slab & (((local[..., :2] / half[:2]) ** 2).sum(-1) <= 1)
    if kind == "polygon":
        return in_slab & winds_around(local[..., :2], corners)
    return ((local / half) ** 2).sum(-1) <= 1


def exact(kind, size, corners=None):
    return {"box": 1, "ellipse": np.pi / 4, "ellipsoid": np.pi / 6}[kind] * np.prod(size) if kind != "polygon" else shoelace(corners) * size[2]


CORNERS = np.array([(-4.03, -3.1), (3.7, -4.2), (1.1, 0.37), (5.2, 4.4), (-3.3, 3.9)])


def region_of(kind, middle, axes, size):
    shared = {"region": kind, "space": "world", "normal": axes[2]}
    if kind == "polygon":
        return {**shared, "vertex": CORNERS @ axes[:2] + middle, "thickness": size[2]}
    return {**shared, "right": axes[0], "center": middle, "size": size}


def check(name, values, steps, kind):
    axes = axes_of((0.3, -0.2, 1), (1, 0.4, 0))
    size = np.array((9.3, 7.1, 4.7))
    centres = places(values.shape, steps, ORIGIN)
    middle = centres.reshape(-1, 3).mean(0) + (0.123, -0.071, 0.037)
    local = (centres - middle) @ axes.T
    there = inside(kind, local, size / 2, CORNERS)
    found = ok("measure", "statistics", name, *words(**region_of(kind, middle, axes, size)), "--json").json
    voxel = abs(np.linalg.det(steps))
    chosen = values[there].astype(np.float64)
    assert found["region_voxels"] == found["count"] == there.sum() > 30, (name, kind)
    near(found["mean"], chosen.mean(), 1e-9)
    near(found["deviation"], chosen.std(), 1e-9)
    assert (found["min"], found["max"]) == (chosen.min(), chosen.max())
    near(found["median"], np.median(chosen), 1e-9)
    near(found["region_volume"], there.sum() * voxel, 1e-9)
    near(found["region_volume_exact"], exact(kind, size, CORNERS), 1e-9)
    if kind != "ellipsoid":
        near(found["region_area_exact"], exact(kind, (*size[:2], 1), CORNERS), 1e-9)
    assert abs(found["region_volume"] / found["region_volume_exact"] - 1) < 0.15


def test_samples_are_those_whose_centres_are_inside_of_every_type():
    for i, kind in enumerate(TYPES):
        values = noise(kind)
        write("any.nrrd", values, spacing=(0.7, 0.9, 0.6), origin=ORIGIN)
        check("any.nrrd", values, np.diag((0.7, 0.9, 0.6)), ("box", "ellipse", "polygon", "ellipsoid")[i % 4])


def test_grids_may_be_turned_or_sheared():
    values = noise("int16", shape=(23, 27, 31))
    for name, steps in (("turned.nrrd", TURNED), ("sheared.nrrd", SHEARED)):
        write(name, values, steps=steps, origin=ORIGIN)
        for kind in ("box", "ellipse", "polygon", "ellipsoid"):
            check(name, values, steps, kind)


def test_one_slice_is_one_sample_of_each_row_across():
    values = noise("uint8", shape=(13, 17, 19))
    write("flat.nrrd", values, spacing=(0.5, 0.8, 2.5))
    y, x = np.mgrid[:17, :19]
    for depth in (6, 6.4):  # between two slices it is the nearer one
        there = ((x - 9) / 5) ** 2 + ((y - 8) / 4) ** 2 <= 1
        found = ok("measure", "statistics", "flat.nrrd", *words(region="ellipse", center=(9, 8, depth), size=(10, 8, 0)), "--json").json
        assert found["count"] == there.sum()
        near(found["mean"], values[6][there].mean(), 1e-12)
        near(found["region_area_exact"], np.pi * 5 * 4 * 0.5 * 0.8, 1e-12)
        near(found["region_volume_exact"], np.pi * 5 * 4 * 0.5 * 0.8 * 2.5, 1e-12)
    # a rectangle of whole steps: of two opposite sides the lower one is part of it
    found = ok("measure", "volume", "flat.nrrd", *words(region="rectangle", center=(9, 8, 6), size=(10, 8, 0)), "--json").json
    assert found["region_voxels"] == 80 and found["volume"] == found["region_volume_exact"] == 80
    world = words(region="polygon", space="world", vertex=[(2, 4, 15), (7, 4, 15), (7, 8, 15), (2, 8, 15)])
    found = ok("measure", "statistics", "flat.nrrd", *world, "--json").json
    assert found["count"] == 50 and found["mean"] == values[6, 5:10, 4:14].mean()
    near(found["region_volume_exact"], 50, 1e-12)


def test_counted_volumes_of_ellipsoids_converge():
    size = np.array((9.7, 7.3, 8.9))
    off = []
    for n in (12, 24, 48, 96):
        write("fine.nrrd", np.zeros((n, n, n), np.uint8), spacing=(12 / n,) * 3, origin=(-6 + 6 / n,) * 3)
        found = ok("measure", "volume", "fine.nrrd", *words(region="ellipsoid", space="world", center=(0.013, 0.027, 0.041), size=size, normal=(1, 2, 3)), "--json").json
        near(found["region_volume_exact"], np.pi / 6 * np.prod(size), 1e-12)
        off.append(abs(found["volume"] - found["region_volume_exact"]))
        assert off[-1] <= found["volume_error"]
    assert off[-1] < off[0] / 8 and off[-1] < 1e-3 * found["region_volume_exact"], off


def test_an_object_in_a_region_is_what_both_have():
    values = noise("int16", shape=(21, 25, 27))
    write("any.nrrd", values, spacing=(1, 1, 1))
    local = places(values.shape, np.eye(3), np.zeros(3)) - (12.2, 11.3, 9.7)
    there = inside("ellipsoid", local, np.array((8, 7, 6.0)))
    asked = words(region="ellipsoid", center=(12.2, 11.3, 9.7), size=(16, 14, 12))
    bright = there & (values >= 100)
    found = ok("measure", "volume", "any.nrrd", "--iso", "100", *asked, "--json").json
    assert found["volume"] == bright.sum() and found["method"] == "count"
    found = ok("measure", "statistics", "any.nrrd", "--iso", "100", *asked, "--json").json
    assert found["count"] == bright.sum() and abs(found["mean"] - values[bright].mean()) < 1e-9
    half = there & (np.arange(21) >= 10)[:, None, None]
    found = ok("measure", "histogram", "any.nrrd", *asked, "--box", "..,..,10..20", "--bins", "16", "--range", "-3000,3000", "--json").json
    assert sum(found["histogram"]["counts"]) == half.sum()
    counts = found["histogram"]
    assert counts["counts"] == list(np.histogram(values[half], 16, (-3000, 3000))[0])
    joint = ok("measure", "joint", "any.nrrd", *asked, "--json").json
    assert sum(map(sum, joint["joint"]["counts"])) + joint["joint"]["beyond"] == there.sum()


def test_what_makes_no_region_is_told():
    write("any.nrrd", noise("uint8"))
    of = ("measure", "statistics", "any.nrrd")
    says(fails(2, *of, "--region", "ellipse"), "--region ellipse needs --center X,Y,Z and --size X,Y,Z")
    says(fails(2, *of, "--region", "box", "--center", "1,2,3"), "--region box needs --size X,Y,Z")
    says(fails(2, *of, "--center", "1,2,3"), "--center does nothing with --region none")
    says(fails(2, *of, "--region", "polygon", "--size", "1,2,3"), "--size does nothing with --region polygon")
    says(fails(2, *of, "--region", "polygon", "--vertex", "1,2,3"), "three times or more; there are 1")
    says(fails(2, *of, "--region", "polygon", *words(vertex=[(1, 1, 1), (2, 2, 2), (3, 3, 3)])), "the corners lie on one line")
    says(fails(2, *of, "--region", "ellipsoid", "--center", "1,2,3", "--size", "4,4,0"), "expected three extents above 0, found 4,4,0")
    says(fails(2, *of, "--region", "box", "--center", "1,2,3", "--size", "4,4,4", "--normal", "0,0,0"), "a direction is needed")
    says(fails(2, *of, "--region", "box", "--center", "1,2,3", "--size", "4,4,4", "--right", "0,0,2"), "it must lie in the plane")
    says(fails(2, "measure", "volume", "any.nrrd", "--method", "cubes", "--region", "sphere", "--center", "9,9,9", "--size", "4,4,4"), "voxels are counted in a region")
    says(fails(2, "measure", "profile", "any.nrrd", "--point", "1,2,3", "--point", "4,5,6", "--region", "sphere", "--center", "9,9,9", "--size", "4,4,4"), "no effect on the profile")
    says(ok(*of, "--region", "sphere", "--center", "500,9,9", "--size", "4,4,4").message, "no voxel has its centre in the region")
    bow = words(region="polygon", vertex=[(2, 2, 4), (12, 12, 4), (12, 2, 4), (2, 12, 4)])
    crossed = ok(*of, *bow, "--normal", "0,0,1", "--json")
    assert crossed.json["region_area_exact"] is None and crossed.json["region_voxels"] > 40
    says(crossed.message, "the polygon crosses itself")


def test_a_range_may_say_that_it_has_no_limit():
    write("any.nrrd", noise("int16"))
    for said, meant in (("100..inf", "100.."), ("-inf..20", "..20")):
        assert ok("measure", "volume", "any.nrrd", "--threshold", said).text == ok("measure", "volume", "any.nrrd", "--threshold", meant).text
    for nothing in ("-inf..inf", "inf..5", "5..-inf"):
        says(fails(2, "measure", "volume", "any.nrrd", "--threshold", nothing), f"expected LO..HI, as in 90..300, 90.. or 90, found '{nothing}'")


def test_scenes_keep_them_and_pictures_show_them():
    write("any.nrrd", noise("uint8", shape=(23, 25, 27)))
    asked = words(region="polygon", vertex=[(4, 4, 11), (20, 6, 11), (12, 20, 11)])
    given = ok("measure", "statistics", "any.nrrd", *asked, "--store", "kept.vv.json:mine", "--json").json
    with open("kept.vv.json", encoding="utf-8") as file:
        kept = json.load(file)["measurements"]["mine"]
    assert kept["region"] == {"kind": "polygon", "outline": [[4, 4, 11], [20, 6, 11], [12, 20, 11]]}
    again = ok("measure", "stored", "kept.vv.json", "--json").json
    assert again["n_changed"] == 0 and again["measurements"][0]["region_voxels"] == given["region_voxels"]
    # another kind, whose numbers stand beside those of the polygon; and back
    edit = ("--set", "measurements.mine.region.kind=ellipse", "--set", "measurements.mine.region.center=12,12,11", "--set", "measurements.mine.region.size=8,8,0")
    changed = volvis("measure", "stored", "kept.vv.json", *edit, "--json")
    assert changed.code == 6
    other = changed.json
    assert other["measurements"][0]["region_voxels"] == (np.hypot(*np.mgrid[-4:5, -4:5]) <= 4).sum()
    hidden = ("--set", "measurements.mine.visible=false")
    for depth, least, most in ((11, 60, 2000), (13, 0, 0)):
        seen = []
        for name, words_of in (("plain.png", hidden), ("drawn.png", ())):
            ok("render", "kept.vv.json", "--slice", "axial", "--cross-hair", f"12,12,{depth}", "--size", "96x96", *words_of, "-o", name)
            seen.append(np.array(Image.open(name).convert("RGB"), int))
        n = (np.abs(seen[1] - seen[0]).max(-1) > 40).sum()
        assert least <= n <= most, (depth, n)


def write_ball(name, radius, n=60):
    """Triangles of a sphere; its corners."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, n + 1)[1:-1], np.linspace(0, 2 * np.pi, 2 * n, endpoint=False), indexing="ij")
    rings = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    corners = (radius * np.concatenate([[(0, 0, 1)], rings, [(0, 0, -1)]])).astype(np.float32).astype(float)
    m, last = 2 * n, len(corners) - 1
    faces = []
    for i in range(m):
        j = (i + 1) % m
        faces += [(0, 1 + i, 1 + j), (last, 1 + (n - 2) * m + j, 1 + (n - 2) * m + i)]
        for r in range(n - 2):
            a, b = 1 + r * m + i, 1 + r * m + j
            faces += [(a, a + m, b), (b, a + m, b + m)]
    with open(name, "w") as file:
        file.write("".join("v %.9g %.9g %.9g\n" % tuple(p) for p in corners) + "".join("f %d %d %d\n" % tuple(k + 1 for k in f) for f in faces))
    return corners


def clipped(corners, middle, axes, half):
    """Volume of a convex body within a box, and the area of the body's own surface there: by half-spaces."""
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    offsets = axes @ middle
    sides = np.concatenate([np.c_[axes, -offsets - half], np.c_[-axes, offsets - half]])
    inside = HalfspaceIntersection(np.concatenate([ConvexHull(corners).equations, sides]), middle * 0.7)
    hull = ConvexHull(inside.intersections)
    own = 0
    for triangle, plane in zip(hull.points[hull.simplices], hull.equations):
        if np.abs(sides - plane).max(1).min() > 1e-6:
            own += np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])) / 2
    return hull.volume, own


def test_of_meshes_boxes_are_cut_out():
    try:
        import scipy.spatial  # noqa: F401
    except ImportError:
        raise Skip("SciPy is not there") from None
    corners = write_ball("ball.obj", 10)
    for normal, right, middle, size in (((0, 0, 1), (1, 0, 0), (0, 0, 7.5), (40, 40, 5)), ((1, 1, 2), (1, -0.3, 0), (3, 2, 4), (9, 8, 7)), ((0.3, -1, 0.2), (1, 0, 0.5), (-4, 5, 1), (30, 6, 12))):
        axes, middle, size = axes_of(normal, right), np.array(middle, float), np.array(size, float)
        region = words(region="box", center=middle, size=size, normal=axes[2], right=axes[0])
        volume, area = clipped(corners, middle, axes, size / 2)
        found = ok("measure", "ball.obj", *region, "--json").json
        assert abs(found["volume"] - volume) <= found["volume_error"] < 1e-4 * volume and found["closed"], (found["volume"], volume)
        assert abs(found["area"] - area) <= found["area_error"] + 1e-6 * area < 1e-3 * area, (found["area"], area)
        near(found["region_volume_exact"], np.prod(size), 1e-12)
    ok("render", "ball.obj", "-o", "m.png", "--size", "16x16", "--save-scene", "m.vv.json")
    place = ("--set", "volumes.ball.place.scale=2,2,2", "--set", "volumes.ball.place.position=5,6,7")
    near(ok("measure", "volume", "m.vv.json", *place, *words(region="box", center=2 * middle + (5, 6, 7), size=2 * size, normal=axes[2], right=axes[0]), "--json").json["volume"], 8 * volume, 1e-5)
    ok("measure", "volume", "ball.obj", *region, "--store", "s.vv.json")
    says(ok("measure", "s.vv.json").text, "as before")
    missed = words(region="box", center=(90, 0, 0), size=(1, 1, 1))
    assert ok("measure", "area", "ball.obj", *missed, "--json").json["area"] == 0
    for path in ("ball.obj", "m.vv.json"):
        says(ok("measure", path, *missed).message, "nothing of the mesh lies in the region: the object is empty")
    assert "closed" not in ok("measure", "ball.obj", *missed).text
    assert "empty" not in ok("measure", "ball.obj", *region).message


def test_that_an_open_mesh_stays_open_is_said_once():
    write_ball("ball.obj", 10, n=8)
    with open("ball.obj", encoding="ascii") as file:
        lines = file.readlines()
    faces = [i for i, line in enumerate(lines) if line.startswith("f ")]
    with open("open.obj", "w", encoding="ascii") as file:
        file.writelines(line for i, line in enumerate(lines) if i not in faces[len(faces) // 2 - 9:len(faces) // 2 + 9])
    region = words(region="box", center=(0, 0, 0), size=(30, 3, 3))
    refused = volvis("measure", "volume", "open.obj", *region)
    said = refused.message
    assert refused.code == 2
    says(said, "it stays open there, at", "the mesh is open", "ask for its area only")
    assert said.count("stays open") == 1 and "--cap" not in said and "1 places" not in said, said


def write_mesh(name, corners, faces):
    with open(name, "w", encoding="ascii") as file:
        file.write("".join("v %.9g %.9g %.9g\n" % tuple(p) for p in corners) + "".join("f %d %d %d\n" % tuple(k + 1 for k in f) for f in faces))


def write_block(name, half):
    """A block around the origin."""
    corners = [[h * (1 if i >> a & 1 else -1) for a, h in enumerate(half)] for i in range(8)]
    write_mesh(name, corners, [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)])


def test_of_meshes_ellipsoids_have_a_closed_form():
    def measured(path, center, size, *more):
        found = ok("measure", path, *words(region="ellipsoid", center=center, size=size, **dict(more)), "--json").json
        return found["area"], found["volume"], found

    write_block("block.obj", (5, 5, 5))
    third = 4 * np.pi / 3
    for center, size, area, volume in (((0, 0, 0), (4, 4, 4), 0, third * 8),                     # all of it inside: no triangle is met
                                       ((0, 0, 0), (40, 40, 40), 600, 1000),                     # all of the block
                                       ((5, 0, 0), (4, 4, 4), 4 * np.pi, third * 4),             # its middle on a face
                                       ((5, 5, 0), (4, 4, 4), 2 * 2 * np.pi, third * 2),         # on an edge
                                       ((5, 5, 5), (4, 4, 4), 3 * np.pi, third),                 # on a corner
                                       ((4, 0, 0), (4, 4, 4), 3 * np.pi, third * 8 - np.pi * 5 / 3),  # a cap 1 high cut off
                                       ((6.5, 0, 0), (4, 4, 4), np.pi * 1.75, np.pi * 0.25 * 5.5 / 3),
                                       ((5, 0, 0), (4, 6, 8), np.pi * 12, third * 12),
                                       ((20, 0, 0), (4, 4, 4), 0, 0)):
        found = measured("block.obj", center, size)
        assert abs(found[0] - area) < 1e-9 * (1 + area) and abs(found[1] - volume) < 1e-9 * (1 + volume), (center, size, found[:2], area, volume)
    assert measured("block.obj", (0, 0, 0), (4, 4, 4))[2]["triangles"] == 0
    cut = [line for line in open("block.obj", encoding="ascii") if line != "f 2 4 6\n"]                 # open on the side of +x
    with open("open.obj", "w", encoding="ascii") as file:
        file.writelines(cut)
    refused = volvis("measure", "volume", "open.obj", *words(region="ellipsoid", center=(5, 0, 0), size=(4, 4, 4)))
    assert refused.code == 2 and "the mesh is open" in refused.message, refused.message
    random = np.random.default_rng(5)                                                            # anywhere, turned: by counting places
    axes = axes_of((1, 1, 2), (1, -0.3, 0))
    middle, half = np.array((3, 2, -4)), np.array((4, 6, 3))
    places = random.uniform(-1, 1, (2000000, 3))
    places = places[(places**2).sum(1) <= 1]
    want = (np.abs(middle + (places * half) @ axes) <= 5).all(1).mean() * third * np.prod(half)
    _, volume, found = measured("block.obj", middle, 2 * half, ("normal", axes[2]), ("right", axes[0]))
    assert abs(volume - want) < 3e-3 * want and found["closed"], (volume, want)
    write_ball("ball.obj", 10, n=200)                                                            # two balls: a lens
    d, r, q = 9, 10, 5
    lens = np.pi * (r + q - d)**2 * (d * d + 2 * d * (r + q) - 3 * (r - q)**2) / (12 * d)
    near(measured("ball.obj", (0, 0, d), (2 * q,) * 3)[1], lens, 1e-3)
    near(measured("ball.obj", (0, 0, d), (2 * q,) * 3)[0], 2 * np.pi * r * (r - (d * d + r * r - q * q) / (2 * d)), 1e-3)
    ok("render", "block.obj", "-o", "m.png", "--size", "16x16", "--save-scene", "m.vv.json")
    for scale in ((2, 2, 2), (-2, 2, 2)):
        place = ("--set", "volumes.block.place.scale=%g,%g,%g" % scale)
        near(ok("measure", "volume", "m.vv.json", *place, *words(region="ellipsoid", center=(10 * np.sign(scale[0]), 0, 0), size=(4, 4, 4)), "--json").json["volume"], third * 4, 1e-9)
    says(ok("measure", "block.obj", *words(region="ellipsoid", center=(0, 0, 0), size=(4, 4, 4))).message, "box and centroid are not measured")
    ok("measure", "area", "m.vv.json", *words(region="ellipsoid", center=(5, 0, 0), size=(8, 8, 8)), "--store", "m.vv.json:ball")
    seen = []
    for name, hidden in (("plain.png", ("--set", "measurements.ball.visible=false")), ("drawn.png", ())):                # and it is drawn
        ok("render", "m.vv.json", "--size", "96x96", *hidden, "-o", name)
        seen.append(np.array(Image.open(name).convert("RGB"), int))
    assert 60 <= (np.abs(seen[1] - seen[0]).max(-1) > 40).sum() <= 2500
    says(fails(2, "measure", "box", "block.obj", *words(region="ellipsoid", center=(0, 0, 0), size=(4, 4, 4))), "in a box or a convex polygon")
    says(fails(2, "measure", "area", "m.vv.json", "--closed", *words(region="ellipsoid", center=(0, 0, 0), size=(4, 4, 4))), "--closed")


def test_of_meshes_polygons_are_cut_out_dents_and_all():
    write_block("block.obj", (5, 5, 5))
    dented = ((-4, -4, 0), (4, -4, 0), (4, 4, 0), (1, 4, 0), (1, -2, 0), (-1, -2, 0), (-1, 4, 0), (-4, 4, 0))  # a U
    convex = ((-4, -4, 0), (4, -4, 0), (8, 2, 0), (4, 8, 0))
    for corners, thickness, area, volume in ((dented, 4, 0, 52 * 4), (dented, 12, 104, 520), (convex, 12, None, None)):
        for turned in (corners, corners[::-1], corners[3:] + corners[:3]):
            found = ok("measure", "block.obj", *sum((("--vertex", "%g,%g,%g" % p) for p in turned), ()), "--region", "polygon", "--thickness", str(thickness), "--json").json
            if corners is convex:
                x, y = np.array([(-4, -4), (4, -4), (5, -2.5), (5, 5), (2, 5)]).T  # what of it is in the block
                base = abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
                area, volume = 2 * base + 10 * (7.5 + 3), 10 * base
                assert np.abs(np.array(found["box_hi"]) - 5).max() < 1e-6, found["box_hi"]
            assert abs(found["area"] - area) < 1e-5 * (1 + area) and abs(found["volume"] - volume) < 1e-5 * volume, (corners, found["area"], area, found["volume"], volume)
    crossed = sum((("--vertex", "%g,%g,0" % p) for p in ((0, 0), (2, 2), (2, 0), (0, 3))), ())
    says(fails(2, "measure", "area", "block.obj", "--region", "polygon", *crossed, "--thickness", "1"), "crosses itself")
    says(fails(2, "measure", "area", "block.obj", "--region", "polygon", *crossed[:6]), "--thickness", "no slices")


def test_of_meshes_other_regions_are_refused_in_a_sentence():
    write_ball("ball.obj", 10, n=8)
    says(fails(2, "measure", "area", "ball.obj", *words(region="ellipse", center=(0, 0, 0), size=(1, 1, 1))), "a box, a polygon or an ellipsoid")
    says(fails(2, "measure", "area", "ball.obj", *words(region="box", center=(0, 0, 0), size=(1, 1, 0))), "no slices")
    says(fails(2, "measure", "area", "ball.obj", *words(region="box", center=(0, 0, 0), size=(1, 1, 1), space="index")), "--space has no effect")


main()
