"""Small response files as missions ship them, written with astropy, and what is in them.

    python responses.py            # writes *.arf, *.rmf, *.rsp and responses.csv beside this file

Rows of the table, from the definitions below and not from the files: `file`, `what` and four columns.

* `area`: energies from and to in keV, and the mean of the area between them in cm2;
* `channel`: index from 0, number, and its energies in keV;
* `response`: row from that of the lowest energies, channel from 0, and the response (probability or
  cm2), where it is not 0;
* `sum`: the largest sum of a row, and whether the area is included.

Numbers of 32 bits are rounded here too, so that the table has the very numbers of the files.
"""

import csv
from pathlib import Path

import numpy as np
from astropy.io import fits

HERE = Path(__file__).parent
ROWS = []


def f32(values):
    return np.asarray(values, dtype=np.float32)


def write(name, *extensions):
    primary = fits.PrimaryHDU()
    primary.header["TELESCOP"] = "EXAMPLE"
    fits.HDUList([primary, *extensions]).writeto(HERE / name, overwrite=True)


def table(name, columns, **keywords):
    extension = fits.BinTableHDU.from_columns(columns, name=name)
    for keyword, value in keywords.items():
        extension.header[keyword] = value
    return extension


def of_class(second, third=None):
    keywords = {"HDUCLASS": "OGIP", "HDUCLAS1": "RESPONSE", "HDUCLAS2": second}
    return keywords | ({"HDUCLAS3": third} if third else {})


def ragged(rows, dtype):
    array = np.empty(len(rows), dtype=object)
    for n, row in enumerate(rows):
        array[n] = np.asarray(row, dtype=dtype)
    return array


def padded(rows, length, fill=0):
    return [list(row) + [fill] * (length - len(row)) for row in rows]


def state_area(name, low, high, area, ranges):
    """Means of a piecewise constant area, by overlaps."""
    for a, b in ranges:
        integral = sum(
            max(0.0, min(b, h) - max(a, l)) * s for l, h, s in zip(low, high, area)
        )
        ROWS.append([name, "area", a, b, float(integral / (b - a)), ""])


def state_matrix(name, channels, rows, included):
    for index, (number, low, high) in enumerate(channels):
        ROWS.append([name, "channel", index, number, low, high])
    for row, groups in enumerate(rows):
        for first, responses in groups:
            for offset, response in enumerate(responses):
                ROWS.append([name, "response", row, first + offset, float(response), ""])
    largest = max(sum(float(r) for _, rs in groups for r in rs) for groups in rows)
    ROWS.append([name, "sum", largest, int(included), "", ""])


# Two areas: 32 bits in keV and cm2, found by class; 64 bits in eV and m2, descending, found by name.

low = f32([0.3, 0.5, 0.8, 1.2, 2.0])
high = f32([0.5, 0.8, 1.2, 2.0, 5.0])
area = f32([12.5, 80.25, 210.0, 150.5, 0.0])
write(
    "bins.arf",
    table(
        "ARF",
        [
            fits.Column("ENERG_LO", "E", unit="keV", array=low),
            fits.Column("ENERG_HI", "E", unit="keV", array=high),
            fits.Column("SPECRESP", "E", unit="cm**2", array=area),
        ],
        **of_class("SPECRESP"),
    ),
)
state_area(
    "bins.arf",
    low.astype(float),
    high.astype(float),
    area.astype(float),
    [(0.0, 10.0), (0.3, 0.5), (0.4, 0.9), (1.0, 1.1), (1.9, 2.1), (6.0, 7.0)],
)

low = np.array([900.0, 500.0, 250.0])
high = np.array([1500.0, 900.0, 500.0])
area = np.array([0.002, 0.015, 0.01])
write(
    "descending.arf",
    table(
        "SPECRESP",
        [
            fits.Column("ENERG_LO", "D", unit="eV", array=low),
            fits.Column("ENERG_HI", "D", unit="eV", array=high),
            fits.Column("SPECRESP", "D", unit="m**2", array=area),
        ],
    ),
)
state_area(
    "descending.arf",
    low / 1000,
    high / 1000,
    area * 10000,
    [(0.25, 1.5), (0.6, 0.7), (0.4, 1.0), (0.1, 0.3)],
)

# A normalised matrix of columns of variable length, channels from 0 (TLMIN), a row without groups.

edges = f32([0.1, 0.2, 0.4, 0.7, 1.0])
groups = [
    [(0, [0.75, 0.25])],
    [(0, [0.125]), (2, [0.5, 0.25, 0.125])],
    [],
    [(1, [0.0625]), (3, [0.1875, 0.5]), (5, [0.25])],
]
channels = [(n, float(f32(0.2 * n)), float(f32(0.2 * (n + 1)))) for n in range(6)]


def bounds(kind="I", unit="keV", factor=1.0):
    return table(
        "EBOUNDS",
        [
            fits.Column("CHANNEL", kind, array=[number for number, _, _ in channels]),
            fits.Column("E_MIN", "E", unit=unit, array=f32([factor * low for _, low, _ in channels])),
            fits.Column("E_MAX", "E", unit=unit, array=f32([factor * high for _, _, high in channels])),
        ],
        **of_class("EBOUNDS"),
    )


matrix = table(
    "MATRIX",
    [
        fits.Column("ENERG_LO", "E", unit="keV", array=edges[:-1]),
        fits.Column("ENERG_HI", "E", unit="keV", array=edges[1:]),
        fits.Column("N_GRP", "I", array=[len(row) for row in groups]),
        fits.Column("F_CHAN", "PI()", array=ragged([[f for f, _ in row] for row in groups], "i2")),
        fits.Column("N_CHAN", "PI()", array=ragged([[len(r) for _, r in row] for row in groups], "i2")),
        fits.Column("MATRIX", "PE()", array=ragged([sum((r for _, r in row), []) for row in groups], "f4")),
    ],
    **of_class("RSP_MATRIX", "REDIST"),
    TLMIN4=0,
    TLMAX4=5,
    DETCHANS=6,
)
write("variable.rmf", matrix, bounds())
state_matrix("variable.rmf", channels, groups, False)

# The same in columns of fixed length, 32-bit integers, with the area in it; channels from 1 without
# TLMIN; the energies of the channels first, in eV.

areas = [3.0, 20.0, 40.0, 32.0]
full = [[(f, [a * x for x in r]) for f, r in row] for a, row in zip(areas, groups)]
channels = [(n + 1, 0.25 * n, 0.25 * (n + 1)) for n in range(6)]
matrix = table(
    "SPECRESP MATRIX",
    [
        fits.Column("ENERG_LO", "E", unit="keV", array=edges[:-1]),
        fits.Column("ENERG_HI", "E", unit="keV", array=edges[1:]),
        fits.Column("N_GRP", "J", array=[len(row) for row in full]),
        # What is beyond the groups that there are is no group, whatever it is.
        fits.Column("F_CHAN", "3J", array=padded([[f + 1 for f, _ in row] for row in full], 3, 99)),
        fits.Column("N_CHAN", "3J", array=padded([[len(r) for _, r in row] for row in full], 3, 99)),
        fits.Column("MATRIX", "6E", unit="cm**2", array=padded([sum((r for _, r in row), []) for row in full], 6)),
    ],
    **of_class("RSP_MATRIX", "FULL"),
)
write("fixed.rsp", bounds("J", "eV", 1000.0), matrix)
state_matrix("fixed.rsp", channels, full, True)

# One group a row, in columns of one number, unsigned; no classes, energies descending, no units.

single = [[(2, [0.5, 0.25])], [(1, [0.25, 0.5])], [(0, [0.875, 0.125])]]
matrix = table(
    "MATRIX",
    [
        fits.Column("ENERG_LO", "D", array=[0.7, 0.4, 0.1]),
        fits.Column("ENERG_HI", "D", array=[1.0, 0.7, 0.4]),
        fits.Column("N_GRP", "B", array=[1, 1, 1]),
        fits.Column("F_CHAN", "I", bzero=32768, array=np.array([row[0][0] + 1 for row in single], dtype=np.uint16)),
        fits.Column("N_CHAN", "I", bzero=32768, array=np.array([2, 2, 2], dtype=np.uint16)),
        fits.Column("MATRIX", "2D", array=[row[0][1] for row in single]),
    ],
    TLMIN4=1,
)
ebounds = bounds()
for keyword in ("HDUCLASS", "HDUCLAS1", "HDUCLAS2"):
    del ebounds.header[keyword]
write("single.rmf", matrix, ebounds)
state_matrix("single.rmf", channels, single[::-1], False)

with open(HERE / "responses.csv", "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["file", "what", "a", "b", "c", "d"])
    writer.writerows([[v if isinstance(v, str) else repr(v) for v in row] for row in ROWS])
