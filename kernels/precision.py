"""The two floating-point types, and where their kernels are compiled.

Kernels that are launched together share one Warp module, by subject, part and precision, so that a
run compiles only what it uses. Gradients are never asked for; without them kernels compile several
times faster.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

BLOCK = 16
"""Right-hand sides solved side by side: one AVX-512 register of float32."""

EPSILON = {"float32": 2.0**-23, "float64": 2.0**-52}
"""Distance from one to the next number, by precision."""

MODULES: set[str] = set()
"""Names of the Warp modules made so far."""


@dataclass(frozen=True)
class Real:
    """Warp types of one precision.

    Attributes:
        name: "float32" or "float64".
        scalar: the Warp scalar.
        vec3: 3-vector.
        vec4: 4-vector.
        mat33: 3 x 3 matrix.
        mat44: 4 x 4 matrix.
        block: vector of BLOCK right-hand sides.
        tiny: smallest number that a norm is divided by.
    """

    name: str
    scalar: Any
    vec3: Any
    vec4: Any
    mat33: Any
    mat44: Any
    block: Any
    tiny: float

    def kernel(self, subject: str, part: str = "") -> Any:
        """Decorator for a kernel of a subject in this precision.

        Kernels that other scenes or devices need than the rest of a subject are a part of it, with
        a module of their own; those that native code replaces on processors are its "plain" part.
        """
        return wp.kernel(enable_backward=False, module=self._module(subject, part))

    def func(self, subject: str) -> Any:
        """Decorator for a function used by kernels of this precision."""
        return wp.func(module=self._module(subject))

    def native(self, snippet: str) -> Any:
        """Decorator for a function of native code, in which SCALAR and LANES are filled in.

        It is for walks through sparse structures, where reckoning the indices of Warp's arrays
        takes longer than the arithmetic.
        """
        name = {"float32": "float", "float64": "double"}[self.name]
        return wp.func_native(snippet.replace("SCALAR", name).replace("LANES", str(BLOCK)))

    def _module(self, subject: str, part: str = "") -> str:
        subject = f"{subject}_{part}" if part else subject
        name = f"warp_softbody.kernels.{subject}.{self.name}"
        MODULES.add(name)
        return name


@cache
def real(name: str) -> Real:
    """The types of "float32" or "float64"."""
    if name == "float32":
        block = wp.types.vector(length=BLOCK, dtype=wp.float32)
        return Real(name, wp.float32, wp.vec3f, wp.vec4f, wp.mat33f, wp.mat44f, block, tiny=1e-30)
    if name == "float64":
        block = wp.types.vector(length=BLOCK, dtype=wp.float64)
        return Real(name, wp.float64, wp.vec3d, wp.vec4d, wp.mat33d, wp.mat44d, block, tiny=1e-200)
    raise ValueError(f"precision must be float32 or float64, got {name!r}")
