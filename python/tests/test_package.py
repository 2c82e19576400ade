"""The package itself: types, the tutorial, and its metadata."""

import json
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

import emitree

HERE = Path(__file__).parent


@pytest.mark.parametrize("arguments", [
    ["mypy.stubtest", "emitree", "--mypy-config-file", "pyproject.toml"],
    ["mypy", "--config-file", "pyproject.toml"],
], ids=lambda arguments: arguments[0])  # fmt: skip
def test_the_types_are_those_of_the_module(arguments, tmp_path):
    pytest.importorskip("mypy")
    environment = os.environ | {"MYPY_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", *arguments]
    subprocess.run(command, check=True, cwd=HERE.parent, env=environment)


def test_everything_is_documented():
    for name in emitree.__all__:
        if name != "__version__":
            assert getattr(emitree, name).__doc__, name


def test_the_version_is_one():
    assert emitree.__version__ == metadata.version("emitree")


#: The notebooks, and what only they need beside astropy, matplotlib and scipy.
NOTEBOOKS = {
    "tutorial": [],
    "fitting": [],
    "surfaces": [],
    "tomography": [],
    # sunpy.map needs reproject, and warns without it.
    "corona": ["sunpy", "reproject"],
    "exosphere": [],
    "magnetosphere": [],
    "cluster": ["yt"],
    "zodiacal": ["zodipy"],
    "darkmatter": ["gammapy"],
    "bolometer": [],
}


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_the_notebooks_run(name):
    for module in ("matplotlib", "astropy", "scipy", *NOTEBOOKS[name]):
        pytest.importorskip(module)
    notebook = json.loads((HERE.parent / "docs" / f"{name}.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells):
        assert not cell["outputs"], "expected a notebook without outputs"
        exec(compile("".join(cell["source"]), f"{name}, code cell {number}", "exec"), names)
    assert len(cells) > 5
    names["ax"].figure.canvas.draw()
    # matplotlib warns of more than twenty open figures.
    pytest.importorskip("matplotlib.pyplot").close("all")
