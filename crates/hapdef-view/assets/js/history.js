// Frames of the last seconds, as they came.

import { readFrame, timeOf, withoutDisplacement } from "./wire.js";

export const KEPT_S = 30;
const MOST_FRAMES = 2400;
/** Displacements that are kept, bytes; older frames go without. */
const MOST_BYTES = 96e6;

/** Keeps frames by time. A time that goes backwards starts anew. */
export class History {
  constructor() {
    this.clear();
  }

  clear() {
    this.entries = [];
    this.bytes = 0;
    this.nLight = 0;
  }

  /** Adds a frame, drops what is too old. */
  add(buffer) {
    const t = timeOf(buffer);
    const last = this.entries.at(-1);
    if (last && t < last.t) this.clear();
    const frame = readFrame(buffer);
    this.entries.push({ t, frame });
    this.bytes += frame.displacement.byteLength;
    while (this.bytes > MOST_BYTES && this.nLight < this.entries.length - 1) {
      this.lighten(this.entries[this.nLight]);
      this.nLight += 1;
    }
    const first = this.entries.findIndex((entry) => entry.t > t - KEPT_S);
    const surplus = Math.max(first, this.entries.length - MOST_FRAMES);
    if (surplus > 64) this.forget(surplus);
    return frame;
  }

  forget(n) {
    for (const { frame } of this.entries.splice(0, n)) this.bytes -= frame.displacement.byteLength;
    this.nLight = Math.max(0, this.nLight - n);
  }

  lighten(entry) {
    this.bytes -= entry.frame.displacement.byteLength;
    entry.frame = withoutDisplacement(entry.frame);
  }

  get last() {
    return this.entries.at(-1)?.frame ?? null;
  }

  /** The frame shown at `t`: the last one not after it. */
  at(t) {
    return this.entries[this.before(t)]?.frame ?? null;
  }

  /** Frames of the `seconds` up to `t`. */
  span(t, seconds) {
    const from = Math.max(0, this.before(t - seconds));
    return this.entries.slice(from, this.before(t) + 1);
  }

  before(t) {
    let low = 0;
    let high = this.entries.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.entries[middle].t <= t) low = middle + 1;
      else high = middle;
    }
    return Math.max(0, low - 1);
  }
}
