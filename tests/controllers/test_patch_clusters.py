"""Clustered patches: a fixed partition of the surface, weighed by area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.support.bodies import box
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters import letter_o
from warp_softbody.controllers.patch_clusters import clustered_patches, partition
from warp_softbody.controllers.patches import Patch
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround
from warp_softbody.world.view import BodyView

SOFT = Material(young_modulus=1e5, poisson_ratio=0.4)
SIZE = (0.4, 0.3, 0.1)
CELLS = (3, 3, 1)


def slab(mesh: TetMesh | None = None) -> Character:
    """A flat box whose lower face is the region "sole"."""
    mesh = mesh or box(CELLS, SIZE)
    sole = np.flatnonzero(mesh.points[:, 2] < 1e-9).astype(np.int32)
    return Character(name="slab", mesh=mesh, material=SOFT, regions={"sole": sole})


def seen(
    character: Character,
    positions: FloatArray | None = None,
    ground: Ground | None = None,
    reach: float = 1e-9,
) -> BodyView:
    """A view in which the nodes within ``reach`` of the ground touch."""
    ground = ground or Plane()
    points = character.mesh.points.copy() if positions is None else positions
    gaps, _ = ground.measure(points)
    on_surface = np.isin(np.arange(len(points)), character.mesh.surface_nodes)
    return BodyView(
        scene=Scene(character=character, ground=ground),
        time=0.0,
        time_step=0.01,
        masses=np.ones(len(points)),
        positions=points,
        velocities=np.zeros_like(points),
        touching=on_surface & (gaps <= reach),
        activations=np.zeros(0),
    )


def middle(patch: Patch, view: BodyView) -> FloatArray:
    return np.asarray(patch.weights @ view.positions)


def test_a_flat_box_has_its_patches_where_the_quarters_of_its_face_lie() -> None:
    view = seen(slab())
    patches = clustered_patches(view, count=4, region="sole")
    assert len(patches) == 4
    # Two nodes a side and quarter; a third of each Kuhn triangle goes to each of its nodes: in
    # units of a cell 1 inside, 1/2 at a side, and 1/3 or 1/6 at a corner, in which two triangles
    # meet or one. Along each axis the two inner nodes of a quarter weigh 3/2.
    cell = np.array(SIZE[:2]) / 3
    whole = np.array(SIZE[:2])
    expected = []
    for right, back in ((0, 0), (1, 1), (0, 1), (1, 0)):
        corner = 1 / 3 if right == back else 1 / 6
        point = cell * 1.5 / (2.0 + corner)
        point = np.where([right, back], whole - point, point)
        expected.append((*point, (2.0 + corner) / 9.0))
    found = [(*middle(patch, view)[:2], patch.area) for patch in patches]
    np.testing.assert_allclose(sorted(found), sorted(expected), rtol=1e-12)
    # All of the triangles' thirds together are the face.
    total = sum(patch.area * middle(patch, view) for patch in patches)
    np.testing.assert_allclose(total, [0.2, 0.15, 0.0], atol=1e-15)
    for patch in patches:
        assert patch.touching and patch.weights.sum() == pytest.approx(1.0)
        assert patch.gap == pytest.approx(0.0, abs=1e-15)
        np.testing.assert_array_equal(patch.frame[0], [0.0, 0.0, 1.0])


def test_an_upright_face_still_has_a_patch() -> None:
    character = slab()
    side = np.flatnonzero(character.mesh.points[:, 0] < 1e-9).astype(np.int32)
    upright = Character(name="slab", mesh=character.mesh, material=SOFT, regions={"side": side})
    patches = clustered_patches(seen(upright), count=4, region="side")
    touching = [patch for patch in patches if patch.touching]
    assert sum(patch.area for patch in touching) == pytest.approx(1.0)
    assert all(patch.weights.sum() == pytest.approx(1.0) for patch in patches)


def grounds() -> list[Ground]:
    corners = np.array([[-2.0, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]])
    return [
        Plane(normal=(0.1, 0.0, 1.0)),
        HeightField(heights=np.zeros((3, 3)), spacing=(2.0, 2.0), origin=(-2.0, -2.0)),
        TriangleGround(vertices=corners, faces=np.array([[0, 1, 2], [0, 2, 3]])),
    ]


@pytest.mark.parametrize("ground", grounds(), ids=lambda ground: type(ground).__name__)
@pytest.mark.parametrize("count", [4, 6, 8])
def test_counts_shares_and_weights_on_any_ground(ground: Ground, count: int) -> None:
    view = seen(slab(), ground=ground, reach=0.02)
    for region in (None, "sole"):
        patches = clustered_patches(view, count=count, region=region)
        assert len(patches) == count
        assert sum(patch.area for patch in patches) == pytest.approx(1.0, abs=1e-12)
        parts = [patch.part for patch in patches]
        assert parts == sorted(set(parts), key=lambda part: part or 0)
        taken = np.stack([patch.weights > 0.0 for patch in patches])
        assert (taken.sum(axis=0) <= 1).all()
        # Every node that touches belongs to some patch, which touches too.
        of_region = np.isin(np.arange(view.node_count), _nodes(view, region))
        assert np.all(np.any(taken, axis=0) | ~(view.touching & of_region))
        touched = [bool(np.any(view.touching & (patch.weights > 0.0))) for patch in patches]
        assert [patch.touching for patch in patches] == touched
        for patch in patches:
            assert patch.weights.min() >= 0.0 and patch.weights.sum() == pytest.approx(1.0)


def _nodes(view: BodyView, region: str | None) -> npt.NDArray[np.int32]:
    character = view.scene.character
    return character.mesh.surface_nodes if region is None else character.region(region)


def test_a_body_in_the_air_has_the_patches_that_come_nearest() -> None:
    character = slab()
    view = seen(character, character.mesh.points + np.array([0.0, 0.0, 0.25]))
    patches = clustered_patches(view, count=5)
    assert len(patches) == 5
    assert sum(patch.area for patch in patches) == pytest.approx(1.0)
    for patch in patches:
        assert not patch.touching
        assert patch.gap == pytest.approx(0.25)
    flying = replace(view, scene=Scene(character=character))
    assert clustered_patches(flying, count=5) == ()


def test_small_motions_change_neither_parts_nor_nodes() -> None:
    character = slab(box((8, 6, 2), SIZE))
    still = seen(character)
    before = clustered_patches(still, count=6)
    rng = np.random.default_rng(0)
    for _ in range(10):
        moved = character.mesh.points.copy()
        step = 1e-3 * rng.standard_normal(moved.shape)
        step[:, 2] = 0.0
        view = seen(character, moved + step)
        after = clustered_patches(view, count=6, last=before)
        touching = [(p, q) for p, q in zip(before, after, strict=True) if p.touching]
        assert [p.part for p, _ in touching] == [q.part for _, q in touching]
        for p, q in touching:
            np.testing.assert_array_equal(p.weights > 0.0, q.weights > 0.0)
            # A weighted mean moves no further than its nodes, and areas by first order: 1e-3 of
            # motion against cells of 0.05 change weights by some 4 % of a patch 0.2 m wide.
            assert np.linalg.norm(middle(q, view) - middle(p, still)) < 0.02


def test_a_rolling_letter_keeps_its_parts() -> None:
    """Turned by 2 degrees a step over the floor: patches come and go, none jumps."""
    character = letter_o()
    rest = character.mesh.points - character.mesh.points.mean(axis=0)
    nodes = character.mesh.surface_nodes
    division = partition(character.mesh, nodes.tobytes(), 48)
    widest = max(
        float(np.ptp(rest[nodes[division.labels == part]], axis=0).max()) for part in range(48)
    )
    known: dict[int, tuple[FloatArray, frozenset[int]]] = {}
    seen_parts = set()
    patches: tuple[Patch, ...] = ()
    for angle in range(0, 360, 2):
        turned = Rotation.from_euler("y", angle, degrees=True).apply(rest)
        turned[:, 2] -= turned[:, 2].min()
        view = seen(character, turned, reach=0.02)
        patches = clustered_patches(view, count=6, last=patches)
        assert len(patches) == 6
        now = {}
        for patch in patches:
            if not patch.touching:
                continue
            assert patch.part is not None
            of_patch = frozenset(np.flatnonzero(patch.weights).tolist())
            now[patch.part] = (patch.weights @ rest, of_patch)
            if patch.part in known:
                point, before = known[patch.part]
                jump = np.linalg.norm(now[patch.part][0] - point)
                # In the body's own frame; at most the size of its part, and nothing but weights
                # by area moves it while its nodes stay.
                assert jump <= np.sqrt(3.0) * widest
                if before == of_patch:
                    assert jump < 0.25 * widest
        seen_parts |= set(now)
        known = now
    assert len(seen_parts) > 12


def test_parts_do_not_depend_on_the_pose_and_are_alike_in_size() -> None:
    mesh = box((12, 12, 2), (0.6, 0.6, 0.1))
    character = slab(mesh)
    division = partition(mesh, character.region("sole").tobytes(), 9)
    again = partition(mesh, character.region("sole").tobytes(), 9)
    assert division is again
    sizes = np.bincount(division.labels)
    assert len(sizes) == 9 and sizes.min() > 0.3 * sizes.mean() and sizes.max() < 3 * sizes.mean()


def test_parts_converge_with_the_mesh() -> None:
    """Their middles are those of the rectangles that halve and third the face, to an edge's length.

    0.4 m by 0.3 m in five: two fifths left of x = 0.16 m, in halves; of the rest a third below
    y = 0.1 m, and what is above in halves.
    """
    exact = [(0.08, 0.075), (0.08, 0.225), (0.28, 0.05), (0.22, 0.2), (0.34, 0.2)]
    for refined in (1, 2, 4):
        cells = (12 * refined, 9 * refined, 1)
        character = slab(box(cells, SIZE))
        division = partition(character.mesh, character.region("sole").tobytes(), 5)
        assert len(division.middles) == 5
        away = np.linalg.norm(division.middles[:, None, :2] - exact, axis=2)
        assert sorted(away.argmin(axis=1)) == [0, 1, 2, 3, 4]
        assert away.min(axis=1).max() < SIZE[0] / cells[0]


def test_unusable_calls_are_refused() -> None:
    view = seen(slab())
    for count in (3, 9):
        with pytest.raises(InputError, match="4 to 8"):
            clustered_patches(view, count=count)
    with pytest.raises(InputError, match="at least 6 parts"):
        clustered_patches(view, count=6, parts=5)
    with pytest.raises(InputError, match="no region 'heel'"):
        clustered_patches(view, region="heel")
