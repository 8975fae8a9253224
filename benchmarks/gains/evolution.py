"""CMA-ES within the unit cube, by the package `cmaes` of the extra ``bench``.

Hansen, *The CMA Evolution Strategy: A Tutorial*, arXiv:1604.00772. A search is a function of its
start and its seed, so that one that was stopped goes on by being told the costs that it knew.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import MissingExtraError

SPREAD = 0.2
"""First standard deviation, as a share of each range."""


class Evaluation(NamedTuple):
    """A point (n,) of the unit cube, its place in the search and its cost."""

    number: int
    point: FloatArray
    cost: float


def minimise(
    cost: Callable[[int, FloatArray], float],
    start: FloatArray,
    *,
    draws: int,
    seed: int,
    known: Mapping[int, float] | None = None,
) -> Iterator[Evaluation]:
    """Points of a search for the least cost, in their order; the first is the start.

    Args:
        cost: of a point by its number.
        start: (n,) in 0..1, n at least 2; the mean of the first generation.
        draws: how many points.
        seed: of the search.
        known: costs by number, of an earlier search with the same start and seed.

    Raises:
        MissingExtraError: `cmaes` is not installed.
    """
    try:
        module = importlib.import_module("cmaes")
    except ImportError as error:
        raise MissingExtraError(
            "searches need the package cmaes; install it with pip install 'warp-softbody[bench]'"
        ) from error
    known = known or {}

    def sample(number: int, point: FloatArray) -> Evaluation:
        found = known[number] if number in known else cost(number, point)
        return Evaluation(number, point, found)

    bounds = np.tile([0.0, 1.0], (len(start), 1))
    optimiser = module.CMA(mean=start.copy(), sigma=SPREAD, bounds=bounds, seed=seed)
    yield sample(0, start)
    generation: list[tuple[FloatArray, float]] = []
    for number in range(1, draws):
        made = sample(number, np.asarray(optimiser.ask()))
        generation.append((made.point, made.cost))
        yield made
        if len(generation) == optimiser.population_size:
            optimiser.tell(generation)
            generation = []
