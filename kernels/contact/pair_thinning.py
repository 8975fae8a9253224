"""The choice of the pairs of a step among the candidates found.

Where two flat surfaces meet, the nodes of each have pairs with the faces of the other. Half of them
would repeat the other half, and hold together what may shear. Of two bodies the one whose nodes
stand less densely where they meet gives way: its nodes count only where they are deeper than the
corners of their triangle say. Edges count only where no nodes beside the crossing hold the bodies.
A pair that bears something is not given up for a gap that rounding decides.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import Mode
from warp_softbody.kernels.contact.pair_edges import make_pair_edges
from warp_softbody.kernels.contact.pair_surfaces import SUBJECT, make_pair_surfaces
from warp_softbody.kernels.contact.structs import make_pair_structs
from warp_softbody.kernels.precision import real

AS_CLOSE = 0.005
"""Part of an edge's length by which a node may be nearer than the corners that stand for it."""

HALF_HELD = 0.005
"""The same for an edge where only one of its ends has met the other body."""

FAR = 0.5
"""Part of an edge's length from which on two free bodies meet without friction in a step: between
points so far apart it would turn both."""

DENSER = 0.9
"""Ratio of the mean spacing of nodes below which one side is denser; else the bodies' rank says."""


@cache
def make_pair_thinning(precision: str) -> SimpleNamespace:
    """Kernels ``compare``, ``thin_nodes``, ``thin_edges`` and ``list_found``, in this order."""
    types = real(precision)
    scalar, vec4 = types.scalar, types.vec4
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    Surfaces = make_pair_surfaces(precision).Surfaces
    Edges = make_pair_edges(precision).Edges
    structs = make_pair_structs(precision)
    NodeCandidates, EdgeCandidates = structs.NodeCandidates, structs.EdgeCandidates
    Pairs = structs.Pairs
    as_close, denser = wp.constant(scalar(AS_CLOSE)), wp.constant(scalar(DENSER))
    far = wp.constant(scalar(FAR))
    half_held = wp.constant(scalar(HALF_HELD))

    @kernel
    def compare(
        # model
        s: Surfaces,
        # in
        corners: wp.array(dtype=wp.vec3i),
        # out
        spacing: wp.array(dtype=scalar),
        numbers: wp.array(dtype=int),
    ):
        # mean spacing of the nodes of body a that have met body b, at a * bodies + b
        bodies = s.low.shape[0]
        for k in range(bodies * bodies):
            spacing[k] = scalar(0.0)
            numbers[k] = 0
        for c in range(corners.shape[0]):
            if corners[c][0] >= 0:
                k = s.node_body[s.nodes[c]] * bodies + s.node_body[corners[c][0]]
                spacing[k] = spacing[k] + s.sizes[c]
                numbers[k] = numbers[k] + 1
        for k in range(bodies * bodies):
            if numbers[k] > 0:
                spacing[k] = spacing[k] / scalar(numbers[k])

    @func
    def gives_way(s: Surfaces, spacing: wp.array(dtype=scalar), a: int, b: int):
        bodies = s.low.shape[0]
        own, other = spacing[a * bodies + b], spacing[b * bodies + a]
        if own < denser * other:
            return False
        if other < denser * own:
            return True
        return s.rank[a] > s.rank[b]

    @kernel
    def thin_nodes(
        # model
        s: Surfaces,
        recovery_speed: scalar,
        # in
        spacing: wp.array(dtype=scalar),
        candidates: NodeCandidates,
        modes: wp.array(dtype=int),
        # out
        pairs: Pairs,
    ):
        # in one body the higher number gives way
        c = wp.tid()
        pairs.nodes[c] = wp.vec4i(-1, -1, -1, -1)
        k, w, i = candidates.corners[c], candidates.weights[c], s.nodes[c]
        if k[0] < 0:
            return
        body, other = s.node_body[i], s.node_body[k[0]]
        edge = wp.min(s.sizes[c], s.sizes[s.slots[k[0]]])
        covered = i > k[0] and i > k[1] and i > k[2]
        if body != other:
            covered = gives_way(s, spacing, body, other)
        covered = covered and candidates.deep[c] < 0
        if covered:
            gap = scalar(0.0)
            for a in range(3):
                slot = s.slots[k[a]]
                back = candidates.corners[slot]
                if back[0] < 0:
                    covered = False
                elif s.node_body[back[0]] != body:
                    covered = False
                gap += w[a] * candidates.gaps[slot]
            slack = as_close * edge
            if modes[c] != Mode.LIFT:
                slack = -slack
            covered = covered and gap < candidates.gaps[c] + slack
        if not covered:
            pairs.nodes[c] = wp.vec4i(i, k[0], k[1], k[2])
            pairs.weights[c] = vec4(scalar(1.0), -w[0], -w[1], -w[2])
            pairs.normal_velocity[c] = wp.min(
                -candidates.gaps[c] / s.step_factors[0], recovery_speed
            )
            if candidates.gaps[c] > far * edge and s.fixed[i] == 0 and s.fixed[k[0]] == 0:
                pairs.friction_factor[c] = scalar(0.0)

    @func
    def covers(
        s: Surfaces,
        candidates: NodeCandidates,
        ends: wp.vec2i,
        place: scalar,
        other: int,
        gap: scalar,
        size: scalar,
        touched: bool,
    ):
        # whether the nodes at the ends of an edge hold it off the other body where it crosses
        known = int(0)
        total = scalar(0.0)
        part = scalar(0.0)
        for a in range(2):
            slot = s.slots[ends[a]]
            if candidates.corners[slot][0] >= 0 and candidates.deep[slot] < 0:
                if s.node_body[candidates.corners[slot][0]] == other:
                    w = wp.where(a == 0, scalar(1.0) - place, place)
                    known += 1
                    part += w
                    total += w * candidates.gaps[slot]
        if known == 0:
            return False
        if known == 1 and part < scalar(0.9):
            return not touched and gap > -half_held * size
        slack = wp.where(touched, -as_close, as_close) * size
        return total < part * gap + slack

    @kernel
    def thin_edges(
        # model
        s: Surfaces,
        edges: Edges,
        recovery_speed: scalar,
        first: int,
        # in
        nodes: NodeCandidates,
        crossing: EdgeCandidates,
        modes: wp.array(dtype=int),
        # out
        pairs: Pairs,
    ):
        number = wp.tid()
        c = first + number
        pairs.nodes[c] = wp.vec4i(-1, -1, -1, -1)
        f = crossing.crossed[number]
        if f < 0:
            return
        k, j, w = edges.ends[number / 2], edges.ends[f], crossing.places[number]
        size = wp.min(s.sizes[s.slots[k[0]]], s.sizes[s.slots[j[0]]])
        touched = modes[c] != Mode.LIFT
        gap = crossing.gaps[number]
        own, other = s.node_body[k[0]], s.node_body[j[0]]
        held = covers(s, nodes, k, w[1], other, gap, size, touched)
        held = held or covers(s, nodes, j, -w[3], own, gap, size, touched)
        sunken = crossing.deep[number / 2] >= 0
        if sunken or not held:
            pairs.nodes[c] = wp.vec4i(k[0], k[1], j[0], j[1])
            pairs.weights[c] = w
            pairs.normals[c] = crossing.normals[number]
            pairs.normal_velocity[c] = wp.min(-gap / s.step_factors[0], recovery_speed)
            free = s.fixed[k[0]] == 0 and s.fixed[j[0]] == 0
            smooth = sunken or (gap > far * size and free)
            pairs.friction_factor[c] = wp.where(smooth, scalar(0.0), scalar(1.0))

    @kernel
    def list_found(
        # in and out
        pairs: Pairs,
        modes: wp.array(dtype=int),
    ):
        # what has no partner lifts
        total = int(0)
        for c in range(pairs.nodes.shape[0]):
            if pairs.nodes[c][0] >= 0:
                pairs.found[total] = c
                total += 1
            else:
                modes[c] = Mode.LIFT
        pairs.found_count[0] = total

    return SimpleNamespace(
        compare=compare, thin_nodes=thin_nodes, thin_edges=thin_edges, list_found=list_found
    )
