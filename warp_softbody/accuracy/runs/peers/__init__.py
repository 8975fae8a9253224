"""Other programs that step the same beam; their packages come with the extra ``bench``."""

from __future__ import annotations

import importlib

MODULES = ("mujoco", "pypardiso")


def missing_peer() -> str | None:
    """One sentence about the first peer that cannot be imported, None if all can."""
    for name in MODULES:
        try:
            module = importlib.import_module(name)
        except ImportError:
            return (
                f"--peers needs the package {name}; install it with "
                "pip install 'warp-softbody[bench]'"
            )
        if name == "mujoco" and not hasattr(module.mjtIntegrator, "mjINT_DISCRETE"):
            return (
                f"--peers needs MuJoCo 3.13 or later, not {module.__version__}; update it with "
                "pip install -U 'warp-softbody[bench]'"
            )
    return None
