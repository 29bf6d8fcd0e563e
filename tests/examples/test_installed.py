#!/usr/bin/env python3
"""The library as a program outside the tree sees it: the examples are built against an installed copy by pkg-config and
a plain compiler, and run.

    test_installed.py MESON BUILD_FOLDER EXAMPLES_FOLDER
"""
import glob
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

COMPILER = os.environ.get("CC", "cc").split()
FLAGS = ["-std=c17", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-Wno-missing-field-initializers"]
# what the program needs for its server, or loads by itself when it is wanted
NOT_OF_THE_LIBRARY = re.compile(r"libwebsockets|libssl|libcrypto|libgdcm")


def run(*words, **more):
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, **more)
    if done.returncode:
        raise AssertionError(f"{' '.join(words)}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = tempfile.mkdtemp(prefix="volvis-installed-")
        run(*MESON, "install", "-C", BUILD, "--no-rebuild", "--destdir", cls.root, "--tags", "devel,runtime")
        found = glob.glob(os.path.join(cls.root, "**", "volvis.pc"), recursive=True)
        assert len(found) == 1, found
        cls.library = os.path.dirname(os.path.dirname(found[0]))
        cls.environment = {**os.environ, "PKG_CONFIG_PATH": os.path.dirname(found[0]), "PKG_CONFIG_SYSROOT_DIR": cls.root,
                           "LD_LIBRARY_PATH": cls.library, "HOME": cls.root}
        cls.flags = run("pkg-config", "--cflags", "--libs", "volvis", env=cls.environment).split()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root)

    def build(self, *names):
        program = os.path.join(self.root, names[0])
        sources = [os.path.join(EXAMPLES, name + ".c") for name in names]
        run(*COMPILER, *FLAGS, *sources, "-o", program, *self.flags, "-lm", cwd=self.root)
        return lambda *words: run(program, *words, cwd=self.root, env=self.environment)

    def read(self, name):
        with open(os.path.join(self.root, name), "rb") as file:
            return file.read()

    def test_a_file_is_loaded_turned_and_rendered(self):
        with open(os.path.join(self.root, "ball.nrrd"), "wb") as file:
            file.write(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 20 20\nencoding: raw\n\n")
            file.write(bytes(max(0, 250 - 3 * ((i - 9) ** 2 + (j - 9) ** 2 + (k - 9) ** 2)) for k in range(20)
                             for j in range(20) for i in range(20)))
        said = self.build("render")("ball.nrrd", "ball.png", "40")
        self.assertRegex(said, r"^ball\.png: 320 x 240 by \w+\n$")
        self.assertEqual(struct.unpack(">II", self.read("ball.png")[16:24]), (320, 240))

    def test_the_surface_of_samples_of_ones_own_is_a_ball(self):
        said = self.build("surface")("ball.ply")
        n = int(re.fullmatch(r"ball\.ply: (\d+) triangles\n", said)[1])
        self.assertGreater(n, 1000)
        data = self.read("ball.ply")
        header, _, body = data.partition(b"end_header\n")
        self.assertIn(b"element face %d" % n, header)
        vertices = int(re.search(rb"element vertex (\d+)", header)[1])
        properties = re.findall(rb"property (\w+) (\w+)", header.partition(b"element face")[0])
        size = sum({b"float": 4, b"uchar": 1, b"double": 8}[kind] for kind, _ in properties)
        form = "<d" if properties[0][0] == b"double" else "<f"
        step = struct.calcsize(form)
        for at in range(0, vertices * size, size * 97):
            place = [struct.unpack_from(form, body, at + step * axis)[0] - 11.75 for axis in range(3)]
            self.assertAlmostEqual(sum(v * v for v in place) ** 0.5, 8, delta=0.15)  # smoothing takes 0.75^2 / 8 of it

    def test_a_mesh_of_ones_own_is_measured(self):
        said = self.build("measure")()
        volume, area = re.fullmatch(r"volume ([\d.]+) cm\^3, known to \S+\narea ([\d.]+) cm\^2, closed\n", said).groups()
        self.assertAlmostEqual(float(volume), 4, places=4)
        self.assertAlmostEqual(float(area), 4 + 4 * 10 ** 0.5, places=4)

    def test_work_is_watched_and_stopped(self):
        self.assertEqual(self.build("progress")(), "the hasty one: cancelled; the patient one: ok\n")

    def test_a_picture_goes_on_from_a_file(self):
        self.assertRegex(self.build("picture")(), r"^\d+ % of 800 x 800 pixels\nthe same bytes\n$")

    def test_rows_of_ones_own_stand_beside_those_that_are_built_in(self):
        self.build("own_rows", "format_dots", "operation_negative", "renderer_film")(".")
        ramp, negative = self.read("ramp.dots"), self.read("negative.dots")
        head = b"DOTS 16 16 16\n"
        self.assertTrue(ramp.startswith(head) and negative.startswith(head))
        self.assertEqual([255 - v for v in ramp[len(head):]], list(negative[len(head):]))
        self.assertTrue(self.read("film.png").startswith(b"\x89PNG"))

    def test_every_example_is_built_by_a_test(self):
        with open(__file__, encoding="utf-8") as file:
            text = file.read()
        for path in glob.glob(os.path.join(EXAMPLES, "*.c")):
            self.assertIn('"' + os.path.splitext(os.path.basename(path))[0] + '"', text)

    def test_the_library_comes_without_server_and_page(self):
        path = os.path.join(self.library, "libvolvis.so.0")
        needed = re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", path, env={**os.environ, "LC_ALL": "C"}))
        self.assertIn("libz.so.1", needed)
        self.assertEqual([name for name in needed if NOT_OF_THE_LIBRARY.search(name)], [])
        data = self.read(path)
        for part in (b"Sec-WebSocket", b"connection-open", b"aria-busy"):
            self.assertFalse(part in data, part)

    def test_pkg_config_asks_for_nothing_but_the_library(self):
        self.assertEqual([word for word in self.flags if word.startswith("-l")], ["-lvolvis"])
        self.assertEqual(len([word for word in self.flags if word.startswith("-I")]), 1)


if __name__ == "__main__":
    MESON, BUILD, EXAMPLES = [sys.argv[1]], sys.argv[2], os.path.abspath(sys.argv[3])
    unittest.main(argv=sys.argv[:1], verbosity=2)
