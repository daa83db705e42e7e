// A line plot over the last ten seconds.

import { roundUp } from "./colour.js";

export const SPAN_S = 10;
/** Least room for the numbers beside the lines, CSS pixels, and their distance from them. */
const LEFT = 34;
const BESIDE = 5;
const BOTTOM = 16;
const TOP = 6;
const RIGHT = 4;

/** Lines over time on a canvas. */
export class Plot {
  constructor(canvas, least) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.least = least;
    this.style = getComputedStyle(canvas);
  }

  /** Draws `lines` [{colour, wide, points: [[t, y, low, high], …]}] up to the time `now`; `low` and `high` are what
   * came between the point before and this one. */
  draw(now, lines, signed) {
    this.size();
    const most = lines.reduce((top, line) => line.points.reduce((m, [, , low, high]) => (Math.max(high, -low) > m ? Math.max(high, -low) : m), top), 0);
    const high = roundUp(Math.max(most, this.least), [1, 1.5, 2, 3, 4, 6, 8, 10]);
    const low = signed ? -high : 0;
    const values = [high, (high + low) / 2, low];
    const left = this.room(values);
    const x = (t) => left + (1 + (t - now) / SPAN_S) * (this.width - left - RIGHT);
    const y = (v) => TOP + ((high - v) / (high - low)) * (this.height - TOP - BOTTOM);
    this.axes(values, left, x, y, now);
    this.pen.save();
    this.pen.beginPath();
    this.pen.rect(left, 0, this.width - left - RIGHT + 1, this.height - BOTTOM + 1);
    this.pen.clip();
    for (const line of lines) this.line(line, x, y);
    this.pen.restore();
  }

  size() {
    const ratio = Math.min(devicePixelRatio, 2);
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    const [w, h] = [Math.round(this.width * ratio), Math.round(this.height * ratio)];
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, this.width, this.height);
  }

  /** Width that the widest of the numbers needs, and the time that ends where the curves begin. */
  room(values) {
    this.pen.font = `11px ${this.style.fontFamily}`;
    const width = (text) => Math.ceil(this.pen.measureText(text).width) + 2;
    const widths = values.map((value) => width(number(value)) + BESIDE);
    return Math.max(LEFT, width(ago(SPAN_S)), ...widths);
  }

  axes(values, left, x, y, now) {
    const { pen } = this;
    pen.fillStyle = this.style.getPropertyValue("--quiet");
    pen.strokeStyle = this.style.getPropertyValue("--line");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of values) {
      const at = Math.round(y(value)) + 0.5;
      this.rule(left, at, this.width - RIGHT, at);
      pen.fillText(number(value), left - BESIDE, at);
    }
    pen.textBaseline = "alphabetic";
    for (const back of [10, 5, 0]) {
      pen.textAlign = ["right", "center", "left"][back / 5];
      pen.fillText(back ? ago(back) : "0", x(now - back), this.height - 3);
    }
  }

  rule(x0, y0, x1, y1) {
    this.pen.beginPath();
    this.pen.moveTo(x0, y0);
    this.pen.lineTo(x1, y1);
    this.pen.stroke();
  }

  line({ colour, wide, points }, x, y) {
    const { pen } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = wide ? 2.2 : 1.3;
    pen.lineJoin = "round";
    pen.beginPath();
    let down = false;
    for (const [t, v, bottom, top] of points) {
      if (!Number.isFinite(v)) {
        down = false;
        continue;
      }
      if (down) pen.lineTo(x(t), y(v));
      else pen.moveTo(x(t), y(v));
      if (y(bottom) - y(top) > 1) {
        pen.moveTo(x(t), y(bottom));
        pen.lineTo(x(t), y(top));
        pen.moveTo(x(t), y(v));
      }
      down = true;
    }
    pen.stroke();
  }
}

const ago = (s) => `−${s} s`;
const number = (value) => String(Number(value.toPrecision(3))).replace("-", "−");
