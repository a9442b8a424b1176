// What the server says, message by message: each request is answered when there is something new, so that a slow
// browser gets fewer messages and nothing piles up.
let token = sessionStorage.getItem("token") ?? "";

export function setToken(text) {
  token = text;
  sessionStorage.setItem("token", text);
}

export function authorised(path, options = {}) {
  const headers = { ...options.headers, ...(token ? { Authorization: `Bearer ${token}` } : {}) };
  return fetch(path, { ...options, headers, cache: "no-store" });
}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Feed {
  constructor({ onMessage, onTrouble, onToken }) {
    Object.assign(this, { onMessage, onTrouble, onToken });
    this.viewer = Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.wantsPicture = true;
    this.wantsEvery = false;
    this.newest = null;
    this.hasTried = false;
    this.isRunning = false;
  }

  troubled() {
    this.onTrouble("ninedot-web does not answer: is it running? Trying again.");
  }

  async start() {
    if (this.isRunning) return;
    this.isRunning = true;
    while (this.isRunning) {
      // A window that nobody sees costs the sensor nothing.
      if (document.hidden) {
        await pause(300);
        continue;
      }
      try {
        await this.next();
      } catch {
        this.troubled();
        await pause(1000);
      }
    }
  }

  async next() {
    const response = await authorised(`/api/live?viewer=${this.viewer}&picture=${this.wantsPicture ? 1 : 0}${this.wantsEvery ? "&every=1" : ""}`, { signal: AbortSignal.timeout(8000) });
    if (response.status === 401 || response.status === 429) {
      this.isRunning = false;
      return this.onToken(await response.text());
    }
    if (response.status === 503) {
      this.onTrouble(await response.text());
      return pause(2000);
    }
    if (!response.ok) throw new Error(response.statusText);
    const bytes = await response.arrayBuffer();
    const length = new DataView(bytes).getUint32(0);
    const message = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
    if (bytes.byteLength > 4 + length) message.jpeg = new Blob([new Uint8Array(bytes, 4 + length)], { type: "image/jpeg" });
    message.received = performance.now();
    this.newest = message;
    this.onMessage(message);
  }
}
