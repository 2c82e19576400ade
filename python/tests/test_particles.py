"""Smoothed particles: kernels, sums and images against integrals of projected kernels."""

import pickle

import numpy as np
import pytest

import emitree

scipy_integrate = pytest.importorskip("scipy.integrate")
scipy_interpolate = pytest.importorskip("scipy.interpolate")

#: Names, and w(x) C as written in the sources, of x = r / H.
WRITTEN = {
    # Monaghan and Lattanzio (1985), eq. 21: of q = r / h, h = H / 2, 1 / (pi h^3).
    "cubic_spline": lambda x: (
        np.where(
            x < 0.5,
            1 - 1.5 * (2 * x) ** 2 + 0.75 * (2 * x) ** 3,
            0.25 * np.maximum(2 - 2 * x, 0) ** 3,
        )
        * 8
        / np.pi
    ),
    # Dehnen and Aly (2012), Table 1.
    "wendland_c2": lambda x: 21 / (2 * np.pi) * (1 - x) ** 4 * (1 + 4 * x),
    "wendland_c4": lambda x: 495 / (32 * np.pi) * (1 - x) ** 6 * (1 + 6 * x + 35 / 3 * x**2),
    "wendland_c6": lambda x: (
        1365 / (64 * np.pi) * (1 - x) ** 8 * (1 + 8 * x + 25 * x**2 + 32 * x**3)
    ),
}
NAMES = [*WRITTEN, "quartic_spline", "quintic_spline"]


def one(kernel, support_radius=1.0):
    return emitree.Particles([[0, 0, 0]], emission=1, support_radius=support_radius, kernel=kernel)


def along(distances):
    return np.column_stack([distances, 0 * distances, 0 * distances])


def cloud(count, seed=1):
    """Particles of a cloud whose density falls with the radius, with about 50 neighbours each."""
    rng = np.random.default_rng(seed)
    position = rng.normal(size=(count, 3))
    density = count * np.exp(-0.5 * (position**2).sum(axis=1)) / (2 * np.pi) ** 1.5
    radius = np.minimum((50 / (4 / 3 * np.pi * density)) ** (1 / 3), 1.5)
    return position, rng.uniform(0.5, 1.5, count) / count, radius


@pytest.mark.parametrize("name", NAMES)
def test_the_integral_over_space_is_one(name):
    kernel = one(name)
    breaks = [1 / 5, 1 / 3, 1 / 2, 3 / 5, 2 / 3]

    def moment(power):
        def integrand(r):
            return 4 * np.pi * r**power * kernel(along(np.array([r])))[0]

        return scipy_integrate.quad(integrand, 0, 1, points=breaks, epsabs=1e-12)[0]

    assert moment(2) == pytest.approx(1, abs=1e-10)
    # A third of the mean square of the distance is that of a coordinate.
    assert moment(4) / 3 == pytest.approx(kernel.standard_deviation[0] ** 2, rel=1e-5)


@pytest.mark.parametrize("name", WRITTEN)
def test_kernels_are_those_of_the_sources(name):
    x = np.linspace(0, 1, 41)
    np.testing.assert_allclose(one(name)(along(x)), WRITTEN[name](x), rtol=1e-12, atol=1e-13)
    # W(r, H) = W(r / H, 1) / H^3, and 0 beyond.
    np.testing.assert_allclose(
        one(name, 3.0)(along(3 * x)), WRITTEN[name](x) / 27, rtol=1e-12, atol=1e-13
    )
    assert not one(name)(along(np.array([1.0, 1.001, 50.0]))).any()


def test_smoothing_lengths_are_half_of_the_support_radii():
    by_length = emitree.Particles([[0, 0, 0]], emission=2, smoothing_length=0.5)
    # The value at the centre is q / (pi h^3).
    assert by_length(np.zeros((1, 3)))[0] == pytest.approx(2 / (np.pi * 0.125))
    assert by_length.support_radius.tolist() == [1.0]


def test_rates_are_the_sums_over_all_particles():
    position, emission, radius = cloud(3000)
    radius[:5] = [1e-3, 1e-2, 5, 20, 40]
    particles = emitree.Particles(position, emission=emission, support_radius=radius)
    points = np.random.default_rng(2).normal(size=(2000, 3)) * 1.5
    exact = np.zeros(len(points))
    for r, q, h in zip(position, emission, radius, strict=True):
        x = np.minimum(np.linalg.norm(points - r, axis=1) / h, 1)
        exact += q * WRITTEN["cubic_spline"](x) / h**3
    np.testing.assert_allclose(particles(points), exact, rtol=1e-10, atol=1e-14)
    # The rate at a point is the same, to the bit, beside whichever others.
    assert np.array_equal(particles(points[::-1])[::-1], particles(points))
    assert np.array_equal(particles(points[7:8]), particles(points)[7:8])
    assert np.array_equal(pickle.loads(pickle.dumps(particles))(points), particles(points))


def test_many_pairs_are_summed_in_parts(monkeypatch):
    position, emission, radius = cloud(2000)
    particles = emitree.Particles(position, emission=emission, support_radius=radius)
    points = np.random.default_rng(3).normal(size=(5000, 3))
    at_once = particles(points)
    monkeypatch.setattr("emitree._particles._PAIRS", 1000)
    assert np.array_equal(particles(points), at_once)
    assert particles(np.empty((0, 3))).shape == (0,)


def test_rates_per_volume_are_multiplied_by_the_volume():
    position, rate, radius = cloud(50)
    mass, density = np.linspace(1, 2, 50), np.linspace(3, 4, 50)
    options = {"support_radius": radius, "kernel": "wendland_c2"}
    of_masses = emitree.Particles(position, rate=rate, mass=mass, density=density, **options)
    of_volumes = emitree.Particles(position, rate=rate, volume=mass / density, **options)
    np.testing.assert_allclose(of_masses.emission, rate * mass / density, rtol=1e-15)
    assert np.array_equal(of_masses.emission, of_volumes.emission)


def test_a_constant_rate_on_a_lattice_is_nearly_constant():
    # Particles at equal distances of 1 with their volume 1: the sum of kernels is about 1.
    axis = np.arange(-4.0, 5.0)
    position = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    particles = emitree.Particles(
        position, rate=3, volume=1, support_radius=2.4, kernel="wendland_c2"
    )
    points = np.random.default_rng(0).uniform(-1, 1, (500, 3))
    np.testing.assert_allclose(particles(points), 3, rtol=0.03)


def projected(name):
    """The integral of a kernel with H = 1 along a line, as a function of its distance b."""

    def integral(b):
        def integrand(z):
            return float(WRITTEN[name](np.hypot(b, z)))

        end = np.sqrt(1 - b * b)
        breaks = [np.sqrt(0.25 - b * b)] if b < 0.5 else None
        return 2 * scipy_integrate.quad(integrand, 0, end, points=breaks, epsabs=1e-10)[0]

    table = np.linspace(0, 1, 201)
    values = np.array([*map(integral, table[:-1]), 0.0])
    spline = scipy_interpolate.CubicSpline(table, values, bc_type=((1, 0.0), (1, 0.0)))
    # The interpolation is right to a hundredth of the tolerance of the images.
    between = np.linspace(0, 0.999, 37)
    assert np.abs(spline(between) - [integral(b) for b in between]).max() < 1e-5 * values[0]
    return spline


def exact_image(name, particles, edge, count, order):
    """Means over pixels of the sum of projected kernels, by Gauss points in each pixel."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    side = edge / count
    centers = (np.arange(count) + 0.5) * side - edge / 2
    axis = (centers[:, None] + 0.5 * side * nodes).ravel()
    profile = projected(name)
    sums = np.zeros((axis.size, axis.size))
    parameters = (particles.position, particles.emission, particles.support_radius)
    for (_, y, z), q, h in zip(*parameters, strict=True):
        # Seen from +x, y points to the right and z up.
        rows, columns = (np.flatnonzero(abs(axis - at) < h) for at in (z, y))
        if len(rows) and len(columns):
            b = np.hypot((axis[rows] - z)[:, None], axis[columns] - y) / h
            sums[np.ix_(rows, columns)] += q / h**2 * np.where(b < 1, profile(b), 0.0)
    parts = sums.reshape(count, order, count, order)
    return np.einsum("iajb,a,b->ij", parts, weights / 2, weights / 2)


@pytest.mark.parametrize("name", ["cubic_spline", "wendland_c2"])
def test_images_are_sums_of_projected_kernels(name):
    position, emission, radius = cloud(1000)
    particles = emitree.Particles(position, emission=emission, support_radius=radius, kernel=name)
    rendering = emitree.render(particles, CAMERA, (40, 40), tolerance=0.01)
    exact = exact_image(name, particles, 5, 40, 6)
    largest = exact.max()
    assert np.abs(exact - exact_image(name, particles, 5, 40, 4)).max() < 2e-4 * largest
    assert rendering.converged
    assert np.abs(rendering.image - exact).max() < 0.01 * largest


def test_a_clump_in_one_pixel_is_seen():
    position, emission, radius = cloud(1000)
    clump = [0.3, 0.52, -0.7] + 0.01 * np.random.default_rng(4).normal(size=(200, 3))
    particles = emitree.Particles(
        np.vstack([position, clump]),
        emission=np.append(emission, np.full(200, 0.2 / 200)),
        support_radius=np.append(radius, np.full(200, 0.02)),
    )
    rendering = emitree.render(particles, CAMERA, (32, 32), tolerance=0.01)
    exact = exact_image("cubic_spline", particles, 5, 32, 24)
    # The clump is most of the brightest pixels.
    assert exact.max() > 5 * exact_image("cubic_spline", particles_of(1000), 5, 32, 4).max()
    assert rendering.converged
    assert np.abs(rendering.image - exact).max() < 0.01 * exact.max()


def test_there_are_few_seeds_whichever_particles():
    particles = particles_of(20000)
    assert 50 < len(particles.seeds) <= 500
    at, radius = particles.seeds[0]
    found = np.flatnonzero((particles.position == at).all(axis=1))
    assert particles.support_radius[found].tolist() == [radius]
    # None for methods that have no use for them.
    emitree.render(particles_of(10), CAMERA, (2, 2), method="los", steps=4)


def test_the_bounds_are_those_of_all_supports():
    particles = emitree.Particles([[0, 0, 0], [1, 2, 3]], emission=1, support_radius=[1, 0.5])
    assert particles.bounds == emitree.Box(min=(-1, -1, -1), max=(1.5, 2.5, 3.5))
    # Without depths a camera needs bounds.
    camera = emitree.Perspective(position=(20, 0, 0), target=(0, 0, 0), field_of_view=(20, 20))
    by_default = emitree.render(particles, camera, (8, 8))
    given = emitree.render(
        lambda *point: particles(*point),
        camera,
        (8, 8),
        bounds=particles.bounds,
        seeds=particles.seeds,
    )
    assert np.array_equal(by_default.image, given.image)
    half = emitree.Box(min=(-1, -1, -1), max=(0, 1, 1))
    cut = emitree.render(particles, camera, (8, 8), bounds=half)
    assert cut.image.sum() < 0.5 * given.image.sum()


CAMERA = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(5, 5))


def particles_of(count):
    position, emission, radius = cloud(count)
    return emitree.Particles(position, emission=emission, support_radius=radius)


GIVEN = {"position": np.zeros((2, 3)), "emission": [1, 1], "smoothing_length": [1, 1]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position": np.zeros((2, 2))}, r"`position` has the shape \(2, 2\): expected \(n, 3\)"),
        ({"position": np.zeros((0, 3))}, r"expected \(n, 3\), n at least 1"),
        ({"position": [[0, 0, 0], [0, np.nan, 0]]}, r"particle 1 is \[0.0, nan, 0.0\]"),
        ({"position": "here"}, "`position` is str: expected an array"),
        ({"emission": [1, 2, 3]}, r"`emission` has the shape \(3,\): expected \(2,\)"),
        ({"emission": [1, np.inf]}, "`emission` of particle 1 is inf: expected a finite number"),
        ({"emission": None}, "expected one of `emission`"),
        ({"rate": [1, 1]}, "expected one of `emission`"),
        ({"volume": 1}, "`volume` is for a `rate` per volume"),
        ({"emission": None, "rate": 1}, "`rate` has none of them beside it: expected `volume`"),
        ({"emission": None, "rate": 1, "mass": 1}, "`rate` has `mass` beside it"),
        (
            {"emission": None, "rate": 1, "mass": 1, "density": [0, 1]},
            "`density` of particle 0 is 0.0: expected a finite number above 0",
        ),
        ({"smoothing_length": [1, 0]}, "`smoothing_length` of particle 1 is 0.0"),
        ({"smoothing_length": None}, "expected one of `smoothing_length` and `support_radius`"),
        ({"support_radius": 1}, "expected one of `smoothing_length` and `support_radius`"),
        ({"smoothing_length": 1e-200}, "particle 0 has the emission 1.0 and the support"),
        ({"kernel": "gaussian"}, "`kernel` is 'gaussian': expected one of 'cubic_spline'"),
        (
            {"emission": np.ma.masked_equal([1, 2], 2)},
            r"`emission` is masked at \(1,\): expected a number or an array",
        ),
    ],
)
def test_wrong_arguments_are_named(changes, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.Particles(**(GIVEN | changes))


def test_quantities_are_refused():
    units = pytest.importorskip("astropy.units")
    with pytest.raises(emitree.SceneError, match="`smoothing_length` is a quantity in kpc"):
        emitree.Particles(**(GIVEN | {"smoothing_length": [1, 1] * units.kpc}))
