"""TIFF, WebP and PDF pictures, checked by readers of others: Pillow, tifffile, zlib."""
import os
import re
import xml.etree.ElementTree as ElementTree
import zlib
import numpy
from harness import Skip, fails, main, ok, png_pixels, png_text, says, volvis, write_ball

SIZE = ["--size", "65x33"]


def has(name):
    return any(row["name"] == name and row["writes"] for row in ok("formats", "--json").json["images"])


def pfm(path):
    with open(path, "rb") as file:
        _, size, _, data = file.read().split(b"\n", 3)
    width, height = map(int, size.split())
    return numpy.frombuffer(data, "<f4").reshape(height, width, 3)[::-1]


def pillow():
    try:
        from PIL import Image
    except ImportError:
        raise Skip("no python3-pil") from None
    return Image


def pixels_of(path):
    with pillow().open(path) as image:
        return numpy.asarray(image)


def tifffile():
    try:
        import tifffile as module
    except ImportError:
        raise Skip("no python3-tifffile") from None
    return module


def filtered_rows(data, n_row, pixel):
    """Rows of PNG's filters, as PDF's predictor 15 has them."""
    rows, above = [], numpy.zeros(n_row, int)
    for at in range(0, len(data), n_row + 1):
        kind, line = data[at], list(data[at + 1:at + 1 + n_row])
        for i in range(n_row):
            a, b, c = line[i - pixel] if i >= pixel else 0, int(above[i]), int(above[i - pixel]) if i >= pixel else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + (0, a, b, (a + b) // 2, paeth)[kind]) % 256
        rows.append(line)
        above = numpy.array(line)
    return numpy.array(rows, numpy.uint8)


def pdf_objects(path):
    """By number: the dictionary's text and the stream's bytes; places are those that the table at the end says."""
    with open(path, "rb") as file:
        data = file.read()
    table = int(re.search(rb"startxref\n(\d+)\n%%EOF\n$", data)[1])
    found = {}
    for number, line in enumerate(re.findall(rb"(\d{10}) \d{5} n \n", data[table:]), 1):
        at = int(line)
        assert data[at:].startswith(b"%d 0 obj\n<<" % number), number
        head = data[at:data.index(b"endobj", at)].split(b"stream\n")[0]
        stream = None
        if b"stream\n" in data[at:data.index(b"endobj", at)]:
            start = at + len(head) + len(b"stream\n")
            stream = data[start:start + int(re.search(rb"/Length (\d+)", head)[1])]
            assert data[start + len(stream):].startswith(b"\nendstream")
        found[number] = (head.decode("latin-1"), stream)
    return found


def pdf_picture(path):
    """RGB, alpha or None, and the page's size in points."""
    image, mask, box = None, None, None
    for head, stream in pdf_objects(path).values():
        if "/Subtype /Image" in head:
            width, bits = (int(re.search(rf"/{key} (\d+)", head)[1]) for key in ("Width", "BitsPerComponent"))
            n = 1 if "/DeviceGray" in head else 3
            assert f"/Predictor 15 /Colors {n} " in head
            rows = filtered_rows(zlib.decompress(stream), width * n * bits // 8, n * bits // 8)
            samples = numpy.frombuffer(rows.tobytes(), ">u2" if bits == 16 else "u1").reshape(len(rows), width, n)
            image, mask = (image, samples[:, :, 0]) if n == 1 else (samples, mask)
        if "/MediaBox" in head:
            box = [float(v) for v in re.search(r"/MediaBox \[([^]]*)\]", head)[1].split()]
    return image, mask, box


def test_a_tiff_has_the_pixels_of_the_png():
    write_ball()
    for clear in ([], ["--background", "transparent"]):
        ok("render", "head.nrrd", "-o", "a.png", *SIZE, *clear)
        ok("render", "head.nrrd", "-o", "a.tif", *SIZE, *clear, "--dpi", "300")
        expected = pixels_of("a.png")
        assert expected.shape[2] == (4 if clear else 3)
        assert (pixels_of("a.tif") == expected).all()
        with pillow().open("a.tif") as image:
            assert image.mode == ("RGBA" if clear else "RGB") and image.info["dpi"] == (300, 300)
            assert image.tag_v2[305].startswith("VolVis ")
        assert (tifffile().imread("a.tif") == expected).all()
        ok("render", "head.nrrd", "-o", "wide.tif", *SIZE, *clear, "--bits", "16")
        ok("render", "head.nrrd", "-o", "wide.png", *SIZE, *clear, "--bits", "16")
        wide = tifffile().imread("wide.tif")
        assert wide.dtype == numpy.uint16 and abs(wide / 257 - expected).max() < 0.6
        ok("compare", "a.png", "a.tif", "--max-difference", "0")
        ok("compare", "wide.png", "wide.tif", "--max-difference", "0")


def test_a_tiff_of_floats_is_linear():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.pfm", *SIZE, "--background", "#203040")
    ok("render", "head.nrrd", "-o", "a.tif", *SIZE, "--background", "#203040", "--bits", "32")
    light = tifffile().imread("a.tif")
    assert light.dtype == numpy.float32 and (light == pfm("a.pfm")).all()
    ok("compare", "a.pfm", "a.tif", "--max-difference", "0")
    ok("render", "head.nrrd", "-o", "clear.tif", *SIZE, "--background", "transparent", "--bits", "32")
    ok("render", "head.nrrd", "-o", "clear.png", *SIZE, "--background", "transparent", "--bits", "16")
    with tifffile().TiffFile("clear.tif") as file:
        assert file.pages[0].extrasamples == (1,) and file.asarray().shape == (33, 65, 4)
    ok("compare", "clear.tif", "clear.png", "--psnr", "80")


def test_a_webp_loses_nothing_unless_asked():
    if not has("webp"):
        raise Skip("built without webp")
    write_ball()
    for clear in ([], ["--background", "transparent"]):
        ok("render", "head.nrrd", "-o", "a.png", *SIZE, *clear)
        ok("render", "head.nrrd", "-o", "a.webp", *SIZE, *clear)
        expected, found = pixels_of("a.png"), pixels_of("a.webp")
        seen = expected[:, :, -1:] > 0 if clear else True # what is under nothing may be anything
        assert found.shape == expected.shape and ((found == expected) | (~seen if clear else False)).all()
        ok("compare", "a.png", "a.webp", "--max-difference", "0")
    ok("render", "head.nrrd", "-o", "lossy.webp", *SIZE, "--image-quality", "20")
    ok("render", "head.nrrd", "-o", "a.png", *SIZE)
    difference = abs(pixels_of("lossy.webp").astype(int) - pixels_of("a.png"))
    assert 0 < difference.max() and difference.mean() < 8
    says(fails(2, "render", "head.nrrd", "-o", "b.webp", "--bits", "16"), "webp", "8 bits")


def test_sizes_beyond_a_format_are_refused_before_work_is_done():
    write_ball()
    if not has("webp"):
        raise Skip("built without webp")
    says(fails(2, "render", "head.nrrd", "-o", "big.webp", "--size", "16384x8", "--dry-run"), "16383", "16384 x 8", "PNG")
    ok("render", "head.nrrd", "-o", "big.webp", "--size", "16383x2", "--dry-run")
    assert not os.path.exists("big.webp")


def test_a_pdf_is_a_page_of_the_size_of_its_picture():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SIZE)
    ok("render", "head.nrrd", "-o", "a.pdf", *SIZE)
    picture, mask, box = pdf_picture("a.pdf")
    assert mask is None and (picture == pixels_of("a.png")).all()
    assert numpy.allclose(box, [0, 0, 65 * 72 / 300, 33 * 72 / 300])
    clear = ["--background", "transparent"]
    ok("render", "head.nrrd", "-o", "clear.png", *SIZE, *clear)
    ok("render", "head.nrrd", "-o", "clear.pdf", *SIZE, *clear, "--dpi", "72")
    picture, mask, box = pdf_picture("clear.pdf")
    expected = pixels_of("clear.png")
    assert (picture == expected[:, :, :3]).all() and (mask == expected[:, :, 3]).all() and box == [0, 0, 65, 33]
    ok("render", "head.nrrd", "-o", "wide.pdf", *SIZE, *clear, "--bits", "16")
    picture, mask, box = pdf_picture("wide.pdf")
    seen = expected[:, :, 3] > 250
    assert picture.dtype == ">u2" and abs(picture[seen] / 257 - expected[:, :, :3][seen]).max() < 1
    says(fails(3, "compare", "a.pdf", "a.png"), "pdf", "only be written")


def test_pictures_repeat_themselves():
    write_ball()
    ok("render", "head.nrrd", "-o", "a.png", *SIZE, "--tf", "viridis", "--view", "30,20", "--title", "<a> & b\u00e9")
    for suffix in ["tif", "pdf"] + ["webp"] * has("webp"):
        ok("render", "a.png", "-o", f"a.{suffix}")
        ok("render", f"a.{suffix}", "-o", "b.png", "--overwrite")
        assert png_pixels("a.png") == png_pixels("b.png"), suffix
        assert png_text("a.png")["VolVis:Scene"] == png_text("b.png")["VolVis:Scene"]
        says(ok("info", f"a.{suffix}").text, "picture with a scene")
    packet = next(stream for head, stream in pdf_objects("a.pdf").values() if "/Metadata /Subtype" in head)
    scene = ElementTree.fromstring(packet).find(".//{urn:volvis:picture}Scene")
    assert scene.text == png_text("a.png")["VolVis:Scene"]


def test_a_tiff_of_samples_stays_a_volume():
    write_ball()
    ok("convert", "head.nrrd", "-o", "volume.tif")
    ok("convert", "head.nrrd", "-o", "again.tif")
    assert ok("compare", "volume.tif", "again.tif", "--json").json["kind"] == "volumes"
    assert ok("info", "volume.tif", "--json").json["dims"] == [32, 32, 32]
    ok("render", "volume.tif", "-o", "picture.tif", *SIZE)
    assert ok("compare", "picture.tif", "picture.tif", "--json").json["kind"] == "images"
    says(fails(2, "compare", "picture.tif", "volume.tif"), "is a picture")
    ok("convert", "picture.tif", "-o", "back.nrrd")  # the data that it shows
    ok("compare", "back.nrrd", "volume.tif", "--max-difference", "0")


def test_odd_sizes_standard_output_and_stems():
    write_ball()
    for suffix in ["tif", "pdf"] + ["webp"] * has("webp"):
        for size in ("1x1", "1x7", "7x1"):
            ok("render", "head.nrrd", "-o", f"a.{suffix}", "--size", size, "--overwrite")
            ok("render", "head.nrrd", "-o", "a.png", "--size", size, "--overwrite")
            if suffix == "pdf":
                assert (pdf_picture("a.pdf")[0] == pixels_of("a.png")).all()
            else:
                assert (pixels_of(f"a.{suffix}") == pixels_of("a.png")).all()
        ok("render", "head.nrrd", "-o", "{stem}." + suffix, *SIZE)
        assert os.path.exists(f"head.{suffix}")


def test_plots_and_previews_are_written_too():
    write_ball()
    for suffix in ["tif", "pdf"] + ["webp"] * has("webp"):
        ok("measure", "histogram", "head.nrrd", "-o", f"plot.{suffix}")
        ok("measure", "histogram", "head.nrrd", "-o", "plot.png", "--overwrite")
        ok("info", "head.nrrd", "--preview", "-o", f"slices.{suffix}")
        found = pdf_picture("plot.pdf")[0] if suffix == "pdf" else pixels_of(f"plot.{suffix}")
        assert (found == pixels_of("plot.png")).all()
    says(fails(3, "render", "plot.pdf", "-o", "a.png"), "holds no scene")


def test_a_figure_has_no_dpi():
    write_ball()
    says(fails(2, "render", "head.nrrd", "-o", "a.svg", "--dpi", "300"), "--dpi", "SVG is a figure")


def test_an_unknown_suffix_lists_what_there_is():
    write_ball()
    says(fails(2, "render", "head.nrrd", "-o", "a.xyz"), ".png", ".jpg", ".tif", ".webp", ".exr", ".pdf", ".pfm", ".svg")


def test_standard_output_has_the_bytes_of_a_file_of_the_format_that_is_asked_for():
    write_ball()
    for suffix in ["png", "jpg", "tif", "exr", "pdf", "pfm", "svg"] + ["webp"] * has("webp"):
        piped = ok("render", "head.nrrd", "-o", "-", "--output-format", suffix, *SIZE).out
        ok("render", "head.nrrd", "-o", f"file.{suffix}", "--overwrite", *SIZE)
        with open(f"file.{suffix}", "rb") as file:
            assert piped == file.read(), suffix
    words = ("render", "head.nrrd", *SIZE, "-o")
    says(fails(2, *words, "-", "--output-format", "jpge"), "no format of pictures 'jpge'", "did you mean 'jpeg'?")
    says(fails(2, *words, "a.png", "--output-format", "jpeg"), "a.png", "suffix says its format")
    says(fails(2, *words, "-", "--output-format", "exr", "--aov", "depth"), "layers", "give a file's name")
    says(fails(2, *words, "-", "--output-format", "svg", "--bits", "8"), "SVG is a figure")
    says(fails(2, *words, "-", "--output-format", "jpeg", "--bits", "16"), "not 16")
    says(volvis("convert", "head.nrrd", "-o", "-", "--output-format", "vvh").message, "one file, or give a file's name")


def test_an_ome_tiff_that_is_cut_is_not_read_with_other_dimensions_in_silence():
    try:
        import tifffile
    except ImportError as error:
        raise Skip(f"{error}: python3-tifffile is missing")
    data = numpy.arange(2 * 3 * 20 * 30, dtype=numpy.uint8).reshape(2, 3, 20, 30)
    tifffile.imwrite("a.ome.tif", data, photometric="minisblack", metadata={"axes": "CZYX"})
    with tifffile.TiffFile("a.ome.tif", mode="r+b") as tif:  # the text at the end, as Bio-Formats has it
        tag = tif.pages[0].tags["ImageDescription"]
        tag.overwrite(tag.value.replace("</OME>", "<!--" + "x" * 200 + "--></OME>"))
    with open("a.ome.tif", "rb") as file:
        whole = file.read()
    at = whole.rindex(b"<?xml")
    ends = {len(whole) - n for n in (1, 2, 5, 26, 150)} | {at + n for n in (0, 1, 40)} | {
        at + whole[at:].index(word) + 20 for word in (b"<Pixels", b"<TiffData")}
    right = ok("info", "a.ome.tif", "--json").json
    assert (right["dims"], right["components"]) == ([30, 20, 3], 2), right
    for end in sorted(ends):
        with open("cut.ome.tif", "wb") as file:
            file.write(whole[:end])
        told = volvis("info", "cut.ome.tif", "--json")
        if end <= at:
            assert told.code == 3 and "OME-XML" in told.message, (end - at, told.code, told.message)
        same = told.code in (0, 7) and (told.json["dims"], told.json["components"]) == ([30, 20, 3], 2)
        assert same or (told.code in (3, 4, 7) and re.search("cut short|ends before", told.message)), (
            end - at, told.code, told.message)


main()
