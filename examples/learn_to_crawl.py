"""A starfish learns to crawl: evolution finds amplitudes and phases of its fibres.

Each fibre contracts as a sine of one period; CMA-ES (pip install cmaes) keeps what goes furthest.
"""

from __future__ import annotations

from typing import Any

import cmaes
import numpy as np
import numpy.typing as npt
import trimesh

import warp_softbody as wsb

Numbers = npt.NDArray[np.float64]


def starfish(tets: int = 1200) -> wsb.Character:
    """Five arms around a disc, lying."""
    turned: Any = trimesh.transformations.rotation_matrix
    parts = [trimesh.creation.cylinder(0.22, 0.16)]
    for turn in 2.0 * np.pi * np.arange(5) / 5.0:
        arm = trimesh.creation.capsule(height=0.5, radius=0.08, count=[12, 12])
        arm.apply_transform(turned(np.pi / 2.0, [0, 1, 0]))
        arm.apply_translation([0.1, 0.0, 0.0])
        arm.apply_transform(turned(turn, [0, 0, 1]))
        parts.append(arm)
    whole: Any = trimesh.util.concatenate(parts)
    return wsb.Character.from_surface(whole, name="starfish", tets=tets)


def contractions(genes: Numbers, time: Numbers, period: float) -> Numbers:
    """Of each gait (g, 2 fibres) at its time (g,) s: half a sine with an amplitude and a phase."""
    size, phase = np.split(genes, 2, axis=1)
    wave = np.sin(2.0 * np.pi * time[:, None] / period + phase)
    return np.clip(size * wave, 0.0, 1.0)


def way(environments: wsb.VectorEnvironment, genes: Numbers, period: float) -> Numbers:
    """How far each gait comes in an episode, over the body's length."""
    environments.reset(seed=0)
    total, over, time = np.zeros(len(genes)), False, np.zeros(len(genes))
    while not over:
        actions = contractions(genes, time, period).astype(np.float32)
        _, reward, terminated, truncated, info = environments.step(actions)
        total, time = total + reward, info["time"]
        over = bool((terminated | truncated).any())
    return total


def main(generations: int = 30, seconds: float = 4.0, period: float = 0.5) -> Numbers:
    """The best way of each generation, over the body's length."""
    scene = wsb.Scene(character=starfish(), ground=wsb.Plane())
    size = 12
    environments = wsb.VectorEnvironment(scene, size, seconds=seconds, steps=3)
    fibers = len(scene.character.fibers)
    mean = np.concatenate([np.full(fibers, 0.5), np.zeros(fibers)])
    search = cmaes.CMA(mean=mean, sigma=0.6, population_size=size, seed=1)
    best = []
    for generation in range(generations):
        genes = np.array([search.ask() for _ in range(size)])
        ways = way(environments, genes, period)
        search.tell([(each, -far) for each, far in zip(genes, ways, strict=True)])
        best.append(float(ways.max()))
        print(f"generation {generation}: {best[-1]:.3f} body lengths in {seconds:g} s", flush=True)
    return np.array(best)


if __name__ == "__main__":
    main()
