"""The volumes behind the golden images: closed forms on small grids, so that nothing of anybody else's is needed."""
import numpy as np

import png


def axes(nx, ny, nz):
    """Coordinates -1..1 along x, y, z, ready to broadcast to [z][y][x]."""
    x, y, z = (np.linspace(-1, 1, n) for n in (nx, ny, nz))
    return x[None, None, :], y[None, :, None], z[:, None, None]


def ball(x, y, z, cx, cy, cz, radius, soft):
    """1 inside, 0 outside, smooth over `soft` on either side of the surface."""
    distance = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - radius
    t = np.clip(0.5 - distance / (2 * soft), 0, 1)
    return t * t * (3 - 2 * t)


def figure(nx, ny, nz):
    """An object without any symmetry: a head-like ball (100) with a hard core (220), an ear at +x (160), a nose at -y
    (160) and a hat at +z (200), 0 around it. Turned, mirrored or shifted pictures of it all look different."""
    x, y, z = axes(nx, ny, nz)
    value = np.zeros((nz, ny, nx))
    for shape, level in (
        (ball(x, y, z, 0, 0, -0.1, 0.62, 0.06), 100),
        (ball(x, y, z, 0.72, 0.1, -0.05, 0.18, 0.06), 160),
        (ball(x, y, z, -0.1, -0.72, -0.2, 0.15, 0.06), 160),
        (ball(x, y, z, -0.2, 0, 0.66, 0.22, 0.06), 200),
        (ball(x, y, z, 0.1, 0.1, -0.05, 0.30, 0.06), 220),
    ):
        value += shape * (level - value)
    return value


def marschner_lobb(n):
    """The signal of Marschner and Lobb 1994, fM = 6, alpha = 0.25, from 0 to 1."""
    x, y, z = axes(n, n, n)
    r = np.sqrt(x * x + y * y)
    rho = np.cos(2 * np.pi * 6 * np.cos(np.pi * r / 2))
    return (1 - np.sin(np.pi * z / 2) + 0.25 * (1 + rho)) / (2 * (1 + 0.25))


def labels(n):
    """Eight labelled octants (1..8) of a ball, 0 around it."""
    x, y, z = axes(n, n, n)
    inside = x**2 + y**2 + z**2 < 0.8
    return np.where(inside, 1 + (x > 0.1) + 2 * (y > -0.1) + 4 * (z > 0.05), 0)


# name: (samples [z][y][x], NRRD type, further header lines)
def figure_u8():
    return np.rint(figure(64, 64, 64)).astype(np.uint8), "uint8", "spacings: 1 1 1\n"


def figure_i16():
    """In Hounsfield-like numbers, on a grid of unequal spacing, in millimetres."""
    header = "space: right-anterior-superior\nspace directions: (1.5,0,0) (0,1.5,0) (0,0,3)\n"
    header += 'space units: "mm" "mm" "mm"\nspace origin: (-48,-48,-48)\n'
    return np.rint(figure(64, 64, 32) * 10 - 1000).astype("<i2"), "int16", header + "endian: little\n"


def figure_u16():
    return np.rint(figure(48, 48, 48) * 257).astype("<u2"), "uint16", "spacings: 1 1 1\nendian: little\n"


def figure_f32():
    """With a hole of NaN and a speck of infinity: both must not be seen."""
    value = (figure(48, 48, 48) / 255).astype("<f4")
    value[20:28, 4:16, 20:28] = np.nan
    value[40, 24, 8] = np.inf
    return value, "float", "spacings: 1 1 1\nendian: little\n"


def figure_sheared():
    """Axes that are neither orthogonal nor of equal length: a tilted gantry."""
    header = "space dimension: 3\nspace directions: (1,0,0) (0.2,1,0) (0,0.4,1.2)\nspace origin: (0,0,0)\n"
    return np.rint(figure(48, 48, 48)).astype(np.uint8), "uint8", header


def ml_f32():
    return marschner_lobb(41).astype("<f4"), "float", "spacings: 1 1 1\nendian: little\n"


def labels_u8():
    return labels(32).astype(np.uint8), "uint8", "spacings: 1 1 1\n"


def color_cube(n):
    """Red along x, green along y, blue along z, from 0 to 255."""
    x, y, z = (np.broadcast_to((a + 1) * 127.5, (n, n, n)) for a in axes(n, n, n))
    return np.stack([x, y, z], axis=-1)


def colors_rgba():
    """A soft ball of colours, with a hole at +x -y that is clear."""
    x, y, z = axes(48, 48, 48)
    alpha = ball(x, y, z, 0, 0, 0, 0.75, 0.1) * (1 - ball(x, y, z, 0.4, -0.55, 0.2, 0.3, 0.05))
    samples = np.concatenate([color_cube(48), (255 * alpha)[..., None]], axis=-1)
    return np.rint(samples).astype(np.uint8), "uint8", "kinds: RGBA-color space space space\nspacings: nan 1 1 1\n"


def colors_rgb():
    """The same colours, black outside of a ball: opacity by luminance."""
    x, y, z = axes(48, 48, 48)
    samples = color_cube(48) * ball(x, y, z, 0, 0, 0, 0.75, 0.1)[..., None]
    return np.rint(samples).astype(np.uint8), "uint8", "kinds: RGB-color space space space\nspacings: nan 1 1 1\n"


VOLUMES = {f.__name__: f for f in (figure_u8, figure_i16, figure_u16, figure_f32, figure_sheared, ml_f32, labels_u8, colors_rgba, colors_rgb)}


def globe():
    """Longitudes in hues, light north and dark south, with a grid of 30 degrees: (height, width, 3), 0 to 1."""
    v, u = (np.arange(90) + 0.5) / 90, (np.arange(180) + 0.5) / 180
    hue = 0.5 + 0.5 * np.cos(2 * np.pi * (u[None, :, None] - np.array([0, 1 / 3, 2 / 3])))
    color = 0.15 + 0.85 * hue * (1 - 0.7 * v[:, None, None])
    lines = (np.arange(90) % 15 == 0)[:, None] | (np.arange(180) % 15 == 0)[None, :]
    return np.where(lines[:, :, None], 1.0, color)


IMAGES = {f.__name__: f for f in (globe,)}


def ring():
    """A torus around the middle of figure_u8, leaning: (vertices, triangles)."""
    n, m = 96, 32
    u, v = (2 * np.pi * np.arange(k) / k for k in (n, m))
    u, v = u[:, None], v[None, :]
    radius = 26 + 4 * np.cos(v)
    x, y, z = radius * np.cos(u), radius * np.sin(u), 4 * np.sin(v) + 0 * u
    turn = np.radians(25)
    places = np.stack([x, y * np.cos(turn) - z * np.sin(turn), y * np.sin(turn) + z * np.cos(turn)], axis=-1) + 31.5
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b, c, d = (((i + di) % n) * m + (j + dj) % m for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)))
    return places.reshape(-1, 3), np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)


MESHES = {f.__name__: f for f in (ring,)}
SUFFIXES = {**dict.fromkeys(VOLUMES, ".nrrd"), **dict.fromkeys(IMAGES, ".png"), **dict.fromkeys(MESHES, ".obj")}


def write(path, name):
    if name in IMAGES:
        png.write(path, IMAGES[name]())
        return
    if name in MESHES:
        places, triangles = MESHES[name]()
        with open(path, "w", encoding="ascii") as file:
            file.writelines("v %.6f %.6f %.6f\n" % tuple(place) for place in places)
            file.writelines("f %d %d %d\n" % tuple(triangle + 1) for triangle in triangles)
        return
    samples, kind, header = VOLUMES[name]()
    sizes = " ".join(str(n) for n in samples.shape[::-1])
    with open(path, "wb") as file:
        file.write(f"NRRD0005\ntype: {kind}\ndimension: {samples.ndim}\nsizes: {sizes}\n{header}encoding: raw\n\n".encode())
        file.write(samples.tobytes())
