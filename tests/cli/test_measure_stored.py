"""Measurements that scenes keep: stored, loaded, asked again; what changed is told."""
import csv
import io
import json
import math
import numpy as np
import os
import shutil
from harness import fails, main, ok, says, volvis
from measure_inputs import distance_to, near, noise, write, write_box, write_sphere


def stored(scene):
    with open(scene, encoding="utf-8") as file:
        return json.load(file)["measurements"]


def figure(measurement, name):
    return next(f for f in measurement["figures"] if f["name"] == name)


def store_some(scene):
    """Of every kind one, with every sort of argument."""
    asked = {
        "half": ("area", "--iso", "0", "--clip", "x:5mm..12mm", "--clip", "plane(n=1,2,0 d=9)", "--box", ":,4:60,:"),
        "counted": ("volume", "--threshold", "1,9", "--method", "count"),
        "piece": ("volume", "--iso", "0", "--seed", "31,32,32"),
        "place": ("box", "--iso", "2"),
        "values": ("statistics",),
        "of_mask": ("statistics", "--mask", "mask.nrrd"),
        "bins": ("histogram", "--bins", "40", "--range", "-5,15"),
        "line": ("profile", "--point", "1,32,32", "--point", "60,32,32", "--samples", "80"),
        "far": ("distance", "--point", "1,2,3", "--point", "4,5,6", "--space", "world"),
        "corner": ("angle", "--point", "9,1,1", "--point", "1,1,1", "--point", "1,9,1"),
        "along": ("geodesic", "--iso", "0", "--point", "10,32,32", "--point", "32,60,32"),
        "outside": ("distance", "--iso", "0", "--point", "1,2,3"),
        "everything": (),
    }
    given = {}
    for name, words in asked.items():
        kind = words[:1]
        given[name] = ok("measure", *kind, "sphere.nrrd", *words[1:], "--store", f"{scene}:{name}", "--json").json
    return given


def small_sphere(**options):
    """For distances of two surfaces, which are asked from many places."""
    write_sphere(n=23, radius=9.0, middle=(10.3, 11.1, 10.8), **options)


def prepare():
    write_sphere(spacing=(0.5, 0.5, 0.5))
    write("mask.nrrd", (distance_to(64, (30, 30, 30)) < 9).astype(np.uint8), spacing=(0.5, 0.5, 0.5))


def test_what_is_stored_gives_the_same_again():
    prepare()
    given = store_some("study.vv.json")
    found = ok("measure", "study.vv.json", "--json").json
    assert found["measured"] == "stored" and found["n_changed"] == 0 and len(found["measurements"]) == len(given)
    for again in found["measurements"]:
        first = given[again["name"]]
        assert not again["changed"] and again["changes"] == [], again["name"]
        for key in ("area", "area_error", "volume", "mean", "distance", "angle", "geodesic", "profile", "histogram", "box_size", "median"):
            assert again.get(key) == first.get(key), (again["name"], key)
    says(ok("measure", "stored", "study.vv.json").text, "half: area, as before", "13 measured, 0 changed")


def test_the_scene_holds_arguments_and_figures():
    prepare()
    first = ok("measure", "area", "sphere.nrrd", "--iso", "0", "--clip", "x:5mm..", "--store", "study.vv.json", "--json").json
    assert first["stored_in"] == "study.vv.json" and first["stored_as"] == "area"
    kept = stored("study.vv.json")["area"]
    assert kept["what"] == "area" and kept["iso"] == 0 and "file" not in kept
    assert kept["cut_planes"] == [{"normal": [1, 0, 0], "offset": 5}]
    area = figure(kept, "area")
    assert area["value"] == first["area"] and area["error"] == first["area_error"] and area["unit"] == "mm^2"
    ok("measure", "volume", "study.vv.json", "--iso", "0", "--store", "whole")
    assert ok("measure", "area", "study.vv.json", "--store", "study.vv.json", "--json").json["stored_as"] == "area_2"
    assert set(stored("study.vv.json")) == {"area", "whole", "area_2"}
    near(figure(stored("study.vv.json")["whole"], "volume")["value"], 4 / 3 * math.pi * 1000, 0.004)


def test_a_way_along_a_surface_is_kept_with_its_path():
    """On the sphere all the way, in the space of its places, and as long as was measured."""
    prepare()
    middle = np.array([31.3, 32.1, 31.8])
    for space, scale in (("index", 1.0), ("world", 0.5)):
        words = sum((["--point", ",".join(str(v * scale) for v in p)] for p in ((10, 32, 32), (32, 60, 32))), [])
        ok("measure", "geodesic", "sphere.nrrd", "--iso", "0", "--space", space, *words, "--store", f"study.vv.json:{space}")
        way = figure(stored("study.vv.json")[space], "geodesic")
        path = np.array(way["path"]) / scale
        assert 8 <= len(path) <= 100
        assert np.all(np.abs(np.linalg.norm(path - middle, axis=1) - 20) < 0.1)
        for end, given in ((path[0], (10, 32, 32)), (path[-1], (32, 60, 32))):  # triangles lean by 1/20, 8 voxels away
            assert np.linalg.norm(end - (middle + 20 * (given - middle) / np.linalg.norm(given - middle))) < 0.4
        near(np.linalg.norm(np.diff(path, axis=0), axis=1).sum() * 0.5, way["value"], 2e-3)
    found = ok("measure", "study.vv.json", "--json").json
    assert found["n_changed"] == 0 and len(found["measurements"][0]["path"]) >= 20


def test_a_changed_volume_gives_new_figures_and_says_so():
    prepare()
    store_some("study.vv.json")
    write_sphere(radius=21.0, spacing=(0.5, 0.5, 0.5))
    result = volvis("measure", "study.vv.json", "--json")
    assert result.code == 6
    found = {m["name"]: m for m in result.json["measurements"]}
    assert not found["far"]["changed"] and not found["corner"]["changed"] and found["half"]["changed"]
    near(found["piece"]["volume"], 4 / 3 * math.pi * 10.5 ** 3, 0.004)
    change = next(c for c in found["piece"]["changes"] if c["name"] == "volume")
    near(change["was"], 4 / 3 * math.pi * 1000, 0.004)
    assert change["is"] == found["piece"]["volume"]
    text = volvis("measure", "stored", "study.vv.json", "piece", "far").text
    says(text, "piece: volume of sphere.nrrd, CHANGED", "it was", "far: distance of sphere.nrrd, as before", "2 measured, 1 changed")
    result = volvis("measure", "stored", "study.vv.json", "piece", "--csv")
    rows = list(csv.DictReader(io.StringIO(result.text)))
    assert result.code == 6 and rows[0]["measurement"] == "piece" and rows[0]["changed"] == "yes"
    assert float(rows[0]["value"]) == found["piece"]["volume"] and float(rows[0]["was"]) == change["was"]
    ok("measure", "stored", "study.vv.json", "--update")
    ok("measure", "study.vv.json")
    assert figure(stored("study.vv.json")["piece"], "volume")["value"] == found["piece"]["volume"]


def test_meshes_and_other_files_are_named_from_the_scene():
    small_sphere(spacing=(0.5, 0.5, 0.5))
    write_box("a.stl")
    write_box("b.stl", at=5.0)
    os.mkdir("sub")
    ok("measure", "distance", "a.stl", "b.stl", "--store", "sub/study.vv.json:apart")
    ok("measure", "volume", "a.stl", "--store", "sub/study.vv.json:box")
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--store", "sub/study.vv.json:ball")
    kept = stored("sub/study.vv.json")
    assert kept["apart"]["file"] == "../a.stl" and kept["apart"]["other"] == "../b.stl" and kept["ball"]["file"] == "../sphere.nrrd"
    near(figure(kept["apart"], "distance")["value"], 3 * math.sqrt(3), 1e-6)
    ok("measure", "distance", "sphere.nrrd", "sphere.nrrd", "--iso", "0", "--other-iso", "3", "--store", "sub/study.vv.json:shell")
    ok("measure", "sub/study.vv.json")
    write_box("b.stl", at=6.0)
    result = volvis("measure", "sub/study.vv.json", "--json")
    assert result.code == 6 and [m["name"] for m in result.json["measurements"] if m["changed"]] == ["apart"]


def test_what_is_read_or_stored_is_not_replaced_by_the_result():
    prepare()
    ok("measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:skull")
    with open("study.vv.json", "rb") as file:
        before = file.read()
    for more in ((), ("--overwrite",)):
        says(fails(2, "measure", "area", "study.vv.json", "--iso", "0", "-o", "study.vv.json", *more), "suffix of a scene")
    for more in ((), ("--overwrite",)):
        says(fails(2, "measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:b", "-o", "./study.vv.json", *more), "study.vv.json")
        says(fails(2, "measure", "stored", "study.vv.json", "--update", "-o", "study.vv.json", *more), "study.vv.json")
    says(fails(2, "measure", "area", "sphere.nrrd", "--iso", "0", "--store", "new.vv.json:b", "-o", "./new.vv.json"), "new.vv.json")
    with open("study.vv.json", "rb") as file:
        assert file.read() == before
    assert not os.path.exists("new.vv.json")
    ok("measure", "area", "study.vv.json", "--iso", "0", "-o", "other.json")
    os.rename("study.vv.json", "study.json")
    says(fails(2, "measure", "area", "study.json", "--iso", "0", "-o", "study.json"), "study.json")


def test_a_file_that_moved_is_given_its_new_place():
    small_sphere(spacing=(0.5, 0.5, 0.5))
    write_box("a.stl")
    write("mask.nrrd", np.ones((23, 23, 23), np.uint8), spacing=(0.5, 0.5, 0.5))
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:ball")
    ok("measure", "statistics", "study.vv.json", "--mask", "mask.nrrd", "--store", "masked")
    ok("measure", "volume", "a.stl", "--store", "study.vv.json:box")
    os.rename("a.stl", "b.stl")
    os.rename("mask.nrrd", "m.nrrd")
    result = volvis("measure", "stored", "study.vv.json")
    assert result.code == 7
    gone = "measurements.{}: was made from '{}', which is not there any more; give its new place by --set measurements.{}=FILE"
    says(result.text, gone.format("box", "a.stl", "box.file"), gone.format("masked", "mask.nrrd", "masked.mask"))
    moved = ("--set", "measurements.box.file=b.stl", "--set", "measurements.masked.mask=m.nrrd")
    again = ok("measure", "stored", "study.vv.json", *moved, "--json").json
    assert again["n_failed"] == 0 and again["n_changed"] == 0
    says(fails(3, "measure", "stored", "study.vv.json", "box"), "--set measurements.box.file=FILE")
    says(fails(2, "measure", "stored", "study.vv.json", "--set", "measurements.bxo.file=b.stl"), "bxo", "ball")


def test_an_update_keeps_the_new_place_of_what_moved():
    small_sphere(spacing=(0.5, 0.5, 0.5))
    write_box("a.stl")
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:ball")
    ok("measure", "volume", "a.stl", "--store", "study.vv.json:box")
    os.rename("sphere.nrrd", "moved.nrrd")
    os.rename("a.stl", "b.stl")
    assert volvis("measure", "study.vv.json", "--update").code == 7
    moved = ("--set", "datasets.sphere.path=moved.nrrd", "--set", "measurements.box.file=b.stl")
    ok("measure", "study.vv.json", "--update", *moved)
    says(ok("measure", "study.vv.json").text, "ball: volume, as before", "box: volume of b.stl, as before", "2 measured")
    with open("study.vv.json", encoding="utf-8") as file:
        assert json.load(file)["datasets"]["sphere"]["path"] == "moved.nrrd"


def test_names_in_scenes_are_shown_without_control_characters():
    small_sphere(spacing=(0.5, 0.5, 0.5))
    bad = "a\033[31mred\nx.nrrd"
    shutil.copy("sphere.nrrd", bad)
    write("mask.nrrd", np.ones((23, 23, 23), np.uint8), spacing=(0.5, 0.5, 0.5))
    ok("measure", "volume", bad, "--mask", bad, "--store", "study.vv.json:a")
    ok("measure", "labels", "mask.nrrd", "--values", bad, "--store", "study.vv.json:b")
    os.rename("study.vv.json", "s\033[31mt.vv.json")
    text = ok("measure", "stored", "s\033[31mt.vv.json").text
    assert "\033" not in text and "as before" in text, text
    assert all(line.startswith((" ", "s?", "a:", "b:", "2 measured")) for line in text.splitlines()), text


def test_samples_that_are_others_than_the_scenes_are_told():
    small_sphere(spacing=(0.5, 0.5, 0.5))
    ok("render", "sphere.nrrd", "-o", "a.png", "--size", "16x16", "--iso", "0", "--save-scene", "s.vv.json")
    assert "others now" not in ok("measure", "volume", "s.vv.json").message
    write_sphere(n=23, radius=8.0, middle=(10.3, 11.1, 10.8), spacing=(0.5, 0.5, 0.5))
    for name in ("a.png", "s.vv.json"):
        says(ok("measure", "volume", name).message, name, "was made from samples of crc32:", "those of 'sphere.nrrd' are others now")
        accepted = ok("measure", "volume", name, "--set", "datasets.sphere.checksum=null")
        assert "others now" not in accepted.message


def test_the_surface_that_a_scene_shows_is_the_object():
    prepare()
    for name in ("a.png", "s.vv.json"):
        ok("render", "sphere.nrrd", "-o", "a.png", "--size", "16x16", "--iso", "5", "--save-scene", "s.vv.json")
        found = ok("measure", "area", name, "--json").json
        assert found["threshold_lo"] == 5
        near(found["area"], ok("measure", "area", "sphere.nrrd", "--iso", "5", "--json").json["area"], 1e-12)
        says(ok("measure", "area", name).text, "values of 5 or more, as in the scene")
        assert ok("measure", "area", name, "--iso", "2", "--json").json["threshold_lo"] == 2
        assert ok("measure", "area", name, "--threshold", ",3", "--json").json["threshold_lo"] is None


def test_a_measurement_may_name_its_volume():
    write("low.nrrd", np.full((4, 5, 6), 3, np.uint8))
    write("high.nrrd", np.full((4, 5, 6), 8, np.uint8))
    place = {"what": "point", "points": [[1, 1, 1]]}
    ok("measure", "point", "low.nrrd", "--point", "1,1,1", "--store", "two.vv.json:first")
    with open("two.vv.json", encoding="utf-8") as file:
        scene = json.load(file)
    scene["datasets"]["high"] = {"path": "high.nrrd"}
    for volume in scene["volumes"].values():
        volume.setdefault("data", next(iter(scene["datasets"])))
    scene["volumes"]["high"] = {"data": "high"}
    scene["measurements"]["second"] = {**place, "volume": "high"}
    with open("two.vv.json", "w", encoding="utf-8") as file:
        json.dump(scene, file)
    found = ok("measure", "stored", "two.vv.json", "--json").json["measurements"]
    assert [one["value"] for one in found] == [3, 8]
    scene["measurements"]["second"]["volume"] = "none"
    with open("two.vv.json", "w", encoding="utf-8") as file:
        json.dump(scene, file)
    says(fails(2, "measure", "stored", "two.vv.json", "second"), "no volume 'none'")


def test_labels_are_compared_too():
    write("labels.nrrd", noise("uint8", seed=9) % 4)
    ok("measure", "labels", "labels.nrrd", "--store", "study.vv.json")
    ok("measure", "study.vv.json")
    write("labels.nrrd", noise("uint8", seed=10) % 4)
    result = volvis("measure", "study.vv.json", "--json")
    assert result.code == 6 and any(c["name"].startswith("label_2") for c in result.json["measurements"][0]["changes"])


def changes(scene):
    result = volvis("measure", "stored", scene, "--json")
    assert result.code == 6
    return {c["name"] for c in result.json["measurements"][0]["changes"]}


def test_every_figure_of_labels_is_compared_and_new_and_gone_ones_are_told():
    labels = np.zeros((8, 9, 10), np.uint8)
    labels[2:4, 2:4, 2:4] = 1
    values = np.arange(720, dtype=np.int16).reshape(8, 9, 10)
    write("labels.nrrd", labels)
    write("values.nrrd", values)
    ok("measure", "labels", "labels.nrrd", "--values", "values.nrrd", "--store", "study.vv.json:l")
    ok("measure", "study.vv.json")
    values[2, 2, 2] -= 50
    values[3, 3, 3] += 50
    write("values.nrrd", values)
    assert changes("study.vv.json") == {"label_1_deviation", "label_1_min", "label_1_max"}
    ok("measure", "stored", "study.vv.json", "--update")
    write("labels.nrrd", np.roll(labels, 1, axis=2))
    assert {"label_1_centroid_x", "label_1_box_lo_x", "label_1_box_hi_x"} <= changes("study.vv.json")
    labels[5, 5, 5] = 7
    write("labels.nrrd", labels)
    says(volvis("measure", "stored", "study.vv.json").text, "CHANGED", "label_7_count    1; new")
    ok("measure", "stored", "study.vv.json", "--update")
    write("labels.nrrd", labels * (labels != 7))
    says(volvis("measure", "stored", "study.vv.json").text, "label_7_count    gone; it was 1")


def test_tables_of_many_labels_and_joint_histograms_are_compared():
    labels = np.arange(8 * 9 * 10, dtype=np.uint16).reshape(8, 9, 10)
    write("labels.nrrd", labels)
    ok("measure", "labels", "labels.nrrd", "--store", "many.vv.json:l")
    assert figure(stored("many.vv.json")["l"], "labels")["value"] == 719
    ok("measure", "many.vv.json")
    labels[1, 1, 1], labels[2, 2, 2] = labels[2, 2, 2], labels[1, 1, 1]
    write("labels.nrrd", labels)
    assert changes("many.vv.json") == {"checksum"}
    values = np.random.default_rng(3).integers(0, 5, (6, 6, 6)).astype(np.uint8)
    write("values.nrrd", values)
    ok("measure", "joint", "values.nrrd", "--store", "joint.vv.json:j")
    ok("measure", "joint.vv.json")
    write("values.nrrd", (values + 1) % 5)
    assert "checksum" in changes("joint.vv.json")


def test_a_file_that_is_missing_leaves_the_other_measurements():
    prepare()
    write_box("a.stl")
    ok("measure", "volume", "a.stl", "--store", "study.vv.json:box")
    ok("measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:ball")
    os.remove("a.stl")
    result = volvis("measure", "study.vv.json")
    assert result.code == 7
    says(result.text, "box: volume, NOT MEASURED", "a.stl", "ball: area", "as before", "1 measured, 0 changed, 1 not measured")
    found = volvis("measure", "study.vv.json", "--json").json
    assert found["n_failed"] == 1 and "a.stl" in next(m for m in found["measurements"] if m["name"] == "box")["error"]
    says(volvis("measure", "stored", "study.vv.json", "--csv").text, "box,,,,,,failed")
    says(fails(3, "measure", "stored", "study.vv.json", "box"), "a.stl")


def test_a_scene_whose_own_volume_is_missing_names_every_measurement():
    prepare()
    ok("measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:ball")
    ok("measure", "volume", "study.vv.json", "--iso", "2", "--store", "room")
    os.remove("sphere.nrrd")
    result = volvis("measure", "study.vv.json")
    assert result.code == 7
    says(result.text, "ball: area, NOT MEASURED", "room: volume, NOT MEASURED", "sphere.nrrd", "0 measured, 0 changed, 2 not measured")
    found = volvis("measure", "study.vv.json", "--json").json
    assert found["n_failed"] == 2 and all("sphere.nrrd" in m["error"] for m in found["measurements"])
    write_box("a.stl")
    ok("measure", "volume", "a.stl", "--store", "study.vv.json:box")
    result = volvis("measure", "study.vv.json")
    assert result.code == 7
    says(result.text, "ball: area, NOT MEASURED", "box: volume of a.stl, as before")


def test_the_unit_of_a_mesh_is_stored():
    write_box("a.stl")
    ok("measure", "volume", "a.stl", "--input-unit", "0.5cm", "--store", "study.vv.json:box")
    assert stored("study.vv.json")["box"]["input_unit"] == "0.5cm"
    assert figure(stored("study.vv.json")["box"], "volume")["unit"] == "cm^3"
    says(ok("measure", "study.vv.json").text, "as before", "cm^3")


def test_a_measurement_of_something_else_is_not_replaced_unsaid():
    prepare()
    shutil.copy("sphere.nrrd", "other.nrrd")
    first = ("measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:a")
    ok(*first)
    assert "replaced" not in ok(*first).message
    says(ok("measure", "area", "other.nrrd", "--iso", "0", "--store", "study.vv.json:a").message, "measurements.a", "area of", "replaced")
    says(ok("measure", "volume", "other.nrrd", "--iso", "0", "--store", "study.vv.json:a").message, "area of other.nrrd", "replaced")


def test_names_may_follow_a_scene():
    prepare()
    ok("measure", "volume", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:big")
    ok("measure", "volume", "sphere.nrrd", "--iso", "9", "--store", "study.vv.json:pp")
    found = ok("measure", "study.vv.json", "pp", "--json").json
    assert [m["name"] for m in found["measurements"]] == ["pp"]


def test_wrong_words_about_scenes_are_told():
    prepare()
    says(fails(2, "measure", "area", "sphere.nrrd", "--store", "skull"), "not a scene", "study.vv.json:skull")
    says(fails(2, "measure", "area", "sphere.nrrd", "--store", "skull.nrrd:area"), "SCENE.vv.json")
    says(fails(2, "measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:a.b"), "--store")
    assert not os.path.exists("study.vv.json")
    says(fails(2, "measure", "stored", "sphere.nrrd"), "not a scene")
    ok("measure", "area", "sphere.nrrd", "--iso", "0", "--store", "study.vv.json:skull")
    says(fails(2, "measure", "stored", "study.vv.json", "skul"), "did you mean 'skull'")
    says(fails(2, "measure", "stored", "study.vv.json", "--iso", "3"), "--iso")
    says(fails(2, "measure", "area", "sphere.nrrd", "--update"), "--update")


def test_a_scene_without_measurements_is_measured_as_before():
    prepare()
    ok("render", "sphere.nrrd", "-o", "a.png", "--size", "16x16", "--save-scene", "plain.vv.json")
    assert ok("measure", "plain.vv.json", "--json").json["measured"] == "summary"
    says(fails(2, "measure", "stored", "plain.vv.json"), "no measurements")


def test_what_is_stored_is_told_listed_and_plotted_again():
    small_sphere()
    write("mask.nrrd", (distance_to(23, (10, 10, 10)) < 6).astype(np.uint8))
    ok("measure", "area", "sphere.nrrd", "--clip", "x:5mm..", "--store", "again.vv.json:chosen")
    ok("measure", "histogram", "sphere.nrrd", "--mask", "mask.nrrd", "--bins", "32", "--store", "again.vv.json:h")
    ok("measure", "distance", "sphere.nrrd", "sphere.nrrd", "--iso", "0", "--other-iso", "5", "--box", ":,:,:15", "--store",
       "again.vv.json:d")
    says(ok("measure", "stored", "again.vv.json").text, "(chosen: it best splits", "plane(n=1,0,0 d=5)", "where mask.nrrd is not 0",
         "values of 0 or more and values of 5 or more", "box of samples :,:,:15")
    assert ok("measure", "stored", "again.vv.json", "chosen", "--json").json["measurements"][0]["automatic"]
    says(ok("info", "again.vv.json").text, "chosen (area), h (histogram), d (distance)")
    found = ok("info", "again.vv.json", "--json").json["measurements"]
    assert [(m["name"], m["what"]) for m in found] == [("chosen", "area"), ("h", "histogram"), ("d", "distance")]
    ok("measure", "histogram", "sphere.nrrd", "--mask", "mask.nrrd", "--bins", "32", "--log", "-o", "first.svg")
    ok("measure", "stored", "again.vv.json", "h", "--log", "-o", "second.svg")
    with open("first.svg", encoding="utf-8") as first, open("second.svg", encoding="utf-8") as second:
        want, got = first.read(), second.read()
    curve = [line for line in want.splitlines() if "<poly" in line or "<path" in line]
    assert curve and all(line in got for line in curve)
    says(fails(2, "measure", "stored", "again.vv.json", "-o", "h.svg"), "one measurement", "3")
    says(fails(2, "measure", "stored", "again.vv.json", "d", "-o", "h.svg"), "distance has none")


main()
