// Gauges on the limb.

import {
  BoxGeometry, Color, GreaterDepth, Group, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, Vector3,
} from "../vendor/three/three.module.min.js";

const COLOURS = ["#f3f6fa", "#ffb454", "#ff7b72", "#8a94a3"];
const SEEN = "#5cc8ff";

/** Gauges on the limb, faint where the limb hides them. */
export class Sites {
  constructor(gauges, size) {
    this.gauges = gauges;
    this.group = new Group();
    const box = new BoxGeometry(0.075 * size, 0.028 * size, 0.014 * size);
    const front = new MeshBasicMaterial();
    const behind = new MeshBasicMaterial({ transparent: true, opacity: 0.4, depthFunc: GreaterDepth, depthWrite: false });
    this.layers = [front, behind].map((material) => new InstancedMesh(box, material, gauges.length));
    this.layers.forEach((layer) => { layer.frustumCulled = false; });
    gauges.forEach((gauge, i) => this.place(i, new Vector3(...gauge.position_m)));
    this.group.add(...this.layers);
    this.shown = "";
    this.moved = false;
  }

  place(i, at) {
    const axis = new Vector3(...this.gauges[i].axis);
    const along = axis.lengthSq() > 0 ? axis.normalize() : new Vector3(1, 0, 0);
    const turned = new Quaternion().setFromUnitVectors(new Vector3(1, 0, 0), along);
    const matrix = new Matrix4().compose(at, turned, new Vector3(1, 1, 1));
    for (const layer of this.layers) layer.setMatrixAt(i, matrix);
  }

  /** Goes with `limb` as it is drawn. */
  follow(limb) {
    if (!limb.bent && !this.moved) return;
    this.moved = limb.bent;
    this.gauges.forEach((gauge, i) => this.place(i, limb.drawnPlace(gauge.position_m)));
    for (const layer of this.layers) layer.instanceMatrix.needsUpdate = true;
  }

  /** Colours by state; the gauge that is looked at stands out. */
  show(states, seen) {
    const key = `${states.join()}/${seen}`;
    if (key === this.shown) return;
    this.shown = key;
    states.forEach((state, i) => {
      const colour = new Color(i === seen ? SEEN : COLOURS[state]);
      for (const layer of this.layers) layer.setColorAt(i, colour);
    });
    for (const layer of this.layers) if (layer.instanceColor) layer.instanceColor.needsUpdate = true;
  }

  /** The colour of each gauge as it is drawn. */
  colours() {
    const colour = new Color();
    return this.gauges.map((_, i) => {
      this.layers[0].getColorAt(i, colour);
      return `#${colour.getHexString()}`;
    });
  }

  /** The gauge within `reach` pixels of a place on the stage, that nearest to it; -1: none. */
  near(stage, x, y, reach) {
    const off = this.gauges.map((_, i) => {
      const [px, py] = stage.project(this.at(i));
      return Math.hypot(px - x, py - y);
    });
    const least = Math.min(...off);
    return least <= reach ? off.indexOf(least) : -1;
  }

  /** Where a gauge is drawn. */
  at(i) {
    const matrix = new Matrix4();
    this.layers[0].getMatrixAt(i, matrix);
    return new Vector3().setFromMatrixPosition(matrix);
  }

  dispose() {
    for (const layer of this.layers) {
      layer.geometry.dispose();
      layer.material.dispose();
      layer.dispose();
    }
  }
}
