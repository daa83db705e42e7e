"use strict";
const { palette, step_mm: STEP_MM, ruler_px: RULER_PX, limbs } = JSON.parse(document.getElementById("data").textContent);
const INNER_SIDE = "#e2e2e2";

/* Where the light comes from: right, up and towards the eye, of unit length. */
const LIGHT = [-0.36, 0.48, 0.8];

/* The colour of a triangle's value, which no light changes, as it is read off the scale; nothing without a value. */
function colour(limb, map, triangle) {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const value = map.values[limb.triangles[3 * triangle + k]];
    if (value === null) return undefined;
    sum += value / 3;
  }
  const part = (sum - map.low) / (map.high - map.low || 1);
  return palette[Math.round(Math.min(Math.max(part, 0), 1) * (palette.length - 1))];
}

/* A triangle without a value: grey, lit, so that the limb's shape shows. */
function lit(p, [i, j, k]) {
  const [a, b] = [j, k].map((v) => [0, 1, 2].map((axis) => p[v + axis] - p[i + axis]));
  const normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const light = normal.reduce((sum, x, axis) => sum + x * LIGHT[axis], 0) / (Math.hypot(...normal) || 1);
  const level = Math.round(95 + 125 * Math.max(light, 0));
  return `rgb(${level},${level},${level})`;
}

/* Right, up and towards the eye, for a view turned about the long axis and tilted. */
function projected(points, limb, yaw, tilt) {
  const [u, a, b] = [limb.up, (limb.up + 1) % 3, (limb.up + 2) % 3];
  const [cy, sy, ct, st] = [Math.cos(yaw), Math.sin(yaw), Math.cos(tilt), Math.sin(tilt)];
  const n = points.length / 3;
  const out = new Float64Array(3 * n);
  for (let i = 0; i < n; i++) {
    const [pa, pb, pu] = [a, b, u].map((axis) => points[3 * i + axis] - limb.centre[axis]);
    const near = cy * pb + sy * pa;
    out[3 * i] = sy * pb - cy * pa;
    out[3 * i + 1] = ct * pu - st * near;
    out[3 * i + 2] = st * pu + ct * near;
  }
  return out;
}

/* The limb, far triangles first, so large that an extent of `size` fits. */
function draw(canvas, limb, map, size, yaw, tilt) {
  const g = canvas.getContext("2d");
  const height = canvas.height - RULER_PX;
  const scale = Math.min(canvas.width / size[0], height / size[1]) * 0.96;
  const place = (p, v) => [canvas.width / 2 + scale * p[v], height / 2 - scale * p[v + 1]];
  const p = projected(limb.points, limb, yaw, tilt);
  const n = limb.triangles.length / 3;
  const depth = new Float64Array(n);
  for (let t = 0; t < n; t++)
    for (let k = 0; k < 3; k++) depth[t] += p[3 * limb.triangles[3 * t + k] + 2];
  const order = Array.from(depth.keys()).sort((s, t) => depth[s] - depth[t]);
  g.fillStyle = "#fff";
  g.fillRect(0, 0, canvas.width, canvas.height);
  g.lineWidth = 0.7;
  g.lineJoin = "round";
  for (const t of order) {
    const [i, j, k] = [0, 1, 2].map((corner) => 3 * limb.triangles[3 * t + corner]);
    const turn =
      (p[j] - p[i]) * (p[k + 1] - p[i + 1]) - (p[k] - p[i]) * (p[j + 1] - p[i + 1]);
    g.fillStyle = g.strokeStyle = turn < 0 ? INNER_SIDE : colour(limb, map, t) ?? lit(p, [i, j, k]);
    g.beginPath();
    for (const v of [i, j, k]) g.lineTo(...place(p, v));
    g.closePath();
    g.fill();
    g.stroke();
  }
  const marks = projected(limb.marks, limb, yaw, tilt);
  g.font = "bold 20px system-ui, sans-serif";
  const rings = Array.from({ length: marks.length / 3 }, (_, m) => place(marks, 3 * m));
  rings.forEach(([x, y], m) => ring(g, x, y, marks[3 * m + 2] < 0));
  const taken = rings.map(([x, y]) => [x - 9, y - 9, x + 9, y + 9]);
  rings.forEach(([x, y], m) => number(g, x, y, String(m), taken));
  ruler(g, canvas, scale / STEP_MM);
}

/* The longest bar of 1, 2 or 5 · 10ⁿ mm within two fifths of the width, over the strip at the foot. */
function ruler(g, canvas, pixelsPerMm) {
  const most = (0.4 * canvas.width) / pixelsPerMm;
  const power = 10 ** Math.floor(Math.log10(most));
  const mm = power * [5, 2, 1].find((step) => step * power <= most);
  const [x, y, width] = [6, canvas.height - 8, mm * pixelsPerMm];
  g.fillStyle = "#fff";
  g.fillRect(0, canvas.height - RULER_PX, canvas.width, RULER_PX);
  g.strokeStyle = g.fillStyle = "#222";
  g.lineWidth = 3;
  g.lineJoin = "miter";
  g.beginPath();
  for (const [dx, dy] of [[0, -8], [0, 0], [width, 0], [width, -8]]) g.lineTo(x + dx, y + dy);
  g.stroke();
  g.font = "20px system-ui, sans-serif";
  g.fillText(`${Number(mm.toPrecision(1))} mm`, x, y - 14);
}

/* A ring; a dashed one on the far side. */
function ring(g, x, y, isFar) {
  g.setLineDash(isFar ? [3, 4] : []);
  for (const [width, ink] of [[6, "#fff"], [2.5, "#c2185b"]]) {
    g.lineWidth = width;
    g.strokeStyle = ink;
    g.beginPath();
    g.arc(x, y, 9, 0, 2 * Math.PI);
    g.stroke();
  }
  g.setLineDash([]);
}

/* A ring's number in the first corner beside it where nothing is yet, else in the first. */
function number(g, x, y, name, taken) {
  const width = g.measureText(name).width;
  const corners = [[12, 7], [-12 - width, 7], [-width / 2, -14], [-width / 2, 28], [10, -8], [-10 - width, -8]];
  const box = ([dx, dy]) => [x + dx, y + dy - 15, x + dx + width, y + dy];
  const isFree = (b) =>
    b[0] >= 0 && b[2] <= g.canvas.width &&
    taken.every((t) => b[2] <= t[0] || b[0] >= t[2] || b[3] <= t[1] || b[1] >= t[3]);
  const corner = corners.find((c) => isFree(box(c))) ?? corners[0];
  taken.push(box(corner));
  g.lineWidth = 5;
  g.strokeStyle = "#fff";
  g.strokeText(name, x + corner[0], y + corner[1]);
  g.fillStyle = "#c2185b";
  g.fillText(name, x + corner[0], y + corner[1]);
}

for (const canvas of document.querySelectorAll("canvas[data-map]")) {
  const limb = limbs[canvas.dataset.limb];
  const yaw = (canvas.dataset.turn * Math.PI) / 2;
  draw(canvas, limb, limb.maps[canvas.dataset.map], limb.size, yaw, 0);
}

for (const canvas of document.querySelectorAll("canvas.turn")) {
  const limb = limbs[canvas.dataset.limb];
  const choice = canvas.parentElement.querySelector("select");
  let [yaw, tilt, across] = [0.6, 0.3, Math.hypot(...limb.size)];
  const show = () => draw(canvas, limb, limb.maps[choice.value], [across, across], yaw, tilt);
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  const turn = (right, down) => {
    yaw -= right;
    tilt = Math.min(Math.max(tilt + down, -1.5), 1.5);
    show();
  };
  const zoom = (by) => {
    across *= by;
    show();
  };
  const keys = {
    ArrowLeft: () => turn(-0.13, 0),
    ArrowRight: () => turn(0.13, 0),
    ArrowUp: () => turn(0, -0.13),
    ArrowDown: () => turn(0, 0.13),
    "+": () => zoom(1 / 1.15),
    "-": () => zoom(1.15),
  };
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) turn(event.movementX * 0.01, event.movementY * 0.01);
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(0.001 * event.deltaY));
  });
  canvas.addEventListener("keydown", (event) => {
    const key = event.ctrlKey || event.metaKey || event.altKey ? undefined : keys[event.key];
    if (!key) return;
    event.preventDefault();
    key();
  });
  choice.addEventListener("change", show);
  show();
}
