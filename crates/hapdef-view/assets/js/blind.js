// What stands in for the stage where the browser gives no WebGL: the numbers go on without it.

import { Vector3 } from "../vendor/three/three.module.min.js";

/** A stage that draws nothing and finds nothing. */
export class Blind {
  constructor(canvas) {
    this.canvas = canvas;
    this.scene = { add() {}, remove() {} };
    this.sphere = { radius: 1 };
    this.controls = { enabled: true };
    this.stale = true;
    this.metresPerPixel = NaN;
    this.towards = new Vector3(0, 0, 1);
    this.axes = [];
    this.right = [1, 0, 0];
  }

  frame() {}

  fit() {}

  turn() {}

  zoom() {}

  pick() {
    return null;
  }

  project() {
    return [0, 0];
  }

  draw() {
    const wasStale = this.stale;
    this.stale = false;
    return wasStale;
  }
}
