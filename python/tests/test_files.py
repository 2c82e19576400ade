"""Files that Python writes: whole or absent, whatever happens."""

import subprocess
import sys
import textwrap

import pytest
from models import peak

import emitree

CUBE = emitree.Canonical()
BOX = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))

FULL = """
    import resource, signal, sys
    import emitree

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    peak = "exp(-30*((x-.5)^2+(y-.5)^2+(z-.5)^2))"
    rendering = emitree.render(peak, emitree.Canonical(), (64, 64))
    resource.setrlimit(resource.RLIMIT_FSIZE, (16384, 16384))
    try:
        if sys.argv[1] == "tree":
            box = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))
            emitree.build_tree(peak, sys.argv[2], box, tolerance=0.02)
        else:
            rendering.to_fits(sys.argv[2], overwrite=True)
    except OSError as error:
        assert sys.argv[2] in str(error), error
        print("no room")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits of files are for Unix")
@pytest.mark.parametrize("what", ["tree", "image"])
def test_a_full_disk_leaves_the_old_file(tmp_path, what):
    old = tmp_path / "old.fits"
    old.write_text("OLD")
    script = tmp_path / "run.py"
    script.write_text(textwrap.dedent(FULL))
    arguments = [sys.executable, str(script), what, str(old)]
    found = subprocess.run(arguments, check=True, capture_output=True, text=True)
    assert found.stdout == "no room\n"
    assert old.read_text() == "OLD"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["old.fits", "run.py"]


def test_a_tree_that_fails_leaves_the_old_file(tmp_path):
    old = tmp_path / "old.fits"
    old.write_text("OLD")

    def fails(position, direction):
        raise ArithmeticError

    with pytest.raises(ArithmeticError):
        emitree.build_tree(fails, old, BOX)
    assert old.read_text() == "OLD" and len(list(tmp_path.iterdir())) == 1


def test_a_tree_that_has_no_place_costs_nothing(tmp_path):
    calls = []

    def counted(position, direction):
        calls.append(len(position))
        return peak(position, direction)

    with pytest.raises(FileNotFoundError, match="expected a folder that can be written"):
        emitree.build_tree(counted, tmp_path / "no" / "tree.fits", BOX)
    with pytest.raises(OSError, match="is a directory: expected a new or an ordinary file"):
        emitree.build_tree(counted, tmp_path, BOX)
    assert not calls


def test_a_file_is_replaced_on_request_alone(tmp_path):
    path = tmp_path / "image.fits"
    rendering = emitree.render(peak, CUBE, (4, 4))
    rendering.to_fits(path)
    first = path.read_bytes()
    with pytest.raises(FileExistsError, match=r"image\.fits"):
        rendering.to_fits(path)
    assert path.read_bytes() == first
    emitree.render(peak, CUBE, (6, 6)).to_fits(path, overwrite=True)
    assert path.read_bytes() != first and len(list(tmp_path.iterdir())) == 1
