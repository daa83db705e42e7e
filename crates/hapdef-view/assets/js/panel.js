// Numbers beside the limb: contacts, plots, gauges, health.

import { contactColour, mapColour, roundUp } from "./colour.js";
import { Plot, SPAN_S } from "./plot.js";
import { element, keep, put } from "./text.js";
import { millimetres } from "./truth.js";
import { drawZoom, makeZoom } from "./zoom.js";

const STATES = ["", "saturated", "dead", "out"];
const WORDS = { saturated: "sat.", dead: "dead", out: "out" };
const TEXT_MS = 100;
const PLOT_MS = 50;
/** A pause longer than this, s, breaks a contact's line. */
const BREAK_S = 0.25;
/** Readings that are explained worse than in one of a thousand frames by chance. */
const POOR_FIT = 1e-3;

/** The readings. */
export class Panel {
  constructor(byId) {
    this.byId = byId;
    this.forces = new Plot(byId("force-plot"), 1);
    this.strains = new Plot(byId("gauge-plot"), 10);
    this.seen = -1;
    this.chosen = -1;
    this.textAt = 0;
    this.plotAt = 0;
    this.healthAt = 0;
  }

  /** Rows for `gauges`. */
  setGauges(gauges) {
    this.rows = gauges.map((gauge, i) => this.row(gauge, i));
    this.rows.forEach(({ root }, i) => root.style.setProperty("--curve", gaugeColour(i, gauges.length)));
    this.byId("gauges").replaceChildren(...this.rows.map((row) => row.root));
  }

  row(gauge, i) {
    const fill = element("span", "fill");
    const track = element("span", "track", fill);
    const value = element("span", "value");
    track.setAttribute("aria-hidden", "true");
    const root = element("li", "", element("span", "", gauge.name), track, value);
    root.tabIndex = 0;
    root.onpointerenter = () => this.look(i);
    root.onpointerleave = () => this.look(this.chosen);
    root.onfocus = () => this.look(i);
    root.onblur = () => this.look(this.chosen);
    root.onclick = () => this.choose(i);
    return { root, fill, value };
  }

  /** Keeps a gauge in sight, or no longer. */
  choose(i) {
    this.chosen = this.chosen === i ? -1 : i;
    this.look(this.chosen);
  }

  /** Sets a gauge off here, in the plot and on the limb. */
  look(i) {
    if (this.seen === i) return;
    this.seen = i;
    this.rows.forEach((row, k) => row.root.classList.toggle("seen", k === i));
    this.plotAt = 0;
    this.onlook();
  }

  /** Shows a frame; `recent` are the frames of the last ten seconds, `found` are the contacts' true ones, `right` is
   * where the screen's right points. */
  show(frame, recent, now, found, right) {
    if (now - this.plotAt >= PLOT_MS) {
      this.plotAt = now;
      this.draw(frame, recent);
    }
    if (now - this.textAt < TEXT_MS) return;
    this.textAt = now;
    this.showContacts(frame, found, right);
    this.showGauges(frame);
  }

  refresh() {
    this.textAt = 0;
    this.plotAt = 0;
  }

  draw(frame, recent) {
    this.forces.draw(frame.t, forceLines(recent), false);
    const n = frame.readings.length;
    const lines = Array.from({ length: n }, (_, i) => ({
      colour: i === this.seen ? this.strains.style.getPropertyValue("--accent") : gaugeColour(i, n),
      wide: i === this.seen,
      points: recent.map(({ t, frame }) => [t, frame.states[i] === 2 ? NaN : frame.readings[i], frame.ranges[2 * i], frame.ranges[2 * i + 1]]),
    }));
    if (this.seen >= 0 && this.seen < n) lines.push(...lines.splice(this.seen, 1));
    this.strains.draw(frame.t, lines, true);
  }

  showContacts({ contacts, others, truths, phase, why, stale }, found, right) {
    const marks = [...contacts.map((mark, i) => ({ mark, other: false, found: found[i], right })), ...others.map((mark) => ({ mark, other: true, found: null, right }))];
    this.byId("truth-key").hidden = truths.length === 0;
    this.byId("no-contacts").hidden = marks.length > 0;
    const unknown = phase === "unknown" ? why : null;
    put(this.byId("unknown"), (marks.length && unknown) || "");
    this.byId("contacts").classList.toggle("stale", Boolean(stale));
    if (!marks.length) this.showNoContacts(this.fault || unknown || (phase === "taring" ? "Taring: touch nothing" : "Nothing touches"));
    for (const [row, item] of keep(this.byId("contacts"), marks, makeContact)) fillContact(row, item);
  }

  showNoContacts(why) {
    put(this.byId("no-contacts"), why);
  }

  /** Before there is a frame. */
  wait() {
    this.showContacts({ contacts: [], others: [], truths: [] }, [], [1, 0, 0]);
    this.showNoContacts(this.fault || "Waiting for readings");
  }

  /** Why no readings come; null: they do. */
  setFault(why) {
    this.fault = why;
    this.refresh();
  }

  showGauges({ readings, states }) {
    const finite = Array.from(readings).filter((reading, i) => Number.isFinite(reading) && states[i] !== 2);
    const range = roundUp(Math.max(10, ...finite.map(Math.abs)));
    this.rows.forEach(({ root, fill, value }, i) => {
      const state = STATES[states[i]];
      for (const name of STATES.slice(1)) root.classList.toggle(name, state === name);
      const known = Number.isFinite(readings[i]) && state !== "dead";
      fill.style.transform = `scaleX(${known ? Math.max(-1, Math.min(1, readings[i] / range)) : 0})`;
      put(value, WORDS[state] ?? (known ? signed(readings[i]) : "–"));
      root.title = state === "out" ? "left out: it jumped alone, or is not well for long enough" : state;
    });
  }

  /** Health is always the newest, whatever frame is shown; a replay may stand still. */
  showHealth(health, p, replay, now) {
    if (now - this.healthAt < TEXT_MS) return;
    this.healthAt = now;
    const items = [
      ["Rate", Number.isFinite(health.rate) ? `${health.rate.toFixed(0)} Hz` : "–", health.rate === 0 && !replay],
      ["Lost", count(health.lost), health.lost > 0],
      ["Dropped", count(health.dropped), health.dropped > 0],
      ["CRC errors", count(health.crc), health.crc > 0],
      ["Latency", `${time(health.p50)} · p99 ${time(health.p99)}`, false],
      ["Fit", fit(p), p < POOR_FIT],
      ["Clock", Number.isFinite(health.clock) ? `±${time(health.clock)}` : "–", false],
      ["Recording", recording(health), health.recording === "failed"],
    ];
    const makeItem = () => element("div", "", element("dt"), element("dd"));
    for (const [row, [name, text, bad]] of keep(this.byId("health"), items, makeItem)) {
      row.classList.toggle("bad", bad);
      put(row.children[0], name);
      put(row.children[1], text);
    }
  }
}

/** A force with a sensible number of digits. */
export const newtons = (force) => `${force.toFixed(force < 9.95 ? 1 : 0)} N`;

const makeContact = () => element("li", "", element("b"), element("span"), element("span", "off"), makeZoom(), element("span", "where"));

function fillContact(row, { mark, other, found, right }) {
  const [force, sure, off, zoom, where] = row.children;
  put(off, found ? `${millimetres(found.off)} off` : "");
  drawZoom(zoom, mark, found?.truth, right);
  row.classList.toggle("other", other);
  row.style.setProperty("--mark", contactColour(mark.id));
  put(force, newtons(mark.newtons));
  put(sure, other ? `or this, ${(100 * mark.weight).toFixed(0)} %` : forceSd(mark));
  put(where, place(mark));
}

function forceSd({ forceSd: sd }) {
  return Number.isFinite(sd) ? `±${sd.toFixed(sd < 0.095 ? 2 : 1)} N` : "";
}

/** Position with the larger standard deviation. */
function place({ position, axes }) {
  const at = Array.from(position, (c, i) => `${"xyz"[i]} ${(1e3 * c).toFixed(0).replace("-", "−")}`).join("  ");
  return `${at}${axes ? ` ±${(1e3 * Math.hypot(...axes[0])).toFixed(1)}` : ""} mm`;
}

function forceLines(recent) {
  const byId = new Map();
  for (const { t, frame } of recent) {
    for (const { id, newtons: force, range: [low, high] } of frame.contacts) {
      if (!byId.has(id)) byId.set(id, []);
      const points = byId.get(id);
      const last = points.at(-1);
      if (last && t - last[0] > BREAK_S) points.push([t, NaN]);
      points.push([t, force, low, high]);
    }
  }
  return [...byId].map(([id, points]) => ({ colour: contactColour(id), wide: true, points }));
}

/** Colours for many lines that both grounds show. */
function gaugeColour(i, n) {
  const [r, g, b] = mapColour("viridis", 0.25 + (0.55 * i) / Math.max(1, n - 1));
  return `rgb(${[r, g, b].map((c) => Math.round(255 * c))})`;
}

const signed = (x) => (Math.abs(x) < 0.05 ? "0.0" : x.toFixed(Math.abs(x) < 9.95 ? 1 : 0)).replace("-", "−");
const count = (n) => n.toLocaleString("en");

function time(us) {
  if (!Number.isFinite(us)) return "–";
  return us < 995 ? `${us.toFixed(us < 9.95 ? 1 : 0)} µs` : `${(us / 1e3).toFixed(us < 9950 ? 1 : 0)} ms`;
}

/** How probable readings are that are explained as badly. */
function fit(p) {
  if (!Number.isFinite(p)) return "–";
  return p < POOR_FIT ? "poor" : `p ${p.toFixed(2)}`;
}

function recording({ recording: state, recorded }) {
  if (state !== "on") return state;
  const seconds = Math.floor(recorded || 0);
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

export { SPAN_S };
