"""Small tables in every format, as numpy, astropy and h5py write them.

    pip install numpy astropy h5py
    python tables.py                # writes the files into tables/ beside this file

All have the same data, L = T^-1 n^2 at T = 1, 10, 100 and n = 2, 4, 8, 16, unless the name of the file says
otherwise.
"""

from pathlib import Path

import h5py
import numpy as np
from astropy import units as u
from astropy.io import fits
from astropy.table import QTable

FOLDER = Path(__file__).with_suffix("")
T, N = np.array([1.0, 10.0, 100.0]), np.array([2.0, 4.0, 8.0, 16.0])
L = N**2 / T[:, None]  # [T, n]


def rows(kind=np.float64):
    """A row for each combination, the rows in no order."""
    t, n = (of.ravel() for of in np.meshgrid(T, N, indexing="ij"))
    order = np.random.default_rng(0).permutation(len(t))
    return {"T": t[order].astype(kind), "n": n[order].astype(kind), "L": L.ravel()[order]}


def write_rows():
    columns = rows()
    table = QTable({"T": columns["T"] * u.K, "n": columns["n"] / u.cm**3, "L": columns["L"]})
    table.write(FOLDER / "two.ecsv", overwrite=True)
    table.write(FOLDER / "two.csv", format="ascii.csv", overwrite=True)
    primary = fits.PrimaryHDU()
    first = fits.table_to_hdu(QTable({"T": T, "L": L[:, 0]}))
    first.name = "COOLING"
    # Integers and single precision, and a text beside the numbers.
    second = fits.table_to_hdu(QTable({**rows(np.float32), "i": np.arange(12), "who": ["a"] * 12}))
    second.name = "TWO"
    vectors = fits.table_to_hdu(QTable({"T": T, "L": L}))
    vectors.name = "VECTORS"
    fits.HDUList([primary, first, second, vectors]).writeto(FOLDER / "tables.fits", overwrite=True)
    images = [fits.PrimaryHDU(L), fits.ImageHDU(T, name="T"), fits.ImageHDU(N, name="n")]
    fits.HDUList(images).writeto(FOLDER / "images.fits", overwrite=True)


def write_arrays():
    np.savez_compressed(FOLDER / "two.npz", T=T, n=N, values=L)
    np.savez(FOLDER / "fortran.npz", T=T[::-1], n=N, L=np.asfortranarray(L[::-1]))
    with h5py.File(FOLDER / "scales.h5", "w") as file:
        file["model/L"] = L
        for axis, (name, nodes) in enumerate({"T": T, "n": N}.items()):
            scale = file.create_dataset(f"model/{name}", data=nodes)
            scale.make_scale(name)
            file["model/L"].dims[axis].attach_scale(scale)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    write_rows()
    write_arrays()
