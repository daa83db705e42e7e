// Forces beside their arrows, never one over the other or over a panel.

const GAP = 4;
const PANELS = "#tools > *, #legend, #ruler, #axes";
/** Down and up. */
const DIRECTIONS = [1, -1];

/** Text over the stage. */
export class Labels {
  constructor(root) {
    this.root = root;
    this.items = [];
  }

  /** Places `labels` [{point, text, small, colour, kind, clear}] on the stage, `clear` pixels or more beside
   * their points. */
  show(stage, labels) {
    while (this.items.length < labels.length) this.items.push(this.add());
    this.items.forEach((item, i) => { item.root.hidden = i >= labels.length; });
    const taken = this.panels();
    labels.forEach((label, i) => this.place(stage, this.items[i], label, taken));
  }

  /** What lies over the stage beside the labels. */
  panels() {
    const { left, top } = this.root.getBoundingClientRect();
    const boxes = Array.from(this.root.parentElement.querySelectorAll(PANELS), (panel) => panel.getBoundingClientRect());
    return boxes.filter((box) => box.width > 0).map((box) => ({ x: box.left - left, y: box.top - top, w: box.width, h: box.height }));
  }

  add() {
    const root = document.createElement("div");
    const text = document.createElement("span");
    const small = document.createElement("small");
    root.append(text, small);
    this.root.append(root);
    return { root, text, small };
  }

  place(stage, item, label, taken) {
    const { root } = item;
    root.className = `label ${label.kind}`;
    root.style.setProperty("--mark", label.colour);
    item.text.textContent = label.text;
    item.small.textContent = label.small;
    const { clientWidth: width, clientHeight: height } = this.root;
    const [w, h] = [root.offsetWidth, root.offsetHeight];
    const [x, y] = stage.project(label.point);
    const beside = Math.max(8, label.clear);
    const sides = [x + beside, x - w - beside];
    if (x < width / 2) sides.reverse();
    const start = clamp(y - h / 2, GAP, height - h - GAP);
    const free = sides.flatMap((side) => DIRECTIONS.map((down) => slide({ side, x: clamp(side, GAP, width - w - GAP), y: start, w, h }, down, taken)));
    const inside = free.filter((place) => place.y >= GAP && place.y <= height - h - GAP);
    const off = (place) => Math.abs(place.y - start) + Math.abs(place.x - place.side);
    const box = inside.reduce((best, place) => (off(place) < off(best) - 1 ? place : best), inside[0] ?? free[0]);
    taken.push(box);
    root.style.transform = `translate(${Math.round(box.x)}px, ${Math.round(box.y)}px)`;
  }
}

/** Moves a box down or up until it is over none of `taken`. */
function slide(box, down, taken) {
  for (let tries = 0; tries <= taken.length; tries += 1) {
    const other = taken.find((place) => overlap(place, box));
    if (!other) break;
    box.y = down > 0 ? other.y + other.h + GAP : other.y - box.h - GAP;
  }
  return box;
}

const clamp = (x, low, high) => Math.max(low, Math.min(x, high));

function overlap(a, b) {
  return a.x < b.x + b.w + GAP && b.x < a.x + a.w + GAP && a.y < b.y + b.h + GAP && b.y < a.y + a.h + GAP;
}
