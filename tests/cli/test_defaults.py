"""The file of defaults: options that hold where the command line says nothing else."""
import os
from harness import fails, main, ok, png_pixels, says, volvis, write_ball

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
    write("render --range 0..100\n")
    says(volvis("render", "a.nrrd", "-o", "a.png", "--percentile", "1..99", env=HERE).message,
         "defaults adds --range 0..100; --no-defaults leaves it out")
    says(ok("doctor", env=HERE).text, "from defaults")
    says(fails(3, "info", "a.nrrd", env={"VOLVIS_DEFAULTS": "absent"}), "absent", "defaults")
    says(ok("doctor", env={"VOLVIS_DEFAULTS": "none"}).text, "none are read")


main()
