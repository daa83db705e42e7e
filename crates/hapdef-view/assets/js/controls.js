// Buttons, sliders, keys.

import { put } from "./text.js";

/** Largest exaggeration; the slider is logarithmic from 1, its left end is none. */
const MOST = 1000;
const TURN = Math.PI / 24;
/** Keys that move a slider. */
const MOVES_SLIDER = /^(Arrow|Page|Home|End)/;
/** Keys that scroll a page that is longer than its window. */
const SCROLLS = /^(Arrow.*| )$/;

/** Wires the page's controls to `act`, an object of functions. */
export class Controls {
  constructor(byId, act) {
    this.byId = byId;
    this.act = act;
    const click = (id, action) => { byId(id).onclick = action; };
    click("tare", () => act.send({ cmd: "tare" }, "Tare"));
    click("record", () => act.send({ cmd: "record", on: byId("record").ariaPressed !== "true" }));
    click("snapshot", () => act.snapshot());
    click("pause", () => act.pause(byId("pause").ariaPressed !== "true"));
    click("turn", () => this.setPress(false));
    click("press", () => this.setPress(true));
    click("fit", () => act.fit());
    click("keep", () => this.setKeep(byId("keep").ariaPressed !== "true"));
    click("random", () => this.setRandom(byId("random").ariaPressed !== "true"));
    click("names", () => this.setNames(byId("names").ariaPressed !== "true"));
    click("help-open", () => this.help());
    byId("help").onclick = (event) => { if (event.target === byId("help")) byId("help").close(); };
    byId("force").oninput = () => this.setForce(Number(byId("force").value));
    byId("exaggerate").oninput = () => this.setExaggeration();
    byId("colours").onchange = () => act.colours(byId("colours").value);
    byId("time").oninput = () => act.seek(Number(byId("time").value));
    addEventListener("keydown", (event) => this.key(event));
    addEventListener("keyup", (event) => { if (event.key === "Enter") act.liftKey(); });
    addEventListener("blur", () => act.blur());
    this.setExaggeration();
  }

  /** Shows what the server offers. */
  offer(offers) {
    this.byId("tare").hidden = !offers.tare;
    this.byId("record").hidden = !offers.record;
    this.byId("press").hidden = !offers.press;
    this.byId("random").hidden = !offers.press;
    if (offers.press) {
      Object.assign(this.byId("force"), { min: offers.press.max_n / 50, max: offers.press.max_n, value: offers.press.default_n });
      this.setForce(offers.press.default_n);
    }
    this.setPress(Boolean(offers.press));
  }

  setPress(on) {
    const pressing = on && !this.byId("press").hidden;
    this.byId("press").ariaPressed = String(pressing);
    this.byId("turn").ariaPressed = String(!pressing);
    this.byId("force-row").hidden = !pressing;
    this.byId("keep").hidden = !pressing;
    this.byId("stage").classList.toggle("pressing", pressing);
    this.act.press(pressing);
  }

  /** Whether presses stay where they were let go. */
  setKeep(on) {
    this.byId("keep").ariaPressed = String(on);
    this.act.keep(on);
  }

  /** Whether the limb is pressed at random while nobody presses it. */
  setRandom(on) {
    this.byId("random").ariaPressed = String(on);
    this.act.send({ cmd: "random", on });
  }

  /** Whether every gauge has its name on the limb. */
  setNames(on) {
    this.byId("names").ariaPressed = String(on);
    this.act.names(on);
  }

  help() {
    const help = this.byId("help");
    if (help.open) help.close();
    else help.showModal();
  }

  setForce(force) {
    this.tell("force", `${force.toFixed(1)} N`);
    this.act.force(force);
  }

  setExaggeration() {
    const x = Number(this.byId("exaggerate").value);
    this.exaggeration = x === 0 ? 0 : Number((MOST ** x).toPrecision(2));
    this.showExaggeration(this.exaggeration);
    this.act.exaggerate(this.exaggeration);
  }

  /** What is drawn of the exaggeration that the slider stands at. */
  showExaggeration(drawn) {
    const all = drawn === this.exaggeration;
    this.tell("exaggerate", drawn === 0 ? "off" : all ? `×${drawn}` : `×${drawn} at most`);
  }

  setPaused(on) {
    if (this.byId("pause").ariaPressed !== String(on)) this.byId("pause").ariaPressed = String(on);
    put(this.byId("pause"), on ? "Resume" : "Pause");
  }

  /** The scrubber: `at` within `from`…`to`, s. */
  setTime(from, to, at, text) {
    const time = this.byId("time");
    if (Number(time.min) !== from) time.min = from;
    if (Number(time.max) !== to) time.max = to;
    if (document.activeElement !== time || !time.matches(":active")) time.value = at;
    this.tell("time", text);
  }

  /** What a slider stands at, to read and to hear. */
  tell(slider, text) {
    put(this.byId(`${slider}-out`), text);
    if (this.byId(slider).ariaValueText !== text) this.byId(slider).ariaValueText = text;
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (isOwn(event) || (this.byId("help").open && event.key !== "?")) return;
    const done = this.keys()[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!done || (event.repeat && !event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    done();
  }

  keys() {
    const { act, byId } = this;
    const tap = (id) => () => { if (!byId(id).hidden) byId(id).click(); };
    return {
      t: tap("tare"),
      r: tap("record"),
      s: tap("snapshot"),
      f: tap("fit"),
      h: tap("keep"),
      a: tap("random"),
      n: tap("names"),
      "?": () => this.help(),
      Escape: () => act.release(),
      " ": tap("pause"),
      p: () => this.setPress(byId("press").ariaPressed !== "true"),
      Enter: () => act.pressMiddle(),
      ArrowLeft: () => act.turn(-TURN, 0),
      ArrowRight: () => act.turn(TURN, 0),
      ArrowUp: () => act.turn(0, -TURN),
      ArrowDown: () => act.turn(0, TURN),
      "+": () => act.zoom(1.15),
      "-": () => act.zoom(1 / 1.15),
    };
  }
}

/** Whether what has the focus takes the key itself. */
function isOwn({ target, key }) {
  if (target.matches("select")) return true;
  if (target.matches("input")) return MOVES_SLIDER.test(key);
  if (target.matches("button") && (key === " " || key === "Enter")) return true;
  return SCROLLS.test(key) && !target.matches("#limb") && isLong(target);
}

/** Whether there is more of what has the focus, or of the page, than is seen. */
function isLong(target) {
  const parts = [target.closest("aside"), document.scrollingElement].filter(Boolean);
  return parts.some((part) => part.scrollHeight > part.clientHeight + 1);
}
