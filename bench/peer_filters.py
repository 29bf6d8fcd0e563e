"""What bench/filters measures filters beside: functions of NumPy, SciPy, scikit-image and Pillow that do the same to samples,
or take the same steps. All work on one thread."""
import numpy as np
from scipy import ndimage


def skimage_is_there():
    try:
        import skimage
    except ImportError:
        return False
    return bool(skimage)


def ball(r):
    z, y, x = np.ogrid[-r : r + 1, -r : r + 1, -r : r + 1]
    return x * x + y * y + z * z <= r * r


def slopes(d):
    x, y, z = np.gradient(d)
    return np.sqrt(x * x + y * y + z * z)


def object_of(d):
    return (d >= 100) & (d <= 1000)


def object_place(d):
    """z, y, x of the first voxel of the object in the middle slice: where a region grows from."""
    middle = len(d) // 2
    return (middle, *np.argwhere(object_of(d[middle]))[0])


def grown(d):
    labels = ndimage.label(object_of(d))[0]
    return labels == labels[object_place(d)]


def strong(d):
    """Parts of the object with a value of 180 or more, as scikit-image's apply_hysteresis_threshold finds them."""
    labels, n = ndimage.label(object_of(d))
    kept = np.zeros(n + 1, bool)
    kept[labels[(d >= 180) & (d <= 1000)]] = True
    return kept[labels]


def otsu(d):
    """Where Otsu's method divides 256 bins."""
    counts, edges = np.histogram(d, 256)
    middle, below = 0.5 * (edges[1:] + edges[:-1]), np.cumsum(counts)
    sums, above = np.cumsum(counts * middle), d.size - below
    means = sums / np.maximum(below, 1) - (sums[-1] - sums) / np.maximum(above, 1)
    return d >= edges[1 + np.argmax(below * above * means**2)]


def equalized(d):
    values, place, counts = np.unique(d, return_inverse=True, return_counts=True)
    return np.interp(np.cumsum(counts), [counts[0], d.size], [values[0], values[-1]])[place].reshape(d.shape)


def matched(d, reference):
    """The steps of scikit-image's match_histograms."""
    _, place, counts = np.unique(d, return_inverse=True, return_counts=True)
    values, others = np.unique(reference, return_counts=True)
    return np.interp(np.cumsum(counts) / d.size, np.cumsum(others) / reference.size, values)[place].reshape(d.shape)


def bilateral(d, sigma, value_sigma):
    """Tomasi & Manduchi by NumPy: a pass over the volume for each place in the ball of 3 sigma."""
    reach = int(3 * sigma)
    wide = np.pad(d.astype("f4"), reach, mode="edge")
    values = d.astype("f4")
    total, weights = np.zeros_like(values), np.zeros_like(values)
    for at in np.argwhere(ball(reach)):
        other = wide[tuple(slice(o, o + n) for o, n in zip(at, d.shape))]
        weight = np.exp(np.float32(-0.5 / value_sigma**2) * (other - values) ** 2)
        weight *= np.float32(np.exp(-0.5 * ((at - reach) ** 2).sum() / sigma**2))
        total += weight * other
        weights += weight
    return total / weights


def diffused(d, iterations, edge, step):
    """Perona & Malik by NumPy."""
    values = d.astype("f4")
    for _ in range(iterations):
        change = np.zeros_like(values)
        for axis in range(3):
            flux = np.diff(values, axis=axis)
            flux *= np.exp(np.float32(-1 / edge**2) * flux * flux)
            change[tuple(slice(-1) if a == axis else slice(None) for a in range(3))] += flux
            change[tuple(slice(1, None) if a == axis else slice(None) for a in range(3))] -= flux
        values += np.float32(step) * change
    return values


def lanczos(d, n):
    """Pillow's resize with three lobes: all slices, then along z."""
    from PIL import Image

    def resized(plane, size):
        return np.asarray(Image.fromarray(plane).resize(size, Image.LANCZOS))

    flat = np.stack([resized(plane, (n, n)) for plane in d]).reshape(len(d), n * n)
    return resized(flat, (n * n, n)).reshape(n, n, n)


def basins(d):
    from skimage.morphology import local_minima
    from skimage.segmentation import watershed

    return watershed(d, ndimage.label(local_minima(d, connectivity=1))[0])


def curves(d):
    from skimage.morphology import skeletonize_3d

    return skeletonize_3d(object_of(d))


def vessels(d):
    from skimage.filters import frangi

    return frangi(d.astype("f4"), sigmas=(1, 2), black_ridges=False)


def patches(d):
    from skimage.restoration import denoise_nl_means

    return denoise_nl_means(d.astype("f4"), patch_size=3, patch_distance=3, h=2.4, sigma=3, fast_mode=True)


def tiles(d):
    from skimage.exposure import equalize_adapthist

    return equalize_adapthist(d / np.float32(d.max()), kernel_size=len(d) // 8)
