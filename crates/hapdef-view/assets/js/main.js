// The page: the newest frame from the link, on the stage and in the panel.

import { Axes } from "./axes.js";
import { Blind } from "./blind.js";
import { Controls } from "./controls.js";
import { History, KEPT_S } from "./history.js";
import { Labels } from "./labels.js";
import { Legend } from "./legend.js";
import { Limb } from "./limb.js";
import { Link } from "./link.js";
import { Marks } from "./marks.js";
import { newtons, Panel, SPAN_S } from "./panel.js";
import { compose } from "./picture.js";
import { Press } from "./press.js";
import { Sites } from "./sites.js";
import { Stage } from "./stage.js";
import { put } from "./text.js";
import { matches, millimetres, TruthRings } from "./truth.js";

const STATES = { live: "live", away: "reconnecting", silent: "no answer", locked: "needs its token", failed: "does not run" };
const SAY_MS = 4000;
/** How near to a gauge a pointer looks at it, CSS pixels. */
const NEAR_PX = 14;

const byId = (id) => document.getElementById(id);
const stage = makeStage(byId("limb"));
const labels = new Labels(byId("labels"));
const legend = new Legend(byId("legend"), byId("ruler"));
const axes = new Axes(byId("axes"));
const panel = new Panel(byId);
const history = new History();
const view = { limb: null, marks: null, sites: null, rings: null, found: [], names: false, tickedAt: 0, exaggeration: 0, map: "viridis", held: null, fresh: false, shown: null, offers: {}, drawn: 0, drawnSeq: null, workMs: 0, fault: null, cameAt: null };
const press = new Press(stage, () => view.limb, send);
panel.onlook = () => { view.fresh = true; };

const controls = new Controls(byId, {
  send,
  snapshot,
  pause,
  seek,
  fit: () => stage.fit(),
  press: (on) => press.enable(on),
  pressMiddle: () => press.pressMiddle(),
  liftKey: () => press.liftKey(),
  release: () => press.release(),
  blur: () => press.lose(),
  keep: (on) => press.keep(on),
  names(on) {
    view.names = on;
    view.fresh = true;
  },
  turn: (right, down) => stage.turn(right, down),
  zoom: (factor) => stage.zoom(factor),
  force(force) {
    press.force = force;
    press.again();
  },
  exaggerate(times) {
    view.exaggeration = times;
    if (view.limb) view.limb.exaggeration = times;
    view.fresh = true;
  },
  colours(name) {
    view.map = name;
    legend.setMap(name);
    view.limb?.setMap(name);
    view.fresh = true;
  },
});

stage.canvas.addEventListener("pointermove", ({ offsetX, offsetY, buttons }) => {
  if (!view.sites || buttons) return;
  const near = view.sites.near(stage, offsetX, offsetY, NEAR_PX);
  panel.look(near < 0 ? panel.chosen : near);
});
stage.canvas.addEventListener("pointerleave", () => panel.look(panel.chosen));

const stills = matchMedia("(prefers-reduced-motion: reduce)");
const link = new Link({ hello, device, frame, text, state });
requestAnimationFrame(tick);

/** The stage, or what stands in for it where there is no WebGL. */
function makeStage(canvas) {
  try {
    return new Stage(canvas);
  } catch {
    byId("stage").classList.add("blind");
    return new Blind(canvas);
  }
}

function hello(message, surface) {
  document.title = `${message.title} · hapdef`;
  byId("title").textContent = message.title;
  const isOther = !view.limb || !isSame(view.limb.rest, surface.positions);
  for (const part of [view.limb?.mesh, view.marks?.group, view.sites?.group, view.rings?.group]) if (part) stage.scene.remove(part);
  for (const part of [view.limb, view.marks, view.sites, view.rings]) part?.dispose();
  view.limb = Object.assign(new Limb(surface), { exaggeration: view.exaggeration, eased: view.exaggeration });
  view.limb.setMap(view.map);
  if (isOther && message.offers.press) say("Drag on the limb to press it");
  if (isOther) stage.frame(view.limb.geometry, message.up, message.view_from);
  view.marks = new Marks(view.limb, stage.sphere.radius);
  view.sites = new Sites(message.gauges, stage.sphere.radius);
  view.rings = new TruthRings(view.limb, stage.sphere.radius);
  stage.scene.add(view.limb.mesh, view.marks.group, view.sites.group, view.rings.group);
  stage.stale = true;
  history.clear();
  Object.assign(view, { shown: null, marked: null, found: [], drawnSeq: null });
  hold(null);
  panel.setGauges(message.gauges);
  panel.wait();
  view.offers = message.offers;
  controls.offer(message.offers);
  if (!message.offers.commands) byId("link").textContent = "view only";
}

/** Where readings come from: whether they are simulated, why none come. */
function device({ simulated, fault }) {
  byId("simulated").hidden = !simulated;
  put(byId("device"), fault ? "device away" : "");
  byId("device").title = fault ?? "";
  view.fault = fault;
  tellFault();
  if (!history.last) panel.wait();
  view.fresh = true;
  age();
}

/** Why nothing new is known, beside the contacts: the program is gone, or the device. */
function tellFault() {
  const { state } = byId("link").dataset;
  const gone = state !== "live" && `No connection, ${lastFrame()}`;
  panel.setFault(gone || (view.fault && `Device away: ${view.fault}`));
}

/** When the last frame came, by the clock on the wall. */
const lastFrame = () => (view.cameAt ? `last frame at ${view.cameAt.toTimeString().slice(0, 8)}` : "no frame yet");

/** Dims a limb that nothing new is known of. */
function age() {
  byId("stage").classList.toggle("old", view.fault !== null || byId("link").dataset.state !== "live");
}

function frame(buffer) {
  view.cameAt = new Date();
  const before = history.last;
  const now = history.add(buffer);
  announce(before, now);
  byId("record").ariaPressed = String(now.health.recording === "on");
  panel.showHealth(now.health, now.p, now.replay, performance.now());
  if (now.replay) controls.setPaused(now.replay.paused);
  if (!view.held || now.replay) view.fresh = true;
  link.send({ cmd: "got", drawn: view.drawnSeq });
}

function text({ type, text: words }) {
  say(type === "refused" ? `Refused: ${words}` : words);
}

function state(name) {
  if (byId("link").dataset.state === name) return;
  const isLive = name === "live";
  byId("link").dataset.state = name;
  byId("link").textContent = isLive || !view.cameAt ? STATES[name] : `${STATES[name]} · ${lastFrame()}`;
  document.body.classList.toggle("gone", !isLive);
  for (const control of document.querySelectorAll("button, input, select")) control.disabled = !isLive;
  tellFault();
  if (!isLive) panel.wait();
  view.fresh = isLive;
  age();
}

/** Draws what is new, at most once for each picture of the screen. */
function tick(now) {
  requestAnimationFrame(tick);
  const began = performance.now();
  const passed = now - view.tickedAt;
  view.tickedAt = now;
  if (view.limb?.ease(stills.matches ? Infinity : passed)) view.fresh = true;
  if (view.fresh && view.limb) {
    const chosen = view.held?.frame ?? history.last;
    if (chosen) show(chosen, now);
    view.fresh = false;
  }
  if (stage.stale) view.marks?.face(stage.towards);
  if (stage.draw() && view.limb) {
    dress();
    view.workMs += performance.now() - began;
  }
}

/** What goes with a picture that was just drawn. */
function dress() {
  legend.setRuler(stage.metresPerPixel);
  axes.show(stage.axes);
  if (!view.shown) return;
  placeLabels();
  view.drawn += 1;
  view.drawnSeq = view.shown.seq;
}

function show(chosen, now) {
  const recent = view.held?.recent ?? history.span(chosen.t, SPAN_S);
  view.limb.show(chosen, chosen.t - (view.shown?.t ?? chosen.t));
  view.marked = view.marks.show(chosen, recent);
  view.rings.show(chosen.truths);
  view.found = matches(chosen.contacts, chosen.truths);
  view.sites.follow(view.limb);
  view.sites.show(Array.from(chosen.states), panel.seen);
  byId("legend").hidden = chosen.components === 0;
  legend.setRange(view.limb.range);
  controls.showExaggeration(view.limb.drawnExaggeration);
  panel.show(chosen, recent, now, view.found, stage.right);
  byId("stage").classList.toggle("unknown", chosen.phase === "unknown");
  view.shown = chosen;
  stage.stale = true;
  showTime(chosen);
}

function showTime(chosen) {
  if (chosen.replay) {
    const { position, duration } = chosen.replay;
    controls.setTime(0, duration, position, `${clock(position)} / ${clock(duration)}`);
    return;
  }
  const back = view.held ? chosen.t - history.last.t : 0;
  controls.setTime(-KEPT_S, 0, back, back < -0.05 ? `${back.toFixed(1).replace("-", "−")} s` : view.held ? "paused" : "live");
}

function placeLabels() {
  const marks = (view.marked ?? []).map(({ mark, other, tail, sign, colour }, i) => ({
    point: tail,
    text: newtons(mark.newtons),
    small: beside(mark, other, i),
    colour,
    kind: other ? "other" : "",
    clear: sign.sprite.visible ? sign.radius / stage.metresPerPixel + 4 : 0,
  }));
  view.sites.gauges.forEach(({ name }, i) => {
    if (!view.names && i !== panel.seen) return;
    marks.push({ point: view.sites.at(i), text: name, small: "", colour: "", kind: i === panel.seen ? "name seen" : "name", clear: 0 });
  });
  labels.show(stage, marks);
}

/** What is said beside a force: how probable, or how far off the truth. */
function beside(mark, other, i) {
  if (other) return `or ${(100 * mark.weight).toFixed(0)} %`;
  return view.found[i] ? `${millimetres(view.found[i].off)} off` : "";
}

/** Stops the picture here; a replay stops at its source, whose frames say so. */
function pause(on) {
  if (history.last?.replay) send({ cmd: "pause", on });
  else hold(on ? view.shown : null);
}

/** Keeps a frame in the picture for as long as it takes, with what led to it; null: the newest. */
function hold(frame) {
  view.held = frame && { frame, recent: history.span(frame.t, SPAN_S) };
  view.fresh = true;
  panel.refresh();
  controls.setPaused(view.held !== null);
}

/** Goes to a time: of the replay from its beginning, else back from now. */
function seek(to) {
  const { last } = history;
  if (!last) return;
  if (last.replay) {
    send({ cmd: "seek", position_s: to });
    return;
  }
  hold(history.at(last.t + to));
}

/** Saves the picture here and tells the program to keep its own. */
function snapshot() {
  picture().toBlob((blob) => {
    const url = URL.createObjectURL(blob);
    Object.assign(document.createElement("a"), { href: url, download: `${byId("title").textContent.replace(/[^a-z0-9]/giu, "-")}-snapshot.png` }).click();
    URL.revokeObjectURL(url);
  });
  if (view.offers.commands && view.shown) send({ cmd: "snapshot", t_s: view.shown.t });
}

/** What the stage shows, with its scales and words, on a canvas. */
function picture() {
  stage.stale = true;
  stage.draw();
  const tags = [...["simulated"].filter(() => !byId("simulated").hidden), ...[byId("device").textContent].filter(Boolean), new Date().toISOString().slice(0, 19).replace("T", " ") + " UTC"];
  const exaggerated = view.exaggeration ? byId("exaggerate-out").textContent : "";
  return compose(byId("stage"), stage.canvas, byId("bar"), {
    title: byId("title").textContent,
    tags,
    displacement: view.shown?.components ? { ticks: legend.texts, exaggerated } : null,
    ruler: legend.length,
    axes: axes.ends,
  });
}

function send(message, done) {
  const sent = link.send(message);
  if (!sent) say("Not connected");
  else if (done) say(done);
  return sent;
}

let silence = 0;
function say(words) {
  byId("say").textContent = words;
  clearTimeout(silence);
  silence = setTimeout(() => { byId("say").textContent = ""; }, SAY_MS);
}

/** Tells a screen reader when contacts begin and end. */
function announce(before, now) {
  const had = before?.contacts.length ?? 0;
  const has = now.contacts.length;
  if (had === has) return;
  byId("events").textContent = has ? `${has} ${has === 1 ? "contact" : "contacts"}: ${now.contacts.map((mark) => newtons(mark.newtons)).join(", ")}` : "Nothing touches";
}

function isSame(a, b) {
  return a.length === b.length && a.every((x, i) => x === b[i]);
}

function clock(seconds) {
  return `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
}

function onScreen(point) {
  const { left, top } = stage.canvas.getBoundingClientRect();
  const [x, y] = stage.project(point);
  return [left + x, top + y];
}

/** For tests: what is shown, and where a node is on the screen. */
globalThis.hapdefView = {
  get nodes() { return view.limb ? view.limb.rest.length / 3 : 0; },
  get t() { return view.shown?.t ?? NaN; },
  get sites() { return view.sites?.colours() ?? []; },
  get others() { return view.shown?.others.length ?? 0; },
  get ellipses() { return (view.marks?.arrows ?? []).filter((arrow) => arrow.group.visible && arrow.ellipse.visible).length; },
  /** True contacts that are shown, and how far off each contact is, m. */
  get truths() { return (view.shown?.truths ?? []).map((mark) => Array.from(mark.position)); },
  get offs() { return view.found.map((found) => found?.off ?? null); },
  get pressing() { return press.fingers.filter((held) => held !== undefined).length; },
  get ghosts() { return view.marks?.nGhosts ?? 0; },
  get newest() { return history.last?.t ?? NaN; },
  get radius() { return stage.sphere.radius; },
  picture,
  get coloured() { return view.shown?.components ? view.shown.displacement.length / view.shown.components : 0; },
  get drawn() { return view.drawn; },
  /** Time that the pictures drawn so far took this page's own script, ms. */
  get workMs() { return view.workMs; },
  get seq() { return view.shown?.seq ?? 0; },
  get contacts() { return (view.shown?.contacts ?? []).map((mark) => Array.from(mark.position)); },
  get arrows() { return (view.marks?.arrows ?? []).filter((arrow) => arrow.group.visible).map((arrow) => arrow.body.position.toArray()); },
  /** Tip and tail of an arrow on the screen. */
  arrowEnds: (i) => [view.marked[i].tip, view.marked[i].tail].map(onScreen),
  /** Where the first arrow, its ellipse, the newest ghost and the gauges are drawn. */
  get marksDrawn() {
    const { arrows: [{ body, ellipse }], ghosts } = view.marks;
    const ofContact = [body.position.toArray(), ellipse.matrix.elements.slice(12, 15), [...ghosts.geometry.attributes.position.array.slice(0, 3)]];
    return [...ofContact, ...view.sites.gauges.map((_, i) => view.sites.at(i).toArray())];
  },
  /** Signs of arrows that are seen along themselves, as [x, y, radius, from its tip] on the screen. */
  get signs() {
    const seen = (view.marked ?? []).filter(({ sign }) => sign.sprite.visible);
    return seen.map(({ tip, sign }) => [...onScreen(tip), sign.radius / stage.metresPerPixel, sign.ofTip]);
  },
  get times() { return history.entries.map((entry) => entry.t); },
  node: (i) => view.limb.node(i).toArray(),
  drawnNode: (i) => view.limb.drawnNode(i).toArray(),
  pickable: (point) => view.limb.geometry.boundingSphere.distanceToPoint(stage.sphere.center.clone().fromArray(point)) < 1e-6,
  project: (i) => onScreen(view.limb.node(i)),
  /** The node that faces the viewer nearest to the middle. */
  facing() {
    const { clientWidth, clientHeight } = stage.canvas;
    const hit = stage.pick(clientWidth / 2, clientHeight / 2, view.limb.mesh);
    return hit ? hit.face.a : -1;
  },
};
