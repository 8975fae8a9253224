// The player of a finished take, all of which is in the page.

import { button, choice, element } from "./dom.js";
import { pageFrame, SPEEDS } from "./frame.js";
import { layerSection } from "./layers.js";
import { Plots } from "./plots.js";
import { Viewer } from "./viewer.js";
import { readOutline, UpdateDecoder } from "./wire.js";

/** Outline and moments of the bytes of a take. */
function readTake(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const parts = [];
  for (let at = 0; at < bytes.length; ) {
    const length = view.getUint32(at, true);
    parts.push(bytes.subarray(at + 4, at + 4 + length));
    at += 4 + length;
  }
  const outline = readOutline(new TextDecoder().decode(parts[0]));
  const decoder = new UpdateDecoder(outline, true);
  return { outline, moments: parts.slice(1).map((part) => decoder.decode(part)) };
}

class Player {
  constructor({ outline, moments }) {
    this.moments = moments;
    this.frame = pageFrame(outline.name);
    this.viewer = new Viewer(this.frame.picture, outline);
    this.plots = new Plots(outline);
    this.plots.fill(moments);
    this.frame.panel.append(layerSection(this.viewer), this.plots.row);
    this.time = moments[0].time;
    this.end = moments[moments.length - 1].time;
    this.speed = 1;
    this.loops = true;
    this.index = -1;
    this.frame.bar.append(...this.makeBar());
    this.setPlaying(moments.length > 1);
    this.show(0);
    new ResizeObserver(() => this.plots.draw(this.index)).observe(this.frame.panel);
    addEventListener("keydown", (event) => this.key(event));
  }

  makeBar() {
    this.play = button("Pause", "Space", () => this.setPlaying(!this.playing), "main");
    this.slider = element("input", "range time-range", [], { type: "range", min: 0, value: 0 });
    this.slider.max = this.moments.length - 1;
    this.slider.setAttribute("aria-label", "Frame");
    this.slider.oninput = () => {
      this.setPlaying(false);
      this.show(Number(this.slider.value));
    };
    const options = SPEEDS.map((value) => ({ value, text: `${value}x`, title: "Speed" }));
    const speeds = choice(options, (value) => {
      this.speed = value;
      speeds.set(value);
    });
    speeds.set(this.speed);
    const loop = button("Loop", "Begin again at the end", () => {
      this.loops = !this.loops;
      loop.setAttribute("aria-pressed", String(this.loops));
    });
    loop.setAttribute("aria-pressed", "true");
    const home = button("Reset view", "Camera as at the start", () => this.viewer.home());
    return [this.play, this.slider, speeds.row, loop, home];
  }

  key(event) {
    if (event.target.matches("input, button")) return;
    const moves = { ArrowLeft: -1, ArrowRight: 1 };
    if (event.key === " ") this.setPlaying(!this.playing);
    else if (event.key in moves) this.stepBy(moves[event.key]);
    else return;
    event.preventDefault();
  }

  stepBy(count) {
    this.setPlaying(false);
    this.show(Math.max(0, Math.min(this.moments.length - 1, this.index + count)));
  }

  setPlaying(playing) {
    if (playing && !this.playing) {
      if (this.index === this.moments.length - 1) this.time = this.moments[0].time;
      this.before = null;
      requestAnimationFrame((now) => this.tick(now));
    }
    this.playing = playing;
    this.play.textContent = playing ? "Pause" : "Play";
  }

  tick(now) {
    if (!this.playing) return;
    if (this.before !== null) this.time += (this.speed * (now - this.before)) / 1000;
    this.before = now;
    if (this.time > this.end + 1e-9) {
      if (this.loops) this.time = this.moments[0].time;
      else this.setPlaying(false);
    }
    this.show(this.indexAt(this.time), false);
    if (this.playing) requestAnimationFrame((then) => this.tick(then));
  }

  /** The last moment that is not later than a time. */
  indexAt(time) {
    let low = 0;
    let high = this.moments.length - 1;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.moments[middle].time <= time + 1e-9) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  show(index, jump = true) {
    if (jump) this.time = this.moments[index].time;
    if (index === this.index) return;
    this.index = index;
    this.viewer.show(this.moments[index]);
    if (jump) this.plots.draw(index);
    else this.plots.drawSoon(index);
    this.slider.value = index;
    this.frame.showTime(this.moments[index].time);
  }
}

window.softBody = { player: new Player(readTake(window.takeBytes)) };
