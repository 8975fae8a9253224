"""Mutated stages through all that reads one: `python -m benchmarks.fuzz.stages --files 1000`.

Bytes are flipped, cut, copied and cleared, and values of attributes are removed, shortened and made
absurd. A file may be read or be refused in one sentence, in a few seconds; anything else is kept in
the folder of ``--keep`` under the seed that makes it again.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody import Body, Character, Frame, Plane, Scene, TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.errors import SoftBodyError
from warp_softbody.stage_exports import StageWriter, draw_take, measure, recover, validate
from warp_softbody.stage_exports.usd.reader import read_takes
from warp_softbody.world.frame import ContactSample

LONGEST = 60.0
"""s that all readers together may take for one file."""

FRAMES = 4
_SPLIT = np.array(
    ((0, 4, 6, 7), (0, 6, 2, 7), (0, 2, 3, 7), (0, 3, 1, 7), (0, 1, 5, 7), (0, 5, 4, 7))
)


def main(argv: list[str] | None = None) -> int:
    """Read mutated stages and tell what came of them; return 1 if one was not dealt with."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1, help="of the first file")
    parser.add_argument("--keep", type=Path, default=Path("fuzzed"), help="folder of the failures")
    args = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        counts: Counter[str] = Counter()
        for path, seed in mutated(folder, args.seed, args.files):
            outcome = tried(path)
            counts[outcome.splitlines()[-1] if outcome in KNOWN else "not dealt with"] += 1
            if outcome not in KNOWN:
                args.keep.mkdir(parents=True, exist_ok=True)
                shutil.copy(path, args.keep / f"seed-{seed}{path.suffix}")
                print(f"seed {seed}: {outcome}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.most_common()))
    return 1 if counts["not dealt with"] else 0


KNOWN = ("read", "refused")


def tried(path: Path) -> str:
    """What came of reading a file in every way: "read", "refused", or what should not happen."""
    begun = time.perf_counter()
    sentences = []
    for read in (_measured, validate, _drawn, _recovered):
        try:
            read(path)
        except SoftBodyError as error:
            sentences.append(str(error))
        except Exception:
            return f"{read.__name__}\n{traceback.format_exc()}"
    taken = time.perf_counter() - begun
    if taken > LONGEST:
        return f"took {taken:.0f} s"
    return "refused" if sentences else "read"


def _measured(path: Path) -> None:
    for take in read_takes(path):
        measure(take)


def _drawn(path: Path) -> None:
    draw_take(path.with_name("drawn.png"), path, count=2, size=(32, 32))


def _recovered(path: Path) -> None:
    """The file as the only chunk of a take that a crash left."""
    target = path.with_name("recovered.usdc")
    target.unlink(missing_ok=True)
    chunks = target.with_name(f".{target.name}.chunks")
    chunks.mkdir(exist_ok=True)
    shutil.copy(path, chunks / "static.usdc")
    shutil.copy(path, chunks / "frames_00000000.usdc")
    try:
        recover(target)
    finally:
        shutil.rmtree(chunks, ignore_errors=True)


def mutated(folder: Path, first: int, count: int) -> Iterator[tuple[Path, int]]:
    """Files in a folder and the seeds that make them, each gone when the next one comes."""
    good = [_stage(folder / f"good{extension}") for extension in (".usdc", ".usda")]
    for seed in range(first, first + count):
        chance = random.Random(seed)
        source = chance.choices(good, weights=(4, 1))[0]
        path = folder / f"mutated{source.suffix}"
        if chance.random() < 0.5:
            path.write_bytes(_other_bytes(source.read_bytes(), chance))
        else:
            _other_values(source, path, chance)
        yield path, seed


def _other_bytes(data: bytes, chance: random.Random) -> bytes:
    """A file with damage like that of a bad disk, a broken download or a wrong editor."""
    changed = bytearray(data)
    kind = chance.randrange(7)
    for _ in range(1 if kind < 5 else chance.randrange(1, 40)):
        place = chance.randrange(len(changed))
        if kind == 0:
            changed[place] ^= 1 << chance.randrange(8)
        elif kind == 1:
            changed[place : place + 4] = chance.choice((b"\xff" * 4, bytes(4), b"\x7f" * 4))
        elif kind == 2:
            return bytes(changed[:place])
        elif kind == 3:
            changed[place : place + chance.randrange(1, 200)] = bytes(50)
        elif kind == 4:
            other = chance.randrange(len(changed))
            changed[place : place + 60] = changed[other : other + 60]
        else:
            changed[place] = chance.randrange(256)
    return bytes(changed)


def _other_values(source: Path, path: Path, chance: random.Random) -> None:
    """A whole file whose attributes hold something else."""
    from pxr import Sdf

    layer = Sdf.Layer.OpenAsAnonymous(str(source))
    attributes: list[Any] = []

    def collect(place: Any) -> None:
        if place.IsPropertyPath() and layer.GetAttributeAtPath(place):
            attributes.append(layer.GetAttributeAtPath(place))

    layer.Traverse(Sdf.Path.absoluteRootPath, collect)
    for attribute in chance.sample(attributes, chance.randrange(1, 4)):
        _change(layer, attribute, chance)
    if chance.random() < 0.1:
        layer.timeCodesPerSecond = chance.choice((0.0, -1.0, 1e300, 1e-300))
    layer.Export(str(path))


def _change(layer: Any, attribute: Any, chance: random.Random) -> None:
    codes = layer.ListTimeSamplesForPath(attribute.path)
    if chance.random() < 0.15:
        attribute.owner.RemoveProperty(attribute)
    elif codes and chance.random() < 0.2:
        layer.EraseTimeSample(attribute.path, chance.choice(codes))
    elif codes:
        code = chance.choice(codes)
        value = _absurd(layer.QueryTimeSample(attribute.path, code), chance)
        layer.SetTimeSample(attribute.path, chance.choice((code, code, 1e30, -5.0)), value)
    elif attribute.default is not None:
        attribute.default = _absurd(attribute.default, chance)


def _absurd(value: Any, chance: random.Random) -> Any:
    """Another value of the same type."""
    if isinstance(value, float | int):
        return type(value)(chance.choice((0, -1, 2**31 - 1)))
    if not hasattr(type(value), "FromNumpy"):
        return value
    array = np.array(value)
    whole = array.dtype.kind in "iu"
    numbers = (-1, 10**9, 0) if whole else (np.nan, np.inf, 1e38, -1e38, 0.0)
    changes: tuple[Callable[[], Any], ...] = (
        lambda: array[: len(array) // 2],
        lambda: array[:0],
        lambda: np.concatenate([array, array[:1]]),
        lambda: np.full_like(array, chance.choice(numbers)),
        lambda: _one_other(array, chance, chance.choice(numbers)),
    )
    return type(value).FromNumpy(np.ascontiguousarray(chance.choice(changes)()))


def _one_other(array: Any, chance: random.Random, number: float) -> Any:
    if array.size:
        array.reshape(-1)[chance.randrange(array.size)] = number
    return array


def _stage(path: Path) -> Path:
    """A stage of two small bodies, one of them with muscles, that move over a plane."""
    scene = Scene(
        character=_cube("first", 0.0, muscular=True),
        others=(Body(character=_cube("second", 0.5, muscular=False)),),
        ground=Plane(friction=0.5),
    )
    with StageWriter(path, scene, metadata={"scene": "fuzzed"}) as stage:
        for index in range(FRAMES):
            stage.write(_frame(scene, index))
    return path


def _cube(name: str, x: float, *, muscular: bool) -> Character:
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) * 0.2
    mesh = TetMesh.from_arrays(corners + np.array([x, 0.0, 0.0]), _SPLIT)
    along = np.linspace(0.05, 0.15, 3)[:, None] * (0, 0, 1) + (x + 0.1, 0.1, 0.0)
    fiber = Fiber(vertices=along, kind=FiberKind.LONGITUDINAL, name="fiber")
    group = MuscleGroup(fibers=(fiber,), strength=1e5, kernel_width=0.1, name="group")
    return Character(name=name, mesh=mesh, muscles=(group,) if muscular else ())


def _frame(scene: Scene, index: int) -> Frame:
    rest, shift = scene.whole.mesh.points, index * np.array([0.01, 0.02, 0.03])
    nodes = np.arange(min(index, 3), dtype=np.int32)
    vertices = [fiber.vertices for fiber in scene.whole.fibers]
    return Frame(
        index=index,
        time=index / 30.0,
        positions=rest + shift,
        velocities=np.tile(30.0 * shift, (len(rest), 1)),
        activations=np.full(scene.whole.segment_count, 0.8),
        fiber_points=np.concatenate(vertices) + shift,
        contacts=ContactSample(
            nodes=nodes,
            points=(rest + shift)[nodes],
            modes=np.ones(len(nodes), dtype=np.int32),
            forces=np.ones((len(nodes), 3)),
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
