"""Which law of friction a model has: the choice of the active set's kernels."""

from __future__ import annotations

from types import SimpleNamespace

from warp_softbody.engine.model import Model
from warp_softbody.errors import InputError
from warp_softbody.kernels.contact.active_set import make_active_set


def active_set_of(model: Model) -> SimpleNamespace:
    """The kernels of the active set for the law and the cone of friction that a model has.

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
    return make_active_set(model.options.precision, directional, directions)
