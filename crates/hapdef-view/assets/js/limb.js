// The limb's surface, coloured by displacement and bent by it.

import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Mesh, MeshStandardMaterial, Vector3,
} from "../vendor/three/three.module.min.js";
import { mapTable, roundUp } from "./colour.js";
import { barycentric, Follower } from "./follow.js";
import { Nearest } from "./nearest.js";

const GREY = 0.42;
const SHRINK_PER_S = 0.35;
/** Farthest that a node is drawn from where it is, by the limb's radius: the limb stays in its window. */
const MOST_BENT = 0.3;
/** Time that an exaggeration takes to be drawn up to 1/e, ms. */
const EASE_MS = 120;

/** The limb's surface. */
export class Limb {
  constructor(surface) {
    this.rest = surface.positions;
    this.restNormals = surface.normals;
    this.geometry = new BufferGeometry();
    const attribute = (values) => new BufferAttribute(values, 3).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute("position", attribute(surface.positions.slice()));
    this.geometry.setAttribute("normal", attribute(surface.normals.slice()));
    this.geometry.setAttribute("color", attribute(new Float32Array(surface.positions.length).fill(GREY)));
    this.geometry.setIndex(new BufferAttribute(surface.triangles, 1));
    this.mesh = new Mesh(this.geometry, new MeshStandardMaterial({ vertexColors: true, side: DoubleSide, roughness: 0.6, metalness: 0 }));
    this.mesh.frustumCulled = false;
    this.geometry.computeBoundingSphere();
    this.restRadius = this.geometry.boundingSphere.radius;
    this.setMap("viridis");
    this.range = 0;
    this.peak = 0;
    this.exaggeration = 0;
    this.eased = 0;
  }

  setMap(name) {
    this.table = mapTable(name);
  }

  /** As much exaggeration as there is room for, or less if less was asked for. */
  room(asked) {
    return Math.min(asked, Math.max(1, (MOST_BENT * this.restRadius) / this.peak));
  }

  /** The exaggeration that will be drawn, to two digits. */
  get drawnExaggeration() {
    return Number(this.room(this.exaggeration).toPrecision(2));
  }

  /** Comes nearer to what was asked for within `ms`; whether there is more to come. */
  ease(ms) {
    const left = this.exaggeration - this.eased;
    if (left === 0) return false;
    const isNear = Math.abs(left) < 0.01 * Math.max(1, this.exaggeration);
    this.eased = isNear ? this.exaggeration : this.exaggeration - left * Math.exp(-ms / EASE_MS);
    return true;
  }

  /** Colours and bends the surface; `dt` s since the last frame, for the scale to follow slowly. */
  show(frame, dt) {
    const { components, displacement } = frame;
    if (!components) {
      this.plain();
      return;
    }
    const peak = largest(displacement, components);
    this.follow(peak, dt);
    this.paint(displacement, components);
    this.bend(displacement, components, peak);
  }

  /** Without a displacement: one grey. */
  plain() {
    const { color, position, normal } = this.geometry.attributes;
    color.array.fill(GREY);
    position.array.set(this.rest);
    normal.array.set(this.restNormals);
    for (const attribute of [color, position, normal]) attribute.needsUpdate = true;
    this.geometry.boundingSphere.radius = this.restRadius;
    this.bent = false;
  }

  /** The scale's end: grows at once, shrinks slowly, in steps of 1, 2, 5. */
  follow(peak, dt) {
    this.peak = Math.max(peak, this.peak * (1 - SHRINK_PER_S * Math.min(Math.max(dt, 0), 1)), 1e-7);
    const range = roundUp(this.peak);
    if (range > this.range || range < 0.3 * this.range) this.range = range;
  }

  paint(displacement, components) {
    const { color } = this.geometry.attributes;
    const scale = 255 / this.range;
    color.array.fill(GREY, displacement.length * 3 / components);
    for (let i = 0; i < displacement.length / components; i += 1) {
      const length = components === 1 ? Math.abs(displacement[i]) : norm(displacement, 3 * i);
      const step = 3 * Math.min(255, Math.round(length * scale));
      color.array[3 * i] = this.table[step];
      color.array[3 * i + 1] = this.table[step + 1];
      color.array[3 * i + 2] = this.table[step + 2];
    }
    color.needsUpdate = true;
  }

  /** No node moves farther than `peak`, m; those beyond the skin move with the nearest one of it. */
  bend(displacement, components, peak) {
    const { position, normal } = this.geometry.attributes;
    const by = this.room(this.eased);
    if (by === 0 && !this.bent) return;
    const onSkin = displacement.length / components;
    if (this.leaders?.onSkin !== onSkin) this.leaders = { onSkin, of: this.leadersOf(onSkin) };
    for (let i = 0; i < this.rest.length / 3; i += 1) {
      const leader = i < onSkin ? i : this.leaders.of[i - onSkin];
      for (let k = 0; k < 3; k += 1) {
        const moved = components === 3 ? displacement[3 * leader + k] : -displacement[leader] * this.restNormals[3 * leader + k];
        position.array[3 * i + k] = this.rest[3 * i + k] + by * moved;
      }
    }
    position.needsUpdate = true;
    this.geometry.boundingSphere.radius = this.restRadius + by * peak;
    if (by === 0) normal.array.set(this.restNormals);
    else vertexNormals(position.array, this.geometry.index.array, normal.array);
    normal.needsUpdate = true;
    this.bent = by !== 0;
  }

  /** Of each node beyond the first `onSkin` the nearest one among these. */
  leadersOf(onSkin) {
    const nearest = new Nearest(this.rest, onSkin);
    return Uint32Array.from({ length: this.rest.length / 3 - onSkin }, (_, i) => nearest.to(this.rest.subarray(3 * (onSkin + i))));
  }

  /** Where a place on the limb at rest is drawn: it goes with the skin that is nearest to it. */
  drawnPlace(place) {
    const at = new Vector3().fromArray(place);
    if (!this.bent) return at;
    this.follower ??= new Follower(this.rest, this.geometry.index.array);
    const { nodes, weights } = this.follower.corners(place);
    nodes.forEach((node, k) => at.addScaledVector(this.drawnNode(node).sub(this.node(node)), weights[k]));
    return at;
  }

  /** Point and normal of the limb at rest where a ray met the limb as drawn. */
  restPoint(hit) {
    const { a, b, c } = hit.face;
    const { position } = this.geometry.attributes;
    const corner = (i) => new Vector3().fromBufferAttribute(position, i);
    const weights = barycentric(hit.point, corner(a), corner(b), corner(c));
    const mix = (values) => [0, 1, 2].map((k) => [a, b, c].reduce((sum, i, n) => sum + weights[n] * values[3 * i + k], 0));
    const normal = new Vector3(...mix(this.restNormals)).normalize();
    return { point: mix(this.rest), normal: normal.toArray() };
  }

  /** A node at rest. */
  node(i) {
    return new Vector3().fromArray(this.rest, 3 * i);
  }

  /** The same as it is drawn. */
  drawnNode(i) {
    return new Vector3().fromBufferAttribute(this.geometry.attributes.position, i);
  }

  dispose() {
    this.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** Unit normals of the vertices, those of the faces weighted by area. */
function vertexNormals(positions, triangles, normals) {
  normals.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    normals[a] += x; normals[a + 1] += y; normals[a + 2] += z;
    normals[b] += x; normals[b + 1] += y; normals[b + 2] += z;
    normals[c] += x; normals[c + 1] += y; normals[c + 2] += z;
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = norm(normals, i) || 1;
    normals[i] /= length; normals[i + 1] /= length; normals[i + 2] /= length;
  }
}

function norm(values, i) {
  const x = values[i], y = values[i + 1], z = values[i + 2];
  return Math.sqrt(x * x + y * y + z * z);
}

function largest(displacement, components) {
  let most = 0;
  for (let i = 0; i < displacement.length; i += components) {
    const length = components === 1 ? Math.abs(displacement[i]) : norm(displacement, i);
    if (length > most) most = length;
  }
  return most;
}
