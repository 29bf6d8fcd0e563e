"""Recipes of docs/filters.md, run as they stand there, beside what other programs have found."""
import os
import re

from harness import Skip, main, ok

try:
    import nibabel as nib
except ImportError:
    nib = None

HEADS = "/usr/share/mricron/templates"
PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs/filters.md")


def lines_of(heading):
    with open(PAGE, encoding="utf-8") as file:
        section = file.read().split(f"## {heading}\n")[1].split("\n## ")[0]
    return re.findall(r"^volvis (.*)$", section, re.M)


def test_the_brain_comes_out_of_the_head():
    if nib is None or not os.path.exists(f"{HEADS}/ch2bet.nii.gz"):
        raise Skip("nibabel or mricron-data is missing: skipped")
    os.symlink(f"{HEADS}/ch2.nii.gz", "ch2.nii.gz")
    lines = lines_of("A recipe: the brain out of a head")
    for line in lines:
        ok(*line.split(), "-q")
    ours = nib.load(lines[-1].split()[3]).get_fdata() > 0
    theirs = nib.load(f"{HEADS}/ch2bet.nii.gz").get_fdata() > 0
    dice = 2 * (ours & theirs).sum() / (ours.sum() + theirs.sum())
    print(f"Dice {dice:.4f}")
    assert dice > 0.95, dice


main()
