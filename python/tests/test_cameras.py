"""The classes of cameras and the table of cameras of the scene reader are the same."""

import dataclasses
import inspect

import pytest

import emitree
from emitree import _native

ROWS = {row["python_class"]: row for row in _native.cameras()}


def test_every_row_has_a_class():
    classes = {name for name in emitree.__all__ if _is_camera(getattr(emitree, name))}
    # The image of a WCS is made of one by a camera of the table.
    assert classes == {*ROWS, "WcsCamera"}


def _is_camera(thing):
    is_class = inspect.isclass(thing) and issubclass(thing, emitree.Camera)
    return is_class and thing is not emitree.Camera


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_the_keywords_of_a_class_are_the_keys_of_its_row(row):
    fields = dataclasses.fields(getattr(emitree, row["python_class"]))
    assert {field.name for field in fields} == {key["name"] for key in row["keys"]}
    needed = {field.name for field in fields if field.default is dataclasses.MISSING}
    assert needed == {key["name"] for key in row["keys"] if key["required"]}


def test_a_class_of_a_user_is_the_camera_that_it_was_made_from():
    class Healpix(emitree.Perspective):
        pass

    camera = Healpix(position=(9, 0, 0), target=(0, 0, 0), field_of_view=(20, 20), far=20)
    assert emitree.render("exp(-r^2)", camera, (4, 4)).image.shape == (4, 4)
