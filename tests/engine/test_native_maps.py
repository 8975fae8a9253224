"""Linear maps of a step by native code against those that NumPy makes."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from tests.support.assembled_bars import some_rows, stretched
from tests.support.bodies import Rig
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.native_maps import StepMaps
from warp_softbody.engine.options import Precision
from warp_softbody.engine.reduced_dynamics import ReducedDynamics

TIGHT = 1e-6
"""Tolerance of both solves; they do the same iterations on the same blocks."""


def patches(body: Rig, count: int) -> tuple[FloatArray, FloatArray]:
    """Weights of eight nodes each, and axes; the last patch is all nodes by their masses."""
    rng = np.random.default_rng(count)
    weights = np.zeros((count, body.model.node_count))
    for own in weights[: count - 1]:
        own[rng.choice(len(own), 8, replace=False)] = rng.uniform(0.1, 1.0, 8)
    weights[count - 1 :] = 2.0 * body.masses
    return weights, rng.standard_normal((count, 3, 3))


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("fixed", [(), (0, 1, 5, 40)])
@pytest.mark.parametrize(("count", "contacts"), [(7, 4), (5, 0), (6, 6), (20, 5)])
def test_they_are_those_of_the_numpy_form(
    count: int, contacts: int, fixed: Any, precision: Precision
) -> None:
    """Momenta among both kinds of rows, more rows than a block, and other rows in between."""
    body, _ = stretched(fixed, precision=precision)
    slow = ReducedDynamics(body.stepper, tolerance=TIGHT)
    fast = ReducedDynamics(body.stepper, tolerance=TIGHT)
    for rows_of in (count, count + 3, count):
        rows = some_rows(body, rows_of, seed=rows_of)
        weights, frames = patches(body, contacts)
        axes = frames[:, :, None, :] * weights[:, None, :, None]
        every = np.concatenate([rows, axes.reshape(3 * contacts, rows.shape[1])])
        expected = slow.solve(every)
        found = fast.fast_maps([rows[:1], rows[1:]], list(weights), list(frames))
        assert found is not None
        assert found.iterations == expected.iterations and found.converged
        np.testing.assert_array_equal(found.compliance, found.compliance.T)
        for name in (entry.name for entry in fields(StepMaps)):
            one, other = getattr(found, name), getattr(expected, name)
            bound = 1e-13 * np.abs(other).max()
            np.testing.assert_allclose(one, other, rtol=0.0, atol=bound, err_msg=name)


def test_rows_that_are_not_finite_and_plain_kernels_are_left_to_numpy() -> None:
    body, _ = stretched()
    rows = some_rows(body, 6)
    weights, frames = patches(body, 1)
    dynamics = ReducedDynamics(body.stepper)
    for spoilt in (np.nan, np.inf):
        wrong = rows.copy()
        wrong[2, 7] = spoilt
        assert dynamics.fast_maps([wrong], list(weights), list(frames)) is None
        assert dynamics.fast_maps([rows], list(weights), [spoilt * frames[0]]) is None
    plain, _ = stretched(native_code=False)
    assert ReducedDynamics(plain.stepper).fast_maps([rows], [], []) is None
