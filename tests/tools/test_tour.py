"""The tour of `make run`, in small pictures of a small head: every command line works, and the page shows what they made.

usage: test_tour.py VOLVIS TOUR
"""
import gzip
import html.parser
import itertools
import os
import struct
import subprocess
import sys
import tempfile

SIZE, N, SPACING = 16, 24, 8.0


class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.images, self.rows = [], 0

    def handle_starttag(self, tag, attributes):
        if tag == "img":
            self.images.append(dict(attributes)["src"])
        self.rows += tag == "tr"


def write_nifti(path, value_of):
    """Bytes by distance from the middle, where the tour's head is: -90 to 90 mm, its middle 20 mm behind the origin."""
    middle = (N - 1) / 2
    samples = bytes(
        value_of(SPACING * ((x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2) ** 0.5, x)
        for z, y, x in itertools.product(range(N), repeat=3)
    )
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, N, N, N, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 2, 8)
    struct.pack_into("<8f", head, 76, 1, SPACING, SPACING, SPACING, 1, 1, 1, 1)
    struct.pack_into("<f", head, 108, 352)
    head[123] = 2  # mm
    struct.pack_into("<2h", head, 252, 0, 1)
    start = -SPACING * middle
    for row, offset in enumerate((start, start - 20, start)):
        struct.pack_into("<4f", head, 280 + 16 * row, *(SPACING * (a == row) for a in range(3)), offset)
    head[344:348] = b"n+1\0"
    with gzip.open(path, "wb") as file:
        file.write(bytes(head) + samples)


def write_head(folder):
    write_nifti(folder + "/ch2.nii.gz", lambda r, x: int(max(0, 130 - r)) if r < 85 else 0)
    write_nifti(folder + "/ch2bet.nii.gz", lambda r, x: int(max(0, 130 - r)) if r < 65 else 0)
    write_nifti(folder + "/aal.nii.gz", lambda r, x: 1 + (x > N / 2) if r < 60 else 0)


def size_of(path):
    with open(path, "rb") as file:
        return struct.unpack(">II", file.read(24)[16:])


def main(program, tour):
    with tempfile.TemporaryDirectory(prefix="volvis-tour-") as folder:
        out = folder + "/out"
        write_head(folder)
        made = subprocess.run([sys.executable, "-B", tour, program, out, f"{SIZE}x{SIZE}"], capture_output=True, text=True,
                              env=os.environ | {"VOLVIS_TOUR_DATA": folder})
        assert made.returncode == 0, made.stdout + made.stderr
        page = Page()
        with open(out + "/index.html", encoding="utf-8") as file:
            page.feed(file.read())
        files = set(os.listdir(out)) - {"index.html"}
        pictures = [name for name in files if name.endswith(".png")]
        assert len(pictures) > 20 and len(page.images) == len(files) and set(page.images) == files, set(page.images) ^ files
        assert all(size_of(f"{out}/{name}") == (SIZE, SIZE) for name in pictures)
        assert page.rows >= 8, "the table of figures is short"
        print(f"{len(pictures)} pictures, {page.rows - 1} figures")


if __name__ == "__main__":
    main(*sys.argv[1:])
