// The picture that is saved: the stage with its newtons, scales and heading on one opaque ground.

const PAD = 14;
const BAR = { width: 170, height: 12 };
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

/** Draws the stage as it is seen on a canvas of its own. `words` has title, tags [text], displacement (null
 * where none is drawn, else {ticks [text], exaggerated}), ruler {width, text}, axes [{letter, end, at}];
 * CSS pixels. */
export function compose(section, stageCanvas, bar, words) {
  const ratio = Math.min(devicePixelRatio, 2);
  const canvas = document.createElement("canvas");
  const frame = section.getBoundingClientRect();
  canvas.width = Math.round(frame.width * ratio);
  canvas.height = Math.round(frame.height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  const style = getComputedStyle(section);
  const colour = (name) => style.getPropertyValue(name);
  const brush = { pen, frame, colour };
  ground(brush);
  const place = stageCanvas.getBoundingClientRect();
  pen.drawImage(stageCanvas, place.left - frame.left, place.top - frame.top, place.width, place.height);
  for (const label of section.querySelectorAll(".label:not([hidden])")) drawLabel(brush, label);
  heading(brush, words);
  scales(brush, bar, words);
  drawAxes(brush, words.axes);
  return canvas;
}

function ground({ pen, frame: { width, height }, colour }) {
  const light = pen.createRadialGradient(width / 2, 0.42 * height, 0, width / 2, 0.42 * height, 0.6 * Math.max(width, height));
  light.addColorStop(0, colour("--glow-a"));
  light.addColorStop(1, colour("--glow-b"));
  pen.fillStyle = light;
  pen.fillRect(0, 0, width, height);
}

function drawLabel({ pen, frame, colour }, label) {
  const box = label.getBoundingClientRect();
  const [x, y] = [box.left - frame.left, box.top - frame.top];
  if (!label.classList.contains("name")) {
    pen.fillStyle = colour("--panel");
    pen.fillRect(x, y, box.width, box.height);
    pen.fillStyle = label.style.getPropertyValue("--mark");
    pen.fillRect(x, y, 4, box.height);
  }
  for (const part of label.children) {
    const at = part.getBoundingClientRect();
    const { fontWeight, fontSize, color } = getComputedStyle(part);
    write(pen, part.textContent, at.left - frame.left, at.top - frame.top + at.height / 2, `${fontWeight} ${fontSize} ${FONT}`, color);
  }
}

function heading({ pen, colour }, { title, tags }) {
  write(pen, title, PAD, PAD + 9, `600 16px ${FONT}`, colour("--text"));
  write(pen, tags.join(" · "), PAD, PAD + 31, `12px ${FONT}`, colour("--quiet"));
}

/** Colours over the ruler, at the bottom left. */
function scales({ pen, frame, colour }, bar, { displacement, ruler }) {
  const [text, font] = [colour("--text"), `12px ${FONT}`];
  const low = frame.height - PAD - 6;
  if (ruler) {
    pen.strokeStyle = text;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(PAD, low - 4);
    pen.lineTo(PAD, low + 3);
    pen.lineTo(PAD + ruler.width, low + 3);
    pen.lineTo(PAD + ruler.width, low - 4);
    pen.stroke();
    write(pen, ruler.text, PAD + ruler.width + 8, low, font, text);
  }
  if (!displacement) return;
  const { ticks, exaggerated } = displacement;
  const top = low - 62;
  write(pen, `Displacement${exaggerated ? `, exaggerated ${exaggerated}` : ""}`, PAD, top, `600 12px ${FONT}`, colour("--quiet"));
  pen.drawImage(bar, PAD, top + 12, BAR.width, BAR.height);
  ["left", "center", "right"].forEach((align, i) => {
    write(pen, ticks[i] ?? "", PAD + (i * BAR.width) / 2, top + 35, font, text, align);
  });
}

/** At the bottom right, those that point away first. */
function drawAxes({ pen, frame, colour }, axes) {
  const [x, y] = [frame.width - PAD - 36, frame.height - PAD - 36];
  for (const { letter, end, at } of axes) {
    Object.assign(pen, { strokeStyle: colour("--quiet"), lineWidth: 1.5 });
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + end[0], y + end[1]);
    pen.stroke();
    write(pen, letter, x + at[0], y + at[1], `12px ${FONT}`, colour("--text"), "center");
  }
}

function write(pen, text, x, y, font, colour, align = "left") {
  Object.assign(pen, { font, fillStyle: colour, textAlign: align, textBaseline: "middle" });
  pen.fillText(text, x, y);
}
