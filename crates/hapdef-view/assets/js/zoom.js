// A contact's 95 % region seen from outside, as large as there is room for.

import { Vector3 } from "../vendor/three/three.module.min.js";
import { roundUp } from "./colour.js";
import { SDS } from "./marks.js";

const SVG = "http://www.w3.org/2000/svg";
/** Where the region's middle is, from the top. */
const MIDDLE = 19;
/** Half of the picture's width, and how much of it the region fills at most. */
const HALF = 24;
const FILLED = 15;
const N_CORNERS = 32;

/** An empty picture. */
export function makeZoom() {
  const svg = part("svg", { viewBox: `${-HALF} ${-MIDDLE} ${2 * HALF} ${2 * HALF}`, class: "zoom", role: "img" });
  svg.append(part("polygon", {}), part("circle", { class: "true", r: 3 }), part("circle", { class: "found", r: 1.4 }), part("path", {}), part("text", { x: 0, y: 2 * HALF - MIDDLE - 1 }));
  return svg;
}

/** Draws a mark's region, its right about the screen's, and the true place if that is known. */
export function drawZoom(svg, mark, truth, right) {
  const [region, real, , bar, text] = svg.children;
  svg.toggleAttribute("hidden", !mark.axes);
  if (!mark.axes) return;
  const [across, up] = directions(mark.normal, right);
  const flat = (vector) => [vector.dot(across), -vector.dot(up)];
  const axes = mark.axes.map((axis) => flat(new Vector3(...axis).multiplyScalar(SDS)));
  const extent = Math.hypot(axes[0][0], axes[0][1], axes[1][0], axes[1][1]);
  const scale = FILLED / Math.max(extent, 1e-6);
  region.setAttribute("points", corners(axes, scale));
  const off = truth && flat(new Vector3(...truth.position).sub(new Vector3(...mark.position))).map((c) => c * scale);
  const isSeen = Boolean(off) && Math.hypot(...off) < MIDDLE - 3;
  real.style.display = isSeen ? "" : "none";
  if (isSeen) Object.entries({ cx: off[0], cy: off[1] }).forEach(([name, value]) => real.setAttribute(name, value.toFixed(2)));
  const length = roundUp(extent / 2.5);
  const half = (length * scale) / 2;
  bar.setAttribute("d", `M${-half} 17v2.5h${2 * half}v-2.5`);
  text.textContent = `${Number((1e3 * length).toPrecision(1))} mm`;
  svg.setAttribute("aria-label", `95 % region, the bar is ${text.textContent} long`);
}

/** Unit vectors along the skin, the first as near to `right` as can be. */
function directions(normal, right) {
  const outward = new Vector3(...normal);
  const across = new Vector3(...right).addScaledVector(outward, -outward.dot(new Vector3(...right)));
  if (across.lengthSq() < 1e-4) across.set(-outward.y, outward.z, outward.x).cross(outward);
  across.normalize();
  return [across, new Vector3().crossVectors(outward, across)];
}

function corners([a, b], scale) {
  const at = (i) => {
    const [cos, sin] = [Math.cos, Math.sin].map((of) => scale * of((2 * Math.PI * i) / N_CORNERS));
    return `${(cos * a[0] + sin * b[0]).toFixed(2)},${(cos * a[1] + sin * b[1]).toFixed(2)}`;
  };
  return Array.from({ length: N_CORNERS }, (_, i) => at(i)).join(" ");
}

function part(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
