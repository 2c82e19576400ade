"""NPY files as numpy reads them."""

import numpy as np
import pytest


def test_image_has_rows_first_and_the_lowest_row_first(samples, image):
    read = np.load(samples / "image.npy", allow_pickle=False)
    assert read.dtype == np.dtype("<f8")
    assert read.flags.c_contiguous
    np.testing.assert_array_equal(read, image)


def test_what_is_not_finite_is_kept(samples, error):
    np.testing.assert_array_equal(np.load(samples / "error.npy"), error)


def test_any_number_of_axes(samples, image):
    np.testing.assert_array_equal(np.load(samples / "cube.npy"), image[:, np.newaxis, :])


@pytest.mark.parametrize("name", ["image", "error", "cube"])
def test_the_bytes_are_those_that_numpy_writes(samples, tmp_path, name):
    np.save(tmp_path / "again.npy", np.load(samples / f"{name}.npy"))
    written = (tmp_path / "again.npy").read_bytes()
    read = (samples / f"{name}.npy").read_bytes()
    # NumPy leaves more spaces for growth of the first axis; the data and the dictionary agree.
    assert read[-8 * 35 :] == written[-8 * 35 :]
    start, end = read.index(b"{"), read.index(b"}")
    assert written[start : written.index(b"}")] == read[start:end]
    assert read[:8] == written[:8]
