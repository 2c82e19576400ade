"""Tables of functions: arrays, files, interpolation, messages."""

import pickle

import numpy as np
import pytest

import emitree

T, N = np.array([1.0, 10.0, 100.0]), np.array([2.0, 4.0, 8.0])
LOGARITHMS = ("T", "n", "values")


def power_law(t, n):
    return n**2 / t


def test_a_power_law_is_exact_in_logarithms():
    table = emitree.Table(power_law(T[:, None], N), {"T": T, "n": N}, logarithmic=LOGARITHMS)
    t, n = np.geomspace(1, 100, 13)[:, None], np.linspace(2, 8, 7)
    np.testing.assert_allclose(table(t, n), power_law(t, n), rtol=1e-13)
    assert table.arguments == ("T", "n")
    np.testing.assert_array_equal(table.nodes("n"), N)
    assert repr(table) == "<emitree.Table: T from 1 to 100, n from 2 to 8>"
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(table))(t, n), table(t, n))


def test_data_arrays_have_names_and_nodes():
    xarray = pytest.importorskip("xarray")
    data = xarray.DataArray(
        power_law(T[:, None], N), dims=("T", "n"), coords={"T": T, "n": N}, name="L"
    )
    table = emitree.Table(data, logarithmic=["T", "n", "L"])
    assert table(20.0, 3.0) == pytest.approx(power_law(20.0, 3.0), rel=1e-13)
    with pytest.raises(emitree.SceneError, match="no coordinate for its dimension n"):
        emitree.Table(data.drop_vars("n"))


def test_beyond_the_axes():
    linear = {"values": [2.0, 4.0], "axes": {"T": [1.0, 3.0]}}
    strict = emitree.Table(**linear)
    with pytest.raises(emitree.SceneError, match="the argument `T` is 4: expected 1 to 3"):
        strict([2.0, 4.0])
    assert emitree.Table(**linear, outside="zero")([0.0, 2.0, 4.0]).tolist() == [0, 3, 0]
    assert emitree.Table(**linear, outside="edge")([0.0, 2.0, 4.0]).tolist() == [2, 3, 4]


@pytest.mark.parametrize("ending", ["csv", "ecsv", "fits", "npz", "h5"])
def test_files(ending, tmp_path):
    file = tmp_path / f"cooling.{ending}"
    axes, values = ["T", "n"], "L"
    rows = np.array([(t, n, power_law(t, n)) for n in N for t in T[::-1]])
    if ending == "csv":
        np.savetxt(file, rows, header="T,n,L", delimiter=",", comments="")
    elif ending in ("ecsv", "fits"):
        table = pytest.importorskip("astropy.table")
        table.Table(rows, names=["T", "n", "L"]).write(file)
    elif ending == "npz":
        np.savez(file, T=T, n=N, L=power_law(T[:, None], N))
    else:
        h5py = pytest.importorskip("h5py")
        with h5py.File(file, "w") as opened:
            opened["a/T"], opened["a/n"], opened["a/L"] = T, N, power_law(T[:, None], N)
        axes, values = ["a/T", "a/n"], "a/L"
    table = emitree.Table(values, axes, file=file, logarithmic=[*axes, values], scale=2.0)
    assert table(30.0, 5.0) == pytest.approx(2 * power_law(30.0, 5.0), rel=1e-12)
    assert pickle.loads(pickle.dumps(table))(30.0, 5.0) == table(30.0, 5.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "expected `values`, an array, or `file`"),
        ({"values": [1, 2]}, "expected `axes`, the nodes of each argument by its name"),
        (
            {"values": [1, 2], "axes": {"T": [1, 2, 3]}},
            r"`values` has the shape \(2,\): expected \(3,\)",
        ),
        ({"values": [1, 2], "axes": {"T": [1, 1]}}, "node 1 of the axis `T` is 1 and follows 1"),
        ({"values": [1, 0], "axes": {"T": [1, 2]}, "logarithmic": "values"}, "above 0"),
        ({"values": [1, 2], "axes": {"T": [1, 2]}, "logarithmic": "t"}, "`logarithmic` has 't'"),
        ({"values": [1, 2], "axes": {"T": [1, 2]}, "outside": "nan"}, "`outside` is 'nan'"),
        ({"values": [1, 2], "axes": {"T": [1, 2]}, "format": "csv"}, "`format` is for files"),
        ({"values": "a", "axes": {"T": [1]}, "file": "a.csv"}, "`axes` has arrays"),
        ({"file": "no.csv"}, "the table .*no.csv: it can't be read"),
        ({"file": "no.doc"}, "no table format for this ending"),
        ({"file": "no.csv", "format": "doc"}, "`format` is 'doc': expected one of 'csv'"),
    ],
)
def test_messages(options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.Table(**options)


def test_what_is_wrong_in_a_file_has_its_line(tmp_path):
    file = tmp_path / "cooling.csv"
    file.write_text("T,L\n1,2\n2,none\n")
    with pytest.raises(emitree.SceneError, match=r"cooling.csv: line 3: the column `L` is `none`"):
        emitree.Table(file=file)
