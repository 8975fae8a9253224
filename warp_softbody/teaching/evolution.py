"""CMA-ES within the unit cube, by the package `cmaes` of the extra ``teach``.

Hansen, *The CMA Evolution Strategy: A Tutorial*, arXiv:1604.00772. A search is a function of its
start, its seed and the costs, so that one that was stopped goes on where costs are remembered.
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
    costs: Callable[[Mapping[int, FloatArray]], Mapping[int, float]],
    start: FloatArray,
    *,
    draws: int,
    seed: int,
) -> Iterator[Evaluation]:
    """Points of a search for the least cost, in their order; the first is the start.

    Args:
        costs: by number, of a generation of points by their numbers.
        start: (n,) in 0..1, n at least 2; the mean of the first generation.
        draws: how many points.
        seed: of the search.

    Raises:
        MissingExtraError: `cmaes` is not installed.
    """
    try:
        module = importlib.import_module("cmaes")
    except ImportError as error:
        raise MissingExtraError(
            "searches need the package cmaes; install it with pip install 'warp-softbody[teach]'"
        ) from error

    def judged(points: Mapping[int, FloatArray]) -> list[Evaluation]:
        found = costs(points)
        return [Evaluation(number, point, found[number]) for number, point in points.items()]

    bounds = np.tile([0.0, 1.0], (len(start), 1))
    optimiser = module.CMA(mean=start.copy(), sigma=SPREAD, bounds=bounds, seed=seed)
    yield from judged({0: start})
    size = optimiser.population_size
    for first in range(1, draws, size):
        numbers = range(first, min(first + size, draws))
        generation = judged({number: np.asarray(optimiser.ask()) for number in numbers})
        yield from generation
        if len(generation) == size:
            optimiser.tell([(one.point, one.cost) for one in generation])
