"""Failures of the suite that are known, with what was measured; each is an expected failure."""

from __future__ import annotations

from itertools import product

Known = dict[tuple[str, str], str]

SINGLE, DOUBLE = "default float32", "default float64"

KINK = "a half turn in one layer of cells is a minimum of the energy: its Hessian is positive there"
SPIN = "inverted tets unfold into a spin that nothing stops, and a turning body swells"
SWELLING = "x+ = x + dt v+ swells a body that turns by w dt a step, where it is under a thousandth"

RECOVERY: Known = {
    ("mirrored free", SINGLE): f"7 of 9 do not, volumes 0.9196 to 1.045: {SPIN}",
    ("mirrored free undamped", SINGLE): f"3 of 9 do not, volumes 0.9196 to 1.023: {SPIN}",
    ("mirrored free undamped", DOUBLE): f"4 of 9 do not, volumes up to 1.053: {SPIN}",
    ("random", SINGLE): f"1 of 12 does not, volume 0.9036: {KINK}",
    ("random", DOUBLE): f"1 of 12 does not, volume 0.9036: {KINK}",
    (
        "random free",
        SINGLE,
    ): f"9 of 12 do not: three kinks (0.904), six spins (up to 1.029): {KINK}",
    (
        "random free",
        DOUBLE,
    ): f"9 of 12 do not: three kinks (0.904), six spins (up to 1.029): {KINK}",
    ("random beam", SINGLE): f"2 of 12 do not, volumes 0.9518 and 0.9571: {KINK}",
    ("random beam", DOUBLE): f"2 of 12 do not, volumes 0.9518 and 0.9571: {KINK}",
    ("kinked", SINGLE): f"about yz and xyz, volume 0.9052: {KINK}",
    ("kinked", DOUBLE): f"about yz and xyz, volume 0.9052: {KINK}",
}
"""Of ``test_case_recovers``, by case and configuration."""

GAIN: Known = {
    ("turn dt 0.5", SINGLE): f"energy up to 2800 times the start's: {SWELLING}",
    ("turn dt 0.5", DOUBLE): f"energy up to 129 times the start's: {SWELLING}",
}
"""Of ``test_case_gains_nothing``, by case and configuration."""

HANGS_ON_ROUNDING = {
    *product(("random", "random beam", "mirrored free undamped"), (SINGLE, DOUBLE)),
}
"""Of ``RECOVERY``: so few starts fail, or so narrowly, that on another machine none may."""
