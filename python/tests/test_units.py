"""Units: quantities in and out, and none needed."""

import subprocess
import sys
import tomllib

import numpy as np
import pytest

import emitree
from emitree import _units

u = pytest.importorskip("astropy.units")


def ball(position, direction):
    """A Gaussian ball, 1000 km wide, for positions in km."""
    return np.exp(-((position / 1000) ** 2).sum(axis=1))


LOOKING = {"target": (0, 0, 0), "field_of_view": (20, 20), "near": 0, "far": 20_000}
IN_KM = emitree.Perspective(position=(10_000, 0, 0), **LOOKING, length_unit="km")
RATE = "ph cm-3 s-1 sr-1"


def assert_same(ours, theirs, tolerance):
    """Factors change the last bits of g, and those the sample points."""
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=tolerance * theirs.max())


def test_quantities_are_converted():
    camera = emitree.Perspective(
        position=[10, 0, 0] * u.Mm,
        target=(0 * u.km, 0 * u.km, 0 * u.m),
        field_of_view=[20 * 60, 20 * 60] * u.arcmin,
        near=0,
        far=2e7 * u.m,
        length_unit="km",
    )
    plain = emitree.render(ball, IN_KM, (8, 8), unit=RATE)
    ours = emitree.render(ball, camera, (8, 8), unit=u.Unit("ph / (cm3 s sr)"))
    assert np.array_equal(plain.image, ours.image)
    assert plain.unit == "ph cm-2 s-1 sr-1" and u.Unit(ours.unit) == u.Unit(plain.unit)


def test_the_first_length_gives_the_unit():
    camera = emitree.Perspective(position=[10_000, 0, 0] * u.km, **LOOKING)
    assert np.array_equal(
        emitree.render(ball, camera, (8, 8)).image, emitree.render(ball, IN_KM, (8, 8)).image
    )


def test_lengths_of_edges_are_converted():
    plane = emitree.Plane(position=[1, 2, 3] * u.Mm, normal=(0, 0, 1))
    rendering = emitree.render("0", IN_KM, (2, 2), edges=[plane])
    assert tomllib.loads(rendering.scene)["edge"][0]["position"] == [1000.0, 2000.0, 3000.0]
    # As of bounds, the first length gives the unit if the camera has none.
    camera = emitree.Canonical()
    unit = tomllib.loads(emitree.render("0", camera, (2, 2), edges=[plane]).scene)["projection"]
    assert unit["length_unit"] == "Mm"


def test_images_are_quantities_on_request():
    rendering = emitree.render(ball, IN_KM, (9, 9), unit=RATE, tolerance=1e-3)
    middle = rendering.quantity[4, 4].to(u.Unit("ph / (m2 s sr)"))
    # sqrt(pi) 1000 km of 1 ph cm-3 s-1 sr-1, nearly.
    assert middle.value == pytest.approx(np.sqrt(np.pi) * 1e6 * 1e6, rel=0.05)
    assert rendering.error_quantity.unit == rendering.quantity.unit
    options = {"unit": RATE, "image_unit": "ph m-2 s-1 sr-1", "tolerance": 1e-3}
    other = emitree.render(ball, IN_KM, (9, 9), **options)
    assert_same(other.image, rendering.image * 1e4, 1e-3)
    with pytest.raises(ValueError, match="the image has no unit"):
        _ = emitree.render(ball, IN_KM, (2, 2)).quantity


def test_functions_may_return_quantities():
    def other(position, direction):
        return ball(position, direction) * u.Unit("1e6 ph / (m3 s sr)")

    plain = emitree.render(ball, IN_KM, (8, 8), unit=RATE)
    ours = emitree.render(other, IN_KM, (8, 8), unit=RATE)
    assert_same(ours.image, plain.image, 0.01)
    with pytest.raises(ValueError, match="expected `unit` to be given"):
        emitree.render(other, IN_KM, (8, 8))
    with pytest.raises(u.UnitConversionError):
        emitree.render(lambda r, d: r[:, 0] * u.km, IN_KM, (8, 8), unit=RATE)


def test_functions_may_take_quantities():
    def with_units(position, direction):
        assert direction.shape == position.shape and not hasattr(direction, "unit")
        return ball(position.to_value(u.km), direction) * u.Unit(RATE)

    plain = emitree.render(ball, IN_KM, (8, 8), unit=RATE)
    ours = emitree.render(with_units, IN_KM, (8, 8), unit=RATE, quantities=True)
    assert_same(ours.image, plain.image, 0.01)


def test_energies_may_be_quantities():
    def spectrum(position, direction, energy):
        return np.exp(-energy / 1000)

    energy = {"min": 0.5 * u.keV, "max": 2.5 * u.keV, "bins": 2, "unit": "eV"}
    ours = emitree.render(spectrum, emitree.Canonical(), (2, 2), energy=energy)
    np.testing.assert_allclose(ours.energies, [500, 1500, 2500])
    energy = {"min": 0.5 * u.keV, "max": 2.5 * u.keV, "bins": 2}
    ours = emitree.render("exp(-E)", emitree.Canonical(), (2, 2), energy=energy)
    assert ours.energy_unit == "keV"


def test_radii_are_those_of_emitree():
    assert _units.to_astropy("R_E").to(u.km) == pytest.approx(6371.0)
    assert _units.to_astropy("ph R_E-2 s-1").is_equivalent("ph / (m2 s)")
    assert _units.to_text(_units.to_astropy("R_E")) == "R_E"
    with pytest.raises(ValueError, match="expected one that FITS has, or a text such as 'R_E'"):
        _units.to_text(u.R_earth * u.s)
    camera = emitree.Perspective(position=[10, 0, 0] * u.R_earth, **LOOKING, length_unit="R_E")
    assert camera.table("R_E")["position"][0] == pytest.approx(10 * 6378.1 / 6371.0)


def test_radii_of_astropy_are_taken_as_they_are():
    # The equatorial radius of the Earth, and not emitree's `R_E`.
    assert _units.to_text(u.R_earth) == "R_E_eq" and _units.to_text(u.R_jup) == "R_jup"
    assert _units.to_astropy("R_E_eq").to(u.km) == pytest.approx(6378.1)
    looking = {"target": (0, 0, 0), "field_of_view": (20, 20), "near": 0, "far": 20}
    ours = emitree.Perspective(position=(10, 0, 0), **looking, length_unit=u.R_earth)
    rendering = emitree.render("exp(-r^2)", ours, (8, 8), unit=RATE)
    in_km = emitree.render("exp(-r^2)", ours, (8, 8), unit=RATE, image_unit="ph km-2 s-1 sr-1")
    plain = emitree.render("exp(-r^2)", emitree.Perspective(position=(10, 0, 0), **looking), (8, 8))
    np.testing.assert_allclose(rendering.image, plain.image * 6378.1e5, rtol=1e-12)
    np.testing.assert_allclose(in_km.image, plain.image * 6378.1e15, rtol=1e-12)
    assert rendering.to_fits()[0].header["LENUNIT"] == "R_E_eq"


def test_wrong_units_name_their_key():
    with pytest.raises(emitree.SceneError, match=r"`position` is .* s: expected a number in km"):
        emitree.render(
            ball, emitree.Perspective(position=[1, 0, 0] * u.s, **LOOKING, length_unit="km"), (2, 2)
        )
    energy = {"min": 1 * u.km, "max": 2 * u.km, "bins": 2, "unit": "keV"}
    with pytest.raises(
        emitree.SceneError, match=r"`energy\.min` is 1\.0 km: expected a number in keV"
    ):
        emitree.render(ball, IN_KM, (2, 2), energy=energy)


def test_borders_of_energy_bins_may_be_quantities():
    def spectrum(position, direction, energy):
        return np.exp(-energy / 1000)

    ours = emitree.render(spectrum, emitree.Canonical(), (2, 2), energy=[500, 1500, 2500] * u.eV)
    assert ours.energy_unit == "eV" and ours.report["energy"]["bins"] == 2
    table = {"min": 500, "max": 2500, "bins": 2, "unit": "eV", "lines": [1 * u.keV]}
    assert emitree.Energies(**table).table()["lines"] == [1000.0]


def test_lengths_without_a_unit_are_not_guessed():
    with pytest.raises(ValueError, match=r"`position` is .* expected a `length_unit` too"):
        IN_KM.__class__(position=[1, 0, 0] * u.km, **LOOKING).table(None)


def test_all_units_of_images_are_known_to_astropy():
    for unit in ("ph cm-2 s-1 sr-1", "R", "erg cm-2 s-1 sr-1", "keV m-2 s-1", "W m-2 sr-1"):
        assert _units.to_astropy(unit).to_string()


WITHOUT = """
import sys
for name in ("astropy", "matplotlib", "xarray", "tqdm", "h5py"):
    sys.modules[name] = None
import emitree
import numpy as np
camera = emitree.Perspective(
    position=np.array([10.0, 0, 0]), target=[0, 0, 0], field_of_view=[20, 20], far=20,
    length_unit="km",
)
rendering = emitree.render(
    lambda r, d: np.exp(-(r**2).sum(axis=1)), camera, np.array([8, 8]),
    unit="ph cm-3 s-1 sr-1", progress=True,
)
assert rendering.unit == "ph cm-2 s-1 sr-1" and rendering._repr_html_()
rendering.to_fits(sys.argv[1])
"""


def test_nothing_but_numpy_is_needed(tmp_path):
    arguments = [sys.executable, "-W", "error", "-c", WITHOUT, str(tmp_path / "image.fits")]
    subprocess.run(arguments, check=True)
    assert (tmp_path / "image.fits").stat().st_size % 2880 == 0
