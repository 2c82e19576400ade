"""Caches: no point is evaluated twice, whatever happens."""

import json
import os
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from models import peak, spectral

import emitree

CUBE = emitree.Canonical()
RECORD = 72
#: Stored points that are evaluated again when a cache is opened, at the most.
COMPARED = 8


class Counted:
    """A function that stores the points that it is called with."""

    def __init__(self, function=peak):
        self.function = function
        self.points = []

    def __call__(self, *arguments):
        self.points += map(bytes, np.hstack([a.reshape(len(a), -1) for a in arguments]))
        return self.function(*arguments)


def same(one, other):
    return np.array_equal(one.image, other.image) and np.array_equal(one.error, other.error)


@pytest.mark.parametrize("name", ["folder", "run.h5"])
def test_a_second_run_evaluates_nothing(tmp_path, name):
    if name.endswith(".h5"):
        pytest.importorskip("h5py")
    plain = emitree.render(peak, CUBE, (32, 32), tolerance=1e-3)
    first, second = Counted(), Counted()
    one = emitree.render(first, CUBE, (32, 32), tolerance=1e-3, cache=tmp_path / name)
    two = emitree.render(second, CUBE, (32, 32), tolerance=1e-3, cache=tmp_path / name)
    assert same(plain, one) and same(plain, two)
    assert len(set(first.points)) == len(first.points)
    assert 0 < len(second.points) <= COMPARED and set(second.points) <= set(first.points)
    assert two.report["cache"] == {
        "found": plain.evaluations,
        "added": 0,
        "compared": len(second.points),
        "damaged": 0,
    }
    assert one.report["cache"]["added"] == len(first.points)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_finer_image_takes_what_is_there(tmp_path):
    first, second = Counted(), Counted()
    emitree.render(first, CUBE, (32, 32), tolerance=1e-2, cache=tmp_path / "c")
    finer = emitree.render(second, CUBE, (32, 32), tolerance=1e-3, cache=tmp_path / "c")
    assert same(finer, emitree.render(peak, CUBE, (32, 32), tolerance=1e-3))
    assert len(second.points) > COMPARED
    assert len(set(first.points) & set(second.points)) <= COMPARED


def test_energies_tell_points_apart(tmp_path):
    options = {"energy": {"min": 1, "max": 2, "bins": 2}, "cache": tmp_path / "c"}
    first, second = Counted(spectral), Counted(spectral)
    one = emitree.render(first, CUBE, (8, 8), **options)
    two = emitree.render(second, CUBE, (8, 8), **options)
    assert first.points and len(second.points) <= COMPARED and same(one, two)
    del options["cache"]
    assert same(one, emitree.render(spectral, CUBE, (8, 8), **options))


def test_executors_and_caches_go_together(tmp_path):
    counted = Counted()
    with ThreadPoolExecutor(2) as executor:
        options = {"executor": executor, "cache": tmp_path / "c", "tolerance": 1e-3}
        one = emitree.render(counted, CUBE, (32, 32), **options)
    assert same(one, emitree.render(peak, CUBE, (32, 32), tolerance=1e-3))
    assert len(set(counted.points)) == len(counted.points)
    assert (tmp_path / "c" / "points.f64").stat().st_size == RECORD * len(counted.points)


def test_a_mistake_loses_nothing_and_is_not_kept(tmp_path):
    calls = []

    def breaks(position, direction):
        calls.append(len(position))
        rates = peak(position, direction)
        if len(calls) == 3:
            rates[-1] = np.nan
        return rates

    with pytest.raises(emitree.EmissionError):
        emitree.render(breaks, CUBE, (32, 32), tolerance=1e-3, cache=tmp_path / "c")
    points = (tmp_path / "c" / "points.f64").stat().st_size // RECORD
    assert points == sum(calls) - 1
    counted = Counted()
    mended = emitree.render(counted, CUBE, (32, 32), tolerance=1e-3, cache=tmp_path / "c")
    assert same(mended, emitree.render(peak, CUBE, (32, 32), tolerance=1e-3))
    compared = mended.report["cache"]["compared"]
    assert len(counted.points) == mended.evaluations - points + compared


def test_a_torn_end_is_dropped(tmp_path):
    emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    points = tmp_path / "c" / "points.f64"
    whole = points.read_bytes()
    points.write_bytes(whole[:-10])
    again = emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    assert again.report["cache"]["added"] == 1 and points.read_bytes() == whole


@pytest.mark.skipif(sys.platform == "win32", reason="caches are locked on Unix alone")
def test_two_renderings_need_two_caches(tmp_path):
    def nested(position, direction):
        emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "c")

    with pytest.raises(ValueError, match="another rendering uses it"):
        emitree.render(nested, CUBE, (4, 4), cache=tmp_path / "c")
    emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "c")


def test_other_units_need_another_cache(tmp_path):
    emitree.render(peak, emitree.Canonical(length_unit="km"), (4, 4), cache=tmp_path / "c")
    with pytest.raises(ValueError, match="`length_unit` is 'km': expected 'm', or another cache"):
        emitree.render(peak, emitree.Canonical(length_unit="m"), (4, 4), cache=tmp_path / "c")
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "mine.txt").write_text("not a cache")
    with pytest.raises(ValueError, match="expected a new or empty folder, or a cache"):
        emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "d")


def flipped(data, place, bits):
    """Bytes with some bits of one of them flipped."""
    changed = bytearray(data)
    changed[place] ^= bits
    return bytes(changed)


def with_rate(data, rate):
    """The first record with another rate, and the checksum that it had."""
    return data[:56] + np.float64(rate).tobytes() + data[64:]


@pytest.mark.parametrize("damage", [
    lambda data: flipped(data, 56 + 6, 0x40),
    lambda data: flipped(data, 56 + 2, 0x10),
    lambda data: flipped(data, 3, 0x01),
    lambda data: with_rate(data, np.nan),
    lambda data: data[:50 * RECORD] + bytes(10 * RECORD) + data[60 * RECORD:],
    lambda data: data[:40 * RECORD] + data[40 * RECORD + 13:],
    lambda data: data + bytes(1000 * RECORD),
], ids=["exponent", "mantissa", "position", "nan", "zeros", "lost bytes", "zero tail"])  # fmt: skip
def test_damaged_points_are_evaluated_again(tmp_path, damage):
    plain = emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    points = tmp_path / "c" / "points.f64"
    whole = points.read_bytes()
    points.write_bytes(damage(whole))
    with pytest.warns(UserWarning, match="damaged points: .*; they are evaluated again") as warned:
        again = emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    assert str(tmp_path / "c") in str(warned[0].message)
    cache = again.report["cache"]
    assert same(plain, again) and cache["damaged"] > 0
    assert cache["added"] == plain.evaluations - cache["found"]
    # What came anew is a record like the others.
    third = Counted()
    missing = np.frombuffer(points.read_bytes()).reshape(-1, 9)
    assert len(missing) >= plain.evaluations
    if points.read_bytes() == whole:
        emitree.render(third, CUBE, (8, 8), cache=tmp_path / "c")
        assert len(third.points) <= COMPARED


def test_a_zero_tail_is_cut_off(tmp_path):
    emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    points = tmp_path / "c" / "points.f64"
    whole = points.read_bytes()
    points.write_bytes(whole + bytes(1000 * RECORD))
    with pytest.warns(UserWarning, match="damaged points: 1000;"):
        emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    assert points.read_bytes() == whole


def test_a_cache_without_an_intact_point_is_refused(tmp_path):
    emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    points = tmp_path / "c" / "points.f64"
    shifted = points.read_bytes()[13:]
    points.write_bytes(shifted)
    with pytest.raises(ValueError, match=r"points\.f64: .*\(no point of it is intact\).*delete it"):
        emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    # Nothing is lost: the file can be repaired by hand.
    assert points.read_bytes() == shifted
    points.write_bytes(b"")
    emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")


def another(position, direction):
    return np.exp(-39 * ((position - 0.5) ** 2).sum(axis=1))


@pytest.mark.parametrize("name", ["folder", "run.h5"])
def test_another_function_is_refused(tmp_path, name):
    if name.endswith(".h5"):
        pytest.importorskip("h5py")
    first = emitree.render(peak, CUBE, (8, 8), cache=tmp_path / name)
    message = (
        r"it was filled by another function, models\.peak: at position \[.*\], emission direction "
        r".* it has the rate .*, and test_cache\.another gives .*: expected the same function"
    )
    with pytest.raises(ValueError, match=message) as raised:
        emitree.render(another, CUBE, (8, 8), cache=tmp_path / name)
    assert str(tmp_path / name) in str(raised.value)
    again = emitree.render(peak, CUBE, (8, 8), cache=tmp_path / name)
    assert same(first, again) and again.report["cache"]["added"] == 0


def test_rounding_is_no_other_function(tmp_path):
    emitree.render(peak, CUBE, (8, 8), cache=tmp_path / "c")
    again = emitree.render(
        lambda r, d: peak(r, d).astype(np.float32), CUBE, (8, 8), cache=tmp_path / "c"
    )
    assert again.report["cache"]["compared"] > 0


@pytest.mark.parametrize("text", [
    b"", b"{}", b"[]", b"null", b'{"format":', b'{"format":1}', b"\xff",
])  # fmt: skip
def test_a_damaged_description_is_named(tmp_path, text):
    emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "c")
    about = tmp_path / "c" / "about.json"
    about.write_bytes(text)
    with pytest.raises(ValueError, match="expected ") as raised:
        emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "c")
    assert str(about) in str(raised.value) and type(raised.value) is ValueError
    about.unlink()
    with pytest.raises(ValueError, match=r"no about\.json"):
        emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "c")


@pytest.mark.parametrize("damage", [
    lambda data: b"",
    lambda data: data[: len(data) // 2],
    lambda data: b"plain text",
], ids=["empty", "half", "text"])  # fmt: skip
def test_a_damaged_hdf5_file_is_named(tmp_path, damage):
    pytest.importorskip("h5py")
    emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "run.h5")
    file = tmp_path / "run.h5"
    file.write_bytes(damage(file.read_bytes()))
    with pytest.raises(ValueError, match=r"run\.h5: it can't be read .*delete it to start anew"):
        emitree.render(peak, CUBE, (4, 4), cache=file)
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize("place", [0.2, 0.5, 0.9])
def test_a_byte_of_an_hdf5_file(tmp_path, place):
    h5py = pytest.importorskip("h5py")
    plain = emitree.render(peak, CUBE, (4, 4), cache=tmp_path / "run.h5")
    file = tmp_path / "run.h5"
    with h5py.File(file) as opened:
        start, length = opened["points"].id.get_offset(), opened["points"].id.get_storage_size()
    data = file.read_bytes()
    file.write_bytes(flipped(data, start + int(place * length), 0xFF))
    with pytest.warns(UserWarning, match="damaged points: 1;"):
        again = emitree.render(peak, CUBE, (4, 4), cache=file)
    assert same(plain, again)


@pytest.mark.parametrize("name", [5, "", "a\0b"])
def test_what_is_no_name_is_no_cache(name):
    with pytest.raises(TypeError, match="expected the name of a folder, or of an HDF5 file"):
        emitree.render(peak, CUBE, (4, 4), cache=name)


KILLED = """
    import sys, time
    import numpy as np
    import emitree

    log, cache = open(sys.argv[1], "ab", buffering=0), sys.argv[2]

    def expensive(position, direction):
        rates = np.exp(-40 * ((position - 0.5) ** 2).sum(axis=1))
        time.sleep(float(sys.argv[3]))
        log.write(np.hstack([position, direction]).tobytes())
        return rates

    rendering = emitree.render(
        expensive, emitree.Canonical(), (64, 64), tolerance=1e-3, batch_size=100, cache=cache
    )
    np.save(sys.argv[4], np.stack([rendering.image, rendering.error]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is for Unix")
@pytest.mark.parametrize("name", ["folder", "run.h5"])
def test_after_a_kill_it_goes_on(tmp_path, name):
    if name.endswith(".h5"):
        pytest.importorskip("h5py")
    log, found = tmp_path / "log", tmp_path / "found.npy"
    script = tmp_path / "run.py"
    script.write_text(textwrap.dedent(KILLED))

    def start(seconds):
        arguments = [str(log), str(tmp_path / name), str(seconds), str(found)]
        return subprocess.Popen([sys.executable, str(script), *arguments])

    folder = tmp_path / (name + ".points" if name.endswith(".h5") else name)
    recorded = {}
    for points in (300, 1200):
        with start(0.02) as process:
            while size(folder / "points.f64") < points * RECORD:
                assert process.poll() is None, "it ended before it could be killed"
                time.sleep(0.005)
            process.kill()
        assert process.returncode == -9 and not found.exists()
        whole = size(folder / "points.f64") // RECORD
        records = np.fromfile(folder / "points.f64", count=9 * whole).reshape(-1, 9)
        recorded[len(logged(log))] = set(map(bytes, records[:, :6]))
    assert json.loads((folder / "about.json").read_text())["version"] == 2
    with start(0.0) as process:
        assert process.wait(60) == 0

    plain = emitree.render(peak, CUBE, (64, 64), tolerance=1e-3)
    image, error = np.load(found)
    assert np.array_equal(image, plain.image) and np.array_equal(error, plain.error)
    # What was recorded at the time of a kill was not evaluated again, except the few points that
    # are compared in each of two runs.
    points = logged(log)
    assert len(recorded) == 2 and len(set(points)) == plain.evaluations
    for killed_at, known in recorded.items():
        assert known and known <= set(points[:killed_at])
        assert len(known & set(points[killed_at:])) <= 2 * COMPARED


def logged(path: Path) -> list[bytes]:
    """The points that the function returned for, in all runs."""
    return list(map(bytes, np.frombuffer(path.read_bytes()).reshape(-1, 6)))


def size(path: Path) -> int:
    return os.stat(path).st_size if path.exists() else 0
