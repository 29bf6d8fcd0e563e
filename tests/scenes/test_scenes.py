"""Every scene of scenes/ reads, is written back as the very bytes it has, and follows the schema that the library prints.

usage: test_scenes.py round_trip|schema TOOL FOLDER
"""
import copy
import glob
import json
import os
import subprocess
import sys


def run(tool, argument):
    done = subprocess.run([tool, argument], check=False, capture_output=True)
    if done.returncode:
        print(done.stderr.decode(), file=sys.stderr)
        sys.exit(done.returncode)
    return done.stdout


def round_trip(tool, scenes):
    for path in scenes:
        with open(path, "rb") as file:
            if run(tool, path) != file.read():
                sys.exit(f"{path}: read and written it has other bytes; the tool prints what it should be")


def wrong_ones(scene):
    """The scene with one thing wrong each time: the schema must refuse it."""
    for path, value in [
        (["titel"], "x"),
        (["schema"], 0),
        (["views", "main", "camera", "azimut"], 1),
        (["views", "main", "width"], 0),
        (["views", "main", "width"], 1.5),
        (["lights", "a.b"], {}),
        (["lights", "back"], {"kind": "bulb"}),
        (["lights", "back"], {"direction": [0, 1]}),
        (["background"], "#12345"),
        (["cut_planes"], {}),
    ]:
        wrong = copy.deepcopy(scene)
        place = wrong
        for name in path[:-1]:
            place = place.setdefault(name, {})
        place[path[-1]] = value
        yield ".".join(path), wrong


def schema(tool, scenes):
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        print("skipped: python3-jsonschema is not installed")
        sys.exit(77)
    rules = json.loads(run(tool, "--schema"))
    Draft202012Validator.check_schema(rules)
    validator = Draft202012Validator(rules)
    for path in scenes:
        with open(path, encoding="utf-8") as file:
            scene = json.load(file)
        for error in validator.iter_errors(scene):
            sys.exit(f"{path}: {error.json_path}: {error.message}")
        for what, wrong in wrong_ones(scene):
            if validator.is_valid(wrong):
                sys.exit(f"{path}: the schema lets a wrong {what} pass")


if __name__ == "__main__":
    found = sorted(glob.glob(os.path.join(sys.argv[3], "*.vv.json")))
    if not found:
        sys.exit(f"there is no scene in {sys.argv[3]}")
    {"round_trip": round_trip, "schema": schema}[sys.argv[1]](sys.argv[2], found)
