"""Threads that simulate at once compute what each would alone."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from tests.api.samples import muscled, scene
from warp_softbody import Body, Plane, Scene, Simulation, SimulationOptions, placed
from warp_softbody.controllers import Balance
from warp_softbody.device.turns import Turns

THREADS = 4


def positions(kind: int) -> bytes:
    """The last frame of one of four runs: passive, controlled, of two bodies, on two threads."""
    character, options = muscled(), SimulationOptions(threads=2 if kind == 3 else 1)
    above = placed(character, name="above", translation=(0.01, 0.02, 0.21))
    scenes = (
        scene(),
        scene(),
        Scene(character=character, others=(Body(character=above),), ground=Plane()),
        scene(),
    )
    controller = Balance() if kind == 1 else None
    simulation = Simulation(scenes[kind], controller, options=options)
    return [frame.positions.tobytes() for frame in simulation.run(0.3)][-1]


def test_four_simulations_in_four_threads() -> None:
    alone = [positions(kind) for kind in range(THREADS)]
    with ThreadPoolExecutor(THREADS) as pool:
        for _ in range(3):
            assert list(pool.map(positions, range(THREADS))) == alone


def test_nobody_is_inside_with_one_who_is_alone() -> None:
    turns, inside, wrong = Turns(), [0, 0], []

    def take_turns(seed: int) -> None:
        random = np.random.default_rng(seed)
        for _ in range(100):
            entered = turns.enter()
            # within a share, and within being alone, both may be asked for again
            assert not turns.enter()
            if random.random() < 0.3:
                with turns.alone(), turns.alone():
                    inside[1] += 1
                    wrong.append(inside[1] != 1)
                    inside[1] -= 1
            wrong.append(inside[1] != 0)
            assert entered
            turns.leave()

    threads = [threading.Thread(target=take_turns, args=(seed,)) for seed in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(wrong) >= 600
    assert not any(wrong)
