"""Run by the Python that has Newton: what it makes of a stage, as JSON."""

from __future__ import annotations

import json
import sys

import newton
import numpy as np


def main(stage: str) -> None:
    """Print the mass, the tets, their Lame values and the shapes that a stage brings."""
    builder = newton.ModelBuilder()
    builder.add_usd(stage)
    materials = np.array(builder.tet_materials, dtype=float).reshape(-1, 3)
    told = {
        "mass": float(np.sum(builder.particle_mass)),
        "tets": len(materials),
        "mu": sorted(set(materials[:, 0].tolist())),
        "lambda": sorted(set(materials[:, 1].tolist())),
        "shapes": len(builder.shape_type),
    }
    print("\n" + json.dumps(told))


if __name__ == "__main__":
    main(sys.argv[1])
