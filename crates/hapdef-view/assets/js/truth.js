// Where a simulated limb is truly pressed, and how far off the contacts are.

import { Group, DoubleSide, GreaterDepth, Mesh, MeshBasicMaterial, RingGeometry, Vector3 } from "../vendor/three/three.module.min.js";

/** A contact farther than this, m, from a true place is not one that found it. */
const FOUND_M = 0.02;
const FORWARD = new Vector3(0, 0, 1);
const COLOUR = "#f3f6fa";

const ring = new RingGeometry(0.8, 1, 40);

/** Of each contact the true one that it found and the distance, m; null: none. Each is found once, the nearest first. */
export function matches(contacts, truths) {
  const pairs = contacts.flatMap((contact, i) => truths.map((truth, k) => ({ i, k, truth, off: distance(contact.position, truth.position) })));
  const found = contacts.map(() => null);
  const taken = new Set();
  for (const { i, k, truth, off } of pairs.sort((a, b) => a.off - b.off)) {
    if (off > FOUND_M) break;
    if (found[i] || taken.has(k)) continue;
    taken.add(k);
    found[i] = { truth, off };
  }
  return found;
}

/** A distance as people say it. */
export const millimetres = (metres) => `${(1e3 * metres).toFixed(metres < 9.95e-3 ? 1 : 0)} mm`;

/** A ring on the skin at each true contact, fainter where the limb hides it. */
export class TruthRings {
  constructor(limb, size) {
    this.limb = limb;
    this.size = size;
    this.group = new Group();
    this.materials = [
      new MeshBasicMaterial({ color: COLOUR, side: DoubleSide, transparent: true, opacity: 0.95, depthWrite: false }),
      new MeshBasicMaterial({ color: COLOUR, side: DoubleSide, transparent: true, opacity: 0.35, depthFunc: GreaterDepth, depthWrite: false }),
    ];
  }

  show(truths) {
    while (this.group.children.length < truths.length) this.group.add(this.add());
    this.group.children.forEach((pair, i) => {
      pair.visible = i < truths.length;
      if (pair.visible) this.place(pair, truths[i]);
    });
  }

  add() {
    const pair = new Group();
    pair.add(...this.materials.map((material) => new Mesh(ring, material)));
    return pair;
  }

  place(pair, { position, normal }) {
    const outward = new Vector3(...normal);
    pair.position.copy(this.limb.drawnPlace(position)).addScaledVector(outward, 0.008 * this.size);
    pair.quaternion.setFromUnitVectors(FORWARD, outward);
    pair.scale.setScalar(0.045 * this.size);
  }

  dispose() {
    for (const material of this.materials) material.dispose();
  }
}

function distance(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
