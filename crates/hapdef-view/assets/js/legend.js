// Scales: colours, exaggeration, length.

import { mapColour, roundUp } from "./colour.js";

const PER_UNIT = { "µm": 1e6, mm: 1e3 };
const RULER_PX = 110;

/** The scales over the stage. */
export class Legend {
  constructor(root, ruler) {
    this.root = root;
    this.bar = root.querySelector("#bar");
    this.ticks = root.querySelector("#ticks");
    this.ruler = ruler;
    this.shown = "";
    this.setMap("viridis");
  }

  setUnit(unit) {
    this.unit = unit;
    this.shown = "";
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
    const text = this.ends(range);
    if (text.join() === this.shown) return;
    this.shown = text.join();
    this.ticks.replaceChildren(...text.map((tick) => Object.assign(document.createElement("span"), { textContent: tick })));
  }

  ends(range) {
    const end = range * PER_UNIT[this.unit];
    return ["0", number(end / 2), `${number(end)} ${this.unit}`];
  }

  /** A bar of 1, 2 or 5 · 10ⁿ mm. */
  setRuler(metresPerPixel) {
    const metres = roundUp((RULER_PX * metresPerPixel) / 2.5);
    const [bar, text] = this.ruler.children;
    bar.style.width = `${metres / metresPerPixel}px`;
    text.textContent = `${number(metres * 1e3)} mm`;
  }
}

function number(x) {
  return String(Number(x.toPrecision(3)));
}
