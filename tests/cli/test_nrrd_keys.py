"""What goes from NRRD to NRRD: keys, comments and fields, as long as they hold. Truth is the definition of NRRD."""
from harness import main, ok
from test_dicom import need

try:
    import numpy
    from nrrd_reader import Nrrd, write
except ImportError:
    pass  # need() says so

FIELDS = (("space", "left-posterior-superior"), ("kinds", "space space space"),
          ("space directions", "(2,0,0) (0,3,0) (0,0,4)"), ("space origin", "(10,20,30)"),
          ("measurement frame", "(0,1,0) (1,0,0) (0,0,-1)"), ("thicknesses", "nan 2.5 5"), ("centerings", "cell cell node"),
          ("labels", '"left" "behind" "up"'), ("content", "a long description " + "y" * 90),
          ("sample units", '"thousandths of a millimetre"'), ("old min", "-1.5"), ("old max", "1e3"))
KEYS = (("modality", "MR"), ("two lines", "a\\nb\\\\c"), ("Zugehörig", "Größe: 5"), ("volvis-like", "kept"))


def volume():
    data = numpy.arange(6 * 5 * 4, dtype="<i2").reshape(6, 5, 4)
    write("in.nrrd", data, FIELDS, KEYS, ("first comment", "", "second"), "NRRD0004")
    return data


def kept(path):
    """Which of the fields and keys are there."""
    n = Nrrd(path)
    names = [f for f in ("measurement frame", "thicknesses", "centerings", "labels", "old min", "old max") if f in n.fields]
    return names + [k for k, _ in KEYS if k in n.keys]


ALL = ["measurement frame", "thicknesses", "centerings", "labels", "old min", "old max", *(k for k, _ in KEYS)]


def test_a_copy_has_all_that_was_said():
    need()
    data = volume()
    ok("convert", "in.nrrd", "-o", "copy.nrrd")
    n = Nrrd("copy.nrrd")
    assert numpy.array_equal(n.data, data) and kept("copy.nrrd") == ALL
    assert n.keys["two lines"] == "a\nb\\c" and n.keys["Zugehörig"] == "Größe: 5"
    assert n.fields["content"] == dict(FIELDS)["content"] and n.fields["old max"] == "1e3"
    assert n.fields["sample units"] == dict(FIELDS)["sample units"]
    assert n.fields["thicknesses"] == "nan 2.5 5" and n.fields["centerings"] == "cell cell node"
    assert n.fields["labels"] == '"left" "behind" "up"'
    assert n.comments[:1] == ["written by VolVis"] and "first comment" in n.comments and "second" in n.comments
    # ours is RAS: x and y of its vectors are turned round
    assert n.fields["space"] == "right-anterior-superior"
    assert n.vectors("measurement frame") == [(0, -1, 0), (-1, 0, 0), (0, 0, -1)]
    for _ in range(2):  # nothing piles up
        ok("convert", "copy.nrrd", "-o", "again.nrrd", "--overwrite")
    again = Nrrd("again.nrrd")
    assert again.fields == n.fields and again.keys == n.keys
    assert [c for c in again.comments if "..." not in c] == [c for c in n.comments if "..." not in c]


def test_what_no_longer_holds_is_left_out():
    need()
    volume()
    ok("crop", "in.nrrd", "-o", "o.nrrd", "--x", "1..3")
    assert kept("o.nrrd") == ALL
    ok("convert", "in.nrrd", "-o", "fine.nrrd", "--spacing", "2mm,3mm,1mm")  # of other steps along z alone
    n = Nrrd("fine.nrrd")
    assert n.fields["thicknesses"] == "nan 2.5 nan" and n.fields["centerings"] == "cell cell none"
    assert n.fields["labels"] == '"left" "behind" "up"' and "modality" in n.keys
    ok("convert", "in.nrrd", "-o", "turned.nrrd", "--order", "LPS", "--overwrite")
    assert kept("turned.nrrd") == ALL
    ok("convert", "in.nrrd", "-o", "zyx.nrrd", "--order", "SPL")
    n = Nrrd("zyx.nrrd")
    assert n.fields["thicknesses"] == "nan 2.5 nan" and n.fields["labels"] == '"" "behind" ""'  # y is y
    assert n.vectors("measurement frame") == [(0, -1, 0), (-1, 0, 0), (0, 0, -1)]
    ok("convert", "in.nrrd", "-o", "yzx.nrrd", "--order", "PSL")
    assert not {"thicknesses", "centerings", "labels"} & set(Nrrd("yzx.nrrd").fields)
    ok("convert", "in.nrrd", "-o", "bytes.nrrd", "--type", "u8", "--range", "0..100")
    assert kept("bytes.nrrd") == ["measurement frame", "thicknesses", "centerings", "labels"]
    ok("convert", "in.nrrd", "-o", "wide.nrrd", "--type", "i32")  # the numbers are others than those of old min
    assert [k for k in ALL if k not in kept("wide.nrrd")] == ["old min", "old max"]


def test_components_keep_their_kind_and_vectors_their_frame():
    need()
    rng = numpy.random.default_rng(2)
    data = rng.integers(-9, 9, (3, 4, 5, 6)).astype("<i2")
    fields = (("space", "left-posterior-superior"), ("kinds", "3-gradient domain domain domain"),
              ("space directions", "none (2,0,0) (0,3,0) (0,0,4)"), ("measurement frame", "(0,1,0) (1,0,0) (0,0,-1)"))
    write("v.nrrd", data, fields)
    ok("convert", "v.nrrd", "-o", "w.nrrd")
    n = Nrrd("w.nrrd")
    assert n.fields["kinds"].split()[0] == "3-gradient"

    def world(n, flip):  # of all vectors, in RAS
        frame = numpy.array(n.vectors("measurement frame")).T
        return numpy.einsum("ij,j...->i...", numpy.diag(flip) @ frame, n.data.astype(float))
    assert numpy.array_equal(world(n, (1, 1, 1)), world(Nrrd("v.nrrd"), (-1, -1, 1)))
    write("hsv.nrrd", abs(data).astype("|u1"), (("kinds", "HSV-color domain domain domain"),))
    ok("convert", "hsv.nrrd", "-o", "hsv2.nrrd")
    assert Nrrd("hsv2.nrrd").fields["kinds"].split()[0] == "HSV-color"
    ok("convert", "hsv.nrrd", "-o", "one.nrrd", "--channel", "0,1")
    assert Nrrd("one.nrrd").fields["kinds"].split()[0] == "list"


def test_gradients_of_diffusion_go_with_their_components():
    need()
    data = numpy.arange(2 * 27, dtype="<i2").reshape(2, 3, 3, 3)
    keys = (("modality", "DWMRI"), ("DWMRI_b-value", "1000"), ("DWMRI_gradient_0000", "0 0 0"), ("DWMRI_gradient_0001", "1 0 0"))
    write("dwi.nrrd", data, (("kinds", "list domain domain domain"),), keys)
    ok("convert", "dwi.nrrd", "-o", "dwi2.nrrd")
    assert list(Nrrd("dwi2.nrrd").keys.items()) == list(keys)
    ok("convert", "dwi.nrrd", "-o", "first.nrrd", "--channel", "0")
    assert Nrrd("first.nrrd").keys == {"modality": "DWMRI"}


if __name__ == "__main__":
    main()
