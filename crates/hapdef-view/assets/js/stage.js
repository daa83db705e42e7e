// Camera, light, turning, drawing when something changed.

import {
  AmbientLight, Box3, DirectionalLight, OrthographicCamera, Raycaster, Scene, Sphere, Vector2, Vector3, WebGLRenderer,
} from "../vendor/three/three.module.min.js";
import { OrbitControls } from "../vendor/three/OrbitControls.js";

/** Height of the tools over the stage, CSS pixels. */
const TOOLS_PX = 58;

/** The 3-D stage. An orthographic camera: the ruler holds everywhere. */
export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0.01, 10);
    this.light = new DirectionalLight(0xffffff, 2.1);
    this.scene.add(new AmbientLight(0xffffff, 1.5), this.light, this.light.target);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.raycaster = new Raycaster();
    this.sphere = new Sphere(new Vector3(), 1);
    this.half = new Vector3(1, 1, 1);
    this.stale = true;
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Looks at a surface from the given direction. */
  frame(geometry, up, from) {
    geometry.computeBoundingSphere();
    this.sphere.copy(geometry.boundingSphere);
    const size = new Box3().setFromBufferAttribute(geometry.attributes.position).getSize(new Vector3());
    const longest = size.toArray().indexOf(Math.max(...size.toArray()));
    this.up = up ? new Vector3(...up).normalize() : new Vector3().setComponent(longest, 1);
    const side = new Vector3().setComponent((longest + 1) % 3, 1);
    this.from = from ? new Vector3(...from) : side.addScaledVector(new Vector3().setComponent((longest + 2) % 3, 1), 0.6);
    this.from.addScaledVector(this.up, 0.12 - this.from.dot(this.up)).normalize();
    this.points = geometry.attributes.position;
    this.fit();
  }

  /** Shows the whole limb from the first direction. */
  fit() {
    if (!this.up) return;
    const { center, radius } = this.sphere;
    this.camera.up.copy(this.up);
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(this.from, 4 * radius);
    this.camera.near = radius * 0.1;
    this.camera.far = radius * 8;
    this.controls.minZoom = 0.5;
    this.controls.maxZoom = 40;
    this.camera.zoom = 1;
    this.controls.update();
    this.measure();
    this.resize();
  }

  /** Extent of the limb across and along the screen. */
  measure() {
    this.camera.updateMatrixWorld(true);
    const point = new Vector3();
    this.extent = new Vector2();
    for (let i = 0; i < this.points.count; i += 1) {
      point.fromBufferAttribute(this.points, i).applyMatrix4(this.camera.matrixWorldInverse);
      this.extent.x = Math.max(this.extent.x, Math.abs(point.x));
      this.extent.y = Math.max(this.extent.y, Math.abs(point.y));
    }
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    if (this.extent) {
      const half = Math.max(this.extent.y * Math.max(1.12, 1 / (1 - (2 * TOOLS_PX) / height)), (this.extent.x * 1.7 * height) / width);
      this.camera.top = half;
      this.camera.bottom = -half;
      this.camera.right = (half * width) / height;
      this.camera.left = -this.camera.right;
    }
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }

  /** Metres of one CSS pixel. */
  get metresPerPixel() {
    return (this.camera.top - this.camera.bottom) / this.camera.zoom / this.canvas.clientHeight;
  }

  /** Towards the viewer. */
  get towards() {
    return new Vector3(0, 0, 1).applyQuaternion(this.camera.quaternion);
  }

  /** Where the screen's right points. */
  get right() {
    return new Vector3(1, 0, 0).applyQuaternion(this.camera.quaternion).toArray();
  }

  /** x, y and z as they are seen, each as [right, up, towards the viewer]. */
  get axes() {
    const seen = this.camera.quaternion.clone().invert();
    return [0, 1, 2].map((k) => new Vector3().setComponent(k, 1).applyQuaternion(seen).toArray());
  }

  /** Where a point is on the canvas, CSS pixels. */
  project(point) {
    const at = point.clone().project(this.camera);
    return [((at.x + 1) / 2) * this.canvas.clientWidth, ((1 - at.y) / 2) * this.canvas.clientHeight];
  }

  /** What of `object` is at a place of the canvas, CSS pixels. */
  pick(x, y, object) {
    const at = new Vector2((x / this.canvas.clientWidth) * 2 - 1, 1 - (y / this.canvas.clientHeight) * 2);
    this.raycaster.setFromCamera(at, this.camera);
    return this.raycaster.intersectObject(object)[0] ?? null;
  }

  /** Turns by angles about the screen's axes. */
  turn(right, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.up, right);
    const side = new Vector3().crossVectors(this.up, offset).normalize();
    const turned = offset.clone().applyAxisAngle(side, down);
    if (Math.abs(turned.clone().normalize().dot(this.up)) < 0.98) offset.copy(turned);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  zoom(factor) {
    const { minZoom, maxZoom } = this.controls;
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * factor, minZoom), maxZoom);
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }

  /** Draws if something changed. */
  draw() {
    if (!this.stale) return false;
    this.stale = false;
    const side = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const up = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    this.light.position.copy(this.camera.position).addScaledVector(side, -2 * this.sphere.radius).addScaledVector(up, 1.6 * this.sphere.radius);
    this.light.target.position.copy(this.controls.target);
    this.renderer.render(this.scene, this.camera);
    return true;
  }
}
