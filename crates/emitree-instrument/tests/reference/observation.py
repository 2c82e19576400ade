"""Expected counts of a small observation, with NumPy and SciPy and without the Rust code.

    python observation.py           # reads bins.arf and variable.rmf, writes observation.csv

The energies are cut at every border of the cube, the area and the matrix, so that on each piece all
three are constant; the point-spread function is convolved directly. Rows of the table: the channel,
the row and the column of the pixel, all from 0, and the counts.

The scene, in both programs: bins of equal ratio from 0.25 to 1.25 keV, radiance
(1 + bin) (1 + row + 2 column) photons s-1 cm-2 sr-1 keV-1, solid angles (1 + column / 10) 1e-3 sr,
2000 s, a kernel of 4 rows and 3 columns with the values 1 to 12 row by row, its source at row 2,
column 1, and a background of 5 counts s-1 keV-1 sr-1.
"""

import csv
from pathlib import Path

import numpy as np
from astropy.io import fits
from scipy.signal import convolve2d

HERE = Path(__file__).parent
BINS, HEIGHT, WIDTH, EXPOSURE = 5, 6, 7, 2000.0

arf = fits.getdata(HERE / "bins.arf", 1)
rmf = fits.getdata(HERE / "variable.rmf", "MATRIX")
ebounds = fits.getdata(HERE / "variable.rmf", "EBOUNDS")


def constant_on(table, values, energy):
    """The value of the row that an energy is in; 0 outside."""
    for row, value in zip(table, values):
        if row["ENERG_LO"] < energy < row["ENERG_HI"]:
            return value
    return np.zeros_like(values[0])


dense = np.zeros((len(rmf), len(ebounds)))
for n, row in enumerate(rmf):
    responses = iter(row["MATRIX"])
    for first, count in zip(row["F_CHAN"], row["N_CHAN"]):
        for channel in range(first, first + count):
            dense[n, channel] = next(responses)

edges = 0.25 * 5.0 ** (np.arange(BINS + 1) / BINS)
borders = np.unique(
    np.concatenate(
        [edges, *(np.float64(t[c]) for t in (arf, rmf) for c in ("ENERG_LO", "ENERG_HI"))]
    )
)

# Response of each channel to one photon s-1 cm-2 sr-1 keV-1 in each bin: cm2 keV.
response = np.zeros((len(ebounds), BINS))
for low, high in zip(borders[:-1], borders[1:]):
    middle = (low + high) / 2
    bin_ = np.searchsorted(edges, middle) - 1
    if 0 <= bin_ < BINS:
        area = constant_on(arf, np.float64(arf["SPECRESP"]), middle)
        response[:, bin_] += (high - low) * area * constant_on(rmf, dense, middle)

rows, columns = np.mgrid[:HEIGHT, :WIDTH]
solid_angles = (1 + columns / 10) * 1e-3
kernel = np.arange(1.0, 13.0).reshape(4, 3)
kernel /= kernel.sum()
blurred = []
for bin_ in range(BINS):
    scene = (1 + bin_) * (1.0 + rows + 2 * columns) * solid_angles
    full = convolve2d(scene, kernel, mode="full")
    blurred.append(full[2 : 2 + HEIGHT, 1 : 1 + WIDTH])

with open(HERE / "observation.csv", "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["channel", "row", "column", "counts"])
    for channel, bound in enumerate(ebounds):
        width = np.float64(bound["E_MAX"]) - np.float64(bound["E_MIN"])
        counts = EXPOSURE * (
            sum(response[channel, b] * blurred[b] for b in range(BINS))
            + 5.0 * width * solid_angles
        )
        for (row, column), value in np.ndenumerate(counts):
            writer.writerow([channel, row, column, repr(float(value))])
