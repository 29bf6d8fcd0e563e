"""The file of defaults: options that hold where the command line says nothing else."""
import os
from harness import fails, main, ok, png_pixels, says, volvis, write_ball, write_box, write_labels

HERE = {"VOLVIS_DEFAULTS": "defaults"}


def write(text, path="defaults"):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def picture(*words, env=None):
    ok("render", *words, "-o", "a.png", env=env)
    return png_pixels("a.png")


def test_options_of_the_file_hold_unless_the_command_line_has_others():
    write_ball("a.nrrd", 16)
    write("# mine\n\n--threads 1\nrender --size 40x30 --background '#ff0000' --quiet\ngaussian --sigma 3vox\n")
    assert picture("a.nrrd", env=HERE) == picture("a.nrrd", "--size", "40x30", "--background", "#ff0000")
    assert picture("a.nrrd", "--size", "20", env=HERE) == picture("a.nrrd", "--size", "20", "--background", "#ff0000")
    assert picture("a.nrrd", "--size", "20", "--no-defaults", env=HERE) == picture("a.nrrd", "--size", "20")
    assert ok("render", "a.nrrd", "-o", "b.png", env=HERE).text == ""  # quiet
    assert ok("render", "a.nrrd", "-o", "b.png", "--no-quiet", "--json", env=HERE).json["threads"] == 1
    ok("gaussian", "a.nrrd", "-o", "b.nrrd", env=HERE)
    ok("gaussian", "a.nrrd", "-o", "c.nrrd", "--sigma", "3vox")
    assert ok("compare", "b.nrrd", "c.nrrd", "--json").json["identical"]


def test_set_adds_to_that_of_the_file():
    write_ball("a.nrrd", 16)
    write("render --size 40 --set lights.key.intensity=2 --set background=#00ff00\n")
    one = picture("a.nrrd", "--set", "background=#0000ff", env=HERE)
    assert one == picture("a.nrrd", "--size", "40", "--set", "lights.key.intensity=2", "--set", "background=#0000ff")


def test_a_picture_is_repeated_as_it_was_made():
    write_ball("a.nrrd", 16)
    before = picture("a.nrrd", "--size", "50")
    write("render --size 40 --background red --set lights.key.intensity=3\n")
    ok("render", "a.png", "-o", "again.png", env=HERE)
    assert png_pixels("again.png") == before
    made = picture("a.nrrd", env=HERE)  # what the file says is in the picture
    ok("render", "a.png", "-o", "again.png")
    assert png_pixels("again.png") == made != before


def test_the_usual_places():
    write_ball("a.nrrd", 16)
    os.makedirs("home/.config/volvis")
    os.makedirs("config/volvis")
    write("render --size 30\n", "home/.config/volvis/defaults")
    write("render --size 20\n", "config/volvis/defaults")
    for env, size in (({"HOME": os.path.abspath("home")}, 30), ({"XDG_CONFIG_HOME": os.path.abspath("config")}, 20),
                      ({"XDG_CONFIG_HOME": os.path.abspath("empty")}, 800)):
        env = {"XDG_CONFIG_HOME": "", "VOLVIS_DEFAULTS": "", **env}
        assert ok("render", "a.nrrd", "-o", "a.png", "--json", env=env).json["width"] == size, env
    said = ok("render", "a.nrrd", "-o", "a.png", "-v", env=env | {"XDG_CONFIG_HOME": os.path.abspath("config")}).message
    says(said, "config/volvis/defaults adds --size 20", "--no-defaults")


def test_what_does_not_fit_is_left_out():
    """Each command makes what it makes without the file, and -v says why."""
    write_ball("a.nrrd", 16)
    write_labels("s.seg.nrrd")
    write_box("c.ply")
    for text, words, left in (
            ("render --mode mip", ("a.nrrd", "--slice", "axial"), "--mode mip"),
            ("render --mode mip", ("a.nrrd", "--iso", 30), "--mode mip"),
            ("render --mode mip", ("a.nrrd", "--threshold", "30.."), "--mode mip"),
            ("render --mode mip", ("c.ply",), "--mode mip"),
            ("render --mode mip\nrender --tf hot", ("a.nrrd", "--iso", 30), "--tf hot"),
            ("render --slice axial --window 3..9", ("a.nrrd", "--iso", 30), "--window 3..9"),
            ("render --iso 30", ("a.nrrd", "--tf", "hot"), "--iso 30"),
            ("render --iso 30", ("c.ply",), "--iso 30"),
            ("render --tf hot --opacity 0.5", ("a.nrrd", "--threshold", "30.."), "--tf hot"),
            ("render --percentile 3..95", ("a.nrrd", "--range", "0..100"), "--percentile 3..95"),
            ("render --percentile 3..95", ("c.ply",), "--percentile 3..95"),
            ("render --fov 30deg", ("a.nrrd", "--parallel", 20), "--fov 30deg"),
            ("render --tf other=hot", ("a.nrrd",), "--tf other=hot")):
        write(text + "\n")
        said = ok("render", *words, "-o", "a.png", "--overwrite", "--size", 20, "-v", env=HERE).message
        says(said, f"defaults:{text.count(chr(10)) + 1}: {left} is left out: ")
        with_file = png_pixels("a.png")
        assert ok("render", *words, "-o", "a.png", "--overwrite", "--size", 20, env=HERE).message == ""
        assert png_pixels("a.png") == with_file == picture(*words, "--size", 20), words
    write("render --mode mip\n")
    with open("a.nrrd", "rb") as file:  # what comes from standard input is not asked for twice
        ok("render", "-", "-o", "a.png", "--overwrite", "--iso", 30, "--size", 20, stdin=file.read(), env=HERE)
    write("convert --type f32 --encoding gzip\nisosurface --iso 30\nmeasure --threshold 9..\nrender --bits 16 --aov depth\n")
    for words in (("convert", "c.ply", "-o", "o.ply"), ("convert", "s.seg.nrrd", "-o", "o.seg.nrrd"),
                  ("convert", "a.nrrd", "-o", "o.npy"), ("convert", "a.nrrd", "-o", "o.nrrd", "--stored"),
                  ("isosurface", "s.seg.nrrd", "-o", "o.ply", "--label", 7), ("measure", "volume", "a.nrrd", "--iso", 30),
                  ("measure", "area", "c.ply"), ("render", "a.nrrd", "-o", "o.jpg", "--size", 20),
                  ("render", "a.nrrd", "-o", "o.svg", "--size", 20)):
        ok(*words, "--overwrite", env=HERE)
    for words in (("render", "a.nrrd", "--iso", 30, "--mode", "mip"), ("render", "a.nrrd", "--range", "0..9", "--percentile", "1..2")):
        fails(2, *words, "-o", "b.png", "--no-defaults")  # what is typed is refused as before


def test_mistakes_name_the_line():
    write_ball("a.nrrd", 16)
    for text, parts in (("render --sise 3", ("defaults:2: ", "did you mean --size?")),
                        ("rendr --size 3", ("defaults:2: ", "did you mean")),
                        ("render --size '3", ("defaults:2: ", "quote")),
                        ("render " + "--threads 1 " * 150, ("defaults:2: ", "at most 256 words")),
                        ("render a.nrrd", ("defaults:2: ", "found 'a.nrrd'")),
                        ("render -o x.png", ("defaults:2: ", "--output cannot be a default")),
                        ("--threads many", ("defaults:2: --threads: ", "'many'")),
                        ("render --bits 99", ("defaults:2: --bits: ",))):
        write("# first\n" + text + "\n")
        result = volvis("render", "a.nrrd", "-o", "a.png", env=HERE)
        assert result.code == 2, text
        says(result.message, *parts)
        ok("render", "--help", env=HERE)
        ok("help", env=HERE)
    write("gaussian --sigmma 3\n")
    ok("render", "a.nrrd", "-o", "a.png", "--size", 20, env=HERE)  # another verb's
    says(" ".join(ok("doctor", env=HERE).text.split()), "WRONG: defaults:1: gaussian has no option --sigmma; did you mean --sigma?")
    write("render --range 9..100\n")
    says(volvis("render", "a.nrrd", "-o", "a.png", "--size", "twelve", env=HERE).message,
         "defaults adds --range 9..100; --no-defaults leaves it out")
    says(ok("doctor", env=HERE).text, "from defaults")
    says(fails(3, "info", "a.nrrd", env={"VOLVIS_DEFAULTS": "absent"}), "absent", "defaults")
    says(ok("doctor", env={"VOLVIS_DEFAULTS": "none"}).text, "none are read")


main()
