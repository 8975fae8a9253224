// What a person may do to a running scene.

import { button, choice, element, section, slider } from "./dom.js";
import { SPEEDS } from "./frame.js";

const CONTROLS = {
  qpcc: ["QPCC", "contacts may stick, slide and lift"],
  static: ["Static", "a QP that takes all contacts for static"],
  none: ["None", "slack muscles"],
};

export class Panel {
  constructor(status, send) {
    this.send = send;
    this.running = status.running;
    this.sections = [this.runSection()];
    if (status.controls.length > 1) this.sections.push(this.controlSection(status));
    if (status.steering !== null) this.sections.push(this.steerSection(status));
    this.sections.push(this.worldSection(status), this.pushSection(status));
    this.show(status);
  }

  runSection() {
    const act = (what) => () => this.send({ do: what });
    this.play = button("Pause", "Space", () => this.toggle(), "main");
    const stepOnce = button("Step", "One time step (right arrow)", act("step"));
    const restart = button("Restart", "From the start pose (R)", act("restart"));
    const options = SPEEDS.map((value) => ({ value, text: `${value}x`, title: "Speed" }));
    this.speed = choice(options, (value) => this.send({ do: "speed", value }));
    this.record = button("Record", "Write a stage (USD)", () => {
      this.send({ do: "record", value: !this.recording });
    });
    this.file = element("span", "file");
    const buttons = element("div", "buttons", [this.play, stepOnce, restart]);
    const recording = element("div", "buttons", [this.record, this.file]);
    return section("Run", [buttons, this.speed.row, recording]);
  }

  controlSection(status) {
    const options = status.controls.map((value) => {
      const [text, title] = CONTROLS[value];
      return { value, text, title };
    });
    this.control = choice(options, (value) => this.send({ do: "control", value }));
    return section("Controller", [this.control.row]);
  }

  steerSection(status) {
    const show = (share) => `${Math.round(100 * share)} %`;
    const steer = () => this.steer();
    const one = (name, i) => slider({
      name, low: -1, high: 1, step: 0.05, value: status.steering[i], show, onset: steer,
    });
    this.ways = ["Forward", "To the left", "Turn left"].map(one);
    const stop = button("Stand", "All three to nothing", () => {
      for (const way of this.ways) way.set(0);
      this.steer();
    });
    const hint = element("p", "hint", ["Shares of what the feet can do."]);
    const rows = this.ways.map((way) => way.row);
    return section("Steer", [...rows, element("div", "buttons", [stop]), hint]);
  }

  steer() {
    const [forward, aside, turning] = this.ways.map((way) => Number(way.range.value));
    this.send({ do: "steer", forward, aside, turning });
  }

  worldSection(status) {
    const set = (what) => (value) => this.send({ do: what, value });
    const [low, high] = [0, 20];
    this.gravity = slider({
      name: "Gravity", low, high, step: 0.1, value: status.gravity,
      show: (value) => `${value.toFixed(1)} m/s²`, onset: set("gravity"),
    });
    const rows = [this.gravity.row];
    if (status.friction !== null) {
      this.friction = slider({
        name: "Friction", low: 0, high: 1.5, step: 0.05, value: status.friction,
        show: (value) => value.toFixed(2), onset: set("friction"),
      });
      rows.push(this.friction.row);
    }
    return section("World", rows);
  }

  pushSection(status) {
    this.push = slider({
      name: "Force", low: 0, high: 1, step: 0.02, value: 0.3,
      show: (share) => `${Math.round(share * status.weight)} N`,
    });
    this.direction = slider({
      name: "Direction", low: -180, high: 180, step: 15, value: 0,
      show: (degrees) => `${degrees}°`,
    });
    const go = button("Push for 0.2 s", "On the upper third (P)", () => this.pushNow());
    const hint = element("p", "hint", ["Or drag any point of the skin."]);
    return section("Push", [this.push.row, this.direction.row, element("div", "buttons", [go]), hint]);
  }

  pushNow() {
    const share = Number(this.push.range.value);
    this.send({ do: "push", share, degrees: Number(this.direction.range.value) });
  }

  toggle() {
    this.send({ do: this.running ? "pause" : "play" });
  }

  key(event) {
    if (event.target.matches("input, button") && event.key === " ") return;
    const acts = {
      " ": () => this.toggle(),
      ArrowRight: () => this.send({ do: "step" }),
      r: () => this.send({ do: "restart" }),
      p: () => this.pushNow(),
    };
    if (event.target.matches("input") || !(event.key in acts)) return;
    acts[event.key]();
    event.preventDefault();
  }

  show(status) {
    this.running = status.running;
    this.recording = Boolean(status.recording);
    this.play.textContent = status.running ? "Pause" : "Play";
    this.speed.set(status.speed);
    this.control?.set(status.control);
    this.gravity.set(status.gravity);
    this.friction?.set(status.friction);
    this.ways?.forEach((way, i) => way.set(status.steering[i]));
    this.record.textContent = this.recording ? "Stop recording" : "Record";
    this.record.setAttribute("aria-pressed", String(this.recording));
    this.file.textContent = status.file ?? "";
    const watches = status.role !== "driver";
    for (const part of this.sections) part.inert = watches;
  }
}
