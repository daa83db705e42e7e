// Places that go with a surface as it is bent.

import { Vector3 } from "../vendor/three/three.module.min.js";
import { Nearest } from "./nearest.js";

/** What places of a surface at rest go with: the corners of the triangle that each is on. */
export class Follower {
  constructor(points, triangles) {
    this.points = points;
    this.triangles = triangles;
    this.nearest = new Nearest(points, points.length / 3);
    this.around = Array.from({ length: points.length / 3 }, () => []);
    triangles.forEach((node, i) => this.around[node].push(i - (i % 3)));
    this.known = new WeakMap();
  }

  /** The corners and their weights, looked for once for each array `place`. */
  corners(place) {
    if (!this.known.has(place)) this.known.set(place, this.find(place));
    return this.known.get(place);
  }

  find(place) {
    const node = this.nearest.to(place);
    const point = new Vector3().fromArray(place);
    let best = { nodes: [node], weights: [1], inside: -Infinity };
    for (const t of this.around[node]) {
      const nodes = this.triangles.subarray(t, t + 3);
      const weights = barycentric(point, ...Array.from(nodes, (i) => new Vector3().fromArray(this.points, 3 * i)));
      const inside = Math.min(...weights);
      if (inside > best.inside) best = { nodes, weights, inside };
    }
    return { nodes: best.nodes, weights: shares(best.weights) };
  }
}

/** Weights of a triangle's corners for a point. */
export function barycentric(point, a, b, c) {
  const area = (p, q, r) => new Vector3().crossVectors(q.clone().sub(p), r.clone().sub(p));
  const whole = area(a, b, c);
  const total = whole.lengthSq();
  if (total === 0) return [1, 0, 0];
  const u = area(point, b, c).dot(whole) / total;
  const v = area(point, c, a).dot(whole) / total;
  return [u, v, 1 - u - v];
}

/** Without what is below nothing, for a point beside its triangle. */
function shares(weights) {
  const kept = weights.map((weight) => Math.max(weight, 0));
  const sum = kept.reduce((a, b) => a + b);
  return kept.map((weight) => weight / sum);
}
