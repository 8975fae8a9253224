// Colours with a meaning; those of muscles and contacts are the ones of stages and pictures.

const CONTRACTION = [0.0, 0.15, 0.5];
const MUSCLE = [
  [0.86, 0.8, 0.62],
  [0.16, 0.62, 0.78],
  [0.02, 0.05, 0.42],
];

/** Linear RGB of a muscle segment by its contraction 1 - l_d / l_0, from 0 to 0.5. */
export function muscleColor(contraction, color) {
  const upper = contraction < CONTRACTION[1] ? 1 : 2;
  const from = CONTRACTION[upper - 1];
  const share = Math.min(1, (contraction - from) / (CONTRACTION[upper] - from));
  const mix = (c) => MUSCLE[upper - 1][c] + share * (MUSCLE[upper][c] - MUSCLE[upper - 1][c]);
  return color.setRGB(mix(0), mix(1), mix(2));
}

/** What a ground's linear RGB is multiplied by: bluer where it slips, darker where it holds more. */
export function frictionTint(factor) {
  const slip = Math.max(0, 1 - factor);
  const hold = Math.max(0.5, 1 - 0.6 * Math.max(0, factor - 1));
  return [hold * (1 - 0.7 * slip), hold * (1 - 0.25 * slip), hold];
}

/** By contact mode: lift, stick, slide. */
export const MODE_COLORS = ["#8c96a3", "#138a36", "#e8730c"];

export const COLORS = {
  background: "#eef1f5",
  tileLight: "#e2e7ed",
  tileDark: "#d3dae2",
  shadow: "#26303f",
  uneven: "#d9e0e8",
  edge: "#98a4b3",
  slippery: "#8fc1e8",
  center: "#101828",
  base: "#138a36",
  capture: "#a21caf",
  plan: "#2563eb",
  hand: "#dc2626",
  x: "#dc2626",
  y: "#138a36",
  z: "#2563eb",
};
