// Pressing the virtual limb with a pointer or the keyboard.

const STEP_MS = 33;

/** Sends presses while the limb is held. */
export class Press {
  constructor(stage, limb, send) {
    this.stage = stage;
    this.limb = limb;
    this.send = send;
    this.on = false;
    this.held = null;
    this.sentAt = 0;
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (event) => this.down(event), true);
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => this.up(event));
  }

  /** Whether dragging on the limb presses it. */
  enable(on) {
    this.on = on;
    if (!on) this.release();
  }

  down(event) {
    if (!this.on || !event.isPrimary || event.button !== 0) return;
    if (!this.pressAt(event.offsetX, event.offsetY)) return;
    this.held = event.pointerId;
    this.stage.controls.enabled = false;
    this.stage.canvas.setPointerCapture(event.pointerId);
  }

  move(event) {
    if (event.pointerId !== this.held || performance.now() - this.sentAt < STEP_MS) return;
    this.pressAt(event.offsetX, event.offsetY);
  }

  up(event) {
    if (event.pointerId === this.held) this.release();
  }

  /** Presses the middle of the view, for the keyboard. */
  pressMiddle() {
    const { clientWidth, clientHeight } = this.stage.canvas;
    if (this.on && this.held === null && this.pressAt(clientWidth / 2, clientHeight / 2)) this.held = "key";
  }

  /** Sends the press again with another force. */
  again() {
    if (this.held !== null && this.last) this.press(this.last);
  }

  release() {
    if (this.held === null) return;
    this.held = null;
    this.stage.controls.enabled = true;
    this.send({ cmd: "release" });
  }

  pressAt(x, y) {
    const limb = this.limb();
    const hit = limb && this.stage.pick(x, y, limb.mesh);
    if (!hit) return false;
    this.press(limb.restPoint(hit));
    return true;
  }

  press({ point, normal }) {
    this.last = { point, normal };
    this.sentAt = performance.now();
    this.send({ cmd: "press", point_m: point, normal, force_n: this.force });
  }
}
