// The page of a running scene.

import { pageFrame } from "./frame.js";
import { Hand } from "./hand.js";
import { layerSection } from "./layers.js";
import { Panel } from "./panel.js";
import { Plots } from "./plots.js";
import { Commands, listen } from "./stream.js";
import { button } from "./dom.js";
import { Viewer } from "./viewer.js";
import { readOutline, UpdateDecoder } from "./wire.js";

class LivePage {
  constructor() {
    this.outline = null;
    this.updates = 0;
    this.shown = 0;
    this.rateFrom = performance.now();
    this.commands = new Commands((text) => this.frame?.tell(text));
  }

  begin(text) {
    this.outline = readOutline(text);
    this.decoder = new UpdateDecoder(this.outline, false);
    this.frame = pageFrame(this.outline.name);
    this.viewer = new Viewer(this.frame.picture, this.outline);
    this.hand = new Hand(this.viewer, this.commands);
    this.plots = new Plots(this.outline);
    const home = button("Reset view", "Camera as at the start", () => this.viewer.home());
    this.rate = document.createElement("span");
    this.rate.className = "rate";
    this.frame.bar.append(home, this.rate);
  }

  status(status) {
    this.commands.viewer = status.viewer;
    if (!this.panel) {
      this.panel = new Panel(status, (command) => this.commands.send(command));
      const parts = [...this.panel.sections, layerSection(this.viewer), this.plots.row];
      this.frame.panel.append(...parts);
      addEventListener("keydown", (event) => this.panel.key(event));
    }
    this.panel.show(status);
    this.hand.allowed = status.role === "driver";
    this.frame.badge.textContent = status.role === "driver" ? "" : "watching";
    this.frame.badge.hidden = status.role === "driver";
    this.frame.tell(status.message);
    if (!status.running) this.rate.textContent = "";
  }

  update(bytes) {
    const moment = this.decoder.decode(bytes);
    this.moment = moment;
    this.shown += 1;
    this.viewer.show(moment);
    this.plots.add(moment);
    this.frame.showTime(moment.time);
  }

  count() {
    this.updates += 1;
    const seconds = (performance.now() - this.rateFrom) / 1000;
    if (seconds < 1) return;
    this.rate.textContent = `${Math.round(this.updates / seconds)} updates a second`;
    this.updates = 0;
    this.rateFrom = performance.now();
  }

  async run() {
    try {
      await listen({
        outline: (text) => this.begin(text),
        status: (status) => this.status(status),
        update: (bytes) => this.update(bytes),
        count: () => this.count(),
      });
      this.end("The program has ended; the last moment stays.");
    } catch (error) {
      this.end(error.message || "The program does not answer.");
    }
  }

  end(text) {
    this.frame ??= pageFrame("warp_softbody");
    if (this.hand) this.hand.allowed = false;
    for (const part of this.panel?.sections ?? []) part.inert = true;
    this.frame.tell(text);
  }
}

window.softBody = new LivePage();
window.softBody.run();
