// A recording, frame by frame, with what was found in each picture then. Frames are fetched a few ahead; where the
// network is too slow for the rate some are left out, and the time stays true.
import { element, fixed, setText } from "./dom.js";
import { authorised } from "./feed.js";
import { draw } from "./overlay.js";
import { whyNothing } from "./search.js";

const RATES = [0.1, 0.25, 0.5, 1, 2];
const AHEAD = 6;
const KEPT = 24;

// The rows of frames.csv: [{number, ms since the first}]
export function framesOf(csv) {
  const rows = csv.trim().split("\n").slice(1).map((row) => row.split(","));
  const first = BigInt(rows[0][1]);
  return rows.map(([number, ns]) => ({ number: Number(number), ms: Number(BigInt(ns) - first) / 1e6 }));
}

export class Replay {
  constructor(node, path, name, onClose) {
    Object.assign(this, { name, index: 0, rate: 1, isPlaying: false, kept: new Map(), path: `${path}/${name}` });
    this.canvas = element("canvas", { id: "replay-picture", role: "img", "aria-label": "the recorded picture with what was found in it", width: 640, height: 480 });
    const button = (id, text, title, onclick) => element("button", { type: "button", id, title, onclick }, text);
    this.playButton = button("replay-play", "Play", "Play or pause (space)", () => this.toggle());
    this.overlayButton = button("replay-overlay", "Overlay", "What was found, drawn over the picture (o)", () => this.toggleOverlay());
    this.overlayButton.setAttribute("aria-pressed", "true");
    // What the page leaves to whatever is typed into; arrows, Home and End are the slider's own.
    const typed = (event) => { if ([" ", ",", ".", "o", "Escape"].includes(event.key) && this.onKey(event.key)) event.preventDefault(); };
    this.slider = element("input", { type: "range", id: "replay-slider", "aria-label": "frame", min: 0, max: 0, value: 0, oninput: () => this.seek(Number(this.slider.value)), onkeydown: typed });
    this.rates = element("select", { id: "replay-rate", "aria-label": "rate", onchange: () => this.setRate(Number(this.rates.value)) },
      ...RATES.map((rate) => element("option", { value: rate, selected: rate === 1 }, `${rate} x`)));
    this.where = element("span.soft", { id: "replay-where" });
    this.what = element("p", { id: "replay-what", role: "status" });
    this.hasOverlay = true;
    node.replaceChildren(this.canvas, element("div.tools", {}, button("replay-back", "◀", "One frame back (,)", () => this.step(-1)), this.playButton,
      button("replay-on", "▶", "One frame on (.)", () => this.step(1)), this.slider, this.rates, this.overlayButton, button("replay-close", "Close", "End the replay (Esc)", onClose), this.where), this.what);
    this.onClose = onClose;
    this.resized = () => this.redraw();
    window.addEventListener("resize", this.resized);
  }

  leave() {
    this.isPlaying = false;
    this.isOver = true;
    window.removeEventListener("resize", this.resized);
    for (const one of this.kept.values()) one.then((frame) => frame?.picture.close());
    this.kept.clear();
  }

  onKey(key) {
    const keys = { " ": () => this.toggle(), ",": () => this.step(-1), ".": () => this.step(1), o: () => this.toggleOverlay(), Escape: this.onClose,
      ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), Home: () => this.seek(0), End: () => this.seek(this.frames.length - 1) };
    // A space on a button presses that button.
    if (!this.frames || !Object.hasOwn(keys, key) || (key === " " && document.activeElement?.matches("button"))) return false;
    keys[key]();
    return true;
  }

  async load() {
    try {
      const [csv, camera] = await Promise.all(["frames.csv", "camera.json"].map((file) => authorised(`${this.path}/${file}`)));
      if (!csv.ok || !camera.ok) throw new Error(await (csv.ok ? camera : csv).text());
      this.camera = await camera.json();
      this.frames = framesOf(await csv.text());
    } catch (error) {
      return setText(this.what, `This recording can't be shown: ${error.message} Download it for \`ninedot replay\`.`);
    }
    this.slider.max = this.frames.length - 1;
    await this.seek(0);
  }

  // The picture as the sensor had it, and its report; null where either is missing.
  get(index) {
    if (!this.kept.has(index)) {
      this.kept.set(index, this.fetch(this.frames[index].number).catch(() => null));
      const far = [...this.kept.keys()].filter((one) => one !== this.shownIndex && (one < this.index - 2 || one > this.index + AHEAD));
      for (const one of far.slice(0, Math.max(0, this.kept.size - KEPT))) {
        this.kept.get(one).then((frame) => frame?.picture.close());
        this.kept.delete(one);
      }
    }
    return this.kept.get(index);
  }

  async fetch(number) {
    const digits = String(number).padStart(6, "0");
    const [picture, report] = await Promise.all([`frames/${digits}.png`, `reports/${digits}.json`].map((file) => authorised(`${this.path}/${file}`)));
    if (!picture.ok) throw new Error(await picture.text());
    return { picture: await createImageBitmap(await picture.blob()), report: report.ok ? await report.json() : null };
  }

  async seek(index) {
    if (!this.frames) return;
    this.index = Math.max(0, Math.min(this.frames.length - 1, index));
    const wanted = this.index;
    this.slider.value = wanted;
    const frame = await this.get(wanted);
    // Where somebody went on meanwhile, that frame is shown.
    if (this.isOver || wanted !== this.index) return;
    this.shown = frame;
    this.shownIndex = wanted;
    this.redraw();
    this.tell(frame);
  }

  step(by) {
    this.pause();
    this.seek(this.index + by);
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  pause() {
    this.isPlaying = false;
    setText(this.playButton, "Play");
  }

  setRate(rate) {
    this.rate = rate;
    this.anchor();
  }

  // What is due is counted from here.
  anchor() {
    this.from = { at: performance.now(), ms: this.frames[this.index].ms };
  }

  async play() {
    if (this.index === this.frames.length - 1) await this.seek(0);
    this.isPlaying = true;
    setText(this.playButton, "Pause");
    this.anchor();
    while (this.isPlaying) {
      const due = this.from.ms + (performance.now() - this.from.at) * this.rate;
      let next = this.index;
      while (next + 1 < this.frames.length && this.frames[next + 1].ms <= due) ++next;
      for (let ahead = next; ahead < Math.min(next + AHEAD, this.frames.length); ++ahead) this.get(ahead);
      if (next !== this.index) await this.seek(next);
      if (this.index === this.frames.length - 1) this.pause();
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
  }

  toggleOverlay() {
    this.hasOverlay = !this.hasOverlay;
    this.overlayButton.setAttribute("aria-pressed", String(this.hasOverlay));
    this.redraw();
  }

  redraw() {
    if (!this.shown) return;
    const { camera, canvas } = this;
    const width = Math.max(camera.width, Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)));
    const height = Math.round((width * camera.height) / camera.width);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    draw(canvas, this.shown.picture, camera, this.shown.report, { overlay: this.hasOverlay, candidates: true });
    canvas.dataset.frame = this.frames[this.index].number;
  }

  tell(frame) {
    const { number, ms } = this.frames[this.index];
    const end = this.frames[this.frames.length - 1].ms;
    setText(this.where, `frame ${number}, ${(ms / 1000).toFixed(2)} of ${(end / 1000).toFixed(2)} s`);
    const report = frame?.report;
    this.what.className = report?.valid ? "good" : "warn";
    if (!frame) return setText(this.what, "This picture is missing or damaged.");
    if (!report) return setText(this.what, "What was found in this picture was not kept.");
    const place = report.in_world.mm.map((value, i) => `${"xyz"[i]} ${fixed(value, 1)}`).join(", ");
    setText(this.what, report.valid ? `Landmark ${report.landmark}: ${place} mm, ${report.dots_used} of 9 dots, residual ${fixed(report.rms_px, 3)} px` : `Not valid: ${report.why}.${report.search ? ` ${whyNothing(report.search)}` : ""}`);
  }
}
