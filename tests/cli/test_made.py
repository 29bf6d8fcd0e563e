"""Data that are made of others: scenes carry the recipe, and pictures, results and measurements are those of files that the verbs write."""
import gzip
import json
import os

import numpy as np

from harness import fails, main, ok, says, volvis, write_labels, write_samples

RANDOM = np.random.default_rng(17)
CHAINS = (  # each as verbs, one by one; the last says what the picture is of
    ("gaussian --sigma 1.5",),
    ("crop --x 2:12 --z 3:",),
    ("gaussian --sigma 1", "threshold --range 90.."),
    ("threshold --range 120..", "components --connectivity 6"),
    ("median --radius 1", "isosurface --iso 100"),
    ("isosurface --iso 100", "simplify --share 0.4", "smooth --iterations 3"),
    ("rescale --type u8 --percentile 1..99", "flip --axes xz"),
)

# what an operation refuses to go without
REQUIRED = {"threshold": ("--range", "90.."), "crop": ("--x", "2:9"), "flip": ("--axes", "x"), "channel": ("--channel", "0"), "grow": ("--seed", "8,7,9"),
            "rescale": ("--type", "u8", "--percentile", "1..99"), "reorient": ("--order", "zyx"), "calc": ("a*2",), "distance": ("--iso", "90"),
            "gaussian": ("--sigma", "1"), "isosurface": ("--iso", "90"), "clamp": ("--range", "20..200")}


def write_blob(path="in.nrrd"):
    z, y, x = np.meshgrid(*(np.arange(n) for n in (13, 15, 17)), indexing="ij")
    values = 200 * np.exp(-((x - 8) ** 2 + (y - 7) ** 2 + (z - 6) ** 2) / 20) + RANDOM.normal(0, 4, x.shape)
    write_samples(path, (17, 15, 13), np.clip(values, 0, 255).astype("u1").tobytes(), spacing=(1, 1, 1.5))
    return values


def read(path):
    with open(path, "rb") as file:
        return file.read()


def by_verbs(chain, path="in.nrrd"):
    """The file that verbs write one by one."""
    for i, step in enumerate(chain):
        verb, *words = step.split()
        out = f"verb{i}" + (".ply" if verb in ("isosurface", "simplify", "smooth") else ".nrrd")
        ok(verb, path, *words, "-o", out, "--overwrite")
        path = out
    return path


def picture(word, *words):
    ok("render", word, *words, "--size", "60", "-o", "picture.pfm", "--overwrite")
    return read("picture.pfm")


def test_scenes_show_the_same_as_files_of_verbs():
    write_blob()
    for chain in CHAINS:
        truth = by_verbs(chain)
        wanted, whole = picture(truth), " | ".join(chain)
        ok("pipe", "in.nrrd", whole, "-o", "made.vv.json", "--overwrite")
        assert picture("made.vv.json") == wanted, chain
        assert picture("in.nrrd", "--apply", whole) == wanted, chain
        out = "piped" + os.path.splitext(truth)[1]
        ok("pipe", whole, "in.nrrd", "-o", out, "--overwrite")
        assert read(out) == read(truth), chain
        with open("made.vv.json") as file:
            made = json.load(file)["datasets"]
        assert len(made) == 1 + len(chain) and len(read("made.vv.json")) < 4000, chain


def test_every_operation_of_one_volume_makes_the_same():
    write_blob()
    ran = set()
    for row in ok("operations", "--json").json["operations"]:
        name, mesh = row["name"], row["makes"] == "mesh"
        if row["min_inputs"] != 1 or row["inputs"][0]["takes"] != "volume":
            continue
        words, out = REQUIRED.get(name, ()), "verb.ply" if mesh else "verb.nrrd"
        if volvis(name, "in.nrrd", *words, "-o", out, "--overwrite").code:
            continue
        chain = " ".join((name, *words))
        ok("pipe", "in.nrrd", chain, "-o", "one.vv.json", "--overwrite")
        if mesh:
            ok("pipe", "in.nrrd", chain, "-o", "made.ply", "--overwrite")
            assert read("made.ply") == read(out), name
        else:
            ok("convert", "one.vv.json", "-o", "made.nrrd", "--overwrite")
            assert read("made.nrrd") == read(out), name
        ran.add(name)
    assert len(ran) > 20 and {"gaussian", "crop", "threshold", "components", "isosurface"} <= ran, sorted(ran)


def test_a_grid_alone_is_taken_of_what_is_made():
    write_blob("in.nrrd")
    ok("crop", "in.nrrd", "--x", "3:", "-o", "c.nrrd")
    ok("resample", "in.nrrd", "onto=c.nrrd", "-o", "truth.nrrd")
    ok("pipe", "in.nrrd", "resample onto=c.nrrd", "-o", "made.vv.json")
    ok("convert", "made.vv.json", "-o", "made.nrrd")
    assert read("made.nrrd") == read("truth.nrrd")
    with open("made.vv.json") as file:
        scene = json.load(file)
    scene["datasets"]["c"] = {"operation": "crop", "inputs": {"volume": "in"}, "parameters": {"x": "3:"}}
    with open("all.vv.json", "w") as file:
        json.dump(scene, file)
    ok("convert", "all.vv.json", "-o", "all.nrrd")
    assert read("all.nrrd") == read("truth.nrrd")


def test_inputs_beside_the_chain_have_their_places():
    a = write_blob("a.nrrd")
    b = write_blob("b.nrrd")
    ok("gaussian", "a.nrrd", "--sigma", 1, "-o", "s.nrrd")
    ok("calc", "p - 0.5*q", "p=s.nrrd", "q=b.nrrd", "-o", "truth.nrrd")
    ok("calc", "a - 0.5*q", "s.nrrd", "q=b.nrrd", "-o", "also.nrrd")
    assert read("truth.nrrd") == read("also.nrrd")
    ok("pipe", "a.nrrd", "gaussian --sigma 1 | calc 'a - 0.5*q' q=b.nrrd", "-o", "one.nrrd")
    assert read("one.nrrd") == read("truth.nrrd")
    ok("pipe", "a.nrrd", "gaussian --sigma 1 | calc 'a - 0.5*q' q=b.nrrd", "-o", "two.vv.json")
    assert picture("two.vv.json") == picture("truth.nrrd")
    ok("calc", "a + b", "a.nrrd", "b.nrrd", "-o", "sum.nrrd")
    ok("pipe", "a.nrrd", "b.nrrd", "calc 'a + b'", "-o", "three.nrrd")
    assert read("three.nrrd") == read("sum.nrrd")
    ok("isosurface", "s.nrrd", "b.nrrd", "--iso", 100, "-o", "truth.ply")
    ok("pipe", "a.nrrd", "gaussian --sigma 1 | isosurface values=b.nrrd --iso 100", "-o", "one.ply")
    assert read("one.ply") == read("truth.ply")
    assert a.shape == b.shape


def test_a_parameter_is_a_path():
    write_blob()
    ok("pipe", "in.nrrd", "gaussian --sigma 1 | threshold --range 90..", "-o", "made.vv.json")
    for setting, chain in (("gaussian.parameters.sigma=2vox", ("gaussian --sigma 2", "threshold --range 90..")),
                           ("threshold.parameters.range=120..200", ("gaussian --sigma 1", "threshold --range 120..200")),
                           ("threshold.inputs.volume=in", ("threshold --range 90..",))):
        assert picture("made.vv.json", "--set", "datasets." + setting) == picture(by_verbs(chain)), setting
    for setting, code, words in (("gaussian.parameters.sgma=2", 2, ("datasets.gaussian.parameters.sgma", "did you mean 'sigma'?")),
                                 ("gaussian.parameters.sigma=2s", 2, ("datasets.gaussian.parameters.sigma", "'2s'")),
                                 ("gaussian.operation=gausian", 2, ("datasets.gaussian.operation", "did you mean 'gaussian'?")),
                                 ("gaussian.inputs.volume=inn", 2, ("datasets.gaussian.inputs.volume", "did you mean 'in'?")),
                                 ("gaussian.inputs.volume=threshold", 2, ("datasets.threshold.inputs", "made of itself (threshold -> gaussian -> threshold)"))):
        says(fails(code, "render", "made.vv.json", "--set", "datasets." + setting, "-o", "x.png"), *words)
    assert not os.path.exists("x.png")


def test_steps_are_switched_off():
    write_blob()
    chain = ("median --radius 1", "gaussian --sigma 2", "threshold --range 90..")
    ok("pipe", "in.nrrd", " | ".join(chain), "-o", "made.vv.json")
    names = [step.split()[0] for step in chain]
    for off in (("gaussian",), ("median",), ("threshold",), ("median", "gaussian"), ("gaussian", "threshold"), tuple(names)):
        left = [step for step in chain if step.split()[0] not in off]
        words = [word for name in off for word in ("--set", f"datasets.{name}.on=false")]
        ok("render", "made.vv.json", *words, "--size", "60", "-o", "off.pfm", "--save-scene", "off.vv.json", "--overwrite")
        truth = by_verbs(left) if left else "in.nrrd"
        # the look is that of the file that the chain made
        ok("convert", "off.vv.json", "-o", "off.nrrd", "--overwrite")
        ok("convert", truth, "-o", "truth.nrrd", "--overwrite")
        assert read("off.nrrd") == read("truth.nrrd"), off
        ok("render", "off.vv.json", "--set", f"volumes.threshold.data=x", "--set", f"datasets.x={{\"path\": \"{truth}\"}}", "--size", "60", "-o",
           "truth.pfm", "--overwrite")
        assert read("off.pfm") == read("truth.pfm"), off
    says(ok("info", "off.vv.json").text, "gaussian of median: sigma 2 (off)")
    ok("pipe", "in.nrrd", "isosurface --iso 100 | smooth --iterations 3", "-o", "mesh.vv.json")
    assert picture("mesh.vv.json", "--set", "datasets.smooth.on=false") == picture(by_verbs(("isosurface --iso 100",)))
    for scene, setting, words in (("mesh.vv.json", "isosurface.on=false", ("datasets.isosurface.on", "makes a mesh, and 'in' is a volume")),
                                  ("made.vv.json", "in.on=false", ("datasets.in.on", "a file cannot be switched off"))):
        says(fails(2, "render", scene, "--set", "datasets." + setting, "-o", "x.png"), *words)
    ring = ("--set", "datasets.median.inputs.volume=gaussian", "--set", "datasets.median.on=false", "--set", "datasets.gaussian.on=false")
    says(fails(2, "render", "made.vv.json", *ring, "-o", "x.png"), "made of itself (gaussian -> median -> gaussian)")


def test_verbs_take_what_is_made_as_they_take_files():
    write_blob()
    ok("gaussian", "in.nrrd", "--sigma", 1, "-o", "s.nrrd")
    ok("pipe", "in.nrrd", "gaussian --sigma 1", "-o", "s.vv.json")
    for words in (("median", "--radius", 1), ("convert",), ("threshold", "--range", "90..")):
        ok(words[0], "s.nrrd", *words[1:], "-o", "file.nrrd", "--overwrite")
        ok(words[0], "s.vv.json", *words[1:], "-o", "made.nrrd", "--overwrite")
        assert read("file.nrrd") == read("made.nrrd"), words
    by_file, by_scene = (ok("measure", word, "--iso", 100, "--json").json for word in ("s.nrrd", "s.vv.json"))
    assert by_file["volume"] == by_scene["volume"] and by_file["area"] == by_scene["area"]
    ok("isosurface", "s.nrrd", "--iso", 90, "-o", "a.ply")
    ok("isosurface", "s.vv.json", "--iso", 90, "-o", "b.ply")
    assert np.frombuffer(read("a.ply")[-400:], "u1").tolist() == np.frombuffer(read("b.ply")[-400:], "u1").tolist()
    says(fails(2, "median", "s.vv.json", "-o", "in.nrrd"), "in.nrrd")


def test_info_lists_recipes():
    write_blob()
    ok("pipe", "in.nrrd", "gaussian --sigma 1 | threshold --range 90..", "-o", "made.vv.json")
    made = ok("info", "made.vv.json", "--json").json["made"]
    assert made == [{"name": "gaussian", "operation": "gaussian", "inputs": {"volume": "in"}, "parameters": {"sigma": 1}},
                    {"name": "threshold", "operation": "threshold", "inputs": {"volume": "gaussian"}, "parameters": {"range": "90.."}}], made
    says(ok("info", "made.vv.json").text, "gaussian of in: sigma 1", "threshold of gaussian: range 90..")


def test_lengths_keep_their_units():
    """As they were written, so that a file in another unit that takes the place of the first is smoothed by the same length."""
    values = RANDOM.integers(0, 255, (9, 10, 11)).astype("u1").tobytes()
    write_samples("mmv.nrrd", (11, 10, 9), values)
    write_samples("umv.nrrd", (11, 10, 9), values, spacing=(1000, 1000, 1000), unit="um")
    ok("gaussian", "umv.nrrd", "--sigma", "2mm", "-o", "truth.nrrd")
    ok("pipe", "mmv.nrrd", "gaussian --sigma 2mm", "-o", "u.vv.json")
    ok("render", "mmv.nrrd", "--apply", "gaussian --sigma 2mm", "--size", 40, "-o", "a.png", "--save-scene", "applied.vv.json")
    for scene in ("u.vv.json", "applied.vv.json"):
        with open(scene, encoding="utf-8") as file:
            world = json.load(file)
        assert world["datasets"]["gaussian"]["parameters"] == {"sigma": "2mm"}, world
        world["datasets"]["mmv"] = {"path": "umv.nrrd"}
        with open("other.vv.json", "w", encoding="utf-8") as file:
            json.dump(world, file)
        ok("convert", "other.vv.json", "-o", "got.nrrd", "--overwrite")
        assert read("got.nrrd").split(b"\n\n", 1)[1] == read("truth.nrrd").split(b"\n\n", 1)[1], scene
    for typed, kept in (("--sigma 2mm --sigma 3", 3), ("--sigma 3 --sigma 1.5vox", "1.5vox"), ("--sigma 2", 2)):
        ok("pipe", "mmv.nrrd", f"gaussian {typed}", "-o", "u.vv.json", "--overwrite")
        made = ok("info", "u.vv.json", "--json").json["made"][0]
        assert made["parameters"] == {"sigma": kept}, made


def test_labels_keep_their_names_and_time_steps_their_number():
    write_labels("labels.seg.nrrd")
    ok("crop", "labels.seg.nrrd", "--x", "1:", "-o", "cropped.nrrd")
    ok("pipe", "labels.seg.nrrd", "crop --x 1:", "-o", "cropped.vv.json")
    assert picture("cropped.nrrd") == picture("cropped.vv.json")
    ok("isosurface", "cropped.nrrd", "-o", "truth.ply")
    ok("pipe", "labels.seg.nrrd", "crop --x 1: | isosurface", "-o", "made.ply")
    assert read("truth.ply") == read("made.ply")
    series = RANDOM.integers(0, 99, (3, 7, 8, 9)).astype("u1")
    with open("series.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 9 8 7 3\nkinds: domain domain domain time\nencoding: raw\n\n" + series.tobytes())
    chain = "gaussian --sigma 1 | rescale --type u8 --percentile 0..100"
    ok("gaussian", "series.nrrd", "--sigma", 1, "-o", "g.nrrd")
    ok("rescale", "g.nrrd", "--type", "u8", "--percentile", "0..100", "-o", "truth.nrrd")
    ok("pipe", "series.nrrd", chain, "-o", "piped.nrrd")
    assert read("piped.nrrd") == read("truth.nrrd")
    ok("pipe", "series.nrrd", chain, "-o", "series.vv.json")
    for t in range(3):
        assert picture("series.vv.json", "--frame", t) == picture("truth.nrrd", "--frame", t), t


def test_a_scene_keeps_its_look_when_a_chain_is_applied():
    write_blob()
    ok("render", "in.nrrd", "--iso", 100, "--size", 60, "-o", "a.png", "--save-scene", "look.vv.json")
    ok("gaussian", "in.nrrd", "--sigma", 2, "-o", "s.nrrd")
    ok("render", "look.vv.json", "--apply", "gaussian --sigma 2", "--save-scene", "made.vv.json", "-o", "made.pfm")
    ok("render", "look.vv.json", "--set", "datasets.in.path=s.nrrd", "--set", "datasets.in.checksum=null", "-o", "truth.pfm")
    assert read("made.pfm") == read("truth.pfm")
    with open("made.vv.json") as file:
        datasets = json.load(file)["datasets"]
    assert datasets["gaussian"]["operation"] == "gaussian" and "path" not in datasets["gaussian"]


def test_a_chain_in_little_memory_gives_the_same_bytes():
    np.save("big.npy", RANDOM.integers(0, 60000, (2000, 64, 64)).astype("u2"))
    ok("convert", "big.npy", "-o", "big.nrrd", "--encoding", "gzip", "--level", 1)  # 16 MB that cannot be mapped
    chain = "gaussian --sigma 1 | flip --axes x | crop --z 100:1900"
    ok("pipe", "big.nrrd", chain, "-o", "whole.nrrd")
    ok("pipe", "big.nrrd", chain, "-o", "parts.nrrd", "--memory", "4M", "--threads", 2)
    assert read("whole.nrrd") == read("parts.nrrd")


def write_vectors(path, samples):
    """Time steps, each z, y, x, component; packed, so that nothing can be mapped."""
    t, z, y, x, c = samples.shape
    header = (f"NRRD0004\ntype: float\ndimension: 5\nsizes: {c} {x} {y} {z} {t}\nkinds: vector space space space time\n"
              "encoding: gzip\nendian: little\n\n")
    with open(path, "wb") as file:
        file.write(header.encode() + gzip.compress(samples.astype("<f4").tobytes(), 1))


def test_a_chain_with_further_inputs_streams():
    samples = np.cumsum(RANDOM.integers(-2, 3, (2, 768, 64, 32, 2)), 1) % 251
    write_vectors("big.nrrd", samples)  # four times the memory
    write_vectors("other.nrrd", samples[1:, ..., ::-1])  # goes with both time steps
    write_samples("mask.nrrd", (32, 64, 768), (RANDOM.random((768, 64, 32)) > 0.3).astype("u1").tobytes())
    chain = "gaussian --sigma 1 | mask mask=mask.nrrd | mean --radius 1vox | calc 'a - 0.5*b' b=other.nrrd | rescale --percentile 1..99 --type u8"
    whole = ok("pipe", "big.nrrd", chain, "-o", "whole.nrrd", "--json").json
    parts = ok("pipe", "big.nrrd", chain, "-o", "parts.nrrd", "--memory", "6M", "--threads", 2, "--json").json
    assert (whole["streamed"], parts["streamed"], parts["frames"], parts["components"]) == (False, True, 2, 2)
    assert parts["peak_bytes"] <= 6 << 20 and read("whole.nrrd") == read("parts.nrrd")
    ok("pipe", "big.nrrd", chain + " | resample --size 16,32,64", "-o", "small.vv.json")  # made data: on the way nothing is held
    ok("convert", "small.vv.json", "--frame", 1, "-o", "made.nrrd", "--memory", "12M")
    ok("resample", "whole.nrrd@1", "--size", "16,32,64", "-o", "truth.nrrd")
    assert read("made.nrrd") == read("truth.nrrd")


def test_series_go_step_by_step_and_one_volume_with_all():
    write_blob("one.nrrd")
    for i in range(3):
        ok("calc", f"a*{i + 1}", "one.nrrd", "-o", f"s{i}.nrrd")
        ok("calc", f"a + {i}", "one.nrrd", "-o", f"t{i}.nrrd")
    for name in "st":
        ok("join", *(f"{name}{i}.nrrd" for i in range(3)), "-o", name + ".nrrd")
    for first, other, pairs in (("s", "t", ("s%d", "t%d")), ("s", "one", ("s%d", "one")), ("one", "t", ("one", "t%d")), ("s@2", "t", ("s2", "t2"))):
        frames = (2,) if "@" in first else range(3)
        for i in frames:
            a, b = (name % i if "%" in name else name for name in pairs)
            ok("calc", "a - b", f"{a}.nrrd", f"{b}.nrrd", "-o", f"r{i}.nrrd", "--overwrite")
        ok(*(("join",) + tuple(f"r{i}.nrrd" for i in frames) if len(frames) > 1 else ("convert", "r2.nrrd")), "-o", "truth.nrrd", "--overwrite")
        words = (first.replace("s", "s.nrrd") if first != "one" else "one.nrrd", f"b={other}.nrrd")
        ok("calc", "a - b", *words, "-o", "verb.nrrd", "--overwrite")
        ok("pipe", words[0], f"calc 'a - b' {words[1]}", "-o", "pipe.nrrd", "--overwrite")
        ok("pipe", words[0], f"calc 'a - b' {words[1]}", "-o", "made.vv.json", "--overwrite")
        for i in frames:
            ok("convert", "made.vv.json", "--frame", i, "-o", "made.nrrd", "--overwrite")
            assert read("made.nrrd") == read(f"r{i}.nrrd"), (first, other, i)
        for path in ("verb.nrrd", "pipe.nrrd"):
            assert read(path)[-len(read("truth.nrrd")) // 2:] == read("truth.nrrd")[-len(read("truth.nrrd")) // 2:], (first, other, path)
            assert ok("info", path, "--json").json["frames"] == len(frames), path
    ok("join", "s0.nrrd", "s1.nrrd", "-o", "two.nrrd")
    says(fails(2, "calc", "a - b", "s.nrrd", "b=two.nrrd", "-o", "x.nrrd"), "two.nrrd", "has 2 time steps but s.nrrd has 3")
    says(fails(2, "pipe", "s.nrrd", "calc 'a - b' b=two.nrrd", "-o", "x.nrrd"), "step 1 of the chain", "'two' has 2 time steps but 's' has 3")
    says(fails(2, "calc", "a - b", "s.nrrd@2", "b=two.nrrd", "-o", "x.nrrd"), "two.nrrd", "number 2")


def test_what_samples_decide_is_worked_out_and_told_once():
    write_blob()
    ok("median", "in.nrrd", "-o", "m.nrrd")
    truth = ok("threshold", "m.nrrd", "--method", "otsu", "-o", "t.nrrd", "--json").json["thresholds"]
    again = ok("pipe", "in.nrrd", "median | threshold --method otsu", "-o", "y.nrrd", "--json").json["thresholds"]
    assert truth == again
    np.save("big.npy", RANDOM.integers(0, 60000, (2000, 64, 64)).astype("u2"))
    ok("convert", "big.npy", "-o", "big.nrrd", "--encoding", "gzip", "--level", 1)
    told = ok("pipe", "big.nrrd", "clamp --range 5.. | threshold --method multi-otsu --classes 3", "-o", "z.nrrd", "--memory", "8M")
    assert told.text.count("1 above") == 1 and "streamed" in told.text, told.text


def test_what_is_wrong_in_a_chain_is_said_with_its_step():
    write_blob()
    for chain, words in (("gausian --sigma 1", ("step 1", "did you mean 'gaussian'")), ("gaussian | trheshold --range 1..", ("step 2", "threshold")),
                         ("gaussian --sgima 1", ("step 1 of the chain, gaussian", "--sigma")), ("calc '-a'", ("step 1 of the chain, calc", "write '0-a'")), ("gaussian |", ("step 2", "operation is missing")),
                         ("gaussian 'x", ("quotation mark",)), ("gaussian --threads 2", ("--threads", "outside of the chain")),
                         ("isosurface --iso 9 | median", ("step 2 of the chain, median", "takes a volume")),
                         ("gaussian --sigma 1 | calc a+b b=none.nrrd", ("step 2 of the chain, calc", "none.nrrd")),
                         ("calc", ("step 1 of the chain, calc", "formula is missing")), ("median | calc", ("step 2", "formula is missing")),
                         ("calc a-b b=in.nrrd@0", ("in.nrrd", "@0", "further input")), ("calc a a=in.nrrd", ("called 'a'", "other names")),
                         ("gaussian in.nrrd", ("takes 1 input at most, there are 2",))):
        done = volvis("pipe", "in.nrrd", chain, "-o", "x.nrrd")
        assert done.code in (2, 3) and done.message.count("\n") == 1, (chain, done.code, done.message)
        says(done.message, *words)
    says(fails(2, "pipe", "in.nrrd", "in.nrrd", "-o", "x.nrrd"), "no word is a chain")
    says(fails(2, "pipe", "in.nrrd", "gausian", "-o", "x.nrrd"), "did you mean 'gaussian'")
    says(fails(2, "pipe", "in.nrrd", "gaussian", "-o", "x.ply"), "x.ply")
    says(fails(2, "pipe", "in.nrrd", "isosurface", "-o", "x.nrrd"), "x.nrrd")
    says(fails(2, "pipe", "-", "gaussian", "-o", "x.vv.json", stdin=read("in.nrrd")), "standard input")
    ok("pipe", "-", "gaussian", "-o", "piped.nrrd", stdin=read("in.nrrd"))
    ok("gaussian", "in.nrrd", "-o", "truth.nrrd")
    assert read("piped.nrrd") == read("truth.nrrd")
    assert not os.path.exists("x.nrrd") and not os.path.exists("x.vv.json")


main()
