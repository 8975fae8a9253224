"""Bodies stay apart, whatever their meshes, places and order, and come apart where they are not.

Depth is measured here from the tets and triangles alone, with no part of the contact code.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.support.bodies import box
from warp_softbody import Material, Plane, Push, Scene, Simulation, SimulationOptions
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.errors import InputError
from warp_softbody.world.frame import Frame
from warp_softbody.world.joined_bodies import Body, placed

Vector = tuple[float, float, float]

SIDE, THICK = 0.3, 0.03
SOFT = Material(young_modulus=1e5, poisson_ratio=0.3)
NO_GRAVITY = (0.0, 0.0, 0.0)


def shares(scene: Scene, frame: Frame) -> dict[str, FloatArray]:
    """Where each body's nodes are."""
    return {part.name: frame.positions[part.nodes] for part in scene.parts}


def smallest_tet(mesh: TetMesh, points: FloatArray) -> float:
    """Least volume of a tet, of that at rest."""
    a, b, c, d = (points[mesh.tets[:, k]] for k in range(4))
    volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6.0
    return float((volumes / mesh.volumes).min())


def depth(points: FloatArray, mesh: TetMesh, other: FloatArray) -> float:
    """Largest distance of points inside a body to its surface, along its triangles' normals, m."""
    corners = other[mesh.tets]
    inverse = inverse_edges(other, mesh.tets)
    inner = np.einsum("tij,ptj->pti", inverse, points[:, None] - corners[:, 0])
    least = np.minimum(inner.min(axis=2), 1.0 - inner.sum(axis=2))
    a, b, c = (other[mesh.surface[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    worst = 0.0
    for p in points[least.max(axis=1) > 1e-9]:
        off = np.einsum("fi,fi->f", p - a, normal)
        q = p - off[:, None] * normal
        over = np.ones(len(a), dtype=bool)
        for s, e in ((a, b), (b, c), (c, a)):
            over &= np.einsum("fi,fi->f", np.cross(e - s, q - s), normal) >= -1e-12
        if over.any():
            worst = max(worst, float(np.abs(off[over]).min()))
    return worst


def deepest(scene: Scene, frame: Frame) -> float:
    """Largest depth of a surface node of any body in any other, m."""
    where = shares(scene, frame)
    bodies = scene.characters
    return max(
        depth(where[one.name][one.mesh.surface_nodes], two.mesh, where[two.name])
        for one in bodies
        for two in bodies
        if one is not two
    )


def ended(scene: Scene, seconds: float, **options: Any) -> tuple[Simulation, Frame]:
    options.setdefault("time_step", 1.0 / 120.0)
    simulation = Simulation(scene, options=SimulationOptions(**options))
    *_, frame = simulation.run(seconds)
    return simulation, frame


def slab(name: str, cells: tuple[int, int, int], low: float) -> Character:
    """A slab whose lowest face stands at a height; its upper face is the region "face"."""
    mesh = box(cells, (SIDE, SIDE, THICK), (-SIDE / 2, -SIDE / 2, low))
    high = np.flatnonzero(mesh.points[:, 2] > low + THICK - 1e-9)
    return Character(name=name, mesh=mesh, material=SOFT, regions={"face": high.astype(np.int32)})


PRESSED = (
    ((8, 8, 2), (3, 3, 1), 0.0, True),
    ((8, 8, 2), (3, 3, 1), 0.0, False),
    ((6, 6, 1), (2, 2, 1), 0.0, True),
    ((6, 6, 1), (2, 2, 1), 0.0, False),
    ((4, 4, 1), (3, 3, 2), 25.0, True),
    ((5, 5, 1), (5, 5, 1), 10.0, False),
)


@pytest.mark.parametrize(("upper", "lower", "degrees", "upper_first"), PRESSED)
def test_pressed_slabs_stay_apart(
    upper: tuple[int, int, int], lower: tuple[int, int, int], degrees: float, upper_first: bool
) -> None:
    """A slab on another, pressed with 50 times its weight for a second; also upside down in mesh.

    14.7 kPa at E = 1e5 Pa: 15 % of strain. Nodes against faces leave what the surfaces bend
    between nodes: the bend of a cell of the finer mesh, some tenths of a millimetre.
    """
    fine, coarse = slab("upper", upper, THICK), slab("lower", lower, 0.0)
    fine = placed(fine, degrees=degrees)
    weight = 1000.0 * SIDE * SIDE * THICK * 9.81
    first, second = (fine, coarse) if upper_first else (coarse, fine)
    region = "face" if upper_first else "upper.face"
    push = Push(region=region, force=(0.0, 0.0, -50.0 * weight), start=0.0, duration=9.0)
    scene = Scene(character=first, others=(Body(character=second),), ground=Plane(), pushes=(push,))
    simulation, frame = ended(scene, 0.6)
    assert deepest(scene, frame) < 1e-3
    where = shares(scene, frame)
    assert min(smallest_tet(c.mesh, where[c.name]) for c in scene.characters) > 0.5
    assert simulation.summary().unconverged_steps <= 1


@pytest.mark.parametrize("turn", [((1.0, 0.0, 0.0), 90.0), ((0.3, 1.0, 0.5), 77.0)])
def test_pressed_slabs_in_any_orientation(turn: tuple[Vector, float]) -> None:
    """Without gravity and ground, pressed against a slab that is fixed at its back."""
    axis, degrees = turn
    lower = slab("lower", (2, 2, 1), 0.0)
    back = np.flatnonzero(lower.mesh.points[:, 2] < 1e-9).astype(np.int32)
    held = Character(name="lower", mesh=lower.mesh, material=SOFT, fixed=back)
    upper = placed(slab("upper", (6, 6, 1), THICK), axis=axis, degrees=degrees)
    away = placed(slab("way", (1, 1, 1), 0.0), axis=axis, degrees=degrees).mesh.points
    up = away[1] - away[0]
    force = -50.0 * 1000.0 * SIDE * SIDE * THICK * 9.81 * up / np.linalg.norm(up)
    x, y, z = force.tolist()
    push = Push(region="face", force=(x, y, z), start=0.0, duration=9.0)
    scene = Scene(
        character=upper,
        others=(Body(character=placed(held, axis=axis, degrees=degrees)),),
        gravity=NO_GRAVITY,
        pushes=(push,),
    )
    _, frame = ended(scene, 0.6)
    assert deepest(scene, frame) < 1e-3


def cube(name: str, at: Vector, cells: int, side: float = 0.2) -> Character:
    x, y, z = (place - side / 2.0 for place in at)
    return Character(name=name, mesh=box((cells,) * 3, (side,) * 3, (x, y, z)))


STARTS: tuple[Vector, ...] = (
    (0.0, 0.0, 0.15),
    (0.0, 0.0, 0.1),
    (0.02, 0.01, 0.08),
    (0.11, 0.09, 0.1),
    (0.01, 0.0, 0.0),
)


@pytest.mark.parametrize("offset", STARTS)
def test_overlapping_cubes_come_apart(offset: Vector) -> None:
    """From any depth, at about the recovery speed of 0.5 m/s, and undamaged."""
    one, two = cube("one", (0.0, 0.0, 0.0), 3), cube("two", offset, 4)
    scene = Scene(character=one, others=(Body(character=two),), gravity=NO_GRAVITY)
    options = SimulationOptions(precision="float64", tolerance=1e-9)
    simulation = Simulation(scene, options=options)
    fastest, momentum = 0.0, simulation.model.masses.sum() * 0.5
    for frame in simulation.run(0.7):
        fastest = max(fastest, float(np.abs(frame.velocities).max()))
    assert deepest(scene, frame) < 1e-3
    assert fastest < 0.8
    assert np.abs(simulation.model.masses @ frame.velocities).max() < 1e-6 * momentum
    where = shares(scene, frame)
    assert min(smallest_tet(c.mesh, where[c.name]) for c in scene.characters) > 0.9


def test_a_cube_inside_another_comes_out() -> None:
    """With no surface in the other's: out from the middle, as no part of a surface says where."""
    outer = cube("outer", (0.0, 0.0, 0.0), 3, side=0.4)
    inner = cube("inner", (0.05, 0.02, 0.0), 2, side=0.1)
    scene = Scene(character=outer, others=(Body(character=inner),), gravity=NO_GRAVITY)
    _, frame = ended(scene, 1.5)
    assert deepest(scene, frame) < 1e-3
    assert shares(scene, frame)["inner"][:, 0].min() > 0.19


def beam(name: str, along: int, cells: int, low: Vector) -> Character:
    """A beam of 0.6 x 0.06 x 0.06 m along an axis, one cell thick."""
    size, count = [0.06] * 3, [1] * 3
    size[along], count[along] = 0.6, cells
    mesh = box((count[0], count[1], count[2]), (size[0], size[1], size[2]), low)
    return Character(name=name, mesh=mesh)


@pytest.mark.parametrize("rise", [0.0, 0.05])
def test_beams_through_each_other_come_apart(rise: float) -> None:
    """No node of either is inside the other; edges lead through."""
    one = beam("one", 0, 2, (-0.35, -0.03, 0.0))
    two = beam("two", 1, 2, (-0.03, -0.35, rise))
    scene = Scene(character=one, others=(Body(character=two),), gravity=NO_GRAVITY)
    _, frame = ended(scene, 0.6)
    assert not edges_cut(scene, frame)


@pytest.mark.parametrize("cells", [2, 7])
def test_beams_laid_across_each_other(cells: int) -> None:
    """Edges bear what no node meets: the upper beam lies on the lower and does not sink in."""
    lower = beam("lower", 0, cells, (-0.3, -0.03, 0.0))
    upper = beam("upper", 1, cells, (-0.03, -0.3, 0.065))
    scene = Scene(character=lower, others=(Body(character=upper),), ground=Plane())
    simulation, frame = ended(scene, 1.5)
    assert simulation.summary().unconverged_steps <= 1
    points = shares(scene, frame)["upper"]
    across = (np.abs(points[:, 1]) < 0.05) & (points[:, 2] < 0.09)
    np.testing.assert_allclose(points[across, 2], 0.06, atol=2e-3)
    assert np.abs(points[:, 0]).max() < 0.04
    weight = upper.mesh.volume * upper.material.density * 9.81
    force = frame.contacts.force_on("upper")
    np.testing.assert_allclose(force, [0.0, 0.0, weight], atol=1e-2 * weight)


def edges_cut(scene: Scene, frame: Frame) -> bool:
    """Whether an edge of one body leads through a triangle of another."""
    where = shares(scene, frame)
    for one in scene.characters:
        faces = one.mesh.surface
        ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        p, q = (where[one.name][ends[:, k]][:, None] for k in range(2))
        for two in scene.characters:
            if one is not two:
                a, b, c = (where[two.name][two.mesh.surface[:, k]][None] for k in range(3))
                if crossed(p, q, a, b, c).any():
                    return True
    return False


def crossed(p: FloatArray, q: FloatArray, *corners: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether segments p q lead through triangles, by the signs of five volumes."""

    def volume(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("efi,efi->ef", np.cross(b - a, c - a), d - a + 0.0 * b))

    a, b, c = (side + 0.0 * p for side in corners)
    p, q = p + 0.0 * a, q + 0.0 * a
    sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)]
    around = np.all([s > 1e-12 for s in sides], axis=0) | np.all(
        [s < -1e-12 for s in sides], axis=0
    )
    return np.asarray(around & (volume(a, b, c, p) * volume(a, b, c, q) < 0.0))


def test_bodies_in_the_same_place_are_refused() -> None:
    one, two = cube("one", (0.0, 0.0, 0.0), 3), cube("two", (0.0, 0.0, 0.0), 4)
    with pytest.raises(InputError, match=r"bodies 'one' and 'two' fill the same place, 0\.2 m"):
        Simulation(Scene(character=one, others=(Body(character=two),)))
