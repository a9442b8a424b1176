// From above: where the landmarks hang, where the camera is, how sure that is, and where it came from.
import { element, fixed, setText } from "./dom.js";
import { MapBuild } from "./map_build.js";
import { Plan } from "./plan.js";
import { colour } from "./plot.js";
import { rotationOf, times } from "./projection.js";

const sightingOf = (landmark, frame) => frame?.landmarks.find((one) => one.id === landmark.id);
const inkOf = (seen) => colour(!seen ? "--soft" : seen.reason ? "--warn" : "--good");

export class MapView {
  constructor(main, shared) {
    this.shared = shared;
    const canvas = element("canvas", { id: "plan", role: "img", "aria-label": "plan of the world from above" });
    this.text = element("p.soft", { id: "place", role: "status" });
    main.append(element("h1", {}, "Map, from above"), this.text, element("section.card.map", {}, canvas),
      this.sightings = element("section.card", { id: "sightings", hidden: true }),
      element("p.soft", {}, "Ellipse: 2-sigma along the world's axes. Path: the last minute. A landmark's tick: where it faces; a dashed line: it is in sight. The arrow: the camera, and where it looks; the square: the robot, where [body] says that the camera sits elsewhere on it."));
    this.build = new MapBuild();
    main.append(...this.build.nodes);
    this.plan = new Plan(canvas);
  }

  leave() {
    this.build.leave();
  }

  update(message) {
    this.message = message;
    const points = this.shared.history.points.filter((p) => p.valid);
    const frame = message.frame;
    this.draw(points, frame);
    this.build.draw();
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

  draw(points, frame) {
    const { plan } = this;
    const landmarks = this.shared.map;
    plan.begin([...landmarks.map((l) => l.mm), ...points.map((p) => p.mm), ...(frame?.has_pose ? [frame.in_world.mm] : [])]);
    const { context, at } = plan;
    this.drawPath(context, points, at);
    if (frame?.valid) this.drawSightings(context, frame, landmarks, at);
    for (const landmark of landmarks) plan.landmark(landmark, inkOf(sightingOf(landmark, frame)));
    if (frame?.has_pose) this.drawCamera(context, frame, at);
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

  drawCamera(context, frame, at) {
    this.drawBody(context, frame, at);
    const pose = frame.in_world;
    const [x, y] = at(pose.mm);
    const ahead = times(rotationOf(pose.q), [0, 0, 1]);
    const angle = Math.atan2(-ahead[1], ahead[0]);
    const ink = frame.valid ? "--accent" : "--soft";
    this.plan.ellipse(pose.mm, pose.sigma_mm.slice(0, 2).map((sigma) => 2 * sigma), colour(ink));
    context.fillStyle = context.strokeStyle = colour(ink);
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
