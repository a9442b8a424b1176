// The wizard of `ninedot calibrate camera`: how to hold the sheet next, drawn into the picture, what there is by now,
// and what came of it.
import { Applying } from "./applying.js";
import { Asking } from "./asking.js";
import { HeadPart } from "./calibrate_head.js";
import { element, fixed, setText, tellVerdict } from "./dom.js";
import { authorised } from "./feed.js";
import { drawCoverage, drawHolding } from "./holding.js";
import { MAP_FIRST, download, placing } from "./made.js";

const PATH = "/api/calibrate";
const ASK_EVERY_MS = 250;
const ASK_AT_REST_MS = 1500;
// What became of the newest picture: kind, words.
const LOOKED = {
  none: ["warn", "No sheet in sight: the whole of it in the picture, evenly lit, not too far away."],
  moving: ["none", "Hold still."],
  seen: ["none", "There is a view of that already: move on."],
  blurred: ["warn", "Too blurred: focus the lens, or give more light."],
  taken: ["good", "Taken."],
};
const ENDS = {
  idle: ["none", "Ready", "Print a landmark, mount it flat, lock focus and zoom. Then start, and bring the sheet to each dashed outline that is drawn into the picture. It takes some four minutes; the service goes on meanwhile."],
  failed: ["bad", "No calibration came of it", ""],
  cancelled: ["none", "Cancelled", "Nothing is kept of it."],
};

// One place, one tilt, one nearness: what else a view is good for is nobody's concern who holds the sheet.
function inShort(meets) {
  const isOther = (name) => /^tilted|^nearer|more$/.test(name);
  const place = meets.find((name) => !isOther(name));
  return [place ? `in the ${place}` : "", ...meets.filter((name) => /^tilted|^nearer/.test(name))].filter(Boolean).join(", ") || "anywhere";
}

export class CalibrateView {
  constructor(main) {
    this.wantsPicture = true;
    this.verdict = element("div.verdict.none", { id: "calibrate-state", role: "status" }, "Asking ...");
    this.looked = element("p.looked", { id: "calibrate-looked", role: "status" });
    this.note = element("p.warn", { id: "calibrate-note", role: "status", hidden: true });
    const button = (id, text, title, order) => element("button", { type: "button", id, title, disabled: true, onclick: () => this.order(order) }, text);
    this.startButton = button("calibrate-start", "Start", "Watches through the running service", "start camera");
    this.finishButton = button("calibrate-finish", "Finish early", "Calibrates with the views that there are", "finish");
    this.cancelButton = button("calibrate-cancel", "Cancel", "Ends it and keeps nothing", "cancel");
    this.canvas = element("canvas", { id: "picture", role: "img", "aria-label": "the newest picture, the sheet in it, and how to hold it next", width: 640, height: 480 });
    this.coverage = element("canvas.coverage", { id: "coverage", role: "img", width: 330, height: 250 });
    this.progress = element("progress", { id: "calibrate-progress", max: 1, value: 0, "aria-label": "how much of it is there" });
    this.wanted = element("p.soft", { id: "calibrate-wanted" });
    this.lacks = element("ul.lacks", { id: "calibrate-lacks" });
    this.going = element("section", { hidden: true }, element("h2", {}, "Views in each part of the picture"), this.coverage, this.progress, this.wanted, this.lacks);
    this.result = element("section.card.result", { id: "calibrate-result", hidden: true });
    this.applying = new Applying("calibrate-applying", { ended: () => this.asking.ask() });
    this.head = new HeadPart(PATH, (text) => this.order(text), this.applying);
    main.append(element("h1", {}, "Calibrate"), element("div.live", {},
      element("section.card.stage", {}, this.canvas, element("div.tools", {}, element("span.mark-ghost", {}, "hold it here"), element("span.mark-sheet", {}, "the sheet now"))),
      element("div.wizards", {}, this.note, element("section.card.wizard", {}, element("h2", {}, "The camera"), this.verdict, this.looked, element("div.tools", {}, this.startButton, this.finishButton, this.cancelButton), this.going), this.head.card)),
    this.applying.card, this.result, this.head.result, this.applying.dialog, this.head.dialog);
    this.asking = new Asking(PATH, (state) => this.tell(state), (state) => (state?.phase === "running" ? ASK_EVERY_MS : ASK_AT_REST_MS));
    this.asking.ask();
  }

  leave() {
    this.asking.end();
    this.applying.end();
    this.picture?.close();
    if (this.url) URL.revokeObjectURL(this.url);
  }

  async order(text) {
    const said = await this.asking.order(text);
    setText(this.note, said);
    this.note.hidden = !said;
    this.asking.ask();
  }

  say(kind, title, words) {
    tellVerdict(this.verdict, kind, title, words);
  }

  tell(state) {
    this.state = state;
    this.head.tell(state);
    const news = state.of === "camera" ? state.news : null;
    const phase = state.of === "camera" ? state.phase : "idle";
    const isRunning = phase === "running";
    this.startButton.disabled = state.phase === "running" || Boolean(state.why_not);
    this.finishButton.disabled = !isRunning || news?.state !== "gathering" || !news.views;
    this.cancelButton.disabled = !isRunning;
    this.going.hidden = !(isRunning && news?.state === "gathering");
    setText(this.looked, "");
    if (state.why_not) this.say("none", "Only to look at", state.why_not);
    else if (isRunning) this.tellRunning(news);
    else if (state.phase === "running" && state.of === "map") this.say(...MAP_FIRST);
    else if (phase === "done") this.say("good", "Calibrated", "What came of it stands below.");
    else this.say(ENDS[phase][0], ENDS[phase][1], phase === "failed" ? state.why || news?.why || "" : ENDS[phase][2]);
    this.tellResult(phase === "done" ? state : null);
    this.redraw();
  }

  tellRunning(news) {
    if (!news) return this.say("none", "Starting ...", "");
    if (news.state !== "gathering") return this.say("none", "Working it out ...", `${news.what ?? ""}: the sheet may be put down. Some ten seconds on a PC, minutes on a small board.`);
    const { ghost, wanted, looked } = news;
    this.say("none", ghost ? `Bring the sheet to the dashed outline: ${inShort(ghost.meets)}` : wanted.length ? `Next: ${wanted[0]}` : "That is enough",
      "Hold it still there for a second. Any other place that is new counts as well.");
    const [kind, words] = LOOKED[looked] ?? ["none", ""];
    this.looked.className = `looked ${kind}`;
    setText(this.looked, words);
    drawCoverage(this.coverage, news);
    this.coverage.setAttribute("aria-label", `views in the nine parts, row by row: ${news.parts.join(", ")}`);
    const open = wanted.length === 1 && /^\d+ more$/.test(wanted[0]) ? parseInt(wanted[0], 10) : null;
    // The views that a good calibration has, or more where a corner needs them.
    this.progress.max = Math.max(30, news.views + (open ?? wanted.length));
    this.progress.value = news.views;
    setText(this.wanted, `${news.views} ${news.views === 1 ? "view" : "views"}; wanted: ${wanted.length ? wanted.join(", ") : "nothing"}`);
    if (this.lacks.dataset.said !== news.lacks.join()) {
      this.lacks.dataset.said = news.lacks.join();
      this.lacks.replaceChildren(...news.lacks.map((lack) => element("li", {}, lack)));
    }
  }

  async tellResult(state) {
    const name = state?.name ?? "";
    if (name === this.shownResult) return;
    this.shownResult = name;
    this.result.hidden = !state;
    if (!state) return;
    const { news } = state;
    const millimetres = (px) => fixed((1000 * px) / news.focal_px[0], 3);
    const fact = (title, value) => element("tr", {}, element("th", {}, title), element("td.n", {}, value));
    const drawing = element("img", { id: "calibrate-drawing", alt: "where the sheet was seen, how far outlines are off, and the expected error of directions" });
    this.result.replaceChildren(
      element("h2", {}, `Calibration ${name}`),
      element("p", {}, `A direction is known to ${fixed(news.directions_px, 3)} px, ${fixed(news.directions_worst_px, 3)} px where it is least certain: at a metre ${millimetres(news.directions_px)} and ${millimetres(news.directions_worst_px)} mm. A tenth of a pixel is good.`),
      drawing,
      element("table.facts", {}, fact("lens model", news.model), fact("focal length", `${news.focal_px.map((px) => fixed(px, 2)).join(", ")} px`), fact("centre", `${news.centre_px.map((px) => fixed(px, 2)).join(", ")} px`),
        fact("views", String(news.views)), fact("outlines are off by", `${fixed(news.outlines_px, 3)} px`)),
      ...(news.wish ? [element("p.warn", {}, news.wish)] : []),
      element("div.tools", {}, element("button", { type: "button", id: "calibrate-download", onclick: () => download(PATH, name, "camera.yaml") }, "Download camera.yaml")),
      element("h2", {}, "Use this"),
      ...placing(state, { path: PATH, id: "calibrate", file: "camera.yaml", option: "--calibration", applying: this.applying, question: `Use calibration ${name}?`,
        where: state.calibration ? `In the place of ${state.calibration}, which is kept beside it.` : `As camera.yaml beside ${state.config}, with a line in that which names it.` }));
    const response = await authorised(`${PATH}/${name}/camera.svg`).catch(() => null);
    if (!response?.ok || !this.asking.isAlive || this.shownResult !== name) return;
    if (this.url) URL.revokeObjectURL(this.url);
    this.url = URL.createObjectURL(await response.blob());
    drawing.src = this.url;
  }

  async update(message) {
    if (!message.jpeg) return;
    const picture = await createImageBitmap(message.jpeg).catch(() => null);
    if (!picture || !this.asking.isAlive) return picture?.close();
    this.picture?.close();
    this.picture = picture;
    this.redraw();
  }

  redraw() {
    if (!this.picture) return;
    const news = this.state?.of === "camera" && this.state.phase === "running" && this.state.news?.state === "gathering" ? this.state.news : null;
    drawHolding(this.canvas, this.picture, news);
  }
}
