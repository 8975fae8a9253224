"""Whether two commits compute the same motions, bit for bit.

``python -m benchmarks.same_bits --record before.json`` writes a hash of every scene's frames; the
same command with ``--against before.json``, run on another commit, says which scenes differ. Only
public names are used, so that the file can be laid beside an older commit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path

import warp_softbody as wsb


def motion_hash(name: str, seconds: float | None) -> str:
    """SHA-256 over the positions, velocities and activations of all frames of a scene.

    Args:
        name: one of `warp_softbody.scenes.names()`.
        seconds: length of the run, s; None for the scene's own.
    """
    plan = wsb.scenes.make(name)
    options = wsb.SimulationOptions(time_step=plan.time_step)
    simulation = wsb.Simulation(plan.scene, plan.controller, options=options)
    total = hashlib.sha256()
    for frame in simulation.run(plan.seconds if seconds is None else min(seconds, plan.seconds)):
        for array in (frame.positions, frame.velocities, frame.activations):
            total.update(array.tobytes())
    return total.hexdigest()


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.same_bits", description=__doc__)
    parser.add_argument("scenes", nargs="*", default=None, help="names of scenes; all by default")
    parser.add_argument("--seconds", type=float, help="most seconds of each scene")
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--record", type=Path, help="file to write the hashes to")
    action.add_argument("--against", type=Path, help="file of hashes to compare with")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command; 1 where a scene differs."""
    given = _arguments().parse_args(arguments)
    known = json.loads(given.against.read_text()) if given.against else {}
    hashes, differing = {}, []
    for name in given.scenes or list(wsb.scenes.names()):
        hashes[name] = motion_hash(name, given.seconds)
        same = given.record is not None or known.get(name) == hashes[name]
        differing += [] if same else [name]
        print(f"{name}: {hashes[name][:16]}{'' if same else ' differs'}", flush=True)
    if given.record:
        given.record.write_text(json.dumps(hashes, indent=1) + "\n")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
