"""Draws an image beside an exact one, with the error of each pixel and its estimate.

python error_map.py exact.npz image.fits picture.png

The exact image is the array `exact` of a NumPy file, its first row at the same edge of the image as
that of the FITS file. Errors are relative to the largest pixel of the exact image.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from astropy.io import fits


def panels(exact, image, estimate):
    """The panels: titles, pixels, the largest value of the colours, and whether they are errors."""
    largest = np.abs(exact).max()
    error, estimate = np.abs(image - exact) / largest, estimate / largest
    brightest, worst = max(exact.max(), image.max()), max(error.max(), estimate.max())
    return (
        ("exact", exact, brightest, False),
        ("emitree", image, brightest, False),
        ("error", error, worst, True),
        ("estimated error", estimate, worst, True),
    )


def main(exact, image, picture):
    """Reads the files and writes the picture."""
    with np.load(exact) as arrays:
        truth = arrays["exact"]
    with fits.open(image) as units:
        radiance, unit = units[0].data, units[0].header["BUNIT"]
        shown = panels(truth, radiance, units["ERROR"].data)
    figure, axes = plt.subplots(1, len(shown), figsize=(9.2, 4.6), layout="constrained")
    for axis, (title, pixels, most, is_error) in zip(axes, shown, strict=True):
        drawn = axis.imshow(
            pixels,
            origin="lower",
            vmin=0.0,
            vmax=most,
            cmap="magma" if is_error else "viridis",
        )
        axis.set_title(title)
        axis.set_xticks([])
        axis.set_yticks([])
        label = "share of the largest pixel" if is_error else f"radiance [{unit}]"
        figure.colorbar(drawn, ax=axis, orientation="horizontal", label=label)
    figure.savefig(picture, dpi=100)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
