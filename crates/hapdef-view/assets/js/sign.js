// What an arrow is where it is seen along itself, as on paper: a cross in a ring from its tail, a dot in
// a ring from its tip.

import { CanvasTexture, Sprite, SpriteMaterial } from "../vendor/three/three.module.min.js";

/** Radius by the limb's. */
const RADIUS = 0.05;
/** Cosines between the arrow and the view from which on it is seen, and seen fully. */
const [FROM, FULLY] = [0.93, 0.97];
/** Opacity of a tip's sign: the limb is before it. */
const BEHIND = 0.6;
const PX = 128;

let signs = null;

/** A sign that faces the viewer; `size` is the limb's radius, m. */
export class Sign {
  constructor(size) {
    signs ??= { tail: draw(cross), tip: draw(dot) };
    this.radius = RADIUS * size;
    this.sprite = new Sprite(new SpriteMaterial({ map: signs.tail, transparent: true, depthTest: false }));
    this.sprite.scale.setScalar(2 * this.radius);
    this.sprite.renderOrder = 1;
    this.sprite.visible = false;
    this.ofTip = false;
  }

  /** At `tip` of an arrow whose tail is `outward` of it. */
  place(tip, outward, colour, opacity) {
    this.sprite.position.copy(tip);
    this.sprite.material.color.set(colour);
    this.outward = outward;
    this.opacity = opacity;
  }

  /** As it is seen by a viewer who is `towards`. */
  face(towards) {
    const along = this.outward.dot(towards);
    const part = Math.min((Math.abs(along) - FROM) / (FULLY - FROM), 1);
    this.ofTip = along < 0;
    this.sprite.visible = part > 0;
    this.sprite.material.map = this.ofTip ? signs.tip : signs.tail;
    this.sprite.material.opacity = part * this.opacity * (this.ofTip ? BEHIND : 1);
  }

  dispose() {
    this.sprite.material.dispose();
  }
}

/** A ring with what `fill` draws within. White takes the arrow's colour, black stays. */
function draw(fill) {
  const canvas = Object.assign(document.createElement("canvas"), { width: PX, height: PX });
  const pen = canvas.getContext("2d");
  pen.scale(PX / 2, PX / 2);
  pen.translate(1, 1);
  for (const [colour, width] of [["#000", 0.24], ["#fff", 0.14]]) {
    Object.assign(pen, { strokeStyle: colour, lineWidth: width });
    pen.beginPath();
    pen.arc(0, 0, 0.86, 0, 2 * Math.PI);
    pen.stroke();
  }
  fill(pen);
  return new CanvasTexture(canvas);
}

function cross(pen) {
  Object.assign(pen, { strokeStyle: "#000", lineWidth: 0.12, lineCap: "round" });
  pen.beginPath();
  for (const side of [-1, 1]) {
    pen.moveTo(-0.26, -0.26 * side);
    pen.lineTo(0.26, 0.26 * side);
  }
  pen.stroke();
}

function dot(pen) {
  pen.fillStyle = "#000";
  pen.beginPath();
  pen.arc(0, 0, 0.2, 0, 2 * Math.PI);
  pen.fill();
}
