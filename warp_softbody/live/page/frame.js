// The page around the picture: title, picture, panel and a bar below.

import { element } from "./dom.js";

/** Simulated over real time, of which one is chosen. */
export const SPEEDS = [0.1, 0.25, 0.5, 1];

export function pageFrame(title) {
  const time = element("span", "time", ["0.00 s"]);
  const badge = element("span", "badge", [""]);
  badge.hidden = true;
  const note = element("p", "note", [""], { hidden: true });
  note.setAttribute("role", "status");
  const picture = element("div", "picture");
  const panel = element("aside", "panel");
  const bar = element("div", "bar");
  const heading = element("h1", "", [title]);
  const head = element("header", "head", [heading, time, badge]);
  const left = element("main", "left", [head, picture, note, bar]);
  document.title = title;
  document.body.append(left, panel);
  const tell = (text) => {
    note.textContent = text;
    note.hidden = !text;
  };
  const showTime = (seconds) => {
    time.textContent = `${seconds.toFixed(2)} s`;
  };
  return { picture, panel, bar, badge, tell, showTime };
}
