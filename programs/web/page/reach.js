// What the head can reach, as it would see it from its middle: pan to the left, tilt upwards.
import { colour, fitted, niceStep } from "./plot.js";
import { rotationOf, transposedTimes } from "./projection.js";

const DEG = 180 / Math.PI;
const MARGIN = 0.08;

// Pan and tilt that would bring the landmark to the middle of the picture, for a camera that sits on the crossing of
// the head's axes and looks along with it. [deg]; null: none is seen
export function landmarkDirection(frame) {
  if (!frame?.found || !frame.has_pose || !frame.head) return null;
  const [x, y, z] = transposedTimes(rotationOf(frame.in_landmark.q), frame.in_landmark.mm.map((value) => -value));
  const [pan, tilt] = [frame.head.pan_deg / DEG, frame.head.tilt_deg / DEG];
  const up = z * Math.sin(tilt) - y * Math.cos(tilt);
  const level = z * Math.cos(tilt) + y * Math.sin(tilt);
  const ahead = level * Math.cos(pan) + x * Math.sin(pan);
  const left = level * Math.sin(pan) - x * Math.cos(pan);
  return [Math.atan2(left, ahead) * DEG, Math.atan2(up, Math.hypot(ahead, left)) * DEG];
}

// limits: {pan: {min, max}, tilt: {min, max}}; at, to, landmark: [pan, tilt] or null; view: half the picture's angles;
// stops: [{at, isSeen}], where it stood, and whether a landmark was in sight
export function drawReach(canvas, { limits, at, to, landmark, view, stops = [] }) {
  const { context, width, height } = fitted(canvas);
  const span = [limits.pan, limits.tilt].map(({ min, max }) => Math.max(10, max - min) * (1 + 2 * MARGIN));
  const scale = Math.min((width - 56) / span[0], (height - 28) / span[1]);
  const middle = [limits.pan, limits.tilt].map(({ min, max }) => (min + max) / 2);
  const place = ([pan, tilt]) => [(width + 40) / 2 - (pan - middle[0]) * scale, (height - 22) / 2 - (tilt - middle[1]) * scale];
  const box = (low, high) => {
    const [x0, y0] = place([high[0], high[1]]);
    const [x1, y1] = place([low[0], low[1]]);
    return [x0, y0, x1 - x0, y1 - y0];
  };
  const inside = box([limits.pan.min, limits.tilt.min], [limits.pan.max, limits.tilt.max]);
  context.fillStyle = colour("--paper");
  context.fillRect(...inside);
  drawGrid(context, limits, place);
  context.lineWidth = 2;
  context.strokeStyle = colour("--ink");
  context.strokeRect(...inside);
  if (at && view) {
    context.setLineDash([5, 4]);
    context.lineWidth = 1.5;
    context.strokeStyle = colour("--accent");
    context.strokeRect(...box([at[0] - view[0], at[1] - view[1]], [at[0] + view[0], at[1] + view[1]]));
    context.setLineDash([]);
  }
  for (const stop of stops) drawStop(context, place(stop.at), stop.isSeen);
  if (landmark) drawLandmark(context, place(landmark));
  if (to) drawCross(context, place(to));
  if (at) drawDot(context, place(at));
}

function drawGrid(context, limits, place) {
  context.lineWidth = 1;
  context.strokeStyle = colour("--line");
  context.fillStyle = colour("--soft");
  const marks = ({ min, max }) => {
    const step = niceStep(Math.max(10, max - min), 6);
    return Array.from({ length: Math.floor((max - min) / step) + 2 }, (_, i) => Math.ceil(min / step - 1e-9) * step + i * step).filter((v) => v <= max + 1e-9);
  };
  const line = (from, to) => {
    context.beginPath();
    context.moveTo(...place(from));
    context.lineTo(...place(to));
    context.stroke();
  };
  context.textAlign = "center";
  for (const pan of marks(limits.pan)) {
    line([pan, limits.tilt.min], [pan, limits.tilt.max]);
    context.fillText(`${pan}°`, place([pan, 0])[0], place([0, limits.tilt.min])[1] + 16);
  }
  context.textAlign = "right";
  for (const tilt of marks(limits.tilt)) {
    line([limits.pan.min, tilt], [limits.pan.max, tilt]);
    context.fillText(`${tilt}°`, place([limits.pan.max, 0])[0] - 6, place([0, tilt])[1] + 4);
  }
}

function drawDot(context, [x, y]) {
  context.fillStyle = colour("--accent");
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.fill();
}

function drawStop(context, [x, y], isSeen) {
  context.strokeStyle = context.fillStyle = colour(isSeen ? "--good" : "--soft");
  context.lineWidth = 1.5;
  context.beginPath();
  context.arc(x, y, 3.5, 0, 2 * Math.PI);
  if (isSeen) context.fill();
  else context.stroke();
}

function drawCross(context, [x, y]) {
  context.strokeStyle = colour("--warn");
  context.lineWidth = 2;
  context.beginPath();
  for (const [dx, dy] of [[1, 0], [0, 1]]) {
    context.moveTo(x - 11 * dx, y - 11 * dy);
    context.lineTo(x + 11 * dx, y + 11 * dy);
  }
  context.stroke();
}

function drawLandmark(context, [x, y]) {
  context.strokeStyle = context.fillStyle = colour("--good");
  context.lineWidth = 2;
  context.beginPath();
  context.arc(x, y, 9, 0, 2 * Math.PI);
  context.stroke();
  context.beginPath();
  context.arc(x, y, 3, 0, 2 * Math.PI);
  context.fill();
}
