"""Cubes are split where they are asked to be, and cubes that touch differ by one level at most."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.body.making.octree import AROUND, LEVELS, Octree


@pytest.fixture(name="tree")
def grown() -> Octree:
    """A grid with some places of each level."""
    tree = Octree.around(np.zeros(3), np.array([1.0, 0.7, 0.9]), 0.2)
    rng = np.random.default_rng(1)
    tree.refine(*(rng.uniform(0.0, 0.7, (2, 3)) for _ in range(LEVELS)))
    return tree


def test_leaves_fill_the_grid(tree: Octree) -> None:
    volume = sum(len(cubes) / 8.0**level for level, cubes in enumerate(tree.leaves().cubes))
    assert volume == np.prod(tree.counts)


def test_places_know_their_leaf(tree: Octree) -> None:
    for level, cubes in enumerate(tree.leaves().cubes):
        middles = tree.origin + (cubes + 0.5) * tree.spacing / 2**level
        assert (tree.levels(middles) == level).all()


def test_leaves_that_touch_differ_by_one_level(tree: Octree) -> None:
    for level, cubes in enumerate(tree.leaves().cubes):
        size = tree.spacing / 2**level
        middles = tree.origin + (cubes + 0.5) * size
        around = (middles[:, None] + 0.51 * size * AROUND).reshape(-1, 3)
        high = tree.origin + tree.counts * tree.spacing
        around = around[((around > tree.origin) & (around < high)).all(axis=1)]
        assert abs(tree.levels(around) - level).max() <= 1


def test_places_outside_are_left_out() -> None:
    tree = Octree.around(np.zeros(3), np.ones(3), 0.5)
    tree.refine(np.array([[9.0, 0.0, 0.0], [-9.0, 0.0, 0.0]]))
    assert tree.least_edge == 0.5


def test_a_box_that_grew_has_the_same_places_split(tree: Octree) -> None:
    other = tree.moved_to(np.full(3, -0.01), np.array([1.01, 0.71, 0.91]))
    fine = tree.leaves().cubes[LEVELS]
    middles = tree.origin + (fine + 0.5) * tree.least_edge
    assert (other.levels(middles) == LEVELS).mean() > 0.7
