// Scales: colours, exaggeration, length.

import { mapColour, roundUp } from "./colour.js";
import { put } from "./text.js";

/** From this end of the colours on they are in mm, m. */
const FROM_MM = 1e-3;
const RULER_PX = 110;

/** The scales over the stage. */
export class Legend {
  constructor(root, ruler) {
    this.root = root;
    this.bar = root.querySelector("#bar");
    this.ticks = root.querySelector("#ticks");
    this.ruler = ruler;
    this.texts = [];
    this.length = null;
    this.setMap("viridis");
  }

  setMap(name) {
    this.bar.width = 160;
    this.bar.height = 1;
    const pen = this.bar.getContext("2d");
    for (let i = 0; i < 160; i += 1) {
      pen.fillStyle = `rgb(${mapColour(name, i / 159).map((c) => Math.round(255 * c))})`;
      pen.fillRect(i, 0, 1, 1);
    }
  }

  /** Ends of the colours, m. */
  setRange(range) {
    const texts = this.ends(range);
    if (texts.join() === this.texts.join()) return;
    this.texts = texts;
    this.ticks.replaceChildren(...texts.map((tick) => Object.assign(document.createElement("span"), { textContent: tick })));
  }

  ends(range) {
    const [end, unit] = range < 0.999999 * FROM_MM ? [1e6 * range, "µm"] : [1e3 * range, "mm"];
    return ["0", number(end / 2), `${number(end)} ${unit}`];
  }

  /** A bar of 1, 2 or 5 · 10ⁿ mm. */
  setRuler(metresPerPixel) {
    if (!(metresPerPixel > 0)) return;
    const metres = roundUp((RULER_PX * metresPerPixel) / 2.5);
    this.length = { width: metres / metresPerPixel, text: `${number(metres * 1e3)} mm` };
    const [bar, text] = this.ruler.children;
    bar.style.width = `${this.length.width}px`;
    put(text, this.length.text);
  }
}

function number(x) {
  return String(Number(x.toPrecision(3)));
}
