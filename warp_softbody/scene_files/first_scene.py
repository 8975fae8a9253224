"""The scene file that one begins with: short, and with all that may be added in comments."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.atomic_files import replace_text
from warp_softbody.errors import InputError, OutputError
from warp_softbody.scene_files.reading import EXTENSION

TEXT = """\
# A scene of warp-softbody. SI units, z is up. docs/scene-files.md has all keys.

name = "{name}"
seconds = 4.0

[ground]
kind = "plane"
friction = 0.8

# The character that a controller moves: one that ships, or `file = "my.char"`, or a surface, as
# `file = "my.obj"` with `height = 1.0`.
[character]
shape = "letter_i"

# What is changed of its material.
[character.material]
young_modulus = 1.8e6
poisson_ratio = 0.48
stiffness_damping = 0.035
volume = "exact"

[character.strengths]
longitudinal = 1.2e6

[controller]
kind = "balance"

# Its head is pushed for a fifth of a second, N.
[[pushes]]
region = "head"
force = [300.0, 0.0, 0.0]
start = 0.5
duration = 0.2

# A material with a name, for several bodies.
[materials.rubber]
young_modulus = 2e5
poisson_ratio = 0.4
stiffness_damping = 0.02
density = 900.0

# A further body: a ball that flies by.
[[bodies]]
name = "ball"
shape = "ball"
radius = 0.1
center = [-1.5, 0.7, 0.4]
material = "rubber"
velocity = [1.0, 0.0, 1.0]
spin = [0.0, 6.0, 0.0]

# One that is moved along a path: a paddle that goes to and fro beside them.
[[bodies]]
name = "paddle"
shape = "box"
size = [0.05, 0.4, 0.4]
cells = [1, 4, 4]
translation = [1.2, 0.7, 0.05]

[[handles]]
region = "paddle"

[handles.path]
times = [0.0, 1.0, 2.0]
shifts = [[0.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.0]]
between = "ease"
afterwards = "repeat"

[options]
time_step = 0.016666666666666666

# What `warp-softbody run` writes beside this file; without it, only what its flags ask for.
# [output]
# stage = "{name}.usdc"
# movie = "{name}.mp4"
# fps = 30
"""


def write_first_scene(path: Path) -> None:
    """Write it.

    Raises:
        InputError: the path does not end in .toml.
        OutputError: the folder cannot be written in.
    """
    if path.suffix.lower() != EXTENSION:
        raise InputError(f"{path}: a scene file must end in {EXTENSION}")
    name = "".join(c if c.isalnum() or c in "-_ " else "_" for c in path.stem)
    try:
        replace_text(path, TEXT.format(name=name))
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
