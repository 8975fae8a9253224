"""Patches as quadratures: the same on every mesh in the limit, continuous in the state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.blocks import SIZE, bent, block, dunes, pressed, seen
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers.contact_quadrature import LOADED, REACH, measure, shares_of
from warp_softbody.controllers.patch_clusters import clustered_patches
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.view import BodyView

QUARTERS = ("left", "right")
LEVELS = 3


def numbers(patches: tuple[Patch, ...], view: BodyView) -> dict[str, FloatArray]:
    """What of the patches a finer mesh is to leave as it is."""
    return {
        "point": np.array([patch.weights @ view.positions for patch in patches]),
        "normal": np.array([patch.frame[0] for patch in patches]),
        "tangent": np.array([patch.frame[1] for patch in patches]),
        "friction": np.array([patch.friction * patch.factors for patch in patches]),
        "area": np.array([patch.area for patch in patches]),
    }


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("ground", [Plane(normal=(0.1, 0.0, 1.0)), dunes()], ids=["plane", "field"])
def test_patches_converge_with_the_mesh(ground: Ground, loaded: bool) -> None:
    """At a rate of at least one over three meshes: point, frame, friction and share."""
    found = []
    for level in range(LEVELS):
        character = block(level)
        positions = bent(character.mesh.points)
        view = (pressed if loaded else seen)(character, positions, ground)
        found.append(numbers(ground_patches(view, QUARTERS), view))
    for name, coarse in found[0].items():
        middle, fine = found[1][name], found[2][name]
        first, second = (float(np.abs(a - b).max()) for a, b in ((coarse, middle), (middle, fine)))
        assert second <= 0.5 * first + 1e-9, (name, first, second)


def test_the_gap_is_that_of_the_lowest_point_to_second_order() -> None:
    """A patch that bears nothing over dunes; their curvature and the foot's are below 1.5 1/m."""
    ground = dunes()
    x, y = np.meshgrid(*(np.linspace(0.0, side, 400) for side in SIZE[:2]), indexing="ij")
    foot = bent(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    gaps, _ = ground.measure(foot)
    for level in range(LEVELS):
        character = block(level)
        view = seen(character, bent(character.mesh.points), ground)
        (patch,) = ground_patches(view, ("foot",))
        edge = 0.15 / 2**level
        assert -1e-6 < patch.gap - gaps.min() < 0.5 * 1.5 * 0.5 * edge**2


def test_a_flat_patch_is_the_same_on_every_mesh() -> None:
    """The area and the middle of a face are those of its triangles, however many."""
    for level in range(LEVELS):
        character = block(level)
        view = seen(character, character.mesh.points.copy(), Plane())
        left, right = ground_patches(view, QUARTERS)
        middles = SIZE * [0.25, 0.5, 0.0], SIZE * [0.75, 0.5, 0.0]
        for patch, middle in zip((left, right), middles, strict=True):
            assert patch.area == pytest.approx(0.5)
            np.testing.assert_allclose(patch.weights @ view.positions, middle, atol=1e-12)


def swing(character: Character, angle: float) -> FloatArray:
    """The block turned about the left edge of its foot, then about the right one below zero."""
    hinge = np.array([0.0 if angle > 0.0 else SIZE[0], 0.0, 0.0])
    points = Rotation.from_rotvec([0.0, -angle, 0.0]).apply(character.mesh.points - hinge) + hinge
    return np.asarray(points - [0.0, 0.0, 1e-3])


def bearing(character: Character, positions: FloatArray) -> BodyView:
    """Pressure grows with the depth, to a loaded foot's in 1e-3 m: contacts are left and won."""
    view = seen(character, positions, Plane())
    foot = character.region("foot")
    shares = measure(view, Plane(), [foot]).areas / (SIZE[0] * SIZE[1])
    depths = np.maximum(-positions[foot, 2], 0.0) / 1e-3
    impulses = np.zeros((len(positions), 3))
    impulses[foot, 2] = LOADED * view.weight * view.time_step * depths * shares
    return replace(view, impulses=impulses)


def largest_change(steps: int, *, clustered: bool = False) -> float:
    """Of the weights, in a step, while the block rocks from edge to edge: sum of their sizes."""
    character = block(1)
    before: FloatArray | None = None
    last: tuple[Patch, ...] = ()
    largest = 0.0
    for angle in np.linspace(-0.05, 0.05, steps + 1):
        view = bearing(character, swing(character, float(angle)))
        if clustered:
            last = clustered_patches(view, count=4, region="foot", last=last)
        else:
            last = ground_patches(view, ("foot", *QUARTERS))
        now = np.array([patch.weights for patch in last])
        if before is not None:
            largest = max(largest, float(np.abs(now - before).sum(axis=1).max()))
        before = now
    return largest


@pytest.mark.parametrize("clustered", [False, True])
def test_weights_are_continuous_while_contacts_come_and_go(clustered: bool) -> None:
    """Half the motion changes them by half: none jumps. All nodes of the foot leave and return."""
    coarse, fine = (largest_change(steps, clustered=clustered) for steps in (800, 1600))
    assert fine < 0.55 * coarse
    # nodes move by 1e-4 m at most, against a reach of 0.01 m and a depth of 1e-3 m
    motion = 0.1 / 800 * SIZE[0]
    assert coarse < 2.0 * motion * (1.0 / REACH + 1.0 / 1e-3)


def test_far_from_the_ground_the_lowest_point_stands_for_a_patch() -> None:
    """Within a reach, however far away that is; the top of the block counts for nothing."""
    character = block()
    view = seen(character, swing(character, 0.4) + np.array([0.0, 0.0, 50.0]), Plane())
    nodes = character.mesh.surface_nodes
    shares, (gap,), _ = shares_of(view, measure(view, Plane(), [nodes]))
    height = view.positions[nodes, 2]
    assert gap == pytest.approx(height.min())
    assert shares @ height < height.min() + 2.0 * REACH
    assert np.isfinite(shares).all() and shares.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_lengths_belong_to_the_body(scale: float) -> None:
    """A block of another size has the same shares in the same pose."""
    one, other = block(1), block(1, scale)
    pose = bent(one.mesh.points)
    view, like = seen(one, pose, Plane()), seen(other, scale * pose, Plane())
    for patch, alike in zip(
        ground_patches(view, QUARTERS), ground_patches(like, QUARTERS), strict=True
    ):
        np.testing.assert_allclose(alike.weights, patch.weights, atol=1e-12)
        assert alike.gap == pytest.approx(scale * patch.gap)
        assert alike.area == pytest.approx(patch.area)


def test_regions_without_faces_have_patches() -> None:
    """An edge has the surface around it; nodes within the body count alike."""
    character = block()
    x, _, z = character.mesh.points.T
    inner = np.setdiff1d(np.arange(len(z), dtype=np.int32), character.mesh.surface_nodes)
    edge = np.flatnonzero((z < 1e-9) & (x < 1e-9)).astype(np.int32)
    character = replace(character, regions={"edge": edge, "inner": inner}, directional_friction=())
    view = seen(character, character.mesh.points.copy(), Plane())
    for patch, nodes in zip(ground_patches(view, ("edge", "inner")), (edge, inner), strict=True):
        assert patch.weights.sum() == pytest.approx(1.0)
        assert set(np.flatnonzero(patch.weights)) <= set(nodes.tolist())
    middle = ground_patches(view, ("edge",))[0].weights @ view.positions
    np.testing.assert_allclose(middle, [0.0, 0.5 * SIZE[1], 0.0], atol=0.04)
