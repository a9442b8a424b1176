// What the head does and why, where it can go, and a hand on it for as long as a button is held.
import { element, fixed, setText, tellVerdict } from "./dom.js";
import { reader } from "./decode.js";
import { Jog } from "./jog.js";
import { JogPad } from "./jogpad.js";
import { draw } from "./overlay.js";
import { drawReach, landmarkDirection } from "./reach.js";

const STATES = {
  1: ["SEARCH", "The landmark is out of sight: the head sweeps all that it can see, until it finds it.", "warn"],
  2: ["ACQUIRE", "The landmark is in sight: the head turns to it.", "warn"],
  3: ["TRACK", "The head keeps the landmark in the middle of the picture.", "good"],
  4: ["COAST", "The landmark is hidden for a moment: the head follows where it should be by now.", "warn"],
  5: ["HOLD", "The head stays where it is: somebody sent it there, or there is nothing to follow.", "none"],
  6: ["PARK", "The head stands at its parking place, or goes there.", "none"],
};
const POINT = 2;
const PARK = 3;
const INHIBITED = 1 << 11;
const FAULT = 1 << 12;
const HAS_HEAD = 1 << 13;
const AT_LIMIT = 1 << 5;
const SPEEDS = [1, 5, 15, 30];
// To make sure of a second click, not of a double one.
const SURE_MS = 5000;

export class AimView {
  constructor(main, shared) {
    this.shared = shared;
    this.wantsPicture = true;
    this.speed = 5;
    this.verdict = element("div.verdict", { id: "aim-state", role: "status" });
    this.owner = element("p", { id: "aim-owner", role: "status" });
    this.note = element("p.warn", { id: "aim-note", role: "status", hidden: true });
    this.takeButton = element("button", { type: "button", id: "take", disabled: true, onclick: () => this.take() }, "Take the head");
    this.followButton = element("button", { type: "button", id: "follow", disabled: true, onclick: () => this.follow() }, "Automatic again");
    this.pad = new JogPad((pan, tilt) => this.jog.turn(pan * this.speed, tilt * this.speed));
    this.speeds = element("div.speeds", { role: "group", "aria-label": "speed" });
    this.facts = element("table.facts", { id: "aim-facts" });
    this.picture = element("canvas", { id: "picture", role: "img", "aria-label": "what the head's camera sees", width: 640, height: 480 });
    this.reach = element("canvas", { id: "reach", role: "img", "aria-label": "what the head can reach, where it is and where the landmark is" });
    this.hand = element("section.card.hand", {}, this.owner, element("div.tools", {}, this.takeButton, this.followButton), this.pad.node, this.speeds, this.note,
      element("p.soft", {}, "The head turns while a button or an arrow key is held and stops with it, with this page, and with the network. Leaving this view gives it back."));
    this.refused = element("section.card.hand", { id: "aim-refused", hidden: true });
    main.append(element("h1", {}, "Aim"), element("div.aim", {},
      element("section.card.stage", {}, this.picture), element("section.card.state", {}, this.verdict, this.facts), this.hand, this.refused,
      element("section.card.reach", {}, element("h2", {}, "What the head can reach"), this.reach,
        element("p.soft", {}, "Dot: the head. Dashes: its picture. Cross: where it is sent. Ring: the landmark, as far as the camera looks along with the head. Frame: the limits."))));
    this.jog = new Jog(shared.viewer, (state, problem) => this.hear(state, problem));
  }

  leave() {
    this.pad.end();
    this.jog.end();
    this.bitmap?.close();
  }

  take() {
    this.jog.take();
    this.pad.node.focus({ preventScroll: true });
  }

  // Whom it is taken from has to be said twice.
  follow() {
    const isOthers = !this.jog.isOurs;
    if (isOthers && !(performance.now() - this.askedAt < SURE_MS)) {
      this.askedAt = performance.now();
      return setText(this.followButton, "Really take it from the controller?");
    }
    this.askedAt = -Infinity;
    this.jog.follow();
  }

  hear(state, problem) {
    if (problem) setText(this.note, problem);
    else setText(this.note, state.note);
    this.note.hidden = !this.note.textContent;
    if (state && !this.speeds.children.length) this.offerSpeeds(state);
    this.aim = state ?? this.aim;
    this.pad.enable(this.jog.mayJog);
    this.tellOwner();
  }

  offerSpeeds({ pan, tilt }) {
    const fastest = Math.max(pan.fastest, tilt.fastest);
    const choices = SPEEDS.filter((speed) => speed < fastest).concat(SPEEDS.some((speed) => speed >= fastest) ? fastest : []);
    this.speed = choices.includes(5) ? 5 : choices[0];
    this.speeds.append(...choices.map((speed) => element("button", { type: "button", "aria-pressed": String(speed === this.speed), onclick: (event) => {
      this.speed = speed;
      for (const button of this.speeds.children) button.setAttribute("aria-pressed", String(button === event.target));
    } }, `${speed} °/s`)));
  }

  tellOwner() {
    const { aim, value } = this;
    if (!aim) return;
    this.refused.hidden = !aim.why_not;
    this.hand.hidden = Boolean(aim.why_not);
    if (aim.why_not) this.refused.replaceChildren(element("h2", {}, "By hand"), element("p", {}, aim.why_not));
    const command = value?.("command");
    const state = value?.("head_state");
    const isFollowing = state >= 1 && state <= 4;
    const isControllers = aim.phase === "free" && !isFollowing && (command === POINT || command === PARK);
    let words = "The service has the head, and aims it by itself.";
    if (aim.phase === "held" && aim.mine) words = "This page has the head.";
    else if (aim.mine) words = "The head is asked for ...";
    else if (aim.holder) words = `Another page has the head, at ${aim.holder}.`;
    else if (aim.phase === "returning") words = "The head is being given back ...";
    else if (isControllers) words = command === PARK ? "A controller has the head: it parked it." : `A controller has the head: it sent it to ${this.placeOf(["pan_set_point", "tilt_set_point"])}.`;
    else if (!isFollowing && !aim.follows && command === 0) words = "Nobody has the head: it waits for a command, `follow` of [pan_tilt] being false.";
    setText(this.owner, words);
    this.takeButton.disabled = aim.phase !== "free" || isControllers || !this.hasHead;
    this.followButton.disabled = !this.hasHead || !(aim.mine || (aim.phase === "free" && !isFollowing && command !== 1));
    if (!isControllers || !(performance.now() - this.askedAt < SURE_MS)) setText(this.followButton, "Automatic again");
  }

  placeOf(names) {
    return names.map((name) => `${fixed(this.value(name), 2)}°`).join(", ");
  }

  async update(message) {
    this.value = message.service && this.shared.registers ? reader(this.shared.registers, message.service) : null;
    const status = this.value?.("status") ?? 0;
    this.hasHead = Boolean(status & HAS_HEAD);
    this.tellState(message, status);
    this.tellOwner();
    this.drawReach(message);
    if (!message.jpeg) return;
    const bitmap = await createImageBitmap(message.jpeg).catch(() => null);
    if (!bitmap) return;
    this.bitmap?.close();
    this.bitmap = bitmap;
    const { width, height } = message.camera;
    if (this.picture.width !== width || this.picture.height !== height) Object.assign(this.picture, { width, height });
    draw(this.picture, bitmap, message.camera, message.frame, { overlay: true, candidates: false });
    this.picture.dataset.frame = message.frame.number;
  }

  tellState(message, status) {
    const { value } = this;
    const say = (...words) => tellVerdict(this.verdict, ...words);
    if (!value) return say("bad", message.problem ? "No service" : "Waiting for the service", message.problem ?? "");
    if (!this.hasHead) return say("none", "No head", "This service has no pan/tilt head: `driver` of [pan_tilt] is \"none\".");
    const [name, words, kind] = STATES[value("head_state")] ?? ["?", "", "warn"];
    if (status & FAULT) say("bad", `${name}, but the head does not answer`, "Its supply, its line and its address: the log says more.");
    else if (status & INHIBITED) say("warn", `${name}: inhibited`, "The inhibit input keeps the head where it is.");
    else say(kind, name, words);
    const command = value("command");
    const isSent = value("head_state") === 5 && command === POINT;
    const row = (title, text, kindOf = "") => element("tr", {}, element("th", {}, title), element(`td.n${kindOf ? `.${kindOf}` : ""}`, {}, text));
    const range = ({ min, max }) => `${min}° to ${max}°`;
    const landmark = landmarkDirection(message.frame);
    this.facts.replaceChildren(
      row("pan and tilt now", this.placeOf(["pan", "tilt"])),
      row("sent to", isSent ? this.placeOf(["pan_set_point", "tilt_set_point"]) : value("head_state") === 6 ? "its parking place" : "the landmark"),
      row("landmark at", landmark ? landmark.map((angle) => `${fixed(Math.round(10 * angle) / 10 + 0, 1)}°`).join(", ") : "not in sight"),
      ...(this.aim ? [row("limits of pan", range(this.aim.pan)), row("limits of tilt", range(this.aim.tilt))] : []),
      ...(status & AT_LIMIT ? [row("at its limit", "it should go further, and can't", "warn")] : []));
  }

  drawReach({ frame, camera }) {
    if (!this.aim || this.aim.driver === "none") return;
    const { value, hasHead } = this;
    const view = camera && [camera.width / 2 / camera.intrinsics[0], camera.height / 2 / camera.intrinsics[1]].map((ratio) => (Math.atan(ratio) * 180) / Math.PI);
    const isSent = hasHead && value("head_state") === 5 && value("command") === POINT;
    drawReach(this.reach, { limits: this.aim, view, landmark: landmarkDirection(frame),
      at: hasHead ? [value("pan"), value("tilt")] : null, to: isSent ? [value("pan_set_point"), value("tilt_set_point")] : null });
  }
}
