// The switches of what is shown, each with the colours that it has in the picture.

import { section, toggle } from "./dom.js";
import { COLORS, MODE_COLORS } from "./palette.js";

const MUSCLES = ["#ede6ce", "#70cee2", "#253fac"];

/** The section of switches for a viewer; parts that the scene has not are left out. */
export function layerSection(viewer) {
  const { outline } = viewer;
  const muscular = outline.segmentCount > 0;
  const layers = [
    muscular && ["muscles", "Muscles", "slack, contracting, contracted to half", MUSCLES, true],
    ["contacts", "Contact forces", "green where they stick, orange where they slide", MODE_COLORS.slice(1), true],
    ["center", "Centre of mass", "and the line down to the ground", [COLORS.center], true],
    outline.ground && ["base", "Base and capture point", "hull of the contacts; where a step would stop the body", [COLORS.base, COLORS.capture], true],
    outline.ground?.friction && ["friction", "Friction", "bluer where the ground slips, darker where it holds more", [COLORS.slippery], true],
    muscular && ["plan", "Patches and plan", "forces that the controller planned", [COLORS.plan], false],
    ["follow", "Camera follows", "the centre of mass", [], true],
  ];
  const rows = layers.filter(Boolean).map(([name, text, title, colors, on]) => {
    viewer.setLayer(name, on);
    return toggle({ text, title, colors, on, onset: (value) => viewer.setLayer(name, value) });
  });
  return section("Layers", rows);
}
