"""A soft ball rolls down stairs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

IntArray = npt.NDArray[np.int32]

RADIUS = 0.15  # m
STEPS = 5
RISE, RUN, WIDTH = 0.1, 0.35, 1.6  # m
LANDING = 2.5  # m, level ground at either end
BALL = Material(young_modulus=6e4, poisson_ratio=0.4, stiffness_damping=0.01)


def ball_mesh(radius: float, center: FloatArray, refinements: int = 2, shells: int = 3) -> TetMesh:
    """Shells of prisms, three tets each, over a refined icosahedron, and tets at the middle."""
    sphere, faces = _icosphere(refinements)
    count = len(sphere)
    layers = [radius * (k + 1) / shells * sphere for k in range(shells)]
    tets = []
    for k in range(shells - 1):
        # corners in the order of their index, so that neighbours cut their common side alike
        low = np.sort(faces, axis=1) + k * count
        high = low + count
        a, b, c = low.T
        d, e, f = high.T
        tets += [
            np.stack(corners, axis=1) for corners in ((a, b, c, f), (a, b, f, e), (a, e, f, d))
        ]
    middle = np.full(len(faces), shells * count)
    tets.append(np.column_stack([faces, middle]))
    points = np.concatenate([*layers, np.zeros((1, 3))])
    every = np.concatenate(tets)
    edges = points[every[:, 1:]] - points[every[:, :1]]
    turned = np.linalg.det(edges) < 0.0
    every[turned, :2] = every[turned, 1::-1]
    return TetMesh.from_arrays(points + center, every.astype(np.int32))


def _icosphere(refinements: int) -> tuple[FloatArray, IntArray]:
    """Unit vectors (v, 3) and outward faces (f, 3)."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    signs = [(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)]
    corners = np.array([np.roll((0.0, a, b), shift) for shift in range(3) for a, b in signs])
    # the faces are the triples of corners at the shortest distance, which is two
    near = np.isclose(np.linalg.norm(corners[:, None] - corners, axis=2), 2.0)
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if near[i, j] and near[j, k] and near[k, i]
    ]
    points, triangles = corners, np.array(faces)
    for _ in range(refinements):
        points, triangles = _halved(points, triangles)
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    inward = np.linalg.det(points[triangles]) < 0.0
    triangles[inward] = triangles[inward, ::-1]
    return points, triangles.astype(np.int32)


def _halved(points: FloatArray, faces: npt.NDArray[np.int_]) -> tuple[FloatArray, IntArray]:
    """Every triangle as four, new corners at the middles of the edges pushed out to the sphere."""
    pairs = np.sort(faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    edges, index = np.unique(pairs, axis=0, return_inverse=True)
    middles = points[edges].sum(axis=1)
    length = np.linalg.norm(points[0])
    middles *= length / np.linalg.norm(middles, axis=1, keepdims=True)
    a, b, c = faces.T
    p, q, r = (index.reshape(-1, 3) + len(points)).T
    parts = [(a, r, q), (r, b, p), (q, p, c), (p, q, r)]
    split = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([points, middles]), split.astype(np.int32)


def stair_ground(friction: float) -> TriangleGround:
    """Treads and risers as one open sheet that falls towards +x, from a landing to a landing."""
    profile = [(-LANDING, STEPS * RISE)]
    for step in range(STEPS):
        height = (STEPS - step) * RISE
        profile += [(step * RUN, height), (step * RUN, height - RISE)]
    profile.append(((STEPS - 1) * RUN + LANDING, 0.0))
    line = np.array(profile)
    sides = [np.column_stack([line[:, 0], np.full(len(line), y), line[:, 1]]) for y in (-1, 1)]
    vertices = np.concatenate(sides) * (1.0, WIDTH / 2.0, 1.0)
    near, far = np.arange(len(line) - 1), np.arange(len(line) - 1) + len(line)
    faces = np.concatenate(
        [np.stack([near, near + 1, far + 1], axis=1), np.stack([near, far + 1, far], axis=1)]
    )
    return TriangleGround(vertices=vertices, faces=faces.astype(np.int32), friction=friction)


def build(values: Values) -> tuple[Scene, None]:
    """The ball on the upper landing, moving towards the first step."""
    center = np.array([-0.5, 0.0, STEPS * RISE + RADIUS])
    scene = Scene(
        character=Character(name="ball", mesh=ball_mesh(RADIUS, center), material=BALL),
        ground=stair_ground(values["friction"]),
        initial_velocity=(values["speed"], 0.0, 0.0),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="stairs",
    description="a soft ball rolls down stairs",
    settings=(
        Setting(name="speed", default=1.0, low=-3.0, high=3.0, unit="m/s", help="at the start, +x"),
        Setting(
            name="friction",
            default=0.8,
            low=0.0,
            high=1e3,
            help="Coulomb coefficient of the stairs",
        ),
    ),
    build=build,
    seconds=4.0,
    time_step=0.01,
)
