#!/usr/bin/python3
"""What people see who choose nothing: many kinds of data by `volvis render FILE`, on one sheet to be looked at.

    bench/defaults/sheet.py VOLVIS OUTPUT.png [PART OF A NAME...]

Real data come from ../shared/data and Debian's mricron-data, where they are; the rest from formulas. There is nothing to
measure here: a person who knows the field should see at once what each is.
"""
import os
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

VOLVIS, OUTPUT, WANTED = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3:]
SHARED = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../../shared/data"))
TEMPLATES = "/usr/share/mricron/templates"
SIDE = 300


def axes(n, span=1.0):
    line = np.linspace(-span, span, n)
    return np.meshgrid(line, line, line, indexing="ij")


def vortices():
    """Signed: two tubes of vorticity that turn against each other."""
    z, y, x = axes(80)
    def tube(y0, z0, sign):
        return sign * np.exp(-(((y - y0 - 0.2 * np.sin(4 * x)) ** 2 + (z - z0) ** 2) / 0.02))
    return (tube(0.35, 0, 1) + tube(-0.35, 0.1, -1)).astype("f4")


def orbital():
    """Signed: a 3d wave function, psi = (3 z^2 - r^2) exp(-r / 3)."""
    z, y, x = axes(72, 14)
    r = np.sqrt(x * x + y * y + z * z)
    return ((3 * z * z - r * r) * np.exp(-r / 2)).astype("f4")


def statistic():
    """A map of t in a brain that is 0 outside: noise, with activations of both signs."""
    z, y, x = axes(64)
    noise = np.random.default_rng(1).normal(0, 1, x.shape)
    for axis in range(3):
        noise = (np.roll(noise, 1, axis) + noise + np.roll(noise, -1, axis)) / np.sqrt(3) * 0.9
    def blob(a, b, c, t):
        return t * np.exp(-((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / 0.02)
    t = noise + blob(0.4, 0.2, 0.1, 9) + blob(-0.4, 0.2, 0.1, 7) + blob(0, -0.5, 0.3, -8)
    return (t * (x * x / 0.6 + y * y / 0.9 + z * z / 0.5 < 1)).astype("f4")


def temperature():
    """Dense: no background; a hot plume in stratified air, in kelvin."""
    z, y, x = axes(64)
    plume = 60 * np.exp(-(x * x + y * y) / (0.05 + 0.1 * (z + 1))) * np.exp(-(z + 1))
    return (290 + 5 * z + plume).astype("f4")


def waves():
    """Dense and signed: Marschner and Lobb's test signal."""
    z, y, x = axes(64)
    r = np.sqrt(x * x + y * y)
    return ((1 - np.sin(np.pi * z / 2) + 0.25 * (1 + np.cos(12 * np.pi * np.cos(np.pi * r / 2)))) / 2.5).astype("f4")


def activity():
    """PET: a faint body with hot spots, a tenth of a voxel in a hundred."""
    z, y, x = axes(72)
    body = (x * x / 0.5 + y * y / 0.25 < 1) * (np.abs(z) < 0.95) * 800.0
    rng = np.random.default_rng(2)
    body = body * rng.gamma(8, 1 / 8, x.shape)
    for a, b, c, r, v in ((0.3, 0.1, 0.2, 0.06, 30000), (-0.2, -0.1, -0.4, 0.1, 15000), (0, 0.1, 0.75, 0.18, 9000)):
        body += v * np.exp(-((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / (2 * r * r / 4))
    return body.astype("f4")


def cells():
    """Microscopy: faint cells over camera noise, 16 bits of which few are used."""
    rng = np.random.default_rng(3)
    z, y, x = axes(80)
    light = np.zeros(x.shape)
    for a, b, c in rng.uniform(-0.8, 0.8, (14, 3)):
        d = np.sqrt((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2)
        light += 300 * np.exp(-((d / 0.16) ** 6)) * (0.6 + 0.4 * np.sin(40 * d))
    return np.clip(110 + light + rng.normal(0, 8, x.shape), 0, 65535).astype("u2")


def ids():
    """Segmented neurons: ids of 32 bits."""
    rng = np.random.default_rng(4)
    seeds = rng.uniform(-1, 1, (40, 3))
    names = rng.integers(10**6, 2**31, 40)
    z, y, x = axes(56)
    best, out = np.full(x.shape, 9.0), np.zeros(x.shape, "u4")
    for (a, b, c), name in zip(seeds, names):
        d = (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
        out[d < best] = name
        best = np.minimum(best, d)
    out[x * x + y * y + z * z > 0.8] = 0
    return out


def picture():
    y, x = np.mgrid[0:200, 0:260] / 200
    return (120 + 60 * np.sin(12 * x) * np.cos(9 * y) + 70 * (np.hypot(x - 0.6, y - 0.5) < 0.2)).astype("u1")[None]


def thresholded():
    """The same map, of which only what is strong was kept, and NaN outside."""
    t = statistic()
    return np.where(t == 0, np.nan, np.where(np.abs(t) < 4, 0, t)).astype("f4")


def bright():
    """An object in bright surroundings: the cells with their values turned round, and dead pixels far below."""
    c = 4000 - cells().astype("i2")
    c.flat[np.random.default_rng(5).choice(c.size, c.size // 5000, replace=False)] = -32768
    return c


FORMULAS = [vortices, orbital, statistic, thresholded, bright, temperature, waves, activity, cells, ids, picture]
FILES = ["volumes/lobster_301x324x56_u8.nhdr", "volumes/engine_256x256x256_u8.nhdr", "volumes/tooth.nhdr",
         "volumes/neghip_64x64x64_u8.nhdr", "volumes/fuel_64x64x64_u8.nhdr", "volumes/hydrogen.vti",
         "volumes/mra_head_256x256x256_u8.nhdr", "volumes/embryo.slc", "volumes/neuron_409x415x119_u8.nhdr",
         "volumes/manix128_128x128x115_u8.raw", "volumes/jet_vort-small.vti", "volumes/chestct_256x256x133_u8.nhdr",
         "volumes/isabel/isabel_02.vti", "volumes/carotid.vtk", "volumes/frogtissue.mhd", "volumes/MR_Gd.nii.gz",
         "volumes/CT_AVM.nii.gz", "volumes/pcasl_4d.nii.gz", "irregular/RectGrid2.vtk", "formats/tiff/nuclei_img3d.tif",
         "formats/tiff/nuclei_mask3d.tif", "formats/tiff/blobs_3d_imagej.tif",
         "formats/tiff/multi-channel-z-series.ome.tif", "formats/dicom/mr_brain_20", "formats/dicom/single:1",
         "formats/dicom/single:1.5", "formats/dicom/MR-MONO2-8-16x-heart.dcm", "formats/mrc/EMD-3001.map",
         "formats/vti/pv_viscous.vti", "formats/inr/liver.inr.gz", "formats/cube/m4_TotalDensity.cube", "formats/pvm/Bucky.pvm",
         "geometry/bunny.ply"]
NIFTI = ["ch2.nii.gz", "ch2bet.nii.gz", "aal.nii.gz", "inia19-NeuroMaps.nii.gz"]


def sources(folder):
    for make in FORMULAS:
        path = os.path.join(folder, make.__name__ + ".npy")
        if not WANTED or any(w in make.__name__ for w in WANTED):
            np.save(path, make())
        yield make.__name__, path
    for name in FILES:
        path = os.path.join(SHARED, name)
        if os.path.exists(path.rsplit(":", 1)[0]):
            yield os.path.basename(name), path
    for name in NIFTI:
        if os.path.exists(os.path.join(TEMPLATES, name)):
            yield name, os.path.join(TEMPLATES, name)


def main():
    tiles = []
    with tempfile.TemporaryDirectory() as folder:
        for name, path in sources(folder):
            if WANTED and not any(w in name for w in WANTED):
                continue
            shot = os.path.join(folder, "shot.png")
            done = subprocess.run([VOLVIS, "render", path, "-o", shot, "--size", f"{SIDE}x{SIDE}", "--overwrite"],
                                  capture_output=True, text=True)
            tile = Image.open(shot).convert("RGB") if done.returncode in (0, 7) else Image.new("RGB", (SIDE, SIDE), "darkred")
            ImageDraw.Draw(tile).text((4, 2), name if done.returncode in (0, 7) else name + "\n" + done.stderr[:200], "white")
            tiles.append(tile)
    columns = min(7, len(tiles))
    sheet = Image.new("RGB", (columns * (SIDE + 4), -(-len(tiles) // columns) * (SIDE + 4)), "white")
    for i, tile in enumerate(tiles):
        sheet.paste(tile, (i % columns * (SIDE + 4), i // columns * (SIDE + 4)))
    sheet.save(OUTPUT)


main()
