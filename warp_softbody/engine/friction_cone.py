"""Which kernels resolve the friction of a model."""

from __future__ import annotations

from types import SimpleNamespace

from warp_softbody.engine.model import Model
from warp_softbody.errors import InputError
from warp_softbody.kernels.contact.active_set import make_contact


def make_friction(model: Model) -> SimpleNamespace:
    """The contact kernels of the friction and of the cone that a model has.

    Raises:
        InputError: where a polygon is asked for together with friction by direction, whose factors
            would leave it lopsided, so that friction no longer opposes the sliding.
    """
    directional = bool(model.body.directional_friction)
    directions = model.options.cone_directions
    if directional and directions:
        raise InputError(
            f"directional friction needs the smooth cone, got cone {model.options.cone!r}"
        )
    return make_contact(model.options.precision, directional, directions)
