"""Crawling: the tail is pulled up while the head holds, then the head is pushed forward."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen, segments
from warp_softbody.controllers.motions.body_measures import mean_weights, region_mean
from warp_softbody.controllers.motions.for_any_body.step_gains import StepGains
from warp_softbody.controllers.motions.for_any_body.stepping import Stepping
from warp_softbody.controllers.motions.for_any_body.ways import MOST_CRAWLED, stepping, way_to_crawl
from warp_softbody.controllers.motions.lying_on_terrain import LyingOnTerrain
from warp_softbody.controllers.motions.over_edges import over_edges
from warp_softbody.controllers.motions.steering import Guide
from warp_softbody.controllers.motions.trajectories import way_on
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch, ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

CATCH_UP = 1.4
"""Longest pull over a stride: by so much a tail that is behind its schedule is to make good."""

TAIL = ("corner_0", "corner_2")
HEAD = ("corner_1", "corner_3")
MIDDLE = ("belly_2", "belly_3")
BELLY_PATCHES = ("belly_0", "belly_1", "belly_2", "belly_3", "belly_4", "belly_5")


class CrawlPhase(Enum):
    """Which end of the body is on its way."""

    REST = "rest"
    PULL = "pull"
    PUSH = "push"

    @classmethod
    def _missing_(cls, value: object) -> CrawlPhase:
        """Refuse a value of none of the phases."""
        return input_kinds.member("CrawlPhase", value, cls)


@dataclass(frozen=True, kw_only=True)
class CrawlGains:
    """Gains, weights and timing of crawling along x, in units of the body (`BodyUnits`).

    Weights are divided by the time step: in a shorter step muscles change a velocity by less, and
    effort would weigh more.

    Attributes:
        stride: L, by which the ends come together and part again in a cycle.
        arch: L, wanted height of the middle of the belly when they are together; 0 keeps it down.
        pull_time: sqrt(L/g), in which the tail is pulled up.
        push_time: sqrt(L/g), in which the head is pushed forward.
        follow: sqrt(g/L), how fast what is off its trajectory is to come back, and how fast an end
            that is to hold comes to a stop.
        hold: sqrt(g/L), how fast an end that holds while the other is on its way comes back to its
            place. An end that stands on its edge turns over it as the body goes flat, and held to
            its place it would keep the body up: 0 asks it only to come to rest.
        corner_weight: sqrt(L/g), of the corners' velocities along the way in units of sqrt(g L).
        side_weight: of their velocities across the way, likewise.
        ground_weight: of their vertical velocities, likewise; keeps the ends flat on the ground.
        middle_weight: of the middle's vertical velocity, likewise.
        activation: cost of effort and change. The effort spreads a contraction over the body: with
            little of it the segments nearest to the moving end, which answer first, do it all.
    """

    stride: float = field(default=0.12, metadata=dimension(length=1.0))
    arch: float = field(default=0.0, metadata=dimension(length=1.0))
    pull_time: float = field(default=1.879, metadata=dimension(time=1.0))
    push_time: float = field(default=1.879, metadata=dimension(time=1.0))
    follow: float = field(default=3.193, metadata=dimension(time=-1.0))
    hold: float = field(default=3.193, metadata=dimension(time=-1.0))
    corner_weight: float = field(default=0.0256, metadata=dimension(time=1.0))
    side_weight: float = field(default=0.0256, metadata=dimension(time=1.0))
    ground_weight: float = field(default=0.0256, metadata=dimension(time=1.0))
    middle_weight: float = field(default=0.0512, metadata=dimension(time=1.0))
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=1.0, change=0.6264)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("pull_time", "push_time", "follow"),
            not_negative=(
                *("stride", "hold", "corner_weight", "side_weight"),
                *("ground_weight", "middle_weight"),
            ),
            finite=("arch",),
        )
        checks.instance("CrawlGains.activation", self.activation, ActivationCost)


@remembered
class Crawl:
    """Moves the four corners of a lying body along trajectories that repeat, and its middle.

    Every phase begins from where the holding end is, and how fast it still moves. A pull ends where
    the tail is due by then, a stride further in each cycle, so that slipping does not add up; the
    way across and the height are those of the start. The plan counts on no
    friction below the end on its way: where it is planned to stick it stays, as freeing it takes
    changes of several contacts at once.
    """

    required_regions = ()
    """Regions that `for_` needs of a character: none, its shape is enough."""

    def __init__(
        self,
        gains: CrawlGains | None = None,
        *,
        start: float = 1.566,
        resting: tuple[int, ...] = (),
    ) -> None:
        """Crawl along +x from ``start`` sqrt(L/g) on, without the ``resting`` segments."""
        self._resting = segments("resting of Crawl", resting)
        self._gains = checks.optional("gains of Crawl", gains, CrawlGains)
        self.phase = CrawlPhase.REST
        self._since = 0.0
        self._lasts = checks.number("start of Crawl", start, above=0.0, unit="sqrt(L/g)")
        self._units: BodyUnits | None = None
        self._home: dict[str, FloatArray] = {}
        self._goals: dict[str, float] = {}
        self._begin: dict[str, tuple[float, float]] = {}
        self._place = 0.0
        self._rises = (0.0, 0.0, 0.0)
        self._length = 0.0
        self._due = 0.0
        self._terrain: LyingOnTerrain | None = None

    @classmethod
    def for_(
        cls,
        character: Character,
        *,
        heading: float = 0.0,
        speed: float | None = None,
        gains: StepGains | None = None,
        steering: Guide | None = None,
    ) -> Stepping:
        """A crawl of any body that lies: sections of its belly are pushed along, last to first.

        Friction needs no direction, as most of the belly holds while one section moves.

        Args:
            character: at most half as high as long, and twice as long along the heading as high.
            heading: rad, from x towards y.
            speed: m/s, on Earth, up to that of the gains, which is what None asks for.
            gains: None for those that suit it.
            steering: as that of `Walk`, in place of a speed; "forward" is along the heading.

        Raises:
            InputError: the body stands, is too short, has no muscles, or the speed is beyond it.
        """
        heading = checks.number("heading of Crawl", heading, unit="rad")
        way = way_to_crawl(character, heading)
        return stepping("Crawl", character, way, heading, speed, gains, steering, MOST_CRAWLED)

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._lasts *= self._units.time
        if not self._home:
            self._home = {name: region_mean(view, view.positions, name) for name in (*TAIL, *HEAD)}
            self._stop(view, (*TAIL, *HEAD))
            self._length = self._end(HEAD) - self._end(TAIL)
            self._due = self._end(TAIL)
            self._lie(view)
        if view.time - self._since >= self._lasts - 1e-9:
            self._advance(view)
        share = (view.time - self._since) / self._lasts
        corners = self._corners(view, share)
        return Goals(
            objectives=(*corners, *self._over_edges(view), self._middle(view, share)),
            patches=self._patches(view),
            activation=self._gains.activation,
            resting=self._resting,
        )

    def _lie(self, view: BodyView) -> None:
        """Remember by how much corners are over the ground that is not level."""
        self._terrain = LyingOnTerrain.of(view, self._units.length if self._units else 1.0)
        if self._terrain is not None:
            for place in self._home.values():
                place[2] -= self._terrain.over(place).height

    def _advance(self, view: BodyView) -> None:
        """Go on to the next phase."""
        g = self._gains
        self._since += self._lasts
        if self.phase is CrawlPhase.PULL:
            self.phase, self._lasts = CrawlPhase.PUSH, g.push_time
            self._stop(view, TAIL)
            self._place = self._end(TAIL) + self._length * self._foreshortening(view)
            self._go(view, HEAD, 0.0)
        else:
            self.phase, self._lasts = CrawlPhase.PULL, g.pull_time
            self._stop(view, HEAD)
            begin = self._end(HEAD) - self._length * self._foreshortening(view)
            self._due += g.stride
            gather = float(np.clip(self._due - begin, g.stride / CATCH_UP, g.stride * CATCH_UP))
            self._place = begin + gather
            self._go(view, TAIL, g.arch)

    def _go(self, view: BodyView, names: tuple[str, ...], height: float) -> None:
        """Send corners and the middle on from where they are, as fast as they are."""
        for name in names:
            place, speed = (
                float(region_mean(view, of, name)[0]) for of in (view.positions, view.velocities)
            )
            self._begin[name] = (place, speed)
        weights = mean_weights(view, MIDDLE)
        middle = float(weights @ view.positions[:, 2])
        climb = float(weights @ view.velocities[:, 2])
        if self._terrain is not None:
            under = self._terrain.along(weights @ view.positions)
            middle -= under.height
            climb -= under.slope * float(weights @ view.velocities[:, 0])
        self._rises = (middle, climb, height)

    def _foreshortening(self, view: BodyView) -> float:
        """How long along x a body of length 1 is on the slope under it."""
        if self._terrain is None:
            return 1.0
        slope = self._terrain.along(view.center_of_mass).slope
        return float(1.0 / np.hypot(1.0, slope))

    def _stop(self, view: BodyView, names: tuple[str, ...]) -> None:
        """Hold corners where they come to rest if their speed decays from now on."""
        for name in names:
            glide = region_mean(view, view.velocities, name) / self._gains.follow
            self._goals[name] = float((region_mean(view, view.positions, name) + glide)[0])

    def _end(self, names: tuple[str, ...]) -> float:
        """Where an end is to be along x, m."""
        return sum(self._goals[name] for name in names) / len(names)

    def _patches(self, view: BodyView) -> tuple[Patch, ...]:
        """The parts of the belly, of which that of the end on its way slips."""
        patches = list(ground_patches(view, BELLY_PATCHES))
        if patches and self.phase is not CrawlPhase.REST:
            end = 0 if self.phase is CrawlPhase.PULL else -1
            patches[end] = unchecked_copy(patches[end], slips=True)
        return tuple(patches)

    def _corners(self, view: BodyView, share: float) -> list[Objective]:
        """Trajectories of the four corners: one end holds, the other follows."""
        moving = {CrawlPhase.REST: (), CrawlPhase.PULL: TAIL, CrawlPhase.PUSH: HEAD}[self.phase]
        g, speeds = self._gains, dict.fromkeys((*TAIL, *HEAD), 0.0)
        for name in moving:
            place, speed = self._begin[name]
            self._goals[name], speeds[name] = way_on(place, speed, self._place, self._lasts, share)
        rests = self.phase is CrawlPhase.REST
        return [
            self._corner(view, name, speed, g.follow if rests or name in moving else g.hold)
            for name, speed in speeds.items()
        ]

    def _corner(self, view: BodyView, name: str, speed: float, follow: float) -> Objective:
        g = self._gains
        weights = mean_weights(view, (name,))
        place = weights @ view.positions
        goal = np.array([self._goals[name], *self._home[name][1:]])
        rates = np.array([follow, g.follow, g.follow])
        climb = 0.0
        if self._terrain is not None:
            rise = self._terrain.over(place)
            goal[2] += rise.height
            climb = rise.slope * speed
        way = np.array([speed, 0.0, climb]) + rates * (goal - place)
        cost = np.array([g.corner_weight, g.side_weight, g.ground_weight])
        stays = ("corner", name)
        return objectives.velocity(view, weights, way, cost / view.horizon, stays=stays)

    def _over_edges(self, view: BodyView) -> tuple[Objective, ...]:
        if self._terrain is None:
            return ()
        weight = self._gains.middle_weight / view.time_step
        return over_edges(view, self._terrain, BELLY_PATCHES, self._gains.follow, weight)

    def _middle(self, view: BodyView, share: float) -> Objective:
        """Up while the ends come together, down while they part."""
        g = self._gains
        weights = mean_weights(view, MIDDLE)
        height, climb = way_on(*self._rises, self._lasts, share)
        if self._terrain is not None:
            under = self._terrain.along(weights @ view.positions)
            height += under.height
            climb += under.slope * float(weights @ view.velocities[:, 0])
        miss = height - weights @ view.positions[:, 2]
        unit = 1.0 / BodyUnits.of(view).speed
        rows = view.kept("rows of the middle", lambda: objectives.mean_rows(view, unit * weights))
        return Objective(
            name="middle",
            rows=rows[2:],
            target=np.array([unit * (climb + g.follow * miss)]),
            weight=np.array([g.middle_weight / view.horizon]),
        )
