// Hold to run: while something is held the server is told so every 20 ms, with the newest time that it told us. By that
// time it lets the head turn for 80 ms, and no longer: whatever becomes of this page, its browser or the
// network, motion ends by the server's clock.
import { authorised } from "./feed.js";

const KEEP_ALIVE_MS = 20;
const REFRESH_MS = 400;
const MOST_UNDER_WAY = 3;

export class Jog {
  constructor(viewer, onState) {
    Object.assign(this, { viewer, onState });
    this.number = 0;
    this.seen = 0;
    this.wanted = [0, 0];
    this.underWay = 0;
    this.state = null;
    this.isAlive = true;
    this.go = () => this.give(true);
    window.addEventListener("pagehide", this.go);
    this.refresh();
  }

  get isOurs() {
    return Boolean(this.state?.mine);
  }

  get mayJog() {
    return this.isOurs && this.state.phase === "held";
  }

  get moves() {
    return this.wanted.some((rate) => rate !== 0);
  }

  async refresh() {
    while (this.isAlive) {
      // A window that nobody sees keeps no head: without news of it the server gives it back.
      if (!document.hidden) await (this.isOurs ? this.tell() : this.ask(`/api/aim?viewer=${this.viewer}`));
      await new Promise((resolve) => setTimeout(resolve, this.state?.phase === "asked" ? KEEP_ALIVE_MS : REFRESH_MS));
    }
  }

  async ask(path, options = {}) {
    try {
      const response = await authorised(path, { signal: AbortSignal.timeout(3000), ...options });
      if (![200, 409].includes(response.status)) return this.hear(null, (await response.text()).trim());
      this.hear(await response.json(), "");
    } catch {
      this.hear(null, "ninedot-web does not answer.");
    }
  }

  hear(state, problem) {
    if (!this.isAlive) return;
    // Answers may overtake each other.
    if (state && state.now < this.seen) return;
    if (state) this.seen = state.now;
    this.state = state;
    if (!this.mayJog) this.turn(0, 0);
    this.onState(state, problem);
  }

  post(text, keepalive = false) {
    return this.ask("/api/aim", { method: "POST", body: text, keepalive });
  }

  async tell(keepalive = false) {
    ++this.underWay;
    await this.post(`jog ${this.viewer} ${++this.number} ${this.seen} ${this.wanted.map((rate) => rate.toFixed(2)).join(" ")}`, keepalive);
    --this.underWay;
  }

  take() {
    return this.post(`take ${this.viewer}`);
  }

  follow() {
    this.turn(0, 0);
    return this.post(`follow ${this.viewer}`);
  }

  give(isLeaving = false) {
    this.turn(0, 0);
    return this.isOurs ? this.post(`give ${this.viewer}`, isLeaving) : null;
  }

  // Degrees a second; 0, 0 stops, and is said at once.
  turn(pan, tilt) {
    if (!this.mayJog) [pan, tilt] = [0, 0];
    const moved = this.moves;
    const isOther = pan !== this.wanted[0] || tilt !== this.wanted[1];
    this.wanted = [pan, tilt];
    if (!this.moves) {
      clearInterval(this.timer);
      if (moved) this.tell(true);
      return;
    }
    if (isOther) this.tell();
    if (!moved) this.timer = setInterval(() => this.underWay < MOST_UNDER_WAY && this.tell(), KEEP_ALIVE_MS);
  }

  end() {
    this.give(true);
    this.isAlive = false;
    window.removeEventListener("pagehide", this.go);
  }
}
