// For hands at the lens: how sharp the landmark is while the focus ring turns, and whether light and exposure are right;
// and the latter two set.
import { element, fixed, setText, tellNoFrame, tellVerdict } from "./dom.js";
import { Exposure } from "./exposure.js";
import { lines } from "./plot.js";
import { SPAN_MS } from "./history.js";
import { BLACK, WHITE, SMALLEST_RADIUS_PX, greyOf, rangeOf, sharpnessOf } from "./sharpness.js";

// Of a sharp lens an edge is blurred by the pixels themselves and little more; from about 2 px on poses suffer
// (docs/trust.md, defocus).
const GOOD_PX = 1, POOR_PX = 1.8;
// Blur that one direction has beyond the other's is motion.
const MOTION_RATIO = 1.6;
const PAPER = { low: 90, best: 190, high: 240 };

// [kind, what, what to do] of the worst that is to be mended.
export function judgement(sharp, frame) {
  if (!sharp) return ["bad", "No landmark to judge by", `Hang the sheet where it will be, its dots ${2 * SMALLEST_RADIUS_PX} px wide or more, and turn the focus ring until it is found: the curve below rises.`];
  const exposure = frame.exposure_ms > 0 ? ` (now ${fixed(1000 * frame.exposure_ms, 0)} us)` : "";
  if (sharp.paper >= WHITE - 2) return ["bad", "Over-exposed", `The paper is white beyond measure: a shorter exposure_us${exposure}, less gain, or less light.`];
  const [along, across] = [Math.max(sharp.sideways, sharp.upright), Math.min(sharp.sideways, sharp.upright)];
  if (along > GOOD_PX && along > MOTION_RATIO * across)
    return ["warn", "Blurred by motion", `${sharp.sideways > sharp.upright ? "Sideways" : "Up and down"} more than across it: a shorter exposure_us${exposure} with more light, or stand still to focus.`];
  if (sharp.blur > GOOD_PX) return [sharp.blur > POOR_PX ? "bad" : "warn", "Not sharp", "Turn the focus ring to the lowest value; a lens that stays so is soiled, or set for another distance."];
  if (sharp.paper - sharp.ink < 40) return ["warn", "Little contrast", `Paper and ink are ${fixed(sharp.paper - sharp.ink, 0)} levels apart: light from the front, no mirror of a lamp on the sheet.`];
  if (sharp.paper < PAPER.low || sharp.paper > PAPER.high) {
    const times = PAPER.best / sharp.paper;
    return ["warn", sharp.paper < PAPER.low ? "Dark" : "Nearly over-exposed", `About ${fixed(times, 1)} times the light: exposure_us${exposure}, gain, or lamps.`];
  }
  return ["good", "Sharp and well exposed", "Fix the focus ring, so that nobody turns it: the calibration holds for this focus."];
}

export class FocusView {
  constructor(main) {
    this.wantsPicture = true;
    this.best = null;
    this.values = [];
    this.marks = true;
    this.canvas = element("canvas", { id: "picture", role: "img", "aria-label": "the newest picture, over- and under-exposed parts marked", width: 640, height: 480 });
    this.marksButton = element("button", { type: "button", title: "Mark what is over- or under-exposed (m)", "aria-pressed": "true", onclick: () => this.toggleMarks() }, "Marks");
    this.verdict = element("div.verdict", { id: "verdict", role: "status" });
    this.figure = element("div.figure", { id: "blur" });
    this.facts = element("table.facts");
    this.plot = element("canvas", { role: "img", "aria-label": "blur over the last minute" });
    this.plotTitle = element("h2", {}, "");
    this.exposure = new Exposure();
    main.append(element("div.live", {},
      element("section.card.stage", {}, this.canvas, element("div.tools", {}, this.marksButton, element("span.mark-white", {}, "over-exposed"), element("span.mark-black", {}, "under-exposed"))),
      element("section.card", {}, this.verdict, this.figure, this.facts,
        element("button", { type: "button", title: "Forget the best value so far (r)", onclick: () => this.forget() }, "Begin anew"))),
    element("section.card.wideplot", {}, this.plotTitle, this.plot), this.exposure.node);
  }

  leave() {
    this.hasLeft = true;
    this.exposure.leave();
  }

  onKey(key) {
    if (key === "m") this.toggleMarks();
    else if (key === "r") this.forget();
    else return false;
    return true;
  }

  toggleMarks() {
    this.marks = !this.marks;
    this.marksButton.setAttribute("aria-pressed", String(this.marks));
  }

  forget() {
    this.best = null;
    this.values = [];
  }

  async update(message) {
    if (!message.frame || !message.jpeg) {
      if (!message.frame) tellNoFrame(this.verdict, message.problem);
      return;
    }
    const bitmap = await createImageBitmap(message.jpeg).catch(() => null);
    if (!bitmap) return;
    if (!this.hasLeft) this.show(bitmap, message);
    bitmap.close();
  }

  show(bitmap, { frame, received }) {
    Object.assign(this.canvas, { width: bitmap.width, height: bitmap.height });
    const context = this.canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(bitmap, 0, 0);
    const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const picture = greyOf(pixels);
    const sharp = frame.found || frame.valid ? sharpnessOf(picture, frame.dots) : null;
    const range = rangeOf(picture);
    if (this.marks) {
      picture.values.forEach((value, i) => {
        if (value >= WHITE) pixels.data.set([255, 60, 60], 4 * i);
        else if (value <= BLACK) pixels.data.set([70, 120, 255], 4 * i);
      });
      context.putImageData(pixels, 0, 0);
    }
    this.canvas.dataset.frame = frame.number;
    this.tell(sharp, range, frame);
    this.follow(sharp, range, received);
  }

  tell(sharp, range, frame) {
    tellVerdict(this.verdict, ...judgement(sharp, frame));
    const fact = (name, value) => element("tr", {}, element("th", {}, name), element("td.n", {}, value));
    const percent = (share) => `${fixed(100 * share, share < 0.1 ? 1 : 0)} %`;
    const of = (value, unit, decimals = 0) => (sharp ? `${fixed(value(), decimals)} ${unit}` : "–");
    this.facts.replaceChildren(
      fact("sideways, up and down", sharp ? `${fixed(sharp.sideways, 2)}, ${fixed(sharp.upright, 2)} px` : "–"),
      fact("contrast of paper and ink", of(() => sharp.paper - sharp.ink, "of 255")),
      fact("paper, ink", sharp ? `${fixed(sharp.paper, 0)}, ${fixed(sharp.ink, 0)}` : "–"),
      fact("over-exposed in the picture", percent(range.white)),
      fact("under-exposed", percent(range.black)),
      fact("exposure", frame.exposure_ms > 0 ? `${fixed(frame.exposure_ms, 2)} ms` : "not told"));
  }

  // Blur where there is a landmark: less is better. Else the picture's own detail: more is.
  follow(sharp, range, now) {
    const measure = sharp ? "blur" : "detail";
    if (measure !== this.measure) {
      this.measure = measure;
      this.forget();
    }
    const value = sharp ? sharp.blur : Math.sqrt(range.energy);
    this.best = this.best === null ? value : sharp ? Math.min(this.best, value) : Math.max(this.best, value);
    this.values.push({ t: now, y: value });
    while (now - this.values[0].t > SPAN_MS) this.values.shift();
    const decimals = sharp ? 2 : 1;
    this.figure.replaceChildren(element("strong", {}, `${fixed(value, decimals)}${sharp ? " px" : ""}`),
      element("span.soft", {}, sharp ? " blur of the edges, 1-sigma; best " : " detail; best "), element("span", {}, fixed(this.best, decimals)));
    setText(this.plotTitle, sharp ? "Blur of the landmark's edges, px: turn to the lowest" : "Detail of the whole picture: turn to the highest");
    lines(this.plot, [{ colour: "--soft", values: this.values.map(({ t }) => ({ t, y: this.best })) }, { colour: "--accent", values: this.values }], { now, least: sharp ? 0.5 : 1, zero: Boolean(sharp) });
  }
}
