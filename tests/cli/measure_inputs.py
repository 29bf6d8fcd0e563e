"""Volumes and meshes whose measures are known."""
import numpy as np


def write(path, values, spacing=(1, 1, 1), unit="mm", origin=(0, 0, 0), steps=None):
    """Samples [z, y, x] as NRRD. steps: the world vectors from sample to sample, where the grid is turned."""
    directions = " ".join("(" + ",".join(repr(float(v)) for v in step) + ")" for step in (np.diag(spacing) if steps is None else steps))
    kinds = {"uint8": "uint8", "uint16": "uint16", "int16": "int16", "int8": "int8", "int32": "int32", "uint32": "uint32", "int64": "int64", "uint64": "uint64", "float32": "float", "float64": "double"}
    nz, ny, nx = values.shape
    header = (f"NRRD0004\ntype: {kinds[values.dtype.name]}\ndimension: 3\nspace: right-anterior-superior\n"
              f"sizes: {nx} {ny} {nz}\nspace directions: {directions}\n"
              f"space origin: ({origin[0]},{origin[1]},{origin[2]})\nspace units: \"{unit}\" \"{unit}\" \"{unit}\"\n"
              "encoding: raw\nendian: little\n\n")
    with open(path, "wb") as file:
        file.write(header.encode() + values.tobytes())


def distance_to(n, centre):
    z, y, x = np.meshgrid(*(np.arange(n),) * 3, indexing="ij")
    return np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)


def write_sphere(path="sphere.nrrd", n=64, radius=20.0, middle=(31.3, 32.1, 31.8), **options):
    write(path, (radius - distance_to(n, middle)).astype(np.float32), **options)


def noise(kind, shape=(19, 23, 29), seed=7):
    random = np.random.default_rng(seed)
    if kind.startswith("float"):
        return (random.normal(10, 3, shape)).astype(kind)
    info = np.iinfo(kind)
    return random.integers(max(info.min, -3000), min(info.max, 3000), shape).astype(kind)


def near(a, b, relative):
    assert abs(a - b) <= relative * abs(b), f"{a} is not within {relative} of {b}"


def write_box(path, at=0.0, size=2.0):
    """An STL with a box."""
    corners = [(at + size * (i & 1), at + size * (i >> 1 & 1), at + size * (i >> 2)) for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    with open(path, "w", encoding="ascii") as file:
        file.write("solid box\n")
        for a, b, c, d in faces:
            for triangle in ((a, b, c), (a, c, d)):
                file.write("facet normal 0 0 0\nouter loop\n")
                for corner in triangle:
                    file.write("vertex %g %g %g\n" % corners[corner])
                file.write("endloop\nendfacet\n")
        file.write("endsolid\n")
