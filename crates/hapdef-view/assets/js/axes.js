// Where x, y and z of the positions point.

const LENGTH = 24;
/** From an axis's end to its letter. */
const BEYOND = 9;
const SVG = "http://www.w3.org/2000/svg";

/** The three axes, on an SVG whose middle is the origin. */
export class Axes {
  constructor(root) {
    this.root = root;
    this.parts = ["x", "y", "z"].map((letter) => {
      const group = document.createElementNS(SVG, "g");
      const [line, text] = ["line", "text"].map((tag) => document.createElementNS(SVG, tag));
      text.textContent = letter;
      group.append(line, text);
      return { letter, group, line, text };
    });
    this.ends = [];
  }

  /** `seen` are the axes as [right, up, towards the viewer]; those that point away are under the others. */
  show(seen) {
    const rounded = seen.map((axis) => axis.map((c) => Number(c.toFixed(3))));
    if (String(rounded) === String(this.seen)) return;
    this.seen = rounded;
    const order = [0, 1, 2].sort((a, b) => rounded[a][2] - rounded[b][2]);
    this.ends = order.map((k) => ({ ...this.parts[k], ...place(rounded[k]) }));
    for (const { line, text, end, at } of this.ends) {
      set(line, { x2: end[0], y2: end[1] });
      set(text, { x: at[0], y: at[1] });
    }
    this.root.replaceChildren(...this.ends.map(({ group }) => group));
  }
}

/** An axis's end and the place of its letter, right and down. */
function place([x, y]) {
  const length = Math.hypot(x, y) || 1;
  const [end, at] = [LENGTH, LENGTH + BEYOND / length].map((by) => [by * x, -by * y]);
  return { end, at };
}

function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
}
