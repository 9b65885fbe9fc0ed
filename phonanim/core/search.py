"""Find a template in a picture: masked normalized correlation over positions and sizes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.float32]
Array = NDArray[np.float64]

COARSE = 32  # columns of the template during the search
SIZES = np.geomspace(0.15, 0.9, 14)  # widths of the template, as shares of the picture's
GUESSES = 4


def first_guesses(image: Grey, template: Grey, mask: Grey) -> list[tuple[float, Array]]:
    """The most likely sizes and positions of a template: pairs of scale and top left corner (2,) in pixels.

    `image` (rows, columns), `template` and `mask` (height, width) grey, the mask 1 where the template
    counts. Best first, by normalized correlation under the mask (Padfield 2012, with one mask).
    """
    small = COARSE / template.shape[1]
    kernel, weights = downscale(template, small), (downscale(mask, small) > 0.99).astype(np.float32)
    found = []
    for size in SIZES:
        scale = size * image.shape[1] / template.shape[1]
        picture = downscale(image, small / scale)
        if min(np.subtract(picture.shape, kernel.shape)) < 0:
            continue
        likeness = correlation_map(picture, kernel, weights)
        row, column = np.unravel_index(int(likeness.argmax()), likeness.shape)
        corner = np.array([column, row]) * scale / small
        found.append((float(likeness.max()), float(scale), corner))
    return [(scale, corner) for _, scale, corner in sorted(found, key=lambda f: -f[0])[:GUESSES]]


def correlation_map(image: Grey, template: Grey, mask: Grey) -> Array:
    """Pearson's r of a masked template with the picture below it, at every position where it fits."""
    count = mask.sum()
    kernel = (template - (template * mask).sum() / count) * mask
    sums, squares = correlate(image, mask), correlate(image**2, mask)
    spread = np.sqrt(np.maximum(squares - sums**2 / count, 1e-3 * count))
    return correlate(image, kernel) / (spread * np.sqrt((kernel**2).sum()))


def correlate(image: Grey, kernel: Grey) -> Array:
    """Sums of the picture under a kernel, at every position where it fits, by the Fourier transform."""
    rows, columns = np.subtract(image.shape, kernel.shape) + 1
    spectrum = np.fft.rfft2(image) * np.conj(np.fft.rfft2(kernel, image.shape))
    return np.asarray(np.fft.irfft2(spectrum, image.shape)[:rows, :columns])


def downscale(image: Grey, scale: float) -> Grey:
    """The picture at `scale` times its size; each pixel is the mean of the pixels that it covers."""
    rows, columns = (max(2, round(size * scale)) for size in image.shape)
    tall = _means(image, rows)
    return _means(tall.T, columns).T


def _means(image: Grey, count: int) -> Grey:
    """Merge rows into `count` means, by differences of the running sum."""
    sums = np.concatenate([np.zeros((1, image.shape[1])), np.cumsum(image, axis=0)])
    edges = np.linspace(0, len(image), count + 1)
    low = np.minimum(edges.astype(int), len(image) - 1)
    at = sums[low] + (edges - low)[:, None] * (sums[low + 1] - sums[low])
    return np.asarray(np.diff(at, axis=0) / np.diff(edges)[:, None], np.float32)
