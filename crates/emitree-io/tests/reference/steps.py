"""Small grids with a fourth axis in every format, as numpy, astropy, h5py and SciPy write them.

    pip install numpy astropy h5py scipy
    python steps.py                 # writes the files into steps/ beside this file

All have g = 1000 t + 100 z + 10 y + x of the indices, on 3 steps at t = 0, 2.5, 10 and on the nodes of grids.py, in the
order [t, z, y, x] unless the name of the file says otherwise.
"""

from pathlib import Path

import h5py
import numpy as np
from astropy.io import fits
from scipy.io import netcdf_file

FOLDER = Path(__file__).with_suffix("")
AXES = {
    "t": np.array([0.0, 2.5, 10.0]),
    "z": np.array([10.0, 20.0]),
    "y": np.array([0.0, 0.5, 2.0]),
    "x": np.array([-1.0, 0.0, 2.0, 6.0]),
}
G = np.tensordot([1000.0, 100.0, 10.0, 1.0], np.indices((3, 2, 3, 4)), 1)


def main():
    FOLDER.mkdir(exist_ok=True)
    np.savez_compressed(FOLDER / "steps.npz", values=G, **AXES)
    np.savez(FOLDER / "fortran.npz", values=np.asfortranarray(G), **AXES)
    np.savez(FOLDER / "one.npz", values=G[1:2], **AXES)
    np.save(FOLDER / "steps.npy", G.astype(np.float32))
    images = [fits.ImageHDU(AXES[name], name=name) for name in "xyzt"]
    fits.HDUList([fits.PrimaryHDU(G), *images]).writeto(FOLDER / "steps.fits", overwrite=True)
    with h5py.File(FOLDER / "last.h5", "w") as file:
        # The steps are the last axis; in chunks, compressed, in a group.
        order = "zyxt"
        data = np.moveaxis(G, 0, -1)
        values = file.create_dataset("run/g", data=data, chunks=(1, 2, 2, 2), compression="gzip")
        for axis, name in enumerate(order):
            scale = file.create_dataset(f"run/{name}", data=AXES[name])
            scale.make_scale(name)
            values.dims[axis].attach_scale(scale)
    with netcdf_file(FOLDER / "records.nc", "w") as file:
        file.createDimension("time", None)
        for name in "zyx":
            file.createDimension(name, len(AXES[name]))
        for name in "zyx":
            file.createVariable(name, "d", (name,))[:] = AXES[name]
        file.createVariable("time", "d", ("time",))[:] = AXES["t"]
        file.createVariable("values", "d", ("time", "z", "y", "x"))[:] = G
    write_openpmd()


def write_openpmd():
    """A scalar and a component of a vector, as the standard has them: openPMD 1.1.

    x = -1, 0, 1, 2; y = 0.25, 0.75, 1.25; z = 10, 20 in units of 0.5 m, and values in units of 2.
    """
    geometry = {
        "geometry": "cartesian",
        "dataOrder": "C",
        "axisLabels": np.array(["z", "y", "x"], dtype=h5py.string_dtype("ascii")),
        "gridSpacing": np.array([10.0, 0.5, 1.0]),
        "gridGlobalOffset": np.array([10.0, 0.0, -1.0]),
        "gridUnitSI": 0.5,
    }
    with h5py.File(FOLDER / "openpmd.h5", "w") as file:
        file.attrs["openPMD"] = "1.1.0"
        meshes = file.create_group("data/100/meshes")
        rho = meshes.create_dataset("rho", data=G[0] / 2)
        field = meshes.create_group("B")
        component = field.create_dataset("x", data=G[1] / 2)
        rho.attrs.update(geometry)
        field.attrs.update(geometry)
        for dataset in (rho, component):
            dataset.attrs["position"] = np.array([0.0, 0.5, 0.0])
            dataset.attrs["unitSI"] = 2.0


if __name__ == "__main__":
    main()
