// Contacts in three dimensions: arrows, ellipses, other explanations, ghosts.

import {
  BufferAttribute, BufferGeometry, CanvasTexture, CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, GreaterDepth, Group, Matrix4, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, Points, PointsMaterial, Quaternion, RingGeometry, Vector3,
} from "../vendor/three/three.module.min.js";
import { contactColour, roundUp } from "./colour.js";
import { Sign } from "./sign.js";

const GHOST_S = 3;
const MOST_GHOSTS = 512;
/** An ellipse holds the contact with 95 % probability: √χ²₀.₉₅(2). */
export const SDS = 2.4477;
const UP = new Vector3(0, 1, 0);

const shaft = new CylinderGeometry(1, 1, 1, 16).translate(0, 0.5, 0);
const head = new ConeGeometry(1, 1, 24).rotateX(Math.PI).translate(0, 0.5, 0);
const disc = new CircleGeometry(1, 48);
const ring = new RingGeometry(0.9, 1, 64);

/** Marks of contacts where they are drawn on `limb`; `size` is the limb's radius, m. */
export class Marks {
  constructor(limb, size) {
    this.limb = limb;
    this.size = size;
    this.group = new Group();
    this.arrows = [];
    this.ghosts = ghostPoints();
    this.group.add(this.ghosts);
    this.fullScale = 0;
  }

  /** Shows a frame's contacts and the ghosts of `recent` frames; returns labels. */
  show(frame, recent) {
    const marks = [...frame.contacts.map((mark) => ({ mark, other: false })), ...frame.others.map((mark) => ({ mark, other: true }))];
    this.fullScale = Math.max(this.fullScale, roundUp(Math.max(0.1, ...marks.map(({ mark }) => mark.newtons))));
    while (this.arrows.length < marks.length) this.add();
    this.arrows.forEach((arrow, i) => { arrow.group.visible = i < marks.length; });
    this.trail(frame.t, recent);
    return marks.map(({ mark, other }, i) => this.place(this.arrows[i], mark, other));
  }

  add() {
    const arrow = new Arrow(this.size);
    this.arrows.push(arrow);
    this.group.add(arrow.group);
  }

  place(arrow, mark, other) {
    const length = this.size * (0.1 + (0.5 * mark.newtons) / this.fullScale);
    const tip = this.limb.drawnPlace(mark.position);
    const tail = arrow.place(mark, tip, length, other);
    return { mark, other, tip, tail, sign: arrow.sign, colour: contactColour(mark.id) };
  }

  /** Signs the arrows whose tails point to a viewer who is `towards`. */
  face(towards) {
    for (const arrow of this.arrows) arrow.sign.face(towards);
  }

  /** Where contacts were in the last seconds, the newest first: those are never the ones left out. */
  trail(now, recent) {
    const { position, color } = this.ghosts.geometry.attributes;
    let n = 0;
    let next = Infinity;
    for (const { t, frame } of recent.toReversed()) {
      if (t <= now - GHOST_S || n === MOST_GHOSTS) break;
      if (t >= now || next - t < GHOST_S / 60) continue;
      next = t;
      for (const { id, position: p } of frame.contacts) {
        if (n === MOST_GHOSTS) break;
        this.limb.drawnPlace(p).toArray(position.array, 3 * n);
        const [r, g, b] = rgb(contactColour(id));
        color.array.set([r, g, b, 0.6 * (1 - (now - t) / GHOST_S)], 4 * n);
        n += 1;
      }
    }
    this.nGhosts = n;
    this.ghosts.geometry.setDrawRange(0, n);
    position.needsUpdate = true;
    color.needsUpdate = true;
  }

  dispose() {
    this.ghosts.geometry.dispose();
    this.ghosts.material.map.dispose();
    this.ghosts.material.dispose();
    for (const arrow of this.arrows) arrow.dispose();
  }
}

/** An arrow with its ellipse; where the limb hides it, a faint one. */
class Arrow {
  constructor(size) {
    this.size = size;
    this.solid = new MeshLambertMaterial();
    this.faint = new MeshBasicMaterial({ transparent: true, opacity: 0.22, depthFunc: GreaterDepth, depthWrite: false });
    this.area = new MeshBasicMaterial({ transparent: true, opacity: 0.35, side: DoubleSide, depthWrite: false });
    this.edge = new MeshBasicMaterial({ side: DoubleSide, transparent: true, depthWrite: false });
    this.body = new Group();
    this.shafts = [shaft, shaft].map((part, i) => new Mesh(part, i ? this.faint : this.solid));
    this.heads = [head, head].map((part, i) => new Mesh(part, i ? this.faint : this.solid));
    this.body.add(...this.shafts, ...this.heads);
    this.ellipse = new Group();
    this.ellipse.add(new Mesh(disc, this.area), new Mesh(ring, this.edge));
    this.ellipse.matrixAutoUpdate = false;
    this.group = new Group();
    this.sign = new Sign(size);
    this.group.add(this.body, this.ellipse, this.sign.sprite);
  }

  /** Points along the force, its tip where the contact is drawn; returns the tail. */
  place(mark, tip, length, other) {
    const outward = new Vector3(...mark.force).multiplyScalar(-1 / (mark.newtons || 1));
    if (!mark.newtons) outward.set(...mark.normal);
    this.colour(mark.id, other);
    this.sign.place(tip, outward, contactColour(mark.id), other ? 0.5 : 1);
    const width = this.size * (other ? 0.009 : 0.012);
    const headLength = Math.min(0.5 * length, 5 * width);
    this.body.position.copy(tip);
    this.body.quaternion.copy(new Quaternion().setFromUnitVectors(UP, outward));
    for (const part of this.shafts) {
      part.position.y = headLength;
      part.scale.set(width, length - headLength, width);
    }
    for (const part of this.heads) part.scale.set(2.3 * width, headLength, 2.3 * width);
    this.placeEllipse(mark, tip);
    return tip.clone().addScaledVector(outward, length);
  }

  placeEllipse(mark, tip) {
    this.ellipse.visible = mark.axes !== null;
    if (!mark.axes) return;
    const normal = new Vector3(...mark.normal);
    const [a, b] = mark.axes.map((axis) => new Vector3(...axis).multiplyScalar(SDS));
    const origin = tip.clone().addScaledVector(normal, 0.006 * this.size);
    this.ellipse.matrix.copy(new Matrix4().makeBasis(a, b, normal).setPosition(origin));
    this.ellipse.matrixWorldNeedsUpdate = true;
  }

  colour(id, other) {
    for (const material of [this.solid, this.faint, this.area]) material.color.set(contactColour(id));
    this.solid.emissive.set(contactColour(id)).multiplyScalar(0.35);
    this.solid.transparent = other;
    this.solid.opacity = other ? 0.5 : 1;
    this.area.opacity = other ? 0.15 : 0.35;
    this.edge.opacity = other ? 0.4 : 1;
  }

  dispose() {
    for (const part of [this.solid, this.faint, this.area, this.edge, this.sign]) part.dispose();
  }
}

function ghostPoints() {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * MOST_GHOSTS), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(4 * MOST_GHOSTS), 4));
  geometry.setDrawRange(0, 0);
  const material = new PointsMaterial({
    size: 9, sizeAttenuation: false, vertexColors: true, transparent: true, depthWrite: false, map: dot(),
  });
  const points = new Points(geometry, material);
  points.frustumCulled = false;
  return points;
}

/** A round dot. */
function dot() {
  const canvas = document.createElement("canvas");
  canvas.width = 32;
  canvas.height = 32;
  const pen = canvas.getContext("2d");
  pen.fillStyle = "#fff";
  pen.arc(16, 16, 14, 0, 2 * Math.PI);
  pen.fill();
  return new CanvasTexture(canvas);
}

function rgb(hex) {
  return [1, 3, 5].map((at) => (parseInt(hex.slice(at, at + 2), 16) / 255) ** 2.2);
}
