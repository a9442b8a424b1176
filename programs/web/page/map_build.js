// The map, made by `ninedot map` from recordings that are kept here: which ones, what is given, what came of it, its use.
import { Applying } from "./applying.js";
import { Asking } from "./asking.js";
import { element, fixed, setText, tellVerdict } from "./dom.js";
import { download, placing } from "./made.js";
import { Plan } from "./plan.js";
import { colour } from "./plot.js";
import { PATH as RECORDINGS, beginOf, seconds } from "./recordings.js";

const PATH = "/api/map/build";
const ASK_EVERY_MS = 300;
const ASK_AT_REST_MS = 2000;
const ENDS = {
  idle: ["none", "Ready", "Walk past the landmarks while a recording is made, so that each is in pictures with a neighbour, from two sides, and at last the first one again. Then choose it here."],
  failed: ["bad", "No map came of it", ""],
  cancelled: ["none", "Cancelled", "Nothing is kept of it."],
  done: ["good", "Built", "What came of it stands below."],
};
// Radius of the largest ellipse.
const MOST_PX = 60;
const HOW = { given: "given", joined: "measured, and fitted", found: "found" };
const listOf = (landmarks) => landmarks.map(({ id }) => id).join(", ");

// What may be given: value and words, the best first.
function origins(landmarks) {
  const measured = landmarks.filter((one) => one.measured);
  const placed = landmarks.filter((one) => one.placed);
  return [
    ...(measured.length ? [["measured", measured.length > 1 ? `What was measured: landmarks ${listOf(measured)}` : `Landmark ${measured[0].id}, as configured`]] : []),
    ...(placed.length > measured.length ? [["map", "The whole map as it is: what is new joins it"]] : []),
    ...landmarks.filter((one) => measured.length !== 1 || !one.measured).map(({ id, placed: isPlaced }) => [String(id), `Landmark ${id} alone, ${isPlaced ? "as configured" : "at 0, 0, 0"}`]),
  ];
}

export class MapBuild {
  constructor() {
    this.chosen = null;  // names; null: nobody has chosen yet
    const button = (id, text, title, onclick) => element("button", { type: "button", id, title, disabled: true, onclick }, text);
    this.verdict = element("div.verdict.none", { id: "map-state", role: "status" }, "Asking ...");
    this.note = element("p.warn", { id: "map-note", role: "status", hidden: true });
    this.list = element("ul.choices", { id: "map-recordings", "aria-label": "recordings to build it from" });
    this.empty = element("p.soft", { hidden: true }, "Nothing has been recorded yet: ", element("a", { href: "#recordings" }, "Recordings"), " starts one.");
    this.origin = element("select", { id: "map-origin" });
    this.originId = element("input", { id: "map-origin-id", type: "number", min: 1, max: 160, value: 1 });
    this.originLine = element("label", {}, "What stays where it is", this.origin);
    this.originIdLine = element("label", { hidden: true }, "The sheet that becomes 0, 0, 0: its id", this.originId);
    this.isNew = element("input", { id: "map-new", type: "checkbox" });
    this.startButton = button("map-start", "Build the map", "The service goes on meanwhile", () => this.start());
    this.cancelButton = button("map-cancel", "Cancel", "Ends it and keeps nothing", () => this.order("cancel"));
    this.progress = element("progress", { id: "map-progress", max: 1, value: 0, "aria-label": "how far it is", hidden: true });
    this.fields = element("div.controls", {}, element("fieldset.recorded", {}, element("legend", {}, "From these recordings"), this.empty, this.list), this.originLine, this.originIdLine,
      element("label.check-line", {}, this.isNew, element("span", {}, "Sheets of ", element("code", {}, "ninedot pattern --id"), " that the configuration does not have join the map")));
    this.card = element("section.card.wizard", { id: "map-build" }, element("h2", {}, "Build it from recordings"), this.verdict, this.progress, this.note, this.fields,
      element("div.tools", {}, this.startButton, this.cancelButton));
    this.result = element("section.card.result", { id: "map-result", hidden: true });
    this.applying = new Applying("map-applying", { ended: () => this.asking.ask() });
    this.nodes = [this.card, this.applying.card, this.result, this.applying.dialog];
    this.asking = new Asking(PATH, (state) => this.tell(state), (state) => (state?.phase === "running" ? ASK_EVERY_MS : ASK_AT_REST_MS));
    this.shelf = new Asking(RECORDINGS, ({ recordings }) => this.tellRecordings(recordings), () => ASK_AT_REST_MS);
    for (const asking of [this.asking, this.shelf]) asking.ask();
  }

  leave() {
    for (const one of [this.asking, this.shelf, this.applying]) one.end();
  }

  async order(text) {
    const said = await this.asking.order(text);
    setText(this.note, said);
    this.note.hidden = !said;
    this.asking.ask();
  }

  start() {
    const origin = this.originIdLine.hidden ? this.origin.value : this.originId.value;
    this.order(["start", origin, ...(this.isNew.checked ? ["new"] : []), ...this.chosen].join(" "));
  }

  // Made anew only where they changed: a box that is about to be ticked stays where it is.
  tellRecordings(recordings) {
    const names = recordings.map(({ name }) => name);
    this.chosen = new Set(this.chosen ? names.filter((name) => this.chosen.has(name)) : recordings.filter(({ why }) => why === "asked").slice(0, 1).map(({ name }) => name));
    if (this.listed !== names.join()) {
      this.listed = names.join();
      this.empty.hidden = names.length > 0;
      this.list.replaceChildren(...recordings.map((one) => this.choice(one)));
    }
    this.permit();
  }

  choice({ name, why, ms, frames }) {
    const box = element("input", { type: "checkbox", value: name, checked: this.chosen.has(name), onchange: () => {
      this.chosen[box.checked ? "add" : "delete"](name);
      this.permit();
    } });
    return element("li", {}, element("label.check-line", {}, box, element("span", {}, beginOf(name).toLocaleString("en-GB"), element("small.soft", {}, ` ${seconds(ms)}, ${frames} frames${why === "loss" ? ", landmark lost" : ""}`))));
  }

  tellOrigins(landmarks) {
    const said = JSON.stringify(landmarks);
    if (said === this.origins) return;
    this.origins = said;
    const before = this.origin.value;
    const options = origins(landmarks);
    this.origin.replaceChildren(...options.map(([value, words]) => element("option", { value }, words)));
    if (options.some(([value]) => value === before)) this.origin.value = before;
    this.originLine.hidden = !landmarks.length;
    this.originIdLine.hidden = landmarks.length > 0;
    // Without them there would be nothing to look for.
    this.isNew.disabled = landmarks.length < 2;
    this.isNew.checked ||= this.isNew.disabled;
  }

  permit() {
    const isRunning = this.state?.phase === "running";
    this.startButton.disabled = !this.state || isRunning || Boolean(this.state.why_not) || !this.chosen?.size;
    this.cancelButton.disabled = !isRunning || this.state.of !== "map";
  }

  tell(state) {
    this.state = state;
    const phase = state.of === "map" ? state.phase : "idle";
    const isRunning = phase === "running";
    this.tellOrigins(state.landmarks);
    this.fields.hidden = isRunning || Boolean(state.why_not);
    this.progress.hidden = !isRunning;
    if (state.why_not) this.say("none", "Only to look at", state.why_not);
    else if (isRunning) this.tellRunning(state.news);
    else if (state.phase === "running") this.say("none", "A calibration is under way", "A map can be built when it is over.");
    else this.say(...ENDS[phase].slice(0, 2), phase === "failed" ? this.inWords(state.why || state.news?.why || "") : ENDS[phase][2]);
    this.permit();
    this.tellResult(phase === "done" ? state : null);
  }

  say(kind, title, words) {
    tellVerdict(this.verdict, kind, title, words);
  }

  // The folder says nothing to whoever looks.
  inWords(line) {
    const folder = this.state.folder.replace(/maps$/, "");
    return line.replaceAll(folder, "").replaceAll(/(\d{8}-\d{6}-(?:asked|loss))(?!\/)/g, (name) => `the recording of ${beginOf(name).toLocaleString("en-GB")}`)
      .replace(": give one with --camera FILE", ": calibrate the camera, and record again");
  }

  tellRunning(news) {
    if (!news) return this.say("none", "Starting ...", "");
    if (news.state !== "reading") return this.say("none", "Working it out ...", `${news.what ?? ""}`);
    const { look, recording, recordings, frame, frames } = news;
    this.progress.value = (look - 1 + (recording - 1 + frame / Math.max(1, frames)) / recordings) / 2;
    this.say("none", look === 1 ? "Looking for landmarks" : "Looking again, where they must be", `picture ${frame} of ${frames}${recordings > 1 ? `, recording ${recording} of ${recordings}` : ""}`);
  }

  tellResult(state) {
    const name = state?.name ?? "";
    if (name === this.shownResult) return;
    this.shownResult = name;
    this.result.hidden = !state;
    if (!state) return;
    const { news, map, config } = state;
    const canvas = element("canvas", { id: "map-drawing", role: "img", "aria-label": "the landmarks from above, with their uncertainties" });
    const enlarged = element("p.soft", {});
    const row = ({ id, mm, sigma_mm: sigma, sigma_deg: sigmaDeg, sightings, how, new: isNew }) => element("tr", {}, element("th", {}, String(id)),
      ...mm.map((value) => element("td.n", {}, fixed(Math.round(10 * value) / 10 || 0, 1))), element("td.n", {}, how === "given" ? "–" : fixed(Math.max(...sigma), 1)), element("td.n", {}, how === "given" ? "–" : fixed(sigmaDeg, 2)),
      element("td.n", {}, String(sightings)), element("td", {}, isNew ? `${HOW[how]}, new` : HOW[how]));
    const header = ["id", "x", "y", "z", "± mm", "± °", "seen", ""].map((title, i) => element(i > 0 && i < 7 ? "th.n" : "th", {}, title));
    this.result.replaceChildren(element("h2", {}, `Map ${name}`), element("p", {}, `${news.summary}.`), canvas, enlarged,
      element("div.scroll", {}, element("table.facts", { id: "map-placed" }, element("tr", {}, ...header), ...news.placed.map(row))),
      element("p.soft", {}, "Places in mm; ±: 1-sigma of the least certain direction, beside what is given."),
      ...(news.lines.length ? [element("ul.lacks.warn", { id: "map-lines" }, ...news.lines.map((line) => element("li", {}, this.inWords(line))))] : []),
      ...(news.wish ? [element("p.soft", { id: "map-wish" }, `To make it better: ${news.wish}.`)] : []),
      element("div.tools", {}, ...["map.toml", "plan.svg"].map((file) => element("button", { type: "button", id: `download-${file.replace(".", "-")}`, onclick: () => download(PATH, name, file) }, `Download ${file}`))),
      element("h2", {}, "Use this"),
      ...placing(state, { path: PATH, id: "map", file: "map.toml", option: "--map", applying: this.applying, question: `Use map ${name}?`,
        where: `${map ? `In the place of ${map}, which is kept beside it` : `As map.toml beside ${config}, with a line in that which names it, in the place of its [[landmarks]]`}. Until then the service goes by the map that it has.` }));
    this.drawn = { plan: new Plan(canvas), placed: news.placed, enlarged };
    this.draw();
  }

  // The view's own size and theme: drawn anew with each message, as its plan is.
  draw() {
    if (!this.drawn || this.result.hidden) return;
    const { plan, placed, enlarged } = this.drawn;
    plan.begin(placed.map(({ mm }) => mm));
    // As large as they may be without hiding each other.
    const widest = Math.max(...placed.flatMap(({ sigma_mm: sigma }) => sigma.slice(0, 2))) * plan.scale;
    const times = widest > 0 ? Math.min(1000, 10 ** Math.max(0, Math.floor(Math.log10(MOST_PX / widest)))) : 1;
    for (const one of placed) {
      if (one.how !== "given") plan.ellipse(one.mm, one.sigma_mm.slice(0, 2).map((sigma) => sigma * times), colour("--accent"));
      plan.landmark(one, colour(one.how === "found" ? "--ink" : "--good"));
    }
    setText(enlarged, `Green: given. Ellipses: 1-sigma along x and y${times > 1 ? `, ${times} times as large` : ""}.`);
  }
}
