// The page: the newest frame from the link, on the stage and in the panel.

import { Controls } from "./controls.js";
import { History, KEPT_S } from "./history.js";
import { Labels } from "./labels.js";
import { Legend } from "./legend.js";
import { Limb } from "./limb.js";
import { Link } from "./link.js";
import { Marks } from "./marks.js";
import { newtons, Panel, SPAN_S } from "./panel.js";
import { Press } from "./press.js";
import { Sites } from "./sites.js";
import { Stage } from "./stage.js";

const STATES = { live: "live", away: "reconnecting", locked: "needs its token" };
const SAY_MS = 4000;

const byId = (id) => document.getElementById(id);
const stage = new Stage(byId("limb"));
const labels = new Labels(byId("labels"));
const legend = new Legend(byId("legend"), byId("ruler"));
const panel = new Panel(byId);
const history = new History();
const view = { limb: null, marks: null, sites: null, exaggeration: 0, map: "viridis", paused: false, shownAt: 0, fresh: false, shown: null, offers: {}, drawn: 0 };
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
  release: () => press.release(),
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

const link = new Link({ hello, frame, text, state });
requestAnimationFrame(tick);

function hello(message, surface) {
  document.title = `${message.title} · hapdef`;
  byId("title").textContent = message.title;
  byId("simulated").hidden = !message.simulated;
  const isFirst = view.limb === null;
  for (const part of [view.limb?.mesh, view.marks?.group, view.sites?.group]) if (part) stage.scene.remove(part);
  view.limb?.dispose();
  view.limb = Object.assign(new Limb(surface), { exaggeration: view.exaggeration });
  view.limb.setMap(view.map);
  if (isFirst && message.offers.press) say("Drag on the limb to press it");
  if (isFirst) stage.frame(view.limb.geometry, message.up, message.view_from);
  view.marks = new Marks(stage.sphere.radius);
  view.sites = new Sites(message.gauges, stage.sphere.radius);
  stage.scene.add(view.limb.mesh, view.marks.group, view.sites.group);
  stage.stale = true;
  history.clear();
  view.shown = null;
  legend.setUnit(message.unit);
  panel.setGauges(message.gauges);
  panel.showNoContacts("Waiting for readings");
  view.offers = message.offers;
  controls.offer(message.offers);
  if (!message.offers.commands) byId("link").textContent = "view only";
  pause(false);
}

function frame(buffer) {
  const before = history.last;
  const now = history.add(buffer);
  announce(before, now);
  byId("record").ariaPressed = String(now.health.recording === "on");
  panel.showHealth(now.health, performance.now());
  if (!view.paused || now.replay) view.fresh = true;
}

function text({ type, text: words }) {
  say(type === "refused" ? `Refused: ${words}` : words);
}

function state(name) {
  byId("link").dataset.state = name;
  byId("link").textContent = STATES[name];
}

/** Draws what is new, at most once for each picture of the screen. */
function tick(now) {
  requestAnimationFrame(tick);
  if (view.fresh && view.limb) {
    const chosen = view.paused && !history.last?.replay ? history.at(view.shownAt) : history.last;
    if (chosen) show(chosen, now);
    view.fresh = false;
  }
  if (!stage.draw() || !view.limb) return;
  legend.setRuler(stage.metresPerPixel);
  if (!view.shown) return;
  placeLabels();
  view.drawn += 1;
}

function show(chosen, now) {
  const recent = history.span(chosen.t, SPAN_S);
  view.limb.show(chosen, chosen.t - (view.shown?.t ?? chosen.t));
  view.marked = view.marks.show(chosen, recent);
  view.sites.show(Array.from(chosen.states), panel.seen);
  byId("legend").hidden = chosen.components === 0;
  legend.setRange(view.limb.range);
  panel.show(chosen, recent, now);
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
  const back = view.paused ? chosen.t - history.last.t : 0;
  controls.setTime(-KEPT_S, 0, back, back < -0.05 ? `${back.toFixed(1).replace("-", "−")} s` : view.paused ? "paused" : "live");
}

function placeLabels() {
  const marks = (view.marked ?? []).map(({ mark, other, tail, colour }) => ({
    point: tail,
    text: newtons(mark.newtons),
    small: other ? `or ${(100 * mark.weight).toFixed(0)} %` : "",
    colour,
    kind: other ? "other" : "",
  }));
  const { seen } = panel;
  if (seen >= 0 && view.sites.gauges[seen]) {
    marks.push({ point: view.sites.at(seen), text: view.sites.gauges[seen].name, small: "", colour: "", kind: "name" });
  }
  labels.show(stage, marks);
}

/** Stops the picture here; a replay stops at its source, too. */
function pause(on) {
  const { last } = history;
  if (last?.replay) send({ cmd: "pause", on });
  view.paused = on;
  view.shownAt = view.shown?.t ?? 0;
  view.fresh = true;
  panel.refresh();
  controls.setPaused(on);
}

/** Goes to a time: of the replay from its beginning, else back from now. */
function seek(to) {
  const { last } = history;
  if (!last) return;
  if (last.replay) {
    send({ cmd: "seek", position_s: to });
    return;
  }
  if (!view.paused) pause(true);
  view.shownAt = last.t + to;
  view.fresh = true;
  panel.refresh();
}

/** Saves the picture here and tells the program to keep its own. */
function snapshot() {
  stage.stale = true;
  stage.draw();
  stage.canvas.toBlob((blob) => {
    const url = URL.createObjectURL(blob);
    Object.assign(document.createElement("a"), { href: url, download: "hapdef.png" }).click();
    URL.revokeObjectURL(url);
  });
  if (view.offers.commands && view.shown) send({ cmd: "snapshot", t_s: view.shown.t });
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

function clock(seconds) {
  return `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
}

/** For tests: what is shown, and where a node is on the screen. */
globalThis.hapdefView = {
  get nodes() { return view.limb ? view.limb.rest.length / 3 : 0; },
  get coloured() { return view.shown?.components ? view.shown.displacement.length / view.shown.components : 0; },
  get drawn() { return view.drawn; },
  get seq() { return view.shown?.seq ?? 0; },
  get contacts() { return (view.shown?.contacts ?? []).map((mark) => Array.from(mark.position)); },
  get arrows() { return (view.marks?.arrows ?? []).filter((arrow) => arrow.group.visible).map((arrow) => arrow.body.position.toArray()); },
  node: (i) => Array.from(view.limb.node(i)),
  project(i) {
    const { left, top } = stage.canvas.getBoundingClientRect();
    const [x, y] = stage.project(view.limb.node(i));
    return [left + x, top + y];
  },
  /** The node that faces the viewer nearest to the middle. */
  facing() {
    const { clientWidth, clientHeight } = stage.canvas;
    const hit = stage.pick(clientWidth / 2, clientHeight / 2, view.limb.mesh);
    return hit ? hit.face.a : -1;
  },
};
