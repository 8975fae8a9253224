"""A soft cube that is dropped while it moves sideways, against explicit steps of other code."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.bodies import box
from tests.verification.dropped_cube import SIDE, G, cube
from warp_softbody.arrays import FloatArray

HEIGHT, SPEED, FRICTION = 0.05, 1.0, 0.5
YOUNG, POISSON, DENSITY, DAMPING = 1e5, 0.4, 1000.0, 0.02
CELLS, SECONDS, EXPLICIT_STEP = 3, 0.8, 2e-4


def stress(strain: FloatArray) -> FloatArray:
    """Hooke's law."""
    mu = YOUNG / (2.0 * (1.0 + POISSON))
    lam = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
    result: FloatArray = mu * (strain + strain.transpose(0, 2, 1)) + lam * trace * np.eye(3)
    return result


def explicit_slide() -> float:
    """Way of the centre of mass, m, by explicit steps with the laws of contact node by node."""
    mesh = box((CELLS,) * 3, (SIDE,) * 3, (-SIDE / 2, -SIDE / 2, HEIGHT))
    x, tets = mesh.points.copy(), mesh.tets
    edges = (x[tets[:, 1:]] - x[tets[:, :1]]).transpose(0, 2, 1)
    inverse, volumes = np.linalg.inv(edges), np.abs(np.linalg.det(edges)) / 6.0
    masses = np.bincount(tets.ravel(), np.repeat(DENSITY * volumes / 4.0, 4))
    v, dt = np.tile([SPEED, 0.0, 0.0], (len(x), 1)), EXPLICIT_STEP
    for _ in range(round(SECONDS / dt)):
        shape, rate = (
            (u[tets[:, 1:]] - u[tets[:, :1]]).transpose(0, 2, 1) @ inverse for u in (x, v)
        )
        U, _, Vt = np.linalg.svd(shape)
        R = U @ Vt
        turned = R.transpose(0, 2, 1) @ (shape + DAMPING * rate) - np.eye(3)
        pull = -volumes[:, None, None] * (R @ stress(turned) @ inverse.transpose(0, 2, 1))
        corners = np.concatenate([-pull.sum(axis=2)[:, :, None], pull], axis=2).transpose(0, 2, 1)
        forces = [np.bincount(tets.ravel(), corners[:, :, k].ravel()) for k in range(3)]
        v = v + dt * np.stack(forces, axis=1) / masses[:, None]
        v[:, 2] -= dt * G
        # a node may come down to the floor, not below; friction takes up to mu of what stops it
        pressed = np.maximum(-x[:, 2] / dt - v[:, 2], 0.0)
        v[:, 2] += pressed
        speed = np.hypot(v[:, 0], v[:, 1])
        kept = 1.0 - np.minimum(FRICTION * pressed / np.maximum(speed, 1e-12), 1.0)
        v[:, :2] *= kept[:, None]
        x = x + dt * v
    return float(masses @ (x - mesh.points)[:, 0] / masses.sum())


def our_slide(dt: float, cells: int = CELLS) -> float:
    """The same by the engine."""
    body = cube(HEIGHT, YOUNG, DAMPING, dt, cells=cells, friction=FRICTION)
    start = body.positions
    body.place(start, np.tile([SPEED, 0.0, 0.0], (len(start), 1)))
    for _ in range(round(SECONDS / dt)):
        body.step()
    return float(body.masses @ (body.positions - start)[:, 0] / body.masses.sum())


def test_a_soft_cube_slides_as_far_as_explicit_steps_say() -> None:
    """And not as far as a rigid one, which keeps half of its speed when it lands."""
    fall = np.sqrt(2.0 * HEIGHT / G)
    rigid = SPEED * fall + (SPEED - FRICTION * G * fall) ** 2 / (2.0 * FRICTION * G)
    assert rigid == pytest.approx(0.127, abs=5e-4)
    found = our_slide(0.0025)
    assert found == pytest.approx(explicit_slide(), rel=0.02)
    assert found < 0.9 * rigid


def test_the_slide_is_that_of_the_explicit_reference_on_the_scene_s_mesh() -> None:
    """0.1016 m with steps of 1e-5 s on 7 cells; docs/contact.md has its source."""
    assert our_slide(0.01, cells=7) == pytest.approx(0.1016, rel=0.01)
