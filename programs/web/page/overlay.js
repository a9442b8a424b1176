// What was found, drawn over the picture: discs and ring as the pose has them, axes, the dots as they were seen, and
// beside a small landmark a magnified cut-out. Readings that are not believed are drawn thin.
import { projector, dotCentre, circle } from "./projection.js";
import { hasGuess, isSeen } from "./search.js";

const COLOURS = { disc: "#ff3cdc", hidden: "#ff8c28", ring: "#00bee6", seen: "#ffeb00", other: "#ffffff", doubt: "#ffb020", spot: "#40d0ff" };
const AXES = [["X", [1, 0, 0], "#ff4848"], ["Z", [0, 0, 1], "#6090ff"], ["Y", [0, 1, 0], "#28dc46"]];
const SMALL_PX = 100;
// A reading that explains the picture so much worse is none any more: odds of one in 300,000.
const EXCLUDED_CHI2 = 25;

function chain(context, points, colour, width, dash = []) {
  if (points.some((point) => !point)) return;
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

function label(context, text, [x, y], colour, size) {
  context.font = `600 ${size}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = size / 4;
  context.strokeStyle = "rgba(0,0,0,.75)";
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

function drawSeen(context, dots, unit) {
  for (const [u, v, major, minor, , visible] of dots) {
    if (!visible) continue;
    const arm = Math.max(3 * unit, Math.min(0.45 * minor, 9 * unit));
    chain(context, [[u - arm, v], [u + arm, v]], COLOURS.seen, unit);
    chain(context, [[u, v - arm], [u, v + arm]], COLOURS.seen, unit);
  }
}

// Where no pose is believed: the outlines as they were seen.
function drawOutlines(context, dots, unit) {
  for (const [u, v, major, minor, angle, visible] of dots) {
    if (visible) ellipse(context, [u, v, major, minor, angle], COLOURS.doubt, 2 * unit);
  }
}

function ellipse(context, [u, v, major, minor, angle], colour, width, dash = []) {
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  context.ellipse(u, v, major, minor, (angle * Math.PI) / 180, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
}

// Where nothing was found: the dark spots, and the dots of the guess that came nearest, dashed where none is there.
function drawSearch(context, search, unit) {
  for (const spot of search.spots) ellipse(context, spot, COLOURS.spot, unit);
  if (!hasGuess(search)) return;
  for (const dot of search.dots) {
    if (isSeen(dot)) ellipse(context, dot, COLOURS.doubt, 2 * unit);
    else ellipse(context, dot, COLOURS.hidden, 1.5 * unit, [3 * unit, 3 * unit]);
  }
}

function drawPose(context, camera, pose, dots, unit) {
  const project = projector(camera, pose);
  chain(context, circle([0, 0, 0], camera.ring_mm, 96).map(project), COLOURS.ring, unit);
  for (let dot = 0; dot < 9; ++dot) {
    const isSeen = dots[dot][5] > 0;
    const outline = circle(dotCentre(camera, dot), dot === 8 ? camera.centre_mm : camera.dot_mm).map(project);
    chain(context, outline, isSeen ? COLOURS.disc : COLOURS.hidden, (isSeen ? 1.5 : 2) * unit, isSeen ? [] : [8 * unit, 8 * unit]);
  }
  const middle = project([0, 0, 0]);
  for (const [axis, direction, colour] of AXES) {
    const tip = project(direction.map((value) => value * 0.75 * camera.ring_mm));
    if (!middle || !tip) continue;
    chain(context, [middle, tip], "rgba(0,0,0,.8)", 5 * unit);
    chain(context, [middle, tip], colour, 3 * unit);
    label(context, axis, [tip[0] + 8 * unit, tip[1] - 8 * unit], colour, 13 * unit);
  }
  drawSeen(context, dots, unit);
  const outside = camera.ring_mm + 2.4 * camera.dot_mm;
  for (let dot = 0; dot < 8; ++dot) {
    const at = project(dotCentre(camera, dot).map((value) => (value * outside) / camera.ring_mm));
    if (at) label(context, `P${dot + 1}`, at, dots[dot][5] > 0 ? "#f0f0f0" : COLOURS.hidden, 12 * unit);
  }
}

// The outline of a reading that is not believed, and the odds against it.
function drawOther(context, camera, candidate, text, unit) {
  const project = projector(camera, candidate);
  const ring = circle([0, 0, 0], camera.ring_mm, 64).map(project);
  chain(context, ring, COLOURS.other, 0.8 * unit, [4 * unit, 4 * unit]);
  const tip = project([0, 0.75 * camera.ring_mm, 0]);
  const middle = project([0, 0, 0]);
  if (!tip || !middle) return;
  chain(context, [middle, tip], COLOURS.other, unit, [4 * unit, 4 * unit]);
  if (text) label(context, text, [tip[0], tip[1] - 12 * unit], COLOURS.other, 11 * unit);
}

export function spanOf(camera, frame) {
  const points = frame.valid
    ? Array.from({ length: 8 }, (_, dot) => projector(camera, frame.in_landmark)(dotCentre(camera, dot))).filter(Boolean)
    : frame.dots.filter((dot) => dot[5] > 0).map(([u, v]) => [u, v]);
  if (points.length < 2) return null;
  const us = points.map((p) => p[0]);
  const vs = points.map((p) => p[1]);
  const low = [Math.min(...us), Math.min(...vs)];
  const high = [Math.max(...us), Math.max(...vs)];
  return { middle: [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2], size: Math.max(high[0] - low[0], high[1] - low[1]) };
}

function drawFound(context, camera, frame, options, unit) {
  if (options.candidates) {
    for (const landmark of frame.landmarks)
      landmark.candidates.forEach((candidate, i) => {
        const isMain = landmark.id === frame.landmark && i === landmark.chosen && frame.valid;
        if (!isMain && candidate.chi2 < EXCLUDED_CHI2) drawOther(context, camera, candidate, i === landmark.chosen && landmark.reason ? `${landmark.id}: ${landmark.why}` : "", unit);
      });
  }
  if (frame.valid) drawPose(context, camera, frame.in_landmark, frame.dots, unit);
  else drawOutlines(context, frame.dots, unit);
}

function drawBrackets(context, { middle, size }, unit) {
  const half = Math.max(size * 0.8, 14 * unit);
  for (const sx of [-1, 1])
    for (const sy of [-1, 1]) {
      const corner = [middle[0] + sx * half, middle[1] + sy * half];
      const arm = half / 3;
      chain(context, [[corner[0] - sx * arm, corner[1]], corner, [corner[0], corner[1] - sy * arm]], COLOURS.disc, 2 * unit);
    }
}

// canvas: any size; the picture fills its width. options: {overlay, candidates}
export function draw(canvas, picture, camera, frame, options) {
  const context = canvas.getContext("2d");
  const scale = canvas.width / camera.width;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.imageSmoothingEnabled = scale < 2;
  if (picture) context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  if (!options.overlay || !frame) return;
  // Pixel centres are integers: half a pixel from the picture's corner.
  const place = (s, origin) => context.setTransform(s, 0, 0, s, s * (0.5 - origin[0]), s * (0.5 - origin[1]));
  const line = Math.max(1, canvas.width / 900);
  const span = spanOf(camera, frame);
  place(scale, [0, 0]);
  if (frame.search && options.candidates) drawSearch(context, frame.search, line / scale);
  if (!span || span.size > SMALL_PX) return drawFound(context, camera, frame, options, line / scale);
  drawBrackets(context, span, line / scale);
  // The cut-out, in the corner that is furthest from the landmark.
  const side = canvas.height * 0.46;
  const zoom = side / (span.size * 1.75);
  const left = span.middle[0] < camera.width / 2 ? canvas.width - side - 8 * line : 8 * line;
  const top = span.middle[1] < camera.height / 2 ? canvas.height - side - 8 * line : 8 * line;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.save();
  context.beginPath();
  context.rect(left, top, side, side);
  context.clip();
  const origin = [span.middle[0] - side / 2 / zoom, span.middle[1] - side / 2 / zoom];
  context.translate(left, top);
  context.imageSmoothingEnabled = false;
  context.fillStyle = "#000";
  context.fillRect(0, 0, side, side);
  if (picture) context.drawImage(picture, (0.0 - origin[0]) * zoom, (0.0 - origin[1]) * zoom, camera.width * zoom, camera.height * zoom);
  context.translate((0.5 - origin[0]) * zoom, (0.5 - origin[1]) * zoom);
  context.scale(zoom, zoom);
  drawFound(context, camera, frame, options, line / zoom);
  context.restore();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.strokeStyle = COLOURS.disc;
  context.lineWidth = 2 * line;
  context.strokeRect(left, top, side, side);
  label(context, `${zoom / scale >= 10 ? Math.round(zoom / scale) : (zoom / scale).toFixed(1)} x`, [left + 26 * line, top + side - 14 * line], "#fff", 13 * line);
}
