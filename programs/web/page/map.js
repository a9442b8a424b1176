// From above: where the landmarks hang, where the camera is, how sure that is, and where it came from.
import { element, fixed, setText } from "./dom.js";
import { MapBuild } from "./map_build.js";
import { colour, fitted, niceStep } from "./plot.js";
import { rotationOf, times } from "./projection.js";

// Of the plan, beyond what there is to see, on each side.
const MARGIN = 0.12;

const sightingOf = (landmark, frame) => frame?.landmarks.find((one) => one.id === landmark.id);
const inkOf = (seen) => colour(!seen ? "--soft" : seen.reason ? "--warn" : "--good");

export class MapView {
  constructor(main, shared) {
    this.shared = shared;
    this.canvas = element("canvas", { id: "plan", role: "img", "aria-label": "plan of the world from above" });
    this.text = element("p.soft", { id: "place", role: "status" });
    main.append(element("h1", {}, "Map, from above"), this.text, element("section.card.map", {}, this.canvas),
      this.sightings = element("section.card", { id: "sightings", hidden: true }),
      element("p.soft", {}, "Ellipse: 2-sigma along the world's axes. Path: the last minute. A landmark's tick: where it faces; a dashed line: it is in sight. The arrow: the camera, and where it looks; the square: the robot, where [body] says that the camera sits elsewhere on it."));
    this.build = new MapBuild();
    main.append(...this.build.nodes);
    this.bounds = null;
  }

  leave() {
    this.build.leave();
  }

  update(message) {
    this.message = message;
    const points = this.shared.history.points.filter((p) => p.valid);
    const frame = message.frame;
    this.draw(points, frame);
    this.listSightings(frame?.landmarks ?? []);
    if (!frame?.has_pose) return setText(this.text, "No pose yet.");
    const [x, y, z] = frame.in_world.mm;
    setText(this.text, `Camera at x ${fixed(x, 0)}, y ${fixed(y, 0)}, z ${fixed(z, 0)} mm, 2-sigma ± ${fixed(2 * frame.in_world.sigma_mm[0], 1)}, ${fixed(2 * frame.in_world.sigma_mm[1], 1)} mm` +
      `${frame.valid ? "" : `; not valid: ${frame.why}`}; landmarks of the map: ${this.shared.map.length}.`);
  }

  // The landmarks of the newest frame, and what each of them was worth.
  listSightings(landmarks) {
    this.sightings.hidden = !landmarks.length;
    const head = element("tr", {}, ...["id", "m", "dots", "quality", "px", ""].map((name) => element("th", {}, name)));
    const rows = [...landmarks].sort((a, b) => a.id - b.id).map((one) => {
      const reading = one.candidates[one.chosen];
      return element("tr", {}, element("th", {}, String(one.id)), element("td.n", {}, reading ? (Math.hypot(...reading.mm) / 1000).toFixed(2) : "–"),
        element("td.n", {}, String(one.dots)), element("td.n", {}, String(one.quality)), element("td.n", {}, reading ? fixed(reading.rms_px, 3) : "–"),
        element(`td${one.reason ? ".warn" : ""}`, {}, one.reason ? one.why : "counts"));
    });
    this.sightings.replaceChildren(element("h2", {}, "In sight"), element("table.facts", {}, head, ...rows));
  }

  // Grows with what is shown; shrinks only when most of it is empty, so that the plan does not breathe.
  fit(places) {
    const wanted = [0, 1].map((i) => [Math.min(...places.map((p) => p[i])), Math.max(...places.map((p) => p[i]))]);
    const size = Math.max(1000, wanted[0][1] - wanted[0][0], wanted[1][1] - wanted[1][0]);
    const inside = this.bounds && wanted.every(([low, high], i) => low >= this.bounds[i][0] && high <= this.bounds[i][1]);
    if (inside && size > 0.5 * this.size) return;
    this.size = size * (1 + 2 * MARGIN);
    this.bounds = wanted.map(([low, high]) => [(low + high - this.size) / 2, (low + high + this.size) / 2]);
  }

  draw(points, frame) {
    const { context, width, height } = fitted(this.canvas);
    const landmarks = this.shared.map;
    const places = [...landmarks.map((l) => l.mm), ...points.map((p) => p.mm), ...(frame?.has_pose ? [frame.in_world.mm] : [])];
    if (!places.length) places.push([0, 0, 0]);
    this.fit(places);
    const scale = Math.min(width, height) / this.size;
    const centre = this.bounds.map(([low, high]) => (low + high) / 2);
    const at = ([x, y]) => [width / 2 + (x - centre[0]) * scale, height / 2 - (y - centre[1]) * scale];
    this.drawGrid(context, width, height, scale, centre, at);
    this.drawPath(context, points, at);
    if (frame?.valid) this.drawSightings(context, frame, landmarks, at);
    for (const landmark of landmarks) this.drawLandmark(context, landmark, frame, at);
    if (frame?.has_pose) this.drawCamera(context, frame, at, scale);
  }

  drawGrid(context, width, height, scale, centre, at) {
    const step = niceStep(width / scale, 8);
    context.lineWidth = 1;
    context.strokeStyle = colour("--line");
    context.fillStyle = colour("--soft");
    const range = (middle, pixels) => {
      const half = pixels / scale / 2;
      const list = [];
      for (let v = Math.ceil((middle - half) / step) * step; v < middle + half; v += step) list.push(v);
      return list;
    };
    context.beginPath();
    for (const x of range(centre[0], width)) {
      const [px] = at([x, 0]);
      context.moveTo(Math.round(px) + 0.5, 0);
      context.lineTo(Math.round(px) + 0.5, height);
      context.textAlign = "center";
      if (px > 60) context.fillText(`${(x / 1000).toFixed(step < 1000 ? 1 : 0)}`, px, height - 6);
    }
    for (const y of range(centre[1], height)) {
      const [, py] = at([0, y]);
      context.moveTo(0, Math.round(py) + 0.5);
      context.lineTo(width, Math.round(py) + 0.5);
      context.textAlign = "left";
      if (py < height - 24) context.fillText(`${(y / 1000).toFixed(step < 1000 ? 1 : 0)}`, 6, py - 4);
    }
    context.stroke();
    context.textAlign = "right";
    context.fillText("x to the right, y up, in m", width - 8, 16);
  }

  drawPath(context, points, at) {
    context.strokeStyle = colour("--accent");
    context.lineWidth = 1.5;
    context.globalAlpha = 0.55;
    context.beginPath();
    points.forEach((point, i) => {
      const before = points[i - 1];
      const isGap = !before || point.t - before.t > 1000 || Math.hypot(point.mm[0] - before.mm[0], point.mm[1] - before.mm[1]) > 500;
      context[isGap ? "moveTo" : "lineTo"](...at(point.mm));
    });
    context.stroke();
    context.globalAlpha = 1;
  }

  // From the camera to what it sees.
  drawSightings(context, frame, landmarks, at) {
    context.lineWidth = 1;
    context.setLineDash([5, 5]);
    for (const landmark of landmarks) {
      const seen = sightingOf(landmark, frame);
      if (!seen) continue;
      context.strokeStyle = inkOf(seen);
      context.beginPath();
      context.moveTo(...at(frame.in_world.mm));
      context.lineTo(...at(landmark.mm));
      context.stroke();
    }
    context.setLineDash([]);
  }

  drawLandmark(context, landmark, frame, at) {
    const seen = sightingOf(landmark, frame);
    const heading = (landmark.heading_deg * Math.PI) / 180;
    const facing = landmark.q ? times(rotationOf(landmark.q), [0, 1, 0]) : [-Math.sin(heading), Math.cos(heading)];
    const [x, y] = at(landmark.mm);
    context.strokeStyle = context.fillStyle = inkOf(seen);
    context.lineWidth = 5;
    context.beginPath();
    context.moveTo(x + 12 * facing[1], y + 12 * facing[0]);
    context.lineTo(x - 12 * facing[1], y - 12 * facing[0]);
    context.stroke();
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + 16 * facing[0], y - 16 * facing[1]);
    context.stroke();
    context.textAlign = "center";
    context.font = "600 14px system-ui, sans-serif";
    context.fillText(String(landmark.id), x - 24 * facing[0], y + 24 * facing[1] + 5);
    context.font = "12px system-ui, sans-serif";
  }

  // The body's origin and its x, forward.
  drawBody(context, frame, at) {
    const { mm, q } = frame.body;
    if (Math.hypot(mm[0] - frame.in_world.mm[0], mm[1] - frame.in_world.mm[1]) < 1) return;
    const ahead = times(rotationOf(q), [1, 0, 0]);
    context.save();
    context.translate(...at(mm));
    context.rotate(Math.atan2(-ahead[1], ahead[0]));
    context.strokeStyle = colour("--ink");
    context.lineWidth = 2;
    context.strokeRect(-12, -9, 24, 18);
    context.beginPath();
    context.moveTo(4, -9);
    context.lineTo(12, 0);
    context.lineTo(4, 9);
    context.stroke();
    context.restore();
  }

  drawCamera(context, frame, at, scale) {
    this.drawBody(context, frame, at);
    const pose = frame.in_world;
    const [x, y] = at(pose.mm);
    const ahead = times(rotationOf(pose.q), [0, 0, 1]);
    const angle = Math.atan2(-ahead[1], ahead[0]);
    const ink = frame.valid ? "--accent" : "--soft";
    context.fillStyle = context.strokeStyle = colour(ink);
    context.globalAlpha = 0.25;
    context.beginPath();
    context.ellipse(x, y, Math.max(2, 2 * pose.sigma_mm[0] * scale), Math.max(2, 2 * pose.sigma_mm[1] * scale), 0, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
    context.save();
    context.translate(x, y);
    context.rotate(angle);
    context.beginPath();
    context.moveTo(16, 0);
    context.lineTo(-9, 9);
    context.lineTo(-4, 0);
    context.lineTo(-9, -9);
    context.closePath();
    context.fill();
    context.restore();
  }
}
