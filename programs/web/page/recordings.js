// What was seen: recorded because somebody asked, or because the landmark was lost; listed, looked at again, fetched.
import { Asking } from "./asking.js";
import { duration, element, saveAs, setText, tellVerdict } from "./dom.js";
import { authorised } from "./feed.js";
import { Replay } from "./replay.js";

export const PATH = "/api/recordings";
const ASK_EVERY_MS = 1000;
// To make sure of a second click, not of a double one.
const SURE_MS = 5000;
const megabytes = (bytes) => `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;
export const seconds = (ms) => (ms < 120000 ? `${(ms / 1000).toFixed(ms < 10000 ? 1 : 0)} s` : duration(ms));

// "20261123-121415-asked": by the sensor's clock, told in the browser's time.
export function beginOf(name) {
  const [, year, month, day, hour, minute, second] = /^(\d{4})(\d\d)(\d\d)-(\d\d)(\d\d)(\d\d)-/.exec(name).map(Number);
  return new Date(Date.UTC(year, month - 1, day, hour, minute, second));
}

const LOSSES = {
  off: ["none", "Losses are not kept", "Set `loss_seconds` of [web] to keep the last seconds before each loss of the landmark."],
  blind: ["none", "No landmark in sight", "As soon as one is valid, what precedes its loss is kept."],
  watching: ["good", "Watching", "When the landmark is lost, what was seen before becomes a recording."],
  lost: ["warn", "The landmark was just lost", "The second after it is still to come."],
  saving: ["warn", "The last loss is being saved", "Meanwhile no other one is watched for."],
};

export class RecordingsView {
  constructor(main, shared) {
    this.shared = shared;
    this.verdict = element("div.verdict.none", { id: "recording-state", role: "status" }, "Asking ...");
    this.startButton = element("button", { type: "button", id: "record", disabled: true, title: "Start or stop a recording (r)", onclick: () => this.toggle() }, "Start recording");
    this.note = element("p.warn", { id: "recording-note", role: "status", hidden: true });
    this.room = element("p.soft", { id: "recording-room" });
    this.losses = element("div.verdict.none", { id: "loss-state", role: "status" });
    this.lossFacts = element("p.soft", { id: "loss-facts" });
    this.list = element("ul.recordings", { id: "recordings", "aria-label": "recordings" });
    this.empty = element("p.soft", { hidden: true }, "Nothing has been recorded yet.");
    this.player = element("section.card.stage", { id: "replay", "aria-label": "replay", hidden: true });
    main.append(element("h1", {}, "Recordings"), element("div.shelf", {},
      element("section.card", {}, element("h2", {}, "By hand"), this.verdict, element("div.tools", {}, this.startButton), this.note, this.room),
      element("section.card", {}, element("h2", {}, "What did it see?"), this.losses, this.lossFacts), this.player,
      element("section.card.list", {}, element("h2", {}, "Kept on the sensor"), this.empty, this.list)));
    this.asking = new Asking(PATH, (state) => this.tell(state), () => ASK_EVERY_MS);
    this.asking.ask();
  }

  leave() {
    this.asking.end();
    this.replay?.leave();
  }

  // What the service says is no matter of this view: it asks for its own state.
  update() {}

  onKey(key) {
    if (key === "r" && !this.startButton.disabled) this.toggle();
    else return Boolean(this.replay?.onKey(key));
    return true;
  }

  async order(text) {
    const said = await this.asking.order(text);
    if (said) this.say(said);
  }

  toggle() {
    this.order(["recording", "starting"].includes(this.state?.phase) ? "stop" : "start");
  }

  say(text) {
    setText(this.note, text);
    this.note.hidden = !text;
  }

  tell(state) {
    this.state = state;
    const isOn = state.phase === "recording" || state.phase === "starting";
    const { running } = state;
    const words = state.why_not ? ["none", "No recordings", state.why_not]
      : running ? ["bad", "Recording", `${seconds(running.ms)}, ${running.frames} frames${running.missed ? `, ${running.missed} missed` : ""}, ${megabytes(running.bytes)}; ends after ${seconds(state.longest_ms)} by itself`]
      : isOn ? ["warn", "Waiting for the first frame", ""]
      : state.may ? ["none", "Ready", `A recording ends by itself after ${seconds(state.longest_ms)}.`]
      : ["none", "Only to look at", "Without a token nothing can be recorded or deleted: set `token_file` of [web]."];
    tellVerdict(this.verdict, ...words);
    setText(this.startButton, isOn ? "Stop" : "Start recording");
    this.startButton.disabled = Boolean(state.why_not) || !state.may || state.phase === "stopping";
    this.startButton.setAttribute("aria-pressed", String(isOn));
    this.say(state.problem || state.note);
    setText(this.room, state.why_not ? "" : `${megabytes(state.bytes)} of ${megabytes(state.most_bytes)} are used.`);
    this.tellLosses(state.loss);
    this.tellList(state);
  }

  tellLosses({ phase, before_ms: before, spacing_ms: spacing, skipped, memory }) {
    tellVerdict(this.losses, ...LOSSES[phase]);
    const facts = [`${seconds(before)} before a loss and a second after it`, memory ? `${megabytes(memory)} of memory` : "",
      spacing ? `a frame every ${spacing} ms, for more do not fit` : "every frame", skipped ? `${skipped} more losses within half a minute of another one` : ""];
    setText(this.lossFacts, phase === "off" ? "" : `${facts.filter(Boolean).join("; ")}.`);
  }

  // Made anew only where it changed: a button that is about to be pressed stays where it is.
  tellList({ recordings, may }) {
    const signature = JSON.stringify([recordings, may]);
    if (signature === this.listed) return;
    this.listed = signature;
    this.empty.hidden = recordings.length > 0;
    this.list.replaceChildren(...recordings.map((one) => this.row(one, may)));
    if (this.replay && !recordings.some(({ name }) => name === this.replay.name)) this.closeReplay();
  }

  row(one, may) {
    const button = (text, title, onclick) => element("button", { type: "button", title, onclick }, text);
    const fetchButton = button("Download", `${one.name}.tar, for \`ninedot replay\``, () => this.fetch(one, fetchButton));
    const deleteButton = button("Delete", "For good; asks once more", () => this.remove(one, deleteButton));
    deleteButton.disabled = !may;
    return element("li", { "data-name": one.name }, element("div.what", {}, element("strong", {}, beginOf(one.name).toLocaleString("en-GB")),
      element(`span.why.${one.why === "loss" ? "warn" : "soft"}`, {}, one.why === "loss" ? "landmark lost" : "asked for"),
      element("small.soft", {}, `${seconds(one.ms)}, ${one.frames} frames${one.missed ? ` and ${one.missed} left out` : ""}, ${megabytes(one.bytes)}; ${one.ended}`)),
    element("div.does", {}, button("Replay", "With what was found in each picture", () => this.open(one)), fetchButton, deleteButton));
  }

  async open({ name }) {
    this.closeReplay();
    this.player.hidden = false;
    this.replay = new Replay(this.player, PATH, name, () => this.closeReplay());
    await this.replay.load();
    this.player.scrollIntoView({ block: "nearest" });
  }

  closeReplay() {
    this.replay?.leave();
    this.replay = null;
    this.player.hidden = true;
    this.player.replaceChildren();
  }

  remove({ name }, button) {
    if (!(performance.now() - button.dataset.askedAt < SURE_MS)) {
      button.dataset.askedAt = performance.now();
      setText(button, "Really delete?");
      setTimeout(() => setText(button, "Delete"), SURE_MS);
      return;
    }
    this.order(`delete ${name}`);
  }

  // As a blob: a link could not carry the token.
  async fetch({ name }, button) {
    button.disabled = true;
    try {
      const response = await authorised(`${PATH}/${name}/download`);
      if (!response.ok) throw new Error(await response.text());
      let bytes = 0;
      const counted = response.body.pipeThrough(new TransformStream({ transform(part, out) {
        bytes += part.byteLength;
        setText(button, megabytes(bytes));
        out.enqueue(part);
      } }));
      saveAs(`${name}.tar`, await new Response(counted).blob());
    } catch (error) {
      this.say(`The download failed: ${error.message}`);
    }
    setText(button, "Download");
    button.disabled = false;
  }
}
