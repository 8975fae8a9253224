"""A simulation goes on from where another one of the same bodies is."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import warp as wp

from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, PairStates, State
from warp_softbody.errors import InputError


def require_same_bodies(model: Model, before: Model) -> None:
    """Refuse a model whose state is none of another one.

    Raises:
        InputError: bodies, muscles, time step or precision differ.
    """
    for name in ("time_step", "precision"):
        own, other = getattr(model.options, name), getattr(before.options, name)
        if own != other:
            raise InputError(
                f"after of a Simulation must have the same {name}, {own!r}, but it has {other!r}"
            )
    mesh, other_mesh = model.body.mesh, before.body.mesh
    lengths, other_lengths = model.muscles.rest_lengths, before.muscles.rest_lengths
    if not (
        np.array_equal(mesh.points, other_mesh.points)
        and np.array_equal(mesh.tets, other_mesh.tets)
        and np.array_equal(lengths, other_lengths)
    ):
        raise InputError("after of a Simulation must be one of the same bodies and muscles")


def copy_motion(
    before: Model, state: State, contacts: Contacts, model: Model, own: State, touching: Contacts
) -> None:
    """Copy a state of a model, and contacts as far as both have them, into those of another one."""
    for entry in fields(state):
        getattr(own, entry.name).assign(getattr(state, entry.name))
    for entry in fields(contacts):
        source, target = getattr(contacts, entry.name), getattr(touching, entry.name)
        if entry.name != "pairs" and source.shape == target.shape:
            target.assign(source)
    if contacts.pairs is not None and touching.pairs is not None:
        for entry in fields(contacts.pairs):
            source = getattr(contacts.pairs, entry.name)
            target = getattr(touching.pairs, entry.name)
            for begin, to, count in _common_pairs(before, model):
                wp.copy(target, source, dest_offset=to, src_offset=begin, count=count)


def _common_pairs(before: Model, model: Model) -> tuple[tuple[int, int, int], ...]:
    """First pair of one, first of the other and number of those that both models have.

    They are of the same bodies, over other grounds or with other contact of surfaces.
    """
    first, second = PairStates.first_on_ground(before), PairStates.first_on_ground(model)
    on_ground = PairStates.count(before) - first if model.scene.has_ground_edges else 0
    parts = ((0, 0, min(first, second)), (first, second, on_ground))
    return tuple(part for part in parts if part[2] > 0)
