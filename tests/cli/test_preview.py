"""Thumbnails of `info --preview`: as image files, and in terminals of every kind."""
import gzip
import itertools
import os
import pty
import re
import select
import subprocess
import termios
import time
from harness import VOLVIS, Skip, environment, fails, main, ok, says, write_ball, write_cells

try:
    import numpy
    from PIL import Image
except ImportError:
    numpy = Image = None


def need_numpy():
    if Image is None:
        raise Skip("needs numpy and Pillow")


def write_volume(path, samples, header):
    with open(path, "wb") as file:
        file.write(f"NRRD0004\n{header}encoding: raw\nendian: little\n\n".encode())
        file.write(numpy.ascontiguousarray(samples).tobytes())


def preview(path, *words):
    ok("info", path, "--preview", "-o", "slices.png", *words)
    return numpy.asarray(Image.open("slices.png").convert("RGB")).astype(int)


def test_values_about_zero_are_blue_below_and_red_above():
    need_numpy()
    line = numpy.sin((numpy.arange(32) + 0.5) / 32 * 2 * numpy.pi)
    hill = numpy.cos((numpy.arange(32) - 15.5) / 32 * numpy.pi)
    samples = (hill[:, None, None] * hill[:, None] * line).astype("f4")  # x is the sign
    write_volume("signed.nrrd", samples, "type: float\ndimension: 3\nsizes: 32 32 32\n")
    picture = preview("signed.nrrd", "--size", "96x32")
    red = picture[..., 0] - picture[..., 2]
    assert (red > 40).any() and (red < -40).any()
    write_volume("positive.nrrd", abs(samples), "type: float\ndimension: 3\nsizes: 32 32 32\n")
    grey = preview("positive.nrrd", "--size", "96x32")
    assert (grey[..., 0] == grey[..., 2]).all()


def test_one_body_looks_the_same_in_all_48_orientations():
    need_numpy()
    rng = numpy.random.default_rng(5)
    body = rng.integers(0, 255, size=(5, 7, 9)).astype("u1")  # by right, front, up
    spacing = (2, 1.5, 1)
    pictures = []
    for order in itertools.permutations(range(3)):
        for flips in itertools.product((1, -1), repeat=3):
            samples = numpy.transpose(body, order)
            directions, origin = [], [0.0, 0.0, 0.0]
            for axis, world in enumerate(order):
                vector = [0.0, 0.0, 0.0]
                vector[world] = flips[axis] * spacing[world]
                directions.append("(%g,%g,%g)" % tuple(vector))
                if flips[axis] < 0:
                    samples = numpy.flip(samples, axis)
                    origin[world] = (body.shape[world] - 1) * spacing[world]
            header = (f"type: uint8\ndimension: 3\nspace: right-anterior-superior\n"
                      f"sizes: {' '.join(map(str, samples.shape))}\nspace directions: {' '.join(directions)}\n"
                      f"space origin: ({origin[0]},{origin[1]},{origin[2]})\n")
            write_volume("body.nrrd", numpy.transpose(samples, (2, 1, 0)), header)
            pictures.append(preview("body.nrrd", "--size", "300x100"))
    assert len(pictures) == 48
    for picture in pictures[1:]:
        assert (picture == pictures[0]).all()


def test_sides_of_the_body_are_where_a_radiologist_expects_them():
    need_numpy()
    body = numpy.zeros((16, 16, 16), "u1")  # z, y, x: right, front and up are the high ends
    body[12:, :, :] += 100
    body[:, 12:, :] += 60
    body[:, :, 12:] += 30
    write_volume("body.nrrd", body, "type: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 16 16 16\n"
                 "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n")
    picture = preview("body.nrrd", "--size", "308x100")[:, :, 0]
    axial, coronal, sagittal = picture[:, 2:98], picture[:, 106:202], picture[:, 210:306]
    assert axial[5:20, 5:15].mean() > axial[5:20, 80:90].mean()     # right is on the left
    assert axial[5:15, 50].mean() > axial[85:95, 50].mean()         # front is at the top
    assert coronal[5:15, 50].mean() > coronal[85:95, 50].mean()     # up is up
    assert coronal[50, 5:15].mean() > coronal[50, 85:95].mean()     # right is on the left
    assert sagittal[50, 5:15].mean() > sagittal[50, 85:95].mean()   # one looks from the left: the nose is there
    assert sagittal[5:15, 50].mean() > sagittal[85:95, 50].mean()


def test_proportions_follow_the_spacing():
    need_numpy()
    write_ball("flat.nrrd", 32, spacing=(1, 1, 3))
    picture = preview("flat.nrrd", "--size", "700x400").max(axis=2)
    columns = picture.max(axis=0) > 20
    edges = numpy.flatnonzero(numpy.diff(columns.astype(int)))
    widths = edges[1::2] - edges[0::2]
    heights = [numpy.ptp(numpy.flatnonzero(picture[:, a + 1:b].max(axis=1) > 20)) for a, b in zip(edges[::2], edges[1::2])]
    assert len(widths) == 3
    assert abs(heights[0] / widths[0] - 1) < 0.1 and abs(heights[1] / widths[1] - 3) < 0.2, (widths, heights)


def test_channels_labels_and_colours_have_their_colours():
    need_numpy()
    write_cells()
    picture = preview("cells.nrrd").reshape(-1, 3)
    assert (picture == (0, 255, 0)).all(axis=1).any() and (picture == (255, 0, 255)).all(axis=1).any()
    labels = numpy.zeros((8, 8, 8), "u1")
    labels[:, :, 4:] = 3
    write_volume("labels.nrrd", labels, "type: uint8\ndimension: 3\nsizes: 8 8 8\nSegment0_ID:=a\n"
                 "Segment0_LabelValue:=3\nSegment0_Color:=1 0.5 0\n")
    found = numpy.unique(preview("labels.nrrd", "--size", "512x256").reshape(-1, 3), axis=0).tolist()
    assert found == [[0, 0, 0], [255, 128, 0]], found
    colours = numpy.zeros((4, 4, 4, 3), "u1")
    colours[:] = (10, 200, 30)
    write_volume("rgb.nrrd", colours, "type: uint8\ndimension: 4\nsizes: 3 4 4 4\n"
                 "kinds: RGB-color domain domain domain\n")
    assert (preview("rgb.nrrd") == (10, 200, 30)).all(axis=2).any()


def test_flat_and_single_samples_have_a_picture():
    need_numpy()
    for dims in ((9, 7, 1), (9, 1, 7), (1, 9, 7), (9, 1, 1), (1, 1, 9), (1, 1, 1)):
        samples = numpy.arange(dims[0] * dims[1] * dims[2], dtype="u1").reshape(dims[::-1])
        write_volume("small.nrrd", samples, f"type: uint8\ndimension: 3\nsizes: {dims[0]} {dims[1]} {dims[2]}\n")
        assert preview("small.nrrd").size > 0
    write_volume("nan.nrrd", numpy.full((4, 4, 4), numpy.nan, "f4"), "type: float\ndimension: 3\nsizes: 4 4 4\n")
    assert preview("nan.nrrd").max() == 0


def test_of_huge_files_only_what_is_shown_is_read():
    need_numpy()
    n = 4096
    with open("huge.nrrd", "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {n} {n} {n}\nencoding: raw\n\n".encode())
        begin = file.tell()
        for z in range(n // 2 - 8, n // 2 + 8):  # a bright plate across the middle
            file.seek(begin + z * n * n + (n // 2 - 40) * n)
            file.write(b"\xff" * (80 * n))
        file.truncate(begin + n**3)
    picture = preview("huge.nrrd", "--size", "308x100")[:, :, 0]  # sample by sample it would not end in a minute
    os.remove("huge.nrrd")
    assert picture.shape == (100, 308)
    assert picture[50, 50] == 255 and picture[40, 50] == 0 and picture[10, 280] == 0


def test_thinned_slices_show_the_same_as_whole_ones():
    need_numpy()
    z, y, x = (a / 900.0 for a in numpy.ogrid[0:900, 0:40, 0:900])
    wave = (numpy.sin(9 * x) * (100 * numpy.cos(7 * z)) + (128 + 20 * y)).astype("u1")
    for name, samples in (("large", wave), ("small", wave[1::3, :, 1::3])):
        steps = [900 / samples.shape[2], 1, 900 / samples.shape[0]]
        write_volume(name + ".nrrd", samples, "type: uint8\ndimension: 3\nsizes: %d %d %d\n" % samples.shape[::-1] +
                     "spacings: %g %g %g\n" % tuple(steps))
    large, small = (preview(name + ".nrrd", "--size", "600x300") for name in ("large", "small"))
    assert large.shape == small.shape and abs(large - small).max() <= 8


def test_what_comes_packed_by_a_pipe_has_a_picture_too():
    write_ball()
    with open("head.nrrd", "rb") as file:
        packed = gzip.compress(file.read())
    shown = ok("info", "head.nrrd", "--preview=blocks").text.splitlines()[-10:]
    assert ok("info", "-", "--preview=blocks", stdin=packed).text.splitlines()[-10:] == shown


def test_what_is_no_terminal_gets_letters():
    write_ball("head.nrrd", 24)
    plain = ok("info", "head.nrrd", "--preview").text
    assert "@@" in plain and "\033" not in plain
    colour = ok("info", "head.nrrd", "--preview=blocks", env={"TERM": "xterm-256color", "COLORTERM": "truecolor"}).text
    says(colour, "\033[38;2;", "\u2580", "\033[0m\n")
    says(ok("info", "head.nrrd", "--preview=blocks", env={"TERM": "xterm-256color", "COLORTERM": ""}).text, "\033[38;5;")
    assert "\033" not in ok("info", "head.nrrd", "--preview=blocks", env={"NO_COLOR": "1", "TERM": "xterm-256color"}).text
    assert "@@" not in ok("info", "head.nrrd", "--preview=none").text


def test_wrong_words_are_refused():
    write_ball("head.nrrd", 8)
    says(fails(2, "info", "head.nrrd", "--preview", "-o", "a.txt"), "suffix")
    says(fails(2, "info", "head.nrrd", "--preview", "-o", "a.png", "--size", "0x4"), "--size")
    says(fails(2, "info", "head.nrrd", "--size", "10x10"), "--preview")
    says(fails(2, "info", "head.nrrd", "--preview=sixels"), "sixel")
    assert ok("info", "head.nrrd", "--preview", "-o", "a.png", "--json").json["preview"] == "a.png"


def read_sixels(text):
    """A picture from its sixels: {(x, y): (r, g, b)} in percent."""
    body = re.search("\033P0;1;0q\"1;1;(\\d+);(\\d+)(.*?)\033\\\\", text, re.S)
    width, height, data = int(body[1]), int(body[2]), body[3]
    picture = numpy.zeros((height, width, 3), int)
    palette, colour, x, y = {}, None, 0, 0
    for token in re.finditer("#(\\d+)(?:;2;(\\d+);(\\d+);(\\d+))?|!(\\d+)(.)|([?-~])|([$-])", data):
        number, r, g, b, run, repeated, single, move = token.groups()
        if number is not None:
            if r is not None:
                palette[int(number)] = (int(r), int(g), int(b))
            else:
                colour = palette[int(number)]
        elif move == "$":
            x = 0
        elif move == "-":
            x, y = 0, y + 6
        else:
            n, bits = (int(run), ord(repeated) - 63) if run else (1, ord(single) - 63)
            for j in range(6):
                if bits >> j & 1:
                    picture[y + j, x : x + n] = colour
            x += n
    return picture


def test_sixels_are_the_picture():
    need_numpy()
    write_ball("head.nrrd", 24)
    write_cells()
    for path, error in (("head.nrrd", 0.6), ("cells.nrrd", 9)):
        sixels = read_sixels(ok("info", path, "--preview=sixel").text)
        png = preview(path, "--size", f"{sixels.shape[1]}x{sixels.shape[0]}") / 2.55
        assert sixels.shape == png.shape
        assert abs(sixels - png).mean() < error, abs(sixels - png).mean()


def in_terminal(reply, *words, **more):
    """What the program says to a terminal that answers like this to 'what are you?'."""
    near, far = pty.openpty()
    before = termios.tcgetattr(far)

    def take():
        os.setsid()
        import fcntl
        fcntl.ioctl(far, termios.TIOCSCTTY, 0)

    env = environment(TERM="xterm-256color", COLORTERM="truecolor", **more)
    child = subprocess.Popen([VOLVIS, *words], stdin=far, stdout=far, stderr=far, env=env, preexec_fn=take)
    said, ended, end = b"", False, time.monotonic() + 60
    while True:
        ready, _, _ = select.select([near], [], [], 0 if ended else 0.02)
        if ready:
            said += os.read(near, 65536)
            if b"\033[c" in said and reply:
                os.write(near, reply)
                reply = b""
        elif ended:
            break
        ended = child.poll() is not None  # what it said before is looked for once more
        assert time.monotonic() < end, f"the program has not ended in 60 s: {said}"
    assert child.returncode == 0, said
    assert termios.tcgetattr(far) == before
    os.close(far)
    os.close(near)
    return said.decode()


def test_a_terminal_is_asked_whether_it_shows_pixels():
    write_ball("head.nrrd", 16)
    for _ in range(20):  # the program waits 0.3 s for an answer, and now and then we are later than that
        said = in_terminal(b"\033[?62;4;6c", "info", "head.nrrd", "--preview")
        if "\033P" in said:
            break
    says(said, "\033P0;1;0q")
    for reply in (b"\033[?1;2c", b"\033[?64;14;45c", b"", b"nonsense"):
        said = in_terminal(reply, "info", "head.nrrd", "--preview")
        assert "\033P" not in said and "\033[48;2;" in said
    assert "\033[" not in in_terminal(b"", "info", "head.nrrd", "--preview", NO_COLOR="1")


main()
