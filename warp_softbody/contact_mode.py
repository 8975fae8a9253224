"""The mode of a contact, as the simulator, the control problem and stages number it."""

from __future__ import annotations

from enum import IntEnum

from warp_softbody.inputs import input_kinds


class ContactMode(IntEnum):
    """Whether a contact lifts, sticks or slides (docs/method.md section 5)."""

    LIFT = 0
    STICK = 1
    SLIDE = 2

    @classmethod
    def _missing_(cls, value: object) -> ContactMode:
        """Refuse a number of none of the modes."""
        return input_kinds.member("ContactMode", value, cls)
