#!/usr/bin/env python3
"""Golden images: render the cases of cases.json and compare them with the pictures that were looked at.

    run.py PROGRAM OUT [--update] [CASE]...

Compared as light (linear, premultiplied): the mean error, the 99th percentile of a pixel's largest error, and the
largest mean signed error of any 8 x 8 window, which sees a shift by a pixel that the others average away. A case that
fails leaves OUT/CASE.png: got, want and eight times the difference, enlarged. --update makes the picture of a case
what is rendered now; look at it before it is committed (tools/golden-update does both).
"""
import functools
import json
import os
import re
import shlex
import subprocess
import sys

import numpy as np

import png
import volumes

HERE = os.path.dirname(os.path.abspath(__file__))
WINDOW = 8
MOST_BYTES = 30000


def read_cases():
    with open(os.path.join(HERE, "cases.json"), encoding="utf-8") as file:
        document = json.load(file)
    for case in document["cases"]:
        case["limits"] = {**document["limits"], **case.get("limits", {})}
        if case["limits"] != document["limits"] and "reason" not in case:
            sys.exit(f"cases.json: case '{case['name']}' has limits of its own without a reason")
    return document["cases"]


@functools.lru_cache(None)
def data_file(out, name):
    """Made once in every run: one that an earlier run left may be of other formulas."""
    path = os.path.join(out, name + volumes.SUFFIXES[name])
    volumes.write(path, name)
    return path


def render(program, out, case):
    """Path of the picture; SystemExit with the program's words when it fails."""
    path = os.path.join(out, case["name"] + ".got.png")
    words = [re.sub(r"^@(\w+)|(?<==)@(\w+)", lambda m: data_file(out, m[1] or m[2]), word) for word in shlex.split(case["arguments"])]
    said = [] if case["name"] == "nothing_said" else ["--set", "views.main.camera.fit=data"]
    if case["name"] != "nothing_said" and not any(word in ("--spp", "--noise", "--quality") for word in words):
        said += ["--spp", "1"]
    command = [program, "render", *words, *said, "--size", "128x128", "-o", path, "--overwrite", "-q"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"exit {done.returncode}: {shlex.join(command)}\n{done.stdout}{done.stderr}")
    return path


def window_means(difference):
    """Mean of every WINDOW x WINDOW window, by running sums."""
    sums = np.zeros((difference.shape[0] + 1, difference.shape[1] + 1, difference.shape[2]))
    sums[1:, 1:] = difference.cumsum(0).cumsum(1)
    corners = sums[WINDOW:, WINDOW:] - sums[:-WINDOW, WINDOW:] - sums[WINDOW:, :-WINDOW] + sums[:-WINDOW, :-WINDOW]
    return corners / WINDOW**2


def errors(got, want):
    difference = png.linear(got) - png.linear(want)
    return {
        "mean": float(np.abs(difference).mean()),
        "p99": float(np.percentile(np.abs(difference).max(axis=2), 99)),
        "local": float(np.abs(window_means(difference)).max()),
    }


def enlarge(image, factor=4):
    return image.repeat(factor, axis=0).repeat(factor, axis=1)


def over_checks(stored):
    """Transparent parts over a checkerboard."""
    height, width, _ = stored.shape
    checks = 0.4 + 0.2 * ((np.arange(height)[:, None] // 8 + np.arange(width)[None, :] // 8) % 2)
    alpha = stored[:, :, 3:]
    return stored[:, :, :3] * alpha + checks[:, :, None] * (1 - alpha)


def show_difference(path, got, want):
    difference = 8 * np.abs(png.linear(got) - png.linear(want))[:, :, :3]
    png.write(path, enlarge(np.concatenate([over_checks(got), over_checks(want), difference], axis=1)))


def check(program, out, case):
    """None, or what is wrong."""
    golden = os.path.join(HERE, case["name"] + ".png")
    if not os.path.exists(golden):
        return f"there is no picture {golden}; make it with: tools/golden-update {case['name']}"
    try:
        got, want = png.read(render(program, out, case))[0], png.read(golden)[0]
    except (RuntimeError, ValueError) as error:
        return str(error)
    if got.shape != want.shape:
        return f"{got.shape[1]} x {got.shape[0]} pixels; the picture has {want.shape[1]} x {want.shape[0]}"
    found = errors(got, want)
    over = [f"{key} {found[key]:.6f} over {limit}" for key, limit in case["limits"].items() if found[key] > limit]
    if not over:
        return None
    shown = os.path.join(out, case["name"] + ".png")
    show_difference(shown, got, want)
    return f"{', '.join(over)}; got, want and difference: {shown}"


def update(program, out, case):
    with open(render(program, out, case), "rb") as file:
        data = png.bare(file.read())
    if len(data) > MOST_BYTES:
        sys.exit(f"{case['name']}: {len(data)} bytes; golden pictures have at most {MOST_BYTES}")
    with open(os.path.join(HERE, case["name"] + ".png"), "wb") as file:
        file.write(data)
    print(f"{case['name']}: {os.path.join(HERE, case['name'] + '.png')}; look at it before you commit it")


def main(program, out, *words):
    os.makedirs(out, exist_ok=True)
    names = [word for word in words if word != "--update"]
    cases = [case for case in read_cases() if not names or case["name"] in names]
    if len(cases) != len(names or cases):
        sys.exit("no such case: " + ", ".join(set(names) - {case["name"] for case in cases}))
    failures = 0
    for case in cases:
        if "--update" in words:
            update(program, out, case)
            continue
        wrong = check(program, out, case)
        failures += wrong is not None
        print(f"[  FAILED  ] {case['name']}\n{wrong}" if wrong else f"[       OK ] {case['name']}", flush=True)
    return 1 if failures or not cases else 0


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
