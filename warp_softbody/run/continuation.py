"""A simulation goes on from where another one of the same bodies is."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, State
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


def copy_motion(state: State, contacts: Contacts, own: State, touching: Contacts) -> None:
    """Copy a state, and contacts where they are of the same kind, into those of another model."""
    for entry in fields(state):
        getattr(own, entry.name).assign(getattr(state, entry.name))
    for entry in fields(contacts):
        source, target = getattr(contacts, entry.name), getattr(touching, entry.name)
        if entry.name != "pairs" and source.shape == target.shape:
            target.assign(source)
    if contacts.pairs is not None and touching.pairs is not None:
        for entry in fields(contacts.pairs):
            getattr(touching.pairs, entry.name).assign(getattr(contacts.pairs, entry.name))
