// What the sensor sees now, and what it makes of it.
import { decimalsFor, element, fixed, saveAs, setText, tellNoFrame, tellVerdict } from "./dom.js";
import { draw } from "./overlay.js";
import { lines } from "./plot.js";
import { whyNothing } from "./search.js";

const ADVICE = {
  2: "Is the sheet in view, lit, and printed as `ninedot pattern` makes it? Nothing in this picture has nine dots on a ring.",
  3: "Too little of the sheet is visible: clear the view, or look at it less from the side.",
  4: "Check the camera's cable and supply; the service goes on looking for it.",
  5: "width_px and height_px of [camera] and the calibration must be of this camera's pictures.",
  6: "The recording or the camera gives a damaged picture.",
  10: "Come nearer, or look at the sheet at an angle: seen straight from far, its mirror image fits as well.",
  11: "Come nearer, light it better, or calibrate: the pose would be too uncertain. `max_sigma_percent` sets the limit.",
  12: "It resembles a landmark and is none, or is bent or soiled: look at the picture.",
  13: "Much in this picture looks like dots: the search goes on in the next frame.",
  14: "No code could be read: more light on the sheet, or less motion.",
  15: "The sheet was moved: hang it back, or make the map anew with `ninedot map`.",
  16: "The zoom moves, or stands where it was not calibrated: `ninedot calibrate zoom`.",
};

const [NO_LANDMARK, CROWDED] = [2, 13];

// A picture that is older is not shown as if it were new.
const STALE_MS = 1500;

export class LiveView {
  constructor(main, shared) {
    this.shared = shared;
    this.wantsPicture = true;
    this.isFrozen = false;
    this.options = { overlay: true, candidates: true };
    const toggle = (key, text, title) => {
      const button = element("button", { type: "button", title, "aria-pressed": "true", onclick: () => {
        this.options[key] = !this.options[key];
        button.setAttribute("aria-pressed", String(this.options[key]));
        this.redraw();
      } }, text);
      return button;
    };
    this.freezeButton = element("button", { type: "button", title: "Hold this picture (f)", "aria-pressed": "false", onclick: () => this.freeze() }, "Freeze");
    this.fullButton = element("button", { type: "button", title: "Over the whole window (Esc ends)", "aria-pressed": "false", onclick: () => this.toggleFull() }, "Full size");
    this.canvas = element("canvas", { id: "picture", role: "img", "aria-label": "the newest picture with what was found in it", width: 640, height: 480 });
    this.age = element("span.soft");
    this.stage = element("section.card.stage", {}, this.canvas, element("div.tools", {}, this.freezeButton, toggle("overlay", "Overlay", "What was found, drawn over the picture"),
      toggle("candidates", "Other readings", "Readings of the picture that are not believed, thin and dashed; where nothing is found, the dark spots and the nearest guess"),
      this.fullButton, element("button", { type: "button", title: "As PNG, as it is shown (s)", onclick: () => this.save() }, "Save"),
      element("span.spacer"), this.age));
    this.verdict = element("div.verdict", { id: "verdict", role: "status" });
    this.pose = element("table.pose", { id: "pose" });
    this.facts = element("table.facts");
    const plot = (title, ...more) => {
      const canvas = element("canvas", { role: "img", "aria-label": `${title}, over the last minute` });
      return [canvas, element("section.card", {}, element("h2", {}, title, ...more), canvas)];
    };
    const [positions, positionCard] = plot("Position from its mean, mm ", ...["x", "y", "z"].map((name) => element(`span.axis.${name}`, {}, ` ${name}`)));
    const [sigmas, sigmaCard] = plot("1-sigma of the position, mm");
    const [latencies, latencyCard] = plot("Latency, ms");
    Object.assign(this, { positions, sigmas, latencies });
    main.append(element("div.live", {}, this.stage, element("section.card", {}, this.verdict, this.pose, this.facts)),
      element("div.plots", {}, positionCard, sigmaCard, latencyCard));
    this.resized = () => this.redraw();
    window.addEventListener("resize", this.resized);
    this.ended = (event) => { if (event.key === "Escape" && this.stage.classList.contains("full")) this.toggleFull(); };
    window.addEventListener("keydown", this.ended);
  }

  leave() {
    window.removeEventListener("resize", this.resized);
    window.removeEventListener("keydown", this.ended);
    this.picture?.close();
  }

  onKey(key) {
    if (key === "f") this.freeze();
    else if (key === "s") this.save();
    else return false;
    return true;
  }

  freeze() {
    this.isFrozen = !this.isFrozen;
    this.freezeButton.setAttribute("aria-pressed", String(this.isFrozen));
    setText(this.freezeButton, this.isFrozen ? "Go on" : "Freeze");
  }

  toggleFull() {
    const isFull = this.stage.classList.toggle("full");
    this.fullButton.setAttribute("aria-pressed", String(isFull));
    this.redraw();
  }

  save() {
    const frame = this.shown?.frame;
    this.canvas.toBlob((blob) => blob && saveAs(`ninedot-frame-${frame?.number ?? 0}.png`, blob), "image/png");
  }

  async update(message) {
    this.drawPlots(message.received);
    if (this.isFrozen) return;
    if (message.fresh) this.freshAt = message.received;
    this.canvas.classList.toggle("stale", message.received - (this.freshAt ?? 0) > STALE_MS);
    if (!message.frame) {
      tellNoFrame(this.verdict, message.problem);
      this.pose.className = "pose stale";
      return;
    }
    this.tell(message);
    if (!message.jpeg) {
      if (message.frame.number !== this.shown?.frame?.number) this.shown = { ...message, number: message.number };
      return;
    }
    const picture = await createImageBitmap(message.jpeg).catch(() => null);
    if (!picture || this.isFrozen) return picture?.close();
    this.picture?.close();
    this.picture = picture;
    this.shown = message;
    this.redraw();
  }

  redraw() {
    if (!this.shown?.camera || !this.picture) return;
    const { camera, frame } = this.shown;
    const width = Math.max(camera.width, Math.round(this.canvas.clientWidth * (window.devicePixelRatio || 1)));
    const height = Math.round((width * camera.height) / camera.width);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    draw(this.canvas, this.picture, camera, frame, this.options);
    this.canvas.dataset.frame = frame.number;
  }

  tell({ frame, camera, service }) {
    const registers = service?.registers;
    const reason = frame.valid ? 0 : (registers?.[5] || frame.reason);
    const isLate = frame.age_ms !== null && frame.age_ms > 500;
    const why = this.shared.registers?.reasons.find((one) => one.code === reason)?.meaning ?? frame.why;
    const kind = frame.valid && !isLate ? (frame.calibrated ? "good" : "warn") : frame.found ? "warn" : "bad";
    const wasSearched = frame.search && (reason === NO_LANDMARK || reason === CROWDED);
    const words = frame.valid && !isLate
      ? [`Landmark ${frame.landmark} found`, frame.calibrated ? (frame.tracking ? "tracking" : "full search") : "not calibrated: run with a camera.yaml of this camera"]
      : [isLate && frame.valid ? "No new frame" : sentence(why), isLate && frame.valid ? ADVICE[4] : wasSearched ? whyNothing(frame.search) : ADVICE[reason] ?? ""];
    tellVerdict(this.verdict, kind, ...words);
    const pose = frame.in_world;
    this.pose.className = frame.valid && !isLate ? "pose" : "pose stale";
    // The same decimals for all three, so that they stand below each other.
    const decimals = decimalsFor(Math.max(...pose.sigma_mm));
    const row = (name, value, sigma, unit) => element("tr", {}, element("th", {}, element(`span.axis.${name}`, {}, name)),
      element("td.n", {}, frame.has_pose ? fixed(value, decimals) : "–"), element("td.n.s", {}, frame.has_pose ? `± ${fixed(sigma, decimals)} ${unit}` : ""));
    const angles = rotationVector(pose.q);
    this.pose.replaceChildren(...["x", "y", "z"].map((name, i) => row(name, pose.mm[i], pose.sigma_mm[i], "mm")),
      ...["x", "y", "z"].map((name, i) => element("tr", {}, element("th", {}, `r${name}`), element("td.n.s", {}, frame.has_pose ? `${fixed(angles[i], 2)}°` : "–"),
        element("td.n.s", {}, frame.has_pose ? `± ${fixed(pose.sigma_deg[i], 3)}°` : ""))));
    const fact = (name, value, kindOf = "") => element("tr", {}, element("th", {}, name), element(`td.n${kindOf ? "." + kindOf : ""}`, {}, value));
    const cuts = Object.entries(frame.cut).filter(([, count]) => count > 0);
    const known = (text) => (frame.has_pose ? text : "–");
    this.facts.replaceChildren(
      fact("age of the pose", frame.age_ms === null ? "none yet" : `${fixed(frame.age_ms, 0)} ms`, isLate ? "bad" : ""),
      fact("odds of another reading", known(odds(frame.ambiguity)), frame.ambiguous ? "warn" : ""),
      fact("dots used", known(`${frame.dots_used} of 9`), frame.valid && frame.dots_used < 9 ? "warn" : ""),
      fact("residual", known(`${fixed(frame.rms_px, 3)} px`)),
      fact("distance", known(`${fixed(frame.distance_mm, 0)} mm`)),
      fact("tilt", known(`${fixed(frame.tilt_deg, 1)}°`)),
      fact("latency", `${fixed(frame.latency_ms, 1)} ms`),
      fact("landmarks in view", `${frame.seen}${frame.rejected ? `, ${frame.rejected} rejected` : ""}`, frame.rejected ? "warn" : ""),
      ...(frame.head ? [fact("head, pan and tilt", `${fixed(frame.head.pan_deg, 1)}° ${fixed(frame.head.tilt_deg, 1)}°`)] : []),
      ...(cuts.length ? [fact("left out by the search since the start", element("span", {}, ...cuts.flatMap(([name, count], i) => [...(i ? [element("br")] : []), `${count} ${name}`])), "warn")] : []),
    );
    setText(this.age, `frame ${frame.number}, ${camera.width} x ${camera.height}`);
  }

  drawPlots(now) {
    const points = this.shared.history.points;
    const valid = points.filter((p) => p.valid);
    const mean = [0, 1, 2].map((i) => valid.reduce((sum, p) => sum + p.mm[i], 0) / (valid.length || 1));
    const of = (pick) => points.map((p) => ({ t: p.t, y: pick(p) }));
    lines(this.positions, ["--x", "--y", "--z"].map((colour, i) => ({ colour, values: of((p) => (p.valid ? p.mm[i] - mean[i] : null)) })), { now, least: 0.1 });
    lines(this.sigmas, [{ colour: "--accent", values: of((p) => (p.valid ? p.sigma : null)) }], { now, least: 0.1, zero: true });
    lines(this.latencies, [{ colour: "--accent", values: of((p) => p.latency) }], { now, least: 1, zero: true });
  }
}

const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1);

const odds = (value) => (value < 0.0005 ? "below 1 in 2000" : `${(100 * value).toFixed(1)} %`);

// Degrees about the world's axes.
function rotationVector([w, x, y, z]) {
  const sine = Math.hypot(x, y, z);
  const scale = sine < 1e-9 ? 0 : ((2 * Math.atan2(sine, w)) / sine) * (180 / Math.PI);
  return [x * scale, y * scale, z * scale];
}
