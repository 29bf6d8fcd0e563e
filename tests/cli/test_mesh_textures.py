"""Images on the triangles of meshes: read from OBJ, PLY and glTF, drawn by triangles and by rays, written back; against
formulas, and against what VTK reads."""
import base64
import io
import json
import math
import os
import struct
import numpy
from PIL import Image
from harness import Skip, fails, main, ok, says

LOOK = ["--no-shading", "--background", "black", "--size", "151x151"]
BOTH = ("surface", "raycast")


def smooth_image(width=37, height=23):
    """Each channel another wave: no two places are alike."""
    y, x = numpy.mgrid[0:height, 0:width]
    return numpy.stack([x * 255 // (width - 1), y * 255 // (height - 1), 128 + 100 * numpy.sin(x / 3 + y / 2)], axis=2).astype(numpy.uint8)


def save(name, pixels):
    Image.fromarray(pixels).save(name)


def quad(name="q", image="tex.png", options="", kd="1 1 1", clamp="-clamp on ", corners=((0, 0), (1, 0), (1, 1), (0, 1))):
    """A unit square with an image on it."""
    with open(f"{name}.mtl", "w") as file:
        file.write(f"newmtl it\nKd {kd}\nmap_Kd {clamp}{image}\n{options}")
    with open(f"{name}.obj", "w") as file:
        file.write(f"# up: z\nmtllib {name}.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n")
        file.writelines(f"vt {u} {v}\n" for u, v in corners)
        file.write("usemtl it\nf 1/1 2/2 3/3 4/4\n")
    return f"{name}.obj"


def picture(*words, name="out.png"):
    ok("render", *words, *LOOK, "-o", name, "--overwrite")
    return numpy.asarray(Image.open(name).convert("RGB")).astype(int)


def decode(pixels):
    v = numpy.asarray(pixels) / 255
    return numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def encode(light):
    return 255 * numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * numpy.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def bilinear(pixels, u, v):
    """Clamped; (0, 0) is the lower left corner; linear light."""
    h, w = pixels.shape[:2]
    x, y = u * w - 0.5, (1 - v) * h - 0.5
    i, j = math.floor(x), math.floor(y)
    at = lambda a, b: decode(pixels[min(max(b, 0), h - 1), min(max(a, 0), w - 1)])
    fx, fy = x - i, y - j
    return (at(i, j) * (1 - fx) + at(i + 1, j) * fx) * (1 - fy) + (at(i, j + 1) * (1 - fx) + at(i + 1, j + 1) * fx) * fy


def test_a_slanted_square_has_the_colour_of_the_texel_at_each_place():
    pixels = smooth_image()
    save("tex.png", pixels)
    quad()
    for look in (["--view", "30,35", "--fov", "60deg"], ["--view", "-20,50", "--parallel", "1.3"]):
        for method in BOTH:
            seen = picture("q.obj", "--method", method, "--spp", 1, *look)
            wanted = [f"--pixel={x},{y}" for x in range(35, 120, 12) for y in range(51, 105, 9)]
            hits = ok("pick", "q.obj", "--method", method, *look, "--size", "151x151", *wanted, "--json").json["pixels"]
            assert sum(p["hit"] for p in hits) >= 15, sum(p["hit"] for p in hits)
            for p in hits:
                if p["hit"]:
                    want = encode(bilinear(pixels, *p["world"][:2]))
                    assert abs(seen[p["y"], p["x"]] - want).max() <= 1.5, (method, look, p, seen[p["y"], p["x"]], want)


def test_triangles_and_rays_give_the_same_colours():
    save("tex.png", smooth_image(301, 177))
    quad(corners=((0, 0), (5, 0), (5, 7), (0, 7)), clamp="")
    for look in (["--view", "30,15"], ["--view", "10,70", "--fov", "80deg"], ["--view", "40,8", "--parallel", "1.1"]):
        a, b = (picture("q.obj", "--method", method, "--spp", 1, *look) for method in BOTH)
        inside = (a.max(axis=2) > 0) & (b.max(axis=2) > 0)
        away = abs(a - b).max(axis=2)[inside]
        assert (away > 2).mean() < 0.01, (look, (away > 2).mean(), away.max())


def test_what_is_finer_than_pixels_becomes_its_mean():
    n = 255
    y, x = numpy.mgrid[0:n, 0:n]
    save("tex.png", numpy.repeat(((x + y) % 2 * 255).astype(numpy.uint8)[..., None], 3, axis=2))
    quad(corners=((0, 0), (3, 0), (3, 3), (0, 3)), clamp="")
    for method in BOTH:
        for look in (["--view", "top", "--parallel", "1.2"], ["--view", "20,10", "--fov", "50deg"]):
            seen = picture("q.obj", "--method", method, "--spp", 1, *look)[..., 0]
            rows, columns = numpy.nonzero(seen)
            middle = seen[(seen > 0) & (abs(numpy.indices(seen.shape)[1] - columns.mean()) < 20)]
            inner = numpy.sort(middle)[len(middle) // 20:]
            assert abs(numpy.median(inner) - 188) <= 3, (method, look, numpy.median(inner))
            assert inner.std() < 6, (method, look, inner.std())


def test_slanted_squares_keep_what_is_seen_across_them():
    """Stripes that run away from the eye are seen where the lengths of a pixel differ ten times."""
    n = 256
    x = numpy.mgrid[0:n, 0:n][1]
    save("tex.png", numpy.repeat((x // 16 % 2 * 255).astype(numpy.uint8)[..., None], 3, axis=2))
    quad()
    for method in BOTH:
        seen = picture("q.obj", "--method", method, "--spp", 1, "--view", "0,7", "--parallel", "1.05")
        row = seen[75, :, 0]
        assert row.max() > 240 and row[8:-8].min() < 15, (method, row)


def test_factors_and_colours_are_multiplied():
    save("tex.png", numpy.full((3, 3, 3), 188, numpy.uint8))
    quad(kd="0.5 1 0")
    at = picture("q.obj", "--view", "top")[75, 75]
    assert abs(at - encode(decode([188, 188, 188]) * decode([128, 255, 0]))).max() <= 1, at
    quad(kd="0 0 0")  # some programs write that beside an image
    assert (picture("q.obj", "--view", "top")[75, 75] == 188).all()
    assert tuple(picture("q.obj", "--view", "top", "--set", "volumes.q.color=#102030")[75, 75]) == (16, 32, 48)
    with open("v.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\ncomment TextureFile tex.png\ncomment up: z\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float u\nproperty float v\nelement face 1\n"
                   "property list uchar int vertex_indices\nend_header\n")
        file.write("0 0 0 255 128 0 0 0\n1 0 0 255 128 0 1 0\n0 1 0 255 128 0 0 1\n3 0 1 2\n")
    seen = picture("v.ply", "--view", "top")
    at = seen[seen[..., 0] == seen[..., 0].max()]
    assert abs(numpy.median(at, axis=0) - encode(decode([188, 188, 188]) * decode([255, 128, 0]))).max() <= 1, at


def glb(name, image, material, accessor_uv=((0, 1), (1, 1), (1, 0), (0, 0)), factor=None, mime="image/png", uri=None, extra=None, colors=None):
    """A unit square in the plane of x and y (z up there), with an image inside."""
    def pad(data):
        return data + bytes(-len(data) % 4)
    places = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 1, 0, -1, 0, 0, -1)
    uv = struct.pack("<8f", *(c for p in accessor_uv for c in p))
    index = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    chunks = [places, uv, index] + ([struct.pack("<12f", *colors)] if colors else []) + ([image] if image else [])
    views, data = [], b""
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)})
        data += pad(chunk)
    pbr = {"baseColorTexture": {"index": 0}, **(extra or {})}
    if extra and "extensions" in extra:
        pbr = {"baseColorTexture": {"index": 0, **extra}}
    if not image and not uri:
        del pbr["baseColorTexture"]
    if factor:
        pbr["baseColorFactor"] = factor
    root = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, **({"COLOR_0": 3} if colors else {})}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": pbr, **material}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": uri} if uri else {"bufferView": len(chunks) - 1, "mimeType": mime}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, -1], "max": [1, 0, 0]},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
                      *([{"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"}] if colors else [])],
        "bufferViews": views, "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    with open(name, "wb") as file:
        file.write(struct.pack("<III", 0x46546C67, 2, 20 + len(text) + 8 + len(data)))
        file.write(struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data)
    return name


def encoded(pixels, kind="PNG", **words):
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, kind, **words)
    return out.getvalue()


def test_gltf_has_its_image_inside_as_text_or_beside_it():
    pixels = smooth_image()
    save("tex.png", pixels)
    quad()
    want = picture("q.obj", "--view", "top", "--spp", 1, "--parallel", "1.1")
    save("my tex.png", pixels)
    for uri in (None, "my%20tex.png", "data:image/png;base64," + base64.b64encode(encoded(pixels)).decode()):
        glb("a.glb", None if uri else encoded(pixels), {}, uri=uri)
        seen = picture("a.glb", "--view", "top", "--spp", 1, "--parallel", "1.1")
        assert abs(seen - want).max() <= 1, (uri, abs(seen - want).max())
    glb("j.glb", encoded(pixels, "JPEG", quality=98, subsampling=0), {}, mime="image/jpeg")
    assert abs(picture("j.glb", "--view", "top", "--spp", 1, "--parallel", "1.1") - want).mean() < 3
    grey = numpy.full((3, 3, 3), 188, numpy.uint8)
    glb("f.glb", encoded(grey), {}, factor=[0.5, 1, 0, 1], colors=[1, 0.5, 1] * 4)
    assert abs(picture("f.glb", "--view", "top")[75, 75] - encode(decode([188] * 3) * [0.5, 0.5, 0])).max() <= 1


def test_gltf_says_what_alpha_means_and_where_images_are_moved():
    pixels = numpy.zeros((16, 16, 4), numpy.uint8)
    pixels[..., 0] = 255
    pixels[:, :8, 3], pixels[:, 8:, 3] = 90, 200
    for mode, left, right in (({}, 255, 255), ({"alphaMode": "MASK"}, 0, 255), ({"alphaMode": "MASK", "alphaCutoff": 0.2}, 255, 255),
                              ({"alphaMode": "BLEND"}, encode(numpy.array(90 / 255)), encode(numpy.array(200 / 255)))):
        glb("a.glb", encoded(pixels), mode)
        for method in BOTH:
            seen = picture("a.glb", "--method", method, "--view", "top", "--parallel", "1.1")[75, :, 0]
            assert abs(seen[40] - left) <= 2 and abs(seen[110] - right) <= 2, (mode, method, seen[40], seen[110])
    quarters = numpy.zeros((16, 16, 3), numpy.uint8)
    quarters[:8, :8], quarters[:8, 8:], quarters[8:, :8] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    moved = {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [0.5, 0.5]}}}
    glb("m.glb", encoded(quarters), {}, extra=moved)
    assert tuple(picture("m.glb", "--view", "top", "--parallel", "1.1")[75, 75]) == (0, 255, 0), "the upper right quarter fills it"


def test_what_is_written_looks_as_what_was_read():
    save("tex.png", smooth_image())
    save("other.png", smooth_image()[::-1, ::-1].copy())
    with open("two.mtl", "w") as file:
        file.write("newmtl one\nKd 1 1 1\nmap_Kd tex.png\nnewmtl two\nKd 1 0.8 0.6\nmap_Kd other.png\nnewmtl plain\nKd 0 1 0\n")
    with open("two.obj", "w") as file:  # a box: each face of its own image and place on it, vertices shared
        file.write("# up: z\nmtllib two.mtl\n" + "".join(f"v {i % 2} {i // 2 % 2} {i // 4}\n" for i in range(8)))
        file.write("vt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\nvt 0.1 0.2\nvt 0.9 0.1\nvt 0.8 0.9\nvt 0.2 0.7\n")
        file.write("usemtl one\nf 1/1 2/2 6/3 5/4\nf 2/5 4/6 8/7 6/8\nusemtl two\nf 5/1 6/2 8/3 7/4\nf 3/5 1/6 5/7 7/8\n"
                   "usemtl plain\nf 1 3 4 2\nf 4 3 7 8\n")
    look = ["--view", "25,30", "--spp", 1]
    want = picture("two.obj", *look)
    assert len({tuple(p) for p in want.reshape(-1, 3)}) > 1000
    told = ok("info", "two.obj", "--json").json
    assert told["closed"] and told["textures"] == 2 and told["coordinates"], told
    last = "two.obj"
    for path, words in (("a.glb", []), ("b.ply", []), ("c.ply", ["--encoding", "ascii"]), ("d.gltf", []), ("e.gltf", ["--encoding", "separate"]),
                        ("f.ply", ["--encoding", "big-endian"]), ("g.obj", [])):
        ok("convert", last, "-o", path, *words)
        for method in BOTH:
            away = abs(picture(path, *look, "--method", method) - want).max(axis=2)
            assert (away > 2).mean() < 0.01, (path, method, (away > 2).mean())
        last = path
    ok("smooth", "two.obj", "-o", "smooth.obj", "--iterations", 2)
    assert ok("info", "smooth.obj", "--json").json["textures"] == 2
    quad(corners=((-1, -1), (2, -1), (2, 2), (-1, 2)))
    want = picture("q.obj", *look)
    for path in ("q.glb", "q2.obj"):
        ok("convert", "q.obj", "-o", path)
        assert (abs(picture(path, *look) - want).max(axis=2) > 2).mean() < 0.01, path
    says(ok("convert", "q.obj", "-o", "q.ply").message, "continued beyond its borders", "PLY", "repeats")
    told = ok("convert", "two.obj", "-o", "two.stl").message
    says(told, "images on triangles")


def test_vtk_reads_what_is_written():
    try:
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
    except ImportError:
        raise Skip("there is no VTK for Python")
    save("tex.png", smooth_image())
    quad()
    want = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]])

    def check(data, flip):
        places, uv = vtk_to_numpy(data.GetPoints().GetData()), vtk_to_numpy(data.GetPointData().GetTCoords())
        for p, t in zip(places, uv):
            assert abs(numpy.array([t[0], 1 - t[1] if flip else t[1]]) - p[[0, 1]]).max() < 1e-6 or flip, (p, t)
            if flip:
                assert abs(numpy.array([t[0], 1 - t[1]]) - [p[0], -p[2]]).max() < 1e-6, (p, t)
    for path, kind in (("a.obj", vtk.vtkOBJReader), ("a.ply", vtk.vtkPLYReader)):
        ok("convert", "q.obj", "-o", path)
        reader = kind()
        reader.SetFileName(path)
        reader.Update()
        assert reader.GetOutput().GetNumberOfPolys() == 2
        check(reader.GetOutput(), False)
    ok("convert", "q.obj", "-o", "a.glb", "--unit", "m", "--input-unit", "m")
    reader = vtk.vtkGLTFReader()
    reader.SetFileName("a.glb")
    reader.Update()
    assert reader.GetNumberOfTextures() == 1
    with open("a.glb", "rb") as file:
        data = file.read()
    n = struct.unpack("<I", data[12:16])[0]
    root = json.loads(data[20:20 + n])
    view = root["bufferViews"][root["images"][0]["bufferView"]]
    image = Image.open(io.BytesIO(data[28 + n + view["byteOffset"]:][:view["byteLength"]]))
    assert (numpy.asarray(image.convert("RGB")) == smooth_image()).all()
    found = []
    walk = reader.GetOutput().NewIterator()
    while not walk.IsDoneWithTraversal():
        found.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    assert len(found) == 1, found
    check(found[0], True)


def test_files_beside_are_found_in_the_folder_and_nowhere_else():
    pixels = smooth_image()
    os.makedirs("in/textures", exist_ok=True)
    save("outside.png", pixels)
    save("in/textures/t.png", pixels)
    save("in/t.png", pixels)
    for image, found in (("textures/t.png", True), ("textures\\t.png", True), ("C:\\work\\t.png", True), ("../outside.png", False),
                         (os.path.abspath("outside.png"), False), ("none.png", False), ("-s 1 1 1 -o 0 0 textures/t.png", True)):
        quad("in/a", image, clamp="")
        with open("in/a.obj") as file:
            text = file.read().replace("mtllib in/", "mtllib ")
        with open("in/a.obj", "w") as file:
            file.write(text)
        told = ok("info", "in/a.obj", "--json")
        assert (told.json["textures"] == 1) == found, (image, told.message)
        assert found or "left out" in told.message, (image, told.message)
    for uri in ("../outside.png", "file:///etc/passwd", "http://example.org/a.png"):
        glb("in/a.glb", None, {}, uri=uri)
        told = ok("info", "in/a.glb", "--json")
        assert told.json["textures"] == 0 and "left out" in told.message or "not a file" in told.message, told.message
    with open("in/a.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\ncomment TextureFile ../outside.png\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float s\n"
                   "property float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n")
    told = ok("info", "in/a.ply", "--json")
    assert told.json["textures"] == 0 and "left out" in told.message, told.message


def clear_image(n=16):
    """Red everywhere, and clear in its left half."""
    pixels = numpy.zeros((n, n, 4), numpy.uint8)
    pixels[..., 0] = 255
    pixels[:, n // 2:, 3] = 255
    return pixels


def test_what_is_clear_keeps_its_colour_where_alpha_does_not_count():
    save("clear.png", clear_image())
    Image.fromarray(clear_image()).save("clear.webp", lossless=True, exact=True)
    Image.fromarray(clear_image()).save("clear.tif")
    for image in ("clear.png", "clear.webp", "clear.tif"):
        quad(image=image)
        for method in BOTH:
            seen = picture("q.obj", "--method", method, "--view", "top", "--parallel", "1.1")
            assert tuple(seen[75, 40]) == tuple(seen[75, 110]) == (255, 0, 0), (image, method, seen[75, 40])
    with open("clear.png", "rb") as file:
        data = file.read()
    glb("a.glb", data, {})
    assert tuple(picture("a.glb", "--view", "top", "--parallel", "1.1")[75, 40]) == (255, 0, 0)
    glb("b.glb", data, {"alphaMode": "BLEND"})
    ok("convert", "b.glb", "-o", "c.glb")
    with open("c.glb", "rb") as file:
        written = file.read()
    n = struct.unpack("<I", written[12:16])[0]
    root = json.loads(written[20:20 + n])
    view = root["bufferViews"][root["images"][0]["bufferView"]]
    image = Image.open(io.BytesIO(written[28 + n + view["byteOffset"]:][:view["byteLength"]]))
    assert (numpy.asarray(image.convert("RGBA")) == clear_image()).all(), "what is written has colours where it is clear"


def test_the_edge_of_what_is_cut_out_has_no_rim():
    """Clear texels are black here; what is between them and the disc has the disc's colour all the same."""
    y, x = numpy.mgrid[0:64, 0:64]
    pixels = numpy.zeros((64, 64, 4), numpy.uint8)
    pixels[numpy.hypot(x - 31.5, y - 31.5) < 24] = (200, 200, 200, 255)
    save("disc.png", pixels)
    quad(image="disc.png", options="map_d disc.png\n")
    same = numpy.array([200, 200, 200])
    for method in BOTH:
        for spp in (1, 4):
            ok("render", "q.obj", "--no-shading", "--background", "#c8c8c8", "--size", "151x151", "--view", "25,40", "--method", method, "--spp", spp,
               "-o", "out.png", "--overwrite")
            seen = numpy.asarray(Image.open("out.png").convert("RGB")).astype(int)
            assert abs(seen - same).max() <= 1, (method, spp, abs(seen - same).max())


def test_gltf_alpha_of_factors_and_vertices_counts_as_the_material_says():
    pixels = numpy.full((4, 4, 4), 255, numpy.uint8)
    pixels[..., 3] = 150
    white = [1, 1, 1] * 4
    for image, colors in ((None, None), (None, white), (encoded(pixels), None)):
        alpha = 150 / 255 if image else 1
        for mode, seen in (({}, 255), ({"alphaMode": "MASK"}, 0), ({"alphaMode": "MASK", "alphaCutoff": 0.1}, 255),
                           ({"alphaMode": "MASK", "alphaCutoff": 0.25 if image else 0.31}, 0), ({"alphaMode": "BLEND"}, encode(numpy.array(0.3 * alpha)))):
            glb("a.glb", image, mode, factor=[1, 1, 1, 0.3], colors=colors)
            for method in BOTH:
                at = picture("a.glb", "--method", method, "--view", "top", "--parallel", "1.1")[75, 75, 0]
                assert abs(at - seen) <= 2, (bool(image), bool(colors), mode, method, at, seen)


def test_colours_of_vertices_that_one_looks_through_come_back_from_gltf():
    with open("v.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\ncomment up: z\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n")
        file.write("0 0 0 255 255 255 90\n1 0 0 255 255 255 90\n0 1 0 255 255 255 90\n3 0 1 2\n")
    ok("convert", "v.ply", "-o", "v.glb")
    want, seen = (picture(path, "--view", "top") for path in ("v.ply", "v.glb"))
    assert want.max() < 200 and abs(want - seen).max() <= 2, (want.max(), seen.max())


def test_gltf_images_that_are_not_there_are_left_out_with_their_place():
    save("tex.png", smooth_image())
    with open("tex.png", "rb") as file:
        data = file.read()
    glb("a.glb", data, {})
    with open("a.glb", "rb") as file:
        good = file.read()
    for old, new, about in ((b'"source": 0', b'"source": 7', "'source' is 7"), (b'"index": 0', b'"index": 7', "'index' is 7")):
        assert old in good, good[:1500]
        with open("a.glb", "wb") as file:
            file.write(good.replace(old, new))
        told = ok("render", "a.glb", *LOOK, "-o", "out.png", "--overwrite").message
        says(told, "a.glb", "material 0", "left out", about, "there are 1")


def test_places_on_images_that_are_not_there_are_told_with_their_line():
    save("tex.png", smooth_image())
    quad()
    with open("q.obj") as file:
        text = file.read()
    with open("q.obj", "w") as file:
        file.write(text.replace("f 1/1 2/2 3/3 4/4", "f 1/9 2/2 3/0 4/4"))
    says(ok("info", "q.obj").message, "q.obj", "line 12", "'1/9'", "4 came before it", "1 others")
    with open("q.obj", "w") as file:
        file.write(text.replace("f 1/1 2/2", "f 0/0 2/2"))
    says(fails(3, "info", "q.obj"), "q.obj:12", "vertex '0',", "counted from 1")


def test_an_image_outside_the_folder_is_said_to_be_there():
    os.makedirs("in", exist_ok=True)
    save("outside.png", smooth_image())
    quad("in/a", "../outside.png")
    with open("in/a.obj") as file:
        text = file.read().replace("mtllib in/", "mtllib ")
    with open("in/a.obj", "w") as file:
        file.write(text)
    says(ok("info", "in/a.obj").message, "../outside.png", "leads out of", "--allow-outside")
    assert ok("info", "in/a.obj", "--allow-outside", "--json").json["textures"] == 1


def test_images_that_are_none_are_left_out_with_a_sentence():
    save("tex.png", smooth_image())
    quad()
    with open("tex.png", "rb") as file:
        good = file.read()
    for bad in (b"", b"no image", good[:200], good[:60] + b"\xff" * 40 + good[100:]):
        with open("tex.png", "wb") as file:
            file.write(bad)
        told = ok("render", "q.obj", *LOOK, "-o", "out.png", "--overwrite")
        says(told.message, "tex.png", "left out")
        glb("a.glb", bad or b"\0", {})
        says(ok("info", "a.glb").message, "left out")
    glb("a.glb", good, {}, uri="data:image/png;base64,%%%")
    says(fails(3, "info", "a.glb"), "base64")


def test_the_import_program_hands_them_over():
    save("tex.png", smooth_image())
    quad()
    a, b = (picture("q.obj", "--view", "30,35", flag) for flag in ("--safe", "--no-safe"))
    assert (a == b).all() and a.max() > 100


main()
