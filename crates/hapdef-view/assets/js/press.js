// Pressing the virtual limb: with several fingers, or one after the other where presses are kept.

const STEP_MS = 33;
/** Presses at a time, as many as the program takes. */
export const MOST_FINGERS = 5;
/** The finger of the keyboard among pointers. */
const KEY = "key";

/** Sends presses while the limb is held. */
export class Press {
  constructor(stage, limb, send) {
    this.stage = stage;
    this.limb = limb;
    this.send = send;
    this.on = false;
    this.keeps = false;
    /** What presses: pointer or key, or null for a press that is kept. */
    this.fingers = new Array(MOST_FINGERS).fill(undefined);
    /** Where each finger pressed last. */
    this.places = [];
    this.sentAt = 0;
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (event) => this.down(event), true);
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.end(event.pointerId));
  }

  /** Whether dragging on the limb presses it. */
  enable(on) {
    this.on = on;
    if (!on) this.release();
  }

  /** Whether presses stay where they were let go; those that stayed end with it. */
  keep(on) {
    this.keeps = on;
    if (!on) this.release();
  }

  down(event) {
    if (!this.on || event.button !== 0) return;
    if (!this.begin(event.pointerId, event.offsetX, event.offsetY)) return;
    this.stage.controls.enabled = false;
    this.stage.canvas.setPointerCapture(event.pointerId);
  }

  /** Whether there was a finger left and the limb below it. */
  begin(by, x, y) {
    const finger = this.fingers.indexOf(undefined);
    if (finger < 0 || !this.pressAt(finger, x, y)) return false;
    this.fingers[finger] = by;
    return true;
  }

  move(event) {
    const finger = this.fingers.indexOf(event.pointerId);
    if (finger < 0 || performance.now() - this.sentAt < STEP_MS) return;
    this.pressAt(finger, event.offsetX, event.offsetY);
  }

  /** A pointer or the key is let go. */
  end(by) {
    const finger = this.fingers.indexOf(by);
    if (finger < 0) return;
    this.fingers[finger] = this.keeps ? null : undefined;
    if (!this.fingers.some((held) => held !== undefined && held !== null)) this.stage.controls.enabled = true;
    if (this.keeps) return;
    const isLast = this.fingers.every((held) => held === undefined);
    this.send(isLast ? { cmd: "release" } : { cmd: "lift", finger });
  }

  /** Presses the middle of the view, for the keyboard. */
  pressMiddle() {
    const { clientWidth, clientHeight } = this.stage.canvas;
    if (this.on && !this.fingers.includes(KEY)) this.begin(KEY, clientWidth / 2, clientHeight / 2);
  }

  /** The keyboard lets go. */
  liftKey() {
    this.end(KEY);
  }

  /** Pointers and keys may be let go unseen: they are taken as let go. */
  lose() {
    for (const held of this.fingers) if (held !== undefined && held !== null) this.end(held);
  }

  /** Sends what is held again with another force; what is kept keeps its own. */
  again() {
    this.fingers.forEach((held, finger) => {
      if (held !== undefined && held !== null) this.press(finger, this.places[finger]);
    });
  }

  /** Lets everything go. */
  release() {
    if (this.fingers.every((held) => held === undefined)) return;
    this.fingers.fill(undefined);
    this.stage.controls.enabled = true;
    this.send({ cmd: "release" });
  }

  pressAt(finger, x, y) {
    const limb = this.limb();
    const hit = limb && this.stage.pick(x, y, limb.mesh);
    if (!hit) return false;
    this.press(finger, limb.restPoint(hit));
    return true;
  }

  press(finger, { point, normal }) {
    this.places[finger] = { point, normal };
    this.sentAt = performance.now();
    this.send({ cmd: "press", finger, point_m: point, normal, force_n: this.force });
  }
}
