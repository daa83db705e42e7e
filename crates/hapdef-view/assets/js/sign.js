// What an arrow is where it is seen from its tail, as on paper: a cross in a ring.

import { CanvasTexture, Sprite, SpriteMaterial } from "../vendor/three/three.module.min.js";

/** Radius by the limb's. */
const RADIUS = 0.05;
/** Cosines between the arrow and the view from which on it is seen, and seen fully. */
const [FROM, FULLY] = [0.93, 0.97];
const PX = 128;

let cross = null;

/** A cross in a ring that faces the viewer; `size` is the limb's radius, m. */
export class Sign {
  constructor(size) {
    cross ??= draw();
    this.radius = RADIUS * size;
    this.sprite = new Sprite(new SpriteMaterial({ map: cross, transparent: true, depthTest: false }));
    this.sprite.scale.setScalar(2 * this.radius);
    this.sprite.renderOrder = 1;
    this.sprite.visible = false;
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
    const part = Math.min((this.outward.dot(towards) - FROM) / (FULLY - FROM), 1);
    this.sprite.visible = part > 0;
    this.sprite.material.opacity = part * this.opacity;
  }

  dispose() {
    this.sprite.material.dispose();
  }
}

/** White takes the arrow's colour, black stays. */
function draw() {
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
  Object.assign(pen, { strokeStyle: "#000", lineWidth: 0.12, lineCap: "round" });
  pen.beginPath();
  for (const side of [-1, 1]) {
    pen.moveTo(-0.26, -0.26 * side);
    pen.lineTo(0.26, 0.26 * side);
  }
  pen.stroke();
  return new CanvasTexture(canvas);
}
