"""Random emissions with exact integrals along lines, and random families of lines."""

import numpy as np
from scipy.special import erf

import emitree


def gaussians(rng, narrowest=0.2):
    """A sum of Gaussians of widths from ``narrowest`` to 1, and its integrals along lines.

    The default is what images resolve.
    """
    count = rng.integers(1, 5)
    centres, heights = rng.uniform(-0.6, 0.6, (count, 3)), rng.uniform(0.2, 1, count)
    sigmas = np.exp(rng.uniform(np.log(narrowest), 0, count))

    def emission(position, direction):
        squares = [((position - centre) ** 2).sum(axis=1) for centre in centres]
        return sum(
            h * np.exp(-q / (2 * s * s)) for h, q, s in zip(heights, squares, sigmas, strict=True)
        )

    def exact(lines):
        total = 0.0
        for centre, height, sigma in zip(centres, heights, sigmas, strict=True):
            offset, width = lines.positions - centre, sigma * np.sqrt(2)
            along = (offset * lines.directions).sum(axis=1)
            square = (offset**2).sum(axis=1) - along**2
            ends = erf((along + lines.lengths) / width) - erf(along / width)
            total += height * np.exp(-square / width**2) * width * np.sqrt(np.pi) / 2 * ends
        return total

    return emission, exact


def balls(rng):
    """A sum of balls, and its integrals along lines."""
    count = rng.integers(1, 4)
    centres, heights = rng.uniform(-0.5, 0.5, (count, 3)), rng.uniform(0.2, 1, count)
    radii = rng.uniform(0.4, 0.9, count)
    each = list(zip(centres, radii, heights, strict=True))

    def emission(position, direction):
        total = np.zeros(len(position))
        for centre, radius, height in each:
            total += height * (((position - centre) ** 2).sum(axis=1) < radius**2)
        return total

    def exact(lines):
        total = np.zeros(len(lines))
        for centre, radius, height in each:
            offset = lines.positions - centre
            along = (offset * lines.directions).sum(axis=1)
            square = radius**2 - (offset**2).sum(axis=1) + along**2
            half = np.sqrt(np.maximum(square, 0))
            ends = [np.clip(end, 0, lines.lengths) for end in (-along - half, -along + half)]
            total += np.where(square > 0, height * (ends[1] - ends[0]), 0)
        return total

    return emission, exact


def random_family(rng, kind, count):
    """Lines through one point outside or inside, parallel ones, or a fan."""
    place = rng.normal(size=3)
    place *= 2 / np.linalg.norm(place)
    if kind == "fan":
        ends = rng.uniform(-0.8, 0.8, (2, 3))
        share = np.linspace(0, 1, count)[:, np.newaxis]
        return emitree.Lines(place, ends[0] + share * (ends[1] - ends[0]) - place, 4.0)
    if kind == "inside":
        return emitree.Lines(rng.uniform(-0.3, 0.3, 3), rng.normal(size=(count, 3)), 3.0)
    target = rng.uniform(-0.8, 0.8, (count, 3))
    if kind == "parallel":
        direction = -0.5 * place
        target -= (target @ direction)[:, np.newaxis] * direction
        return emitree.Lines(target - 2 * direction, direction, 4.0)
    return emitree.Lines(place, target - place, rng.uniform(2, 6))
