"""The same scene by the command and from Python: the same FITS files, header by header, and report."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from astropy.io import fits

import emitree

ROOT = Path(__file__).parents[2]
#: The command, which `cargo xtask python` builds for this; by hand: `cargo build -p emitree-cli`.
COMMAND = Path(os.environ.get("EMITREE_COMMAND", ROOT / "target/debug/emitree"))
EXAMPLES = ROOT / "examples"
#: What differs from run to run.
TIMES = {"DATE", "CHECKSUM", "DATASUM"}
MEASURED = {"seconds", "peak_memory_bytes"}

IMAGE = {"image.width": 24, "image.height": 16}


def cards(hdu):
    return [tuple(card) for card in hdu.header.cards if card.keyword not in TIMES]


def settled(report):
    return {key: value for key, value in report.items() if key not in MEASURED}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("holmstrom", IMAGE),
        ("holmstrom", IMAGE | {"render.method": "paper"}),
        ("k_corona", {"image.width": 16, "image.height": 16, "render.tolerance": 0.1}),
        ("bremsstrahlung", {"image.width": 12, "image.height": 12, "render.tolerance": 0.1}),
        ("power_law", {"image.nside": 4, "render.tolerance": 0.1}),
    ],
)
def test_the_command_and_python_write_the_same_file(tmp_path, name, changes):
    scene = EXAMPLES / f"{name}.toml"
    ours = tmp_path / "python.fits"
    rendering = emitree.render(scene, changes=changes)
    rendering.to_fits(ours)
    theirs, report = tmp_path / "command.fits", tmp_path / "report.json"
    sets = [f"--set={key}={value}" for key, value in changes.items()]
    subprocess.run(
        [COMMAND, "render", scene, *sets, "-o", theirs, "--report", report, "--quiet"],
        check=True,
        timeout=60,
    )
    assert settled(json.loads(report.read_text())) == settled(rendering.report)
    with fits.open(ours) as python, fits.open(theirs) as command:
        assert [hdu.name for hdu in python] == [hdu.name for hdu in command]
        for one, other in zip(python, command, strict=True):
            assert cards(one) == cards(other)
            if one.data is not None and one.data.dtype.names is None:
                assert np.array_equal(one.data, other.data, equal_nan=True)
            elif one.data is not None:
                for column in one.data.dtype.names:
                    assert np.array_equal(one.data[column], other.data[column], equal_nan=True)
