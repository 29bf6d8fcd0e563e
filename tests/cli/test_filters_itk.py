"""Filters against those of ITK, where `ninja -C build bench/peer_itk` has made the program that runs them."""
import os
import subprocess

from harness import VOLVIS, Skip, main, ok

try:
    import numpy as np
    from scipy import ndimage
except ImportError:
    np = None

PEER = os.path.join(os.path.dirname(VOLVIS), "bench", "peer_itk")


def need_itk():
    if np is None or not os.path.exists(PEER):
        raise Skip("ITK or SciPy is not there, or `ninja -C build bench/peer_itk` was not run")


def theirs(data, name, *numbers):
    words = [PEER, name, "%d,%d,%d" % data.shape[::-1], *map(str, numbers)]
    done = subprocess.run(words, input=data.astype("f4").tobytes(), capture_output=True, check=True, timeout=120)
    return np.frombuffer(done.stdout, "f4").reshape(data.shape)


def ours(data, *words):
    np.save("a.npy", data)
    ok(words[0], "a.npy", "-o", "b.npy", "--overwrite", *words[1:])
    return np.load("b.npy")


def blobs(shape, seed=1):
    data = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), 1.5)
    return (60 + 30 * data / data.std()).astype("f4")


def test_a_bias_field_is_that_of_n4():
    need_itk()
    shape = (19, 22, 25)
    z, y, x = (np.linspace(-1, 1, n).reshape([-1 if i == a else 1 for i in range(3)]) for a, n in enumerate(shape))
    inside = z * z + y * y + x * x < 0.9
    tissue = np.digitize(blobs(shape), [45, 75]) * 60 + 100 + np.random.default_rng(2).normal(0, 2, shape)
    bright = np.where(inside, tissue * np.exp(0.3 * x - 0.2 * y * y + 0.15 * x * y), 0).astype("f4")
    for levels in 1, 2:
        how = ("--levels", levels, "--iterations", "20", "--range", "20..", "--every", "1")
        field = ours(bright, "bias", "--output", "field", *how)[inside]
        apart = np.log(field * theirs(bright, "bias", levels, 20, 20)[inside] / bright[inside])
        assert np.log(field).std() > 0.02 and apart.std() < 1e-5, (levels, np.log(field).std(), apart.std())


def test_regions_grow_as_confidence_connected_ones():
    need_itk()
    data = blobs((19, 23, 31))
    for deviations, iterations, radius in (2.5, 0, 1), (2.5, 3, 1), (1.5, 2, 2), (2, 1, 3):
        want = theirs(data, "grow", 15, 12, 9, deviations, iterations, radius)
        got = ours(data, "grow", "--seed", "15,12,9", "--deviations", deviations, "--iterations", iterations, "--radius", radius)
        assert 50 < want.sum() < data.size and (got == want).all(), (deviations, iterations, radius)


def test_bilateral_is_near_that_of_itk():
    need_itk()
    data = blobs((17, 19, 23)) + np.random.default_rng(3).normal(0, 5, (17, 19, 23)).astype("f4")
    want = theirs(data, "bilateral", 1, 15)  # its window is a box, and its weights are those of a table
    got = ours(data, "bilateral", "--sigma-voxels", "1,1,1", "--value-sigma", "15")
    assert np.abs(got - want).max() < 0.03 * np.abs(got - data).max(), np.abs(got - want).max()


main()
