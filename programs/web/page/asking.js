// A desk of ninedot-web: its state, asked for again and again while a view is shown, and what it is told to do.
import { authorised } from "./feed.js";

const PATIENCE_MS = 8000;

export class Asking {
  // tell: takes the state; every_ms: until it is asked for again, after that state
  constructor(path, tell, every_ms) {
    Object.assign(this, { path, tell, every_ms, isAlive: true });
  }

  end() {
    this.isAlive = false;
    clearTimeout(this.timer);
  }

  async ask() {
    clearTimeout(this.timer);
    try {
      const response = await authorised(this.path, { signal: AbortSignal.timeout(PATIENCE_MS) });
      if (response.ok) this.take(await response.json());
    } catch {
      // The page's frame says that nobody answers.
    }
    if (this.isAlive) this.timer = setTimeout(() => this.ask(), this.every_ms(this.state));
  }

  take(state) {
    if (!this.isAlive) return;
    this.state = state;
    this.tell(state);
  }

  // Returns what there is to say about it; "": it is being done.
  async order(text) {
    try {
      const response = await authorised(this.path, { method: "POST", body: text, signal: AbortSignal.timeout(PATIENCE_MS) });
      const answer = await response.text();
      if (!answer.startsWith("{")) return answer.trim();
      this.take(JSON.parse(answer));
      return "";
    } catch {
      return "ninedot-web does not answer: nothing was done.";
    }
  }
}
