"""Formulas of volumes, and inputs by name: numpy says what comes out."""
import numpy as np

from harness import fails, main, ok, says

RANDOM = np.random.default_rng(5)


def write(name, kind="f4", shape=(7, 9, 11)):
    values = RANDOM.normal(0, 100, shape).astype(kind)
    np.save(name + ".npy", values)
    return values.astype("f8")


def calc(formula, *inputs, **options):
    formula = f"--formula={formula}" if formula[0] == "-" else formula
    ok("calc", formula, *inputs, "-o", "out.npy", "--overwrite", *(word for k, v in options.items() for word in (f"--{k}", v)))
    return np.load("out.npy")


def test_formulas_are_those_of_numpy():
    a, b, k = write("a"), write("b", "i2"), np.arange(7)[:, None, None]
    inputs = ("a.npy", "b.npy")
    for formula, truth in (("a - 0.5*b", a - 0.5 * b), ("a > b ? a : b", np.maximum(a, b)), ("-a^2 + (a + b)/3", -(a * a) + (a + b) / 3),
                           ("where(b % 7 == 3 || a < 0, 1, 0)", ((np.fmod(b, 7) == 3) | (a < 0)) * 1.0),
                           ("hypot(a, b) + atan2(a, b)*pi", np.hypot(a, b) + np.arctan2(a, b) * np.pi),
                           ("clamp(min(a, b, 10), -20, 5)", np.clip(np.minimum(np.minimum(a, b), 10), -20, 5)),
                           ("sqrt(abs(a)) * !(b >= 0) && b != 1", ((np.sqrt(abs(a)) * (b < 0) != 0) & (b != 1)) * 1.0),
                           ("log(exp(a/100)) + 0*b + k", np.log(np.exp(a / 100)) + k)):
        got = calc(formula, *inputs)
        assert got.dtype == "f4" and np.allclose(got, truth, rtol=1e-6, atol=1e-5), formula
    assert np.array_equal(calc("round(a) + b", *inputs, type="i32"), np.rint(np.where(np.rint(a) == a, a, np.floor(abs(a) + 0.5) * np.sign(a))) + b)


def test_all_types_and_what_is_missing():
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"):
        for shape in (5, 7, 9), (1, 6, 1):
            data = np.abs(RANDOM.normal(0, 40, shape)).astype(kind)
            if kind[0] == "f":
                data[0, 2, 0] = np.nan
            np.save("a.npy", data)
            a = data.astype("f8")
            assert np.allclose(calc("0.5*a - 3", "a.npy", type="f64"), 0.5 * a - 3, rtol=1e-15, equal_nan=True), kind
            want = np.nan_to_num(np.floor(a / 2) + 1).clip(0, 100)
            got = calc("clamp(floor(a/2) + 1, 0, 100)", "a.npy", type="u8")
            assert got.dtype == "u1" and (got == want).all(), kind


def test_names_say_which_volume_is_which():
    a, b = write("a"), write("b")
    truth = (a - b).astype("f4")
    for words in (("first-second", "first=a.npy", "second=b.npy"), ("first-second", "second=b.npy", "first=a.npy"), ("a-b", "a.npy", "b.npy"),
                  ("a-second", "a.npy", "second=b.npy")):
        assert np.allclose(calc(*words), truth, rtol=1e-6), words
    by_option = ("calc", "-o", "named.npy", "--formula", "p-q", "--names", "p,q", "a.npy", "b.npy")
    ok(*by_option)
    assert np.allclose(np.load("named.npy"), truth, rtol=1e-6)
    says(fails(2, "calc", "p+q", "p=a.npy", "p=b.npy", "-o", "x.npy"), "'p'")
    says(fails(2, "calc", "p+q", "p=a.npy", "q=b.npy", "--names", "p,q", "-o", "x.npy"), "NAME=FILE")


def test_inputs_of_other_operations_have_names_too():
    a, b = write("a"), write("b")
    ok("isosurface", "a.npy", "b.npy", "-o", "one.ply", "--iso", "0")
    ok("isosurface", "values=b.npy", "a.npy", "-o", "two.ply", "--iso", "0")
    ok("isosurface", "values=b.npy", "volume=a.npy", "-o", "three.ply", "--iso", "0")
    assert open("one.ply", "rb").read() == open("two.ply", "rb").read() == open("three.ply", "rb").read()
    says(fails(2, "isosurface", "a.npy", "vaules=b.npy", "-o", "x.ply"), "no input 'vaules'", "volume, values")
    says(fails(2, "isosurface", "values=b.npy", "-o", "x.ply"), "volume is missing")
    says(fails(2, "isosurface", "a.npy", "values=b.npy", "values=b.npy", "-o", "x.ply"), "same input")


def test_what_is_wrong_is_said_with_its_column():
    write("a"), write("small", shape=(3, 4, 5))
    for formula, parts in (("a +", ("column 4", "the end")), ("a + q", ("'q'", "column 5")), ("sin(a", ("')'",)), ("squrt(a)", ("squrt", "sqrt"))):
        says(fails(2, "calc", formula, "a.npy", "-o", "x.npy"), *parts)
    says(fails(2, "calc", "a+b", "a.npy", "small.npy", "-o", "x.npy"), "resample")
    says(fails(2, "calc", "a", "a.npy", "b=small.npy", "-o", "x.npy"), "does not use")


main()
