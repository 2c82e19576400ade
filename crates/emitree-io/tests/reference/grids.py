"""Small grids in every format, as numpy, astropy, h5py and netCDF4 write them.

    pip install numpy astropy h5py netCDF4
    python grids.py                 # writes the files into grids/ beside this file

All have the same data, g = 100 z + 10 y + x of the indices, on 4 x 3 x 2 nodes (x, y, z) at
x = -1, 0, 2, 6; y = 0, 0.5, 2; z = 10, 20, unless the name of the file says otherwise.
"""

import os
from pathlib import Path

import h5py
import netCDF4
import numpy as np
from astropy.io import fits

FOLDER = Path(__file__).with_suffix("")
X, Y, Z = np.array([-1.0, 0.0, 2.0, 6.0]), np.array([0.0, 0.5, 2.0]), np.array([10.0, 20.0])
INDICES = np.indices((2, 3, 4))
G = 100.0 * INDICES[0] + 10.0 * INDICES[1] + INDICES[2]  # [z, y, x]

Y_GLOBE, R_GLOBE, LON_GLOBE = (60.0, 0.0, -60.0), (1.0, 2.0), (0.0, 120.0, 240.0)


def write_fits(name, hdus):
    fits.HDUList(hdus).writeto(FOLDER / name, overwrite=True)


def image(data, name=None, kind=fits.ImageHDU, **cards):
    hdu = kind(data)
    if name:
        hdu.header["EXTNAME"] = name
    for key, value in cards.items():
        hdu.header[key] = value
    return hdu


def write_all_fits():
    unit = {"BUNIT": "cm-3 s-1"}
    axes = [image(X, "x"), image(Y, "y"), image(Z, "z")]
    write_fits("smile.fits", [image(G, kind=fits.PrimaryHDU, **unit), *axes])
    # Other types, the axes in another order, upper case.
    mixed = [image(Z.astype(">f4"), "Z"), image(X.astype(np.int16), "X"), image(Y, "Y")]
    write_fits("smile_mixed.fits", [image(G.astype(np.float32), kind=fits.PrimaryHDU), *mixed])
    nameless = [image(X), image(Y), image(Z)]
    write_fits("nameless.fits", [image(G.astype(np.uint8), kind=fits.PrimaryHDU), *nameless])
    # Cubes beside each other, none in the primary HDU.
    cubes = [image(2 * G, "other"), image(G, "emissivity", **unit)]
    write_fits("extension.fits", [fits.PrimaryHDU(), *cubes, *axes])
    linear = {"CRPIX1": 1.0, "CRVAL1": -1.0, "CDELT1": 0.5, "CRPIX2": 2.0, "CRVAL2": 0.0,
              "CDELT2": 3.0, "CRPIX3": 0.5, "CRVAL3": 10.0, "CDELT3": 10.0}
    write_fits("wcs.fits", [image(G, kind=fits.PrimaryHDU, **linear)])
    rotated = {**linear, "PC1_2": 0.1}
    write_fits("wcs_rotated.fits", [image(G, kind=fits.PrimaryHDU, **rotated)])
    write_fits("no_axes.fits", [image(G, kind=fits.PrimaryHDU)])
    write_fits("flat.fits", [image(G[0], kind=fits.PrimaryHDU), *axes])
    # Stored as integers: physical = BZERO + BSCALE stored, and one blank.
    scaled = image(G.copy(), kind=fits.PrimaryHDU)
    scaled.scale("int16", bzero=100.0, bscale=0.5)
    write_fits("scaled.fits", [scaled, *axes])
    blank = image(G.astype(np.int16), kind=fits.PrimaryHDU, BLANK=112)
    write_fits("blank.fits", [blank, *axes])


def write_all_numpy():
    for name, kind in [("f8", "<f8"), ("f4_big", ">f4"), ("i2", "<i2"), ("i8_big", ">i8"),
                       ("u1", "|u1"), ("i4_big", ">i4"), ("u8", "<u8")]:
        np.save(FOLDER / f"{name}.npy", G.astype(kind))
    np.save(FOLDER / "negative_i2.npy", -G.astype(">i2"))
    np.save(FOLDER / "fortran.npy", np.asfortranarray(G))
    np.save(FOLDER / "xyz.npy", np.ascontiguousarray(G.T))
    np.save(FOLDER / "complex.npy", G.astype(complex))
    np.savez(FOLDER / "plain.npz", values=G, x=X, y=Y, z=Z)
    np.savez_compressed(FOLDER / "compressed.npz", rate=G.astype("f4"), lon=X, lat=Y, z=Z)


def write_all_hdf5():
    with h5py.File(FOLDER / "plain.h5", "w") as file:
        file["values"] = G
        file["values"].attrs["units"] = "cm-3 s-1"
        file["x"], file["y"], file["z"] = X, Y, Z.astype("f4")
    # Chunks that do not divide the shape, filters, a group, big-endian numbers.
    with h5py.File(FOLDER / "group.h5", "w", libver="latest") as file:
        run = file.create_group("run/last")
        run.create_dataset("g", data=G.astype(">f4"), chunks=(2, 2, 3), compression="gzip",
                           shuffle=True, fletcher32=True)
        for name, axis in (("x", X), ("y", Y), ("z", Z)):
            run[name] = axis
        file["note"] = "text is no number"
    # A chunk that was never written has the fill value, and an attribute may call it missing.
    for name, missing in (("unwritten.h5", None), ("missing.h5", -1.0)):
        with h5py.File(FOLDER / name, "w") as file:
            values = file.create_dataset("values", G.shape, "f8", chunks=(1, 3, 4), fillvalue=-1.0)
            values[0] = G[0]
            if missing is not None:
                values.attrs["_FillValue"] = missing
            file["x"], file["y"], file["z"] = X, Y, Z


def write_netcdf(name, kind, order, fill=None, packed=False, names="xyz"):
    with netCDF4.Dataset(FOLDER / name, "w", format=kind) as file:
        for axis, data, called in zip("xyz", (X, Y, Z), names):
            file.createDimension(called, len(data))
            file.createVariable(called, "f8", (called,))[:] = data
        by_axis = dict(zip("xyz", names))
        dimensions = tuple(by_axis[axis] for axis in order)
        values = file.createVariable("values", "i2" if packed else "f4", dimensions,
                                     fill_value=fill)
        values.units = "cm-3 s-1"
        if packed:
            values.scale_factor, values.add_offset = 0.5, 100.0
        data = np.transpose(G, ["zyx".index(axis) for axis in order])
        values[:] = np.ma.masked_equal(data, 112.0) if fill is not None else data


def write_all_netcdf():
    write_netcdf("classic.nc", "NETCDF3_CLASSIC", "zyx")
    write_netcdf("version4.nc", "NETCDF4", "zyx")
    write_netcdf("version4_yxz.nc", "NETCDF4", "yxz")
    write_netcdf("packed.nc", "NETCDF3_64BIT_OFFSET", "zyx", packed=True)
    write_netcdf("fill.nc", "NETCDF4", "zyx", fill=-999.0)
    write_netcdf("named_axes.nc", "NETCDF4", "zyx", names=("lon", "lat", "height"))
    # Never written at all: the default fill value of the format.
    with netCDF4.Dataset(FOLDER / "default_fill.nc", "w", format="NETCDF3_CLASSIC") as file:
        for axis, data in zip("xyz", (X, Y, Z)):
            file.createDimension(axis, len(data))
            file.createVariable(axis, "f8", (axis,))[:] = data
        file.createVariable("values", "f4", ("z", "y", "x"))[0] = G[0]


def write_globe():
    """Spherical: descending latitudes and the names and units of geography."""
    axes = {"lat": (Y_GLOBE, "degrees_north"), "radius": (R_GLOBE, "km"), "lon": (LON_GLOBE, "degrees_east")}
    with netCDF4.Dataset(FOLDER / "globe.nc", "w", format="NETCDF3_CLASSIC") as file:
        for name, (data, unit) in axes.items():
            file.createDimension(name, len(data))
            variable = file.createVariable(name, "f8", (name,))
            variable[:] = data
            variable.units = unit
        values = file.createVariable("values", "f8", ("lat", "radius", "lon"))
        lat, radius, lon = np.meshgrid(Y_GLOBE, R_GLOBE, LON_GLOBE, indexing="ij")
        values[:] = radius + lat / 100 + 10 * (lon == 120)


def main():
    FOLDER.mkdir(exist_ok=True)
    write_all_fits()
    write_all_numpy()
    write_all_hdf5()
    write_all_netcdf()
    write_globe()
    for path in sorted(FOLDER.iterdir()):
        print(f"{os.path.getsize(path):8} {path.name}")


main()
