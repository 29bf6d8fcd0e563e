"""--watch: the output is made again when what it was made of changes."""
from contextlib import contextmanager
import json
import os
import select
import shutil
import signal
import struct
import subprocess
import time
import zlib
from harness import VOLVIS, environment, fails, main, ok, png_pixels, png_text, says, write_ball, write_nrrd

PATIENCE = 30  # seconds for what must come: nobody is so slow


class Watcher:
    """The program with --watch; what it says comes line by line."""

    def __init__(self, process):
        self.process, self.said = process, b""

    def wait_for(self, text):
        """Until it says this, which it has not said before; returns all that came until then."""
        end, came = time.monotonic() + PATIENCE, b""
        while text.encode() not in came:
            assert select.select([self.process.stdout], [], [], max(0, end - time.monotonic()))[0], f"no {text!r}: {came}"
            piece = os.read(self.process.stdout.fileno(), 65536)
            assert piece, f"it has ended before {text!r}: {came}"
            came += piece
        return came.decode()


@contextmanager
def watching(*words, env=None):
    process = subprocess.Popen([VOLVIS, *map(str, words), "--watch"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               bufsize=0, env=environment(**(env or {})))
    try:
        yield Watcher(process)
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE)
        assert process.returncode == 130, process.returncode
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def block(n):
    return lambda x, y, z: 200 if max(abs(x - 8), abs(y - 8), abs(z - 8)) < n else 0


def write_gray(path, value):
    """A slice of 4 x 4."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 0, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress((b"\0" + bytes([value]) * 4) * 4)) + chunk(b"IEND", b""))


def test_a_picture_follows_its_data_however_they_are_replaced():
    write_nrrd("a.nrrd", (16, 16, 16), block(2))
    with watching("render", "a.nrrd", "-o", "a.png", "--size", 40) as watcher:
        first = watcher.wait_for("Ctrl-C ends it")
        says(first, "a.png: 40 x 40", "watching 1 file")
        pictures = [png_pixels("a.png")]
        write_nrrd("a.nrrd", (16, 16, 16), block(4))  # written in place
        watcher.wait_for("a.png: ")
        pictures.append(png_pixels("a.png"))
        write_nrrd("new", (16, 16, 16), block(6))  # another one in its place
        os.replace("new", "a.nrrd")
        watcher.wait_for("a.png: ")
        pictures.append(png_pixels("a.png"))
        write_nrrd("new", (16, 16, 16), block(7))  # gone, and there again
        os.remove("a.nrrd")
        os.rename("new", "a.nrrd")
        watcher.wait_for("a.png: ")
        pictures.append(png_pixels("a.png"))
    assert len(set(pictures)) == 4
    ok("render", "a.nrrd", "-o", "b.png", "--size", 40)
    assert png_pixels("b.png") == pictures[-1]


def test_it_goes_on_after_an_error():
    write_ball("a.nrrd", 16)
    with watching("render", "a.nrrd", "-o", "a.png", "--size", 40) as watcher:
        watcher.wait_for("Ctrl-C ends it")
        before = png_pixels("a.png")
        with open("a.nrrd", "rb") as file:
            whole = file.read()
        with open("a.nrrd", "wb") as file:
            file.write(whole[:100])
        watcher.wait_for("volvis: a.nrrd: ")
        assert png_pixels("a.png") == before
        with open("a.nrrd", "wb") as file:
            file.write(whole)
        watcher.wait_for("a.png: ")


def test_what_is_read_besides_the_words_is_watched_too():
    write_nrrd("a.nrrd", (16, 16, 16), block(4))
    write_nrrd("other.nrrd", (16, 16, 16), block(6))
    ok("render", "a.nrrd", "-o", "x.png", "--size", 40, "--save-scene", "a.vv.json")
    with open("a.vv.json", encoding="utf-8") as file:
        scene = json.load(file)
    for dataset in scene["datasets"].values():  # else it is refused that the data is another
        del dataset["checksum"]
    with open("a.vv.json", "w", encoding="utf-8") as file:
        json.dump(scene, file)
    with open("tf.json", "w", encoding="ascii") as file:
        file.write('{"opacity": [[0, 0], [200, 0.1]]}')
    with watching("render", "a.vv.json", "-o", "a.png", "--tf", "tf.json") as watcher:
        says(watcher.wait_for("Ctrl-C ends it"), "watching 3 files")
        pictures = [png_pixels("a.png")]
        shutil.copy("other.nrrd", "a.nrrd")
        watcher.wait_for("a.png: ")
        pictures.append(png_pixels("a.png"))
        with open("tf.json", "w", encoding="ascii") as file:
            file.write('{"opacity": [[0, 0], [200, 0.9]]}')
        watcher.wait_for("a.png: ")
        pictures.append(png_pixels("a.png"))
    assert len(set(pictures)) == 3


def test_a_folder_is_watched_for_new_slices():
    os.mkdir("slices")
    for z in range(3):
        write_gray(f"slices/{z}.png", 50 * z)
    with watching("convert", "slices", "-o", "out.nrrd", "--type", "f32") as watcher:
        says(watcher.wait_for("Ctrl-C ends it"), "out.nrrd: 4 x 4 x 3 f32")
        write_gray("slices/3.png", 150)
        watcher.wait_for("out.nrrd: 4 x 4 x 4 f32")
        assert not select.select([watcher.process.stdout], [], [], 1.5)[0], "it woke itself"


def test_each_input_is_made_by_itself():
    write_ball("a.nrrd", 16)
    write_ball("b.nrrd", 16)
    with watching("gaussian", "a.nrrd", "b.nrrd", "-o", "{stem}-soft.nrrd") as watcher:
        says(watcher.wait_for("Ctrl-C ends it"), "a-soft.nrrd", "b-soft.nrrd", "watching 2 files")
        write_ball("b.nrrd", 20)
        again = watcher.wait_for("b-soft.nrrd: 20 x 20 x 20")
        assert "a-soft" not in again


def test_a_file_of_somebody_else_is_not_replaced():
    write_ball("a.nrrd", 16)
    with open("notes.png", "wb") as file:
        file.write(b"not a picture of ours")
    says(fails(2, "render", "a.nrrd", "-o", "notes.png", "--watch"), "notes.png", "already exists", "--overwrite")
    with watching("render", "a.nrrd", "-o", "a.png", "--size", 40) as watcher:
        watcher.wait_for("Ctrl-C ends it")
        with open("a.png", "wb") as file:
            file.write(b"mine")
        write_ball("a.nrrd", 20)
        says(watcher.wait_for("another program"), "a.png", "--overwrite")
        with open("a.png", "rb") as file:
            assert file.read() == b"mine"
    ok("render", "a.nrrd", "-o", "a.png", "--size", 40)
    with watching("render", "a.nrrd", "-o", "a.png", "--size", 50) as watcher:  # VolVis made it
        watcher.wait_for("Ctrl-C ends it")
    assert "VolVis" in " ".join(png_text("a.png"))


def test_the_output_of_in_and_out_is_made_again():
    write_ball("a.nrrd", 16)
    with watching("convert", "a.nrrd", "a.mha") as watcher, watching("gaussian", "a.nrrd", "b.nii") as other:
        watcher.wait_for("Ctrl-C ends it")
        other.wait_for("Ctrl-C ends it")
        write_ball("a.nrrd", 20)
        watcher.wait_for("a.mha: 20 x 20 x 20")
        other.wait_for("b.nii: 20 x 20 x 20")
        with open("a.mha", "wb") as file:
            file.write(b"mine")
        write_ball("a.nrrd", 12)
        says(watcher.wait_for("another program"), "a.mha", "--overwrite")
        assert not select.select([watcher.process.stdout], [], [], 0.6)[0], "it says so again without a change"
    with open("a.mha", "rb") as file:
        assert file.read() == b"mine"
    says(fails(2, "convert", "a.nrrd", "a.mha", "--watch"), "a.mha: already exists")
    says(fails(2, "convert", "a.nrrd", "a.nrrd", "--watch", "--overwrite"), "an input too")
    says(fails(2, "convert", "a.nrrd", "-", "--output-format", "nrrd", "--watch"), "give -o a file")


def test_what_fails_early_waits_for_a_change_too():
    write_ball("a.nrrd", 16)
    with open("defaults", "w", encoding="ascii") as file:
        file.write("gaussian --sigma 2vox\n")
    with watching("gaussian", "a.nrrd", "-o", "b.nrrd", env={"VOLVIS_DEFAULTS": "defaults"}) as watcher:
        watcher.wait_for("Ctrl-C ends it")
        with open("defaults", "w", encoding="ascii") as file:
            file.write("gaussian --sigmma 2vox\n")
        write_ball("a.nrrd", 20)
        watcher.wait_for("did you mean --sigma?")
        assert not select.select([watcher.process.stdout], [], [], 0.6)[0], "it says so again without a change"


def test_what_comes_only_once_cannot_be_watched():
    write_ball("a.nrrd", 16)
    says(fails(2, "render", "-", "-o", "a.png", "--watch"), "standard input", "as a file")
    says(fails(2, "render", "a.nrrd", "-o", "-", "--watch"), "-o -", "give -o a file")
    os.mkfifo("pipe")
    says(fails(2, "convert", "pipe", "-o", "b.nrrd", "--input-format", "nrrd", "--watch"), "pipe", "only once")
    says(fails(2, "gaussian", "a.nrrd", "-o", "a.nrrd", "--overwrite", "--watch"), "a.nrrd", "an input too")
    says(fails(2, "render", "a.nrrd", "-o", "a.png", "--tff", "bone", "--watch"), "did you mean --tf?")
    says(fails(2, "render", "a.nrrd", "-o", "a.png", "--watch", "--dry-run"), "--dry-run")


def test_writing_that_nobody_tells_of_is_found_by_looking():
    """Through a mapping: inotify tells nothing of it until it is closed."""
    import mmap
    write_nrrd("a.nrrd", (16, 16, 16), block(4))
    with watching("render", "a.nrrd", "-o", "a.png", "--size", 40) as watcher:
        watcher.wait_for("Ctrl-C ends it")
        before = png_pixels("a.png")
        with open("a.nrrd", "r+b") as file, mmap.mmap(file.fileno(), 0) as mapped:
            mapped[-4096:-2048] = bytes([200]) * 2048
            mapped.flush()
            watcher.wait_for("a.png: ")
        assert png_pixels("a.png") != before


main()
