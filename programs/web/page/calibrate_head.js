// The wizard of `ninedot calibrate pan-tilt`: what the head is about to do, where it has been, and what came of it.
import { element, fixed, setText, tellVerdict } from "./dom.js";
import { MAP_FIRST, download, placing } from "./made.js";
import { drawReach } from "./reach.js";

const ENDS = {
  idle: ["none", "Ready", "The lens must be calibrated before. By how much each axis turns for what it is told, its play, and where axes and camera sit on each other: the head moves before a landmark, by itself, and the service goes on."],
  failed: ["bad", "No calibration came of it", ""],
  cancelled: ["none", "Cancelled", "Nothing is kept of it, and the head does what it did before."],
  done: ["good", "Calibrated", "What came of it stands below."],
};
const range = ({ min, max }) => `${fixed(min, 1)} to ${fixed(max, 1)}°`;
const axisRow = (name, { told, are, spread, play }) => element("tr", {}, element("th", {}, name), element("td.n", {}, `${fixed(told[0], 1)} to ${fixed(told[1], 1)}°`),
  element("td.n", {}, `${fixed(are[0], 2)} to ${fixed(are[1], 2)}°`), element("td.n", {}, play === null ? "unknown" : `${fixed(play, 2)}°`), element("td.n", {}, `${fixed(spread, 3)}°`));

function partOf({ part, stops, planned, inhibited, seen }) {
  if (inhibited) return ["warn", "The inhibit input keeps the head where it is", "It goes on when that is released."];
  const words = seen ? "A landmark is in sight." : "No landmark is in sight.";
  if (part === "find") return ["none", "Looking for a landmark", words];
  if (part === "reach") return ["none", "How far it stays in sight", words];
  return part === "home" ? ["none", "Going back", ""] : ["none", `Stop ${stops + 1} of ${planned}`, words];
}

export class HeadPart {
  // path: of the desk; order: hands it a text; applying: of the view
  constructor(path, order, applying) {
    Object.assign(this, { path, applying, stops: [] });
    const button = (id, text, title, onclick) => element("button", { type: "button", id, title, disabled: true, onclick }, text);
    this.verdict = element("div.verdict.none", { id: "head-state", role: "status" });
    this.startButton = button("head-start", "Start ...", "The head moves by itself", () => this.dialog.showModal());
    this.finishButton = button("head-finish", "Finish early", "Calibrates with the stops that there are", () => order("finish"));
    this.cancelButton = button("head-cancel", "Cancel", "Stops the head and keeps nothing", () => order("cancel"));
    this.progress = element("progress", { id: "head-progress", max: 1, value: 0, "aria-label": "how many of the stops are made" });
    this.canvas = element("canvas", { id: "head-stops", role: "img", "aria-label": "what the head may reach, where it is, and where it saw a landmark" });
    this.going = element("div", { hidden: true }, this.progress, this.canvas);
    this.result = element("section.card.result", { id: "head-result", hidden: true });
    this.moves = element("p", {});
    const close = () => this.dialog.close();
    this.dialog = element("dialog.sure", { "aria-labelledby": "head-sure-title" }, element("h2", { id: "head-sure-title" }, "The head will move by itself"), this.moves,
      element("p", {}, "Is nothing in its way, does the robot stand still, and does a landmark hang a metre or two before it?"),
      element("div.tools", {}, element("button", { type: "button", id: "head-sure", onclick: () => { close(); order("start pan-tilt"); } }, "Move it"), element("button", { type: "button", onclick: close }, "Not now")));
    this.card = element("section.card.wizard", { id: "calibrate-head" }, element("h2", {}, "The pan/tilt head"), this.verdict,
      element("div.tools", {}, this.startButton, this.finishButton, this.cancelButton), this.going);
  }

  tell(state) {
    const { head, news } = state;
    const isOwn = state.of === "pan-tilt";
    const phase = isOwn ? state.phase : "idle";
    const isRunning = phase === "running";
    const whyNot = state.why_not || head.why_not;
    this.startButton.disabled = state.phase === "running" || Boolean(whyNot);
    this.finishButton.disabled = !isRunning || news?.state !== "moving" || !news.stops;
    this.cancelButton.disabled = !isRunning;
    this.going.hidden = !isRunning || news?.state !== "moving";
    setText(this.moves, `Within pan ${range(head.limits.pan)} and tilt ${range(head.limits.tilt)}, for one to three minutes. It looks for a landmark, finds out how far it can turn with one in sight, and stops some 60 times within that. Meanwhile it does not follow; Cancel stops it.`);
    if (whyNot) this.say("none", "Only to look at", whyNot);
    else if (isRunning) this.tellRunning(state);
    else if (state.phase === "running" && state.of === "map") this.say(...MAP_FIRST);
    else this.say(...ENDS[phase].slice(0, 2), phase === "failed" ? state.why || news?.why || "" : ENDS[phase][2]);
    this.tellResult(phase === "done" ? state : null);
  }

  say(kind, title, words) {
    tellVerdict(this.verdict, kind, title, words);
  }

  tellRunning({ news, head, number }) {
    if (!news) return this.say("none", "Starting ...", "");
    if (news.state !== "moving") return this.say("none", "Working it out ...", `${news.what ?? ""}: the head does what it did before.`);
    this.say(...partOf(news));
    if (number !== this.number) Object.assign(this, { number, stops: [], before: null });
    this.progress.max = news.planned || 1;
    this.progress.value = news.planned ? news.stops : 0;
    const at = [news.pan_deg, news.tilt_deg];
    // It stood there: the same angles twice.
    if (this.before?.every((angle, i) => angle === at[i]) && !this.stops.some(({ at: other }) => Math.hypot(other[0] - at[0], other[1] - at[1]) < 0.05)) this.stops.push({ at, isSeen: news.seen });
    this.before = at;
    this.canvas.dataset.stops = this.stops.filter(({ isSeen }) => isSeen).length;
    if (!this.going.hidden) drawReach(this.canvas, { limits: head.limits, at, stops: this.stops });
  }

  tellResult(state) {
    const name = state?.name ?? "";
    if (name === this.shownResult) return;
    this.shownResult = name;
    this.result.hidden = !state;
    if (!state) return;
    const { news } = state;
    this.result.replaceChildren(element("h2", {}, `Calibration ${name}`),
      element("p", {}, `Where a landmark is seen is foretold to ${fixed(news.foretold_deg, 2)}°, at stops that played no part in it; with the configuration as it was to ${fixed(news.before_deg, 2)}°. Most of what is left is play.`),
      element("table.facts", {}, element("tr", {}, ...["", "told", "turned", "play", "spread"].map((title) => element("th", {}, title))), axisRow("pan", news.pan), axisRow("tilt", news.tilt)),
      element("ul.lacks", {}, ...news.lines.filter((line) => !/^(pan|tilt|directions)/.test(line)).map((line) => element("li", {}, line))),
      element("div.tools", {}, element("button", { type: "button", id: "head-download", onclick: () => download(this.path, name, "head.toml") }, "Download head.toml")),
      element("h2", {}, "Use this"),
      ...placing(state, { path: this.path, id: "head", file: "head.toml", option: "--head", applying: this.applying, question: `Use calibration ${name} of the head?`,
        where: `Its numbers take the place of those in [body], [pan_tilt.pan] and [pan_tilt.tilt] of ${state.config}, which is kept beside it.` }));
  }
}
