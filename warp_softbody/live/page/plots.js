// Small plots of numbers over time.

import { element, section } from "./dom.js";
import { COLORS } from "./palette.js";
import { numberOf } from "./wire.js";

const AXES = [["x", COLORS.x], ["y", COLORS.y], ["z", COLORS.z]];
const HEIGHT = 64;
const LONGEST = 6;
const BETWEEN = 150;

const vector = (name) => AXES.map(([axis, color]) => [`${name}.${axis}`, axis, color]);

const PLOTS = [
  ["Milliseconds of a step", "ms", [
    ["ms.control", "control", "#7c3aed"],
    ["ms.assembly", "assembly", "#0891b2"],
    ["ms.solve", "solve", "#e8730c"],
    ["ms.contact", "contact", "#138a36"],
  ]],
  ["QPs of a step", "", [["qps", "QPs", "#7c3aed"]]],
  ["Momentum", "N s", vector("momentum")],
  ["Angular momentum", "N m s", vector("spin")],
  ["Speed of the centre of mass", "m/s", vector("velocity")],
  ["Mean contraction", "", [["contraction", "1 - l_d / l_0", "#253fac"]]],
];

/** The plots of those numbers that an outline has. */
export class Plots {
  constructor(outline) {
    this.outline = outline;
    this.momenta = outline.place.has("momentum.x");
    this.plots = PLOTS.filter(([, , series]) => this.has(series)).map((plot) => new Plot(...plot));
    this.row = section("Plots", this.plots.map((plot) => plot.row));
    this.times = [];
    this.drawn = 0;
  }

  has(series) {
    const [name] = series[0];
    if (name === "contraction" && !this.outline.segmentCount) return false;
    return this.outline.place.has(name) && !(this.momenta && name.startsWith("velocity"));
  }

  /** Add a moment at the end; a time before the last one begins anew. */
  add(moment) {
    if (moment.time < this.times.at(-1)) this.clear();
    if (moment.time === this.times.at(-1)) return;
    this.times.push(moment.time);
    for (const plot of this.plots) plot.add((name) => numberOf(this.outline, moment, name));
    while (this.times.at(-1) - this.times[0] > LONGEST) this.drop();
    this.drawSoon(null);
  }

  /** Draw, unless that was done a moment ago. */
  drawSoon(cursor) {
    const now = performance.now();
    if (now - this.drawn < BETWEEN) return;
    this.drawn = now;
    this.draw(cursor);
  }

  /** All moments of a take at once. */
  fill(moments) {
    this.times = moments.map((moment) => moment.time);
    for (const moment of moments) {
      for (const plot of this.plots) plot.add((name) => numberOf(this.outline, moment, name));
    }
  }

  clear() {
    this.times = [];
    for (const plot of this.plots) plot.clear();
  }

  drop() {
    this.times.shift();
    for (const plot of this.plots) plot.drop();
  }

  /** Draw all; a cursor stands at an index, or nowhere. */
  draw(cursor) {
    for (const plot of this.plots) plot.draw(this.times, cursor);
  }
}

class Plot {
  constructor(title, unit, series) {
    this.series = series.map(([name, label, color]) => ({ name, label, color, values: [] }));
    this.canvas = element("canvas", "plot");
    this.range = element("span", "range-text");
    const legend = this.series.map(({ label, color }) => {
      const made = element("span", "legend", [label]);
      made.style.color = color;
      return made;
    });
    const head = element("div", "plot-head", [element("span", "name", [title]), this.range]);
    const keys = legend.length > 1 ? [element("div", "legends", legend)] : [];
    this.row = element("figure", "figure", [head, this.canvas, ...keys]);
    this.unit = unit;
  }

  add(read) {
    for (const part of this.series) part.values.push(read(part.name));
  }

  drop() {
    for (const part of this.series) part.values.shift();
  }

  clear() {
    for (const part of this.series) part.values = [];
  }

  draw(times, cursor) {
    const width = this.canvas.clientWidth;
    if (!width || times.length < 2) return;
    const ratio = Math.min(2, window.devicePixelRatio);
    if (this.canvas.width !== Math.round(width * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = HEIGHT * ratio;
    }
    const pen = this.canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, HEIGHT);
    const [low, high] = this.limits();
    const last = times.length - 1;
    const x = (i) => (width * (times[i] - times[0])) / (times[last] - times[0]);
    const y = (value) => HEIGHT - 3 - ((HEIGHT - 6) * (value - low)) / (high - low);
    pen.strokeStyle = "#d0d7e0";
    this.stroke(pen, [[0, y(0)], [width, y(0)]]);
    for (const { values, color } of this.series) {
      pen.strokeStyle = color;
      pen.lineWidth = 1.4;
      this.stroke(pen, values.map((value, i) => [x(i), y(value)]).filter(([, v]) => isFinite(v)));
    }
    if (cursor !== null) {
      pen.strokeStyle = "#101828";
      this.stroke(pen, [[x(cursor), 0], [x(cursor), HEIGHT]]);
    }
    this.range.textContent = `${short(low)} to ${short(high)} ${this.unit}`;
  }

  /** Lowest and highest value, with zero between them. */
  limits() {
    const all = this.series.flatMap(({ values }) => values).filter((value) => isFinite(value));
    const low = all.reduce((a, b) => Math.min(a, b), 0);
    const high = all.reduce((a, b) => Math.max(a, b), 0);
    return high > low ? [low, high] : [low, low + 1];
  }

  stroke(pen, points) {
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.stroke();
  }
}

/** A number with three digits that count. */
export function short(value) {
  return String(Number(value.toPrecision(value !== 0 && Math.abs(value) < 1 ? 2 : 3)));
}
