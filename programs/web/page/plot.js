// Lines over the last minute, and bars; drawn in the page's own colours.
import { SPAN_MS } from "./history.js";

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Sizes a canvas to where it stands; returns its context, drawing in CSS pixels.
export function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height };
}

// A step of 1, 2 or 5 times a power of ten, so that about `count` of them fill the range.
export function niceStep(range, count) {
  const raw = range / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].find((step) => step * power >= raw) * power;
}

export const short = (value, step) => value.toFixed(Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9))));

// series: [{values: [{t, y}], colour, name}]; a y of null is a gap. options: {unit, now, least: smallest range, zero}
export function lines(canvas, series, { unit, now, least = 1, zero = false }) {
  const { context, width, height } = fitted(canvas);
  const values = series.flatMap((one) => one.values.map((p) => p.y)).filter((y) => y !== null && Number.isFinite(y));
  let low = zero ? 0 : Math.min(...values);
  let high = Math.max(...values);
  if (!values.length) [low, high] = [0, least];
  const room = Math.max(0, least - (high - low));
  if (!zero) low -= room / 2;
  high += zero ? room : room / 2;
  const step = niceStep(high - low, 3);
  low = Math.floor(low / step) * step;
  high = Math.ceil(high / step) * step;
  const [left, right, top, bottom] = [58, width - 6, 8, height - 20];
  const xOf = (t) => right - ((now - t) / SPAN_MS) * (right - left);
  const yOf = (y) => bottom - ((y - low) / (high - low)) * (bottom - top);
  context.textBaseline = "middle";
  context.textAlign = "right";
  context.lineWidth = 1;
  for (let y = low; y <= high + step / 2; y += step) {
    context.strokeStyle = colour("--line");
    context.beginPath();
    context.moveTo(left, Math.round(yOf(y)) + 0.5);
    context.lineTo(right, Math.round(yOf(y)) + 0.5);
    context.stroke();
    context.fillStyle = colour("--soft");
    context.fillText(short(y, step), left - 6, yOf(y));
  }
  context.textBaseline = "alphabetic";
  for (const seconds of [60, 40, 20, 0]) {
    context.textAlign = seconds === 60 ? "left" : seconds ? "center" : "right";
    context.fillText(seconds ? `-${seconds} s` : "now", xOf(now - seconds * 1000), height - 4);
  }
  context.lineWidth = 1.8;
  context.lineJoin = "round";
  for (const one of series) {
    context.strokeStyle = colour(one.colour);
    context.beginPath();
    let isDown = false;
    for (const { t, y } of one.values) {
      if (y === null || !Number.isFinite(y)) {
        isDown = false;
        continue;
      }
      context[isDown ? "lineTo" : "moveTo"](xOf(t), yOf(y));
      isDown = true;
    }
    context.stroke();
  }
  return { low, high, unit };
}

// bins: counts; edgeOf(i): upper edge of bin i. Only the part that is used is drawn.
export function bars(canvas, bins, edgeOf, unit) {
  const { context, width, height } = fitted(canvas);
  const used = bins.map((count, i) => (count ? i : -1)).filter((i) => i >= 0);
  context.fillStyle = colour("--soft");
  if (!used.length) return context.fillText("nothing counted yet", 8, 20);
  const first = Math.max(0, used[0] - 2);
  const last = Math.min(bins.length - 1, Math.max(used[used.length - 1] + 2, first + 11));
  const most = Math.max(...bins);
  const [left, right, top, bottom] = [8, width - 8, 18, height - 24];
  const step = (right - left) / (last - first + 1);
  for (let i = first; i <= last; ++i) {
    const x = left + (i - first) * step;
    // By the root, so that a single late frame among thousands is seen.
    const h = bins[i] ? Math.max(3, Math.sqrt(bins[i] / most) * (bottom - top)) : 0;
    context.fillStyle = colour("--accent");
    context.fillRect(x + 1, bottom - h, Math.max(1, step - 2), h);
    context.fillStyle = colour("--soft");
    context.textAlign = "center";
    if (bins[i] && step > 26) context.fillText(String(bins[i]), x + step / 2, bottom - h - 4);
    if ((i - first) % Math.ceil(46 / step) === 0) context.fillText(edgeOf(i), x + step, height - 8);
  }
  context.textAlign = "right";
  context.fillText(unit, right, 12);
}
