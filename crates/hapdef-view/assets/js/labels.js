// Forces beside their arrows, never one over the other.

const GAP = 4;

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
    const taken = [];
    labels.forEach((label, i) => this.place(stage, this.items[i], label, taken));
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
    const right = x >= width / 2;
    const beside = Math.max(8, label.clear);
    const box = { x: clamp(right ? x + beside : x - w - beside, GAP, width - w - GAP), y: clamp(y - h / 2, 52, height - h - GAP), w, h };
    for (let tries = 0; tries < 8; tries += 1) {
      const other = taken.find((place) => overlap(place, box));
      if (!other) break;
      box.y = other.y + other.h + GAP;
    }
    taken.push(box);
    root.style.transform = `translate(${Math.round(box.x)}px, ${Math.round(box.y)}px)`;
  }
}

const clamp = (x, low, high) => Math.max(low, Math.min(x, high));

function overlap(a, b) {
  return a.x < b.x + b.w + GAP && b.x < a.x + a.w + GAP && a.y < b.y + b.h + GAP && b.y < a.y + a.h + GAP;
}
