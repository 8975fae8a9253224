"""A session runs a scene in one thread, as a page asks for it.

The status that pages are told is a JSON object:

    viewer     the name that the page's commands bear
    role       "driver" or "watcher"
    running, speed, control, gravity, friction   as they are set; friction null without a ground
    steering   shares forward, aside and turning; null where the controller cannot be steered
    controls   that there are
    weight     N, of the character at the start
    recording  whether a stage is being written;  file  its name, or what became of it
    message    a sentence, where something went wrong
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import SoftBodyError
from warp_softbody.live.audience import Audience
from warp_softbody.live.commands import Command
from warp_softbody.live.grab import Grab
from warp_softbody.live.live_scene import LiveScene
from warp_softbody.live.pacing import Pace
from warp_softbody.live.scene_view import SceneView
from warp_softbody.live.shove import Shove
from warp_softbody.live.stage_recording import StageRecording
from warp_softbody.live.step_numbers import NUMBERS, StepNumbers
from warp_softbody.live.wire import UpdateEncoder, as_text
from warp_softbody.run.simulation import Simulation

FPS = 30.0
"""Updates a second, of simulated and of real time alike at speed 1."""
MOST_WAITING = 256
"""Commands that wait; of more the page is told that it is too fast."""
IDLE = 0.25
"""Seconds between looks while nothing runs."""


class LiveSession:
    """Steps a scene while pages look on, and does what their driver asks for.

    Commands may be given by any thread; all else is done by the one that calls `run`.

    Attributes:
        audience: the pages.
        view: of the scene.
    """

    def __init__(self, scene: LiveScene, folder: Path) -> None:
        """Build the first simulation; stages are recorded into a folder."""
        self._scene = scene
        self._folder = folder
        self._commands: queue.Queue[Command] = queue.Queue(MOST_WAITING)
        self._ending = threading.Event()
        self._numbers = StepNumbers()
        more = (*NUMBERS, *(f"hand.{axis}" for axis in "xyz"), *(f"pull.{axis}" for axis in "xyz"))
        plan = scene.plan
        self.view = SceneView(plan.scene, name=plan.name, fps=FPS, more=more)
        self._encoder = UpdateEncoder(self.view.outline.points, differences=False)
        self.audience = Audience(as_text(self.view.outline.as_json()))
        self._running = True
        self._message = ""
        self._file: str | None = None
        self._grab: Grab | None = None
        self._shove: Shove | None = None
        self._recording: StageRecording | None = None
        self._pace = Pace()
        self._simulation = self._taken(scene.begun())
        self._steps_per_frame = round(1.0 / (FPS * self._time_step))
        self._since_frame = 0
        self._show()

    @property
    def _time_step(self) -> float:
        return self._simulation.model.options.time_step

    def _taken(self, simulation: Simulation) -> Simulation:
        simulation.observe(self._numbers.note)
        self.view.measures.set_gravity(simulation.model.scene.gravity)
        return simulation

    def ask(self, command: Command) -> bool:
        """Let a command wait for its turn; whether there is room."""
        try:
            self._commands.put_nowait(command)
        except queue.Full:
            return False
        self.audience.joined.set()
        return True

    def end(self) -> None:
        """Let `run` return after the step in hand."""
        self._ending.set()
        self.audience.joined.set()

    def status(self, role: str, viewer: str) -> bytes:
        """What a page is told beside the picture."""
        scene = self._scene
        return as_text(
            {
                "viewer": viewer,
                "role": role,
                "running": self._running,
                "speed": self._pace.speed,
                "control": scene.method,
                "controls": list(scene.methods),
                "gravity": scene.gravity,
                "friction": scene.friction,
                "steering": (scene.steering or (0.0, 0.0, 0.0)) if scene.steers else None,
                "weight": self.view.measures.weight,
                "recording": self._recording is not None,
                "file": self._file,
                "message": self._message,
            }
        )

    def run(self, ended: Callable[[], bool] = bool) -> None:
        """Step, show and obey until `end`, or ``ended``; time stands still while nobody looks."""
        try:
            while not (self._ending.is_set() or ended()):
                self.turn()
        finally:
            self._stop_recording()
            self.audience.close()

    def turn(self) -> None:
        """Do what waits, then one step if one is due, or wait for a moment."""
        self._obey()
        if not (self._running and len(self.audience)):
            self._pace.begin()
            self.audience.joined.wait(IDLE)
            self.audience.joined.clear()
            return
        wait = self._pace.wait(self._time_step)
        if wait > 0.0:
            time.sleep(min(wait, 1.0 / FPS))
        else:
            self._step()

    def _obey(self) -> None:
        before = self._set_values()
        while True:
            try:
                command = self._commands.get_nowait()
            except queue.Empty:
                break
            self._guarded(partial(self._do, command))
        if self._set_values() != before:
            self._guarded(self._continue)
            self.audience.wake()

    def _set_values(self) -> tuple[object, ...]:
        scene = self._scene
        return scene.method, scene.gravity, scene.friction

    def _guarded(self, act: Callable[[], None]) -> None:
        """Do something; what cannot be done is told, and the scene stands still."""
        try:
            act()
        except SoftBodyError as error:
            self._message = str(error)
            self._running = False
            self.audience.wake()

    def _do(self, command: Command) -> None:
        self._message = ""
        getattr(self, f"_do_{command.do}")(**command.given)
        self.audience.wake()

    def _do_play(self) -> None:
        self._running = True

    def _do_pause(self) -> None:
        self._running = False

    def _do_step(self) -> None:
        self._running = False
        self._step(show=True)

    def _do_restart(self) -> None:
        self._let_go()
        self._stop_recording()
        self._numbers.clear()
        self._since_frame = 0
        self._simulation = self._taken(self._scene.begun())
        self._show()

    def _do_speed(self, value: float) -> None:
        self._pace.speed = value

    def _do_control(self, value: str) -> None:
        if value in self._scene.methods:
            self._scene.method = value

    def _do_gravity(self, value: float) -> None:
        self._scene.gravity = value

    def _do_friction(self, value: float) -> None:
        if self._scene.friction is not None:
            self._scene.friction = value

    def _do_steer(self, forward: float, aside: float, turning: float) -> None:
        self._scene.steer(forward, aside, turning)

    def _do_push(self, share: float, degrees: float) -> None:
        weight = self.view.measures.weight or 0.0
        if self._shove is not None:
            self._shove.end()
        self._shove = Shove(self._simulation, share * weight, math.radians(degrees))

    def _do_grab(self, point: int, to: tuple[float, ...]) -> None:
        self._let_go()
        if point < len(self.view.nodes):
            self._grab = Grab(self._simulation, int(self.view.nodes[point]), to)

    def _do_drag(self, to: tuple[float, ...]) -> None:
        if self._grab is not None:
            self._grab.move(to)

    def _do_release(self) -> None:
        self._let_go()
        self._show()

    def _do_record(self, value: bool) -> None:
        if not value:
            self._stop_recording()
        elif self._recording is None:
            scene = self._simulation.model.scene
            self._recording = StageRecording(self._folder, self._scene.plan.name, scene, FPS)
            self._file = self._recording.path.name

    def _stop_recording(self) -> None:
        recording, self._recording = self._recording, None
        if recording is not None:
            self._file = recording.close()

    def _let_go(self) -> None:
        if self._grab is not None:
            self._grab.release()
        self._grab = None

    def _continue(self) -> None:
        """Go on under what was set; a hand keeps hold."""
        held, shove = self._grab, self._shove
        self._simulation = self._taken(self._scene.continued(self._simulation))
        if held is not None:
            self._grab = Grab(self._simulation, held.node, tuple(held.to.tolist()))
        if shove is not None:
            self._shove = shove.continued(self._simulation)
        self._pace.begin()

    def _step(self, *, show: bool = False) -> None:
        self._guarded(self._advance)
        self._since_frame += 1
        whole = self._since_frame >= self._steps_per_frame
        if whole:
            self._since_frame = 0
        slow = self._pace.speed * self._steps_per_frame < 1.5
        if whole or slow or show:
            self._show(record=whole)

    def _advance(self) -> None:
        if self._grab is not None:
            self._grab.pull(self._simulation)
        if self._shove is not None and self._shove.over(self._simulation.time):
            self._shove.end()
            self._shove = None
        self._simulation.step()
        self._pace.note(self._time_step)

    def _show(self, *, record: bool = False) -> None:
        frame = self._simulation.frame()
        if record and self._recording is not None:
            self._guarded(partial(self._recording.write, frame))
        numbers = np.concatenate([self._numbers.mean(), self._hand()])
        moment = self.view.moment(frame, numbers)
        self.audience.show(self._encoder.encode(moment))

    def _hand(self) -> FloatArray:
        if self._grab is None:
            return np.full(6, np.nan)
        return np.concatenate([self._grab.place(self._simulation), self._grab.force])
