// The last minute, for plots and paths.
export const SPAN_MS = 60000;

export class History {
  constructor() {
    this.points = [];
    this.counts = [];
  }

  add(message) {
    const now = message.received;
    const frame = message.frame;
    if (frame && message.fresh) {
      const pose = frame.in_world;
      this.points.push({
        t: now, valid: frame.valid, mm: pose.mm, q: pose.q,
        sigma: Math.hypot(...pose.sigma_mm), latency: frame.latency_ms,
      });
      this.counts.push({ t: now, processed: frame.processed, dropped: frame.dropped, failed: frame.failed, bins: frame.latency_bins });
    }
    for (const list of [this.points, this.counts]) while (list.length && now - list[0].t > SPAN_MS) list.shift();
    // A service that was started again counts from 0.
    const first = this.counts[0];
    const last = this.counts[this.counts.length - 1];
    if (first && last.processed < first.processed) this.counts = [last];
  }

  // What was counted within the last minute; null while nothing is known.
  gained(name) {
    if (this.counts.length < 2) return null;
    return this.counts[this.counts.length - 1][name] - this.counts[0][name];
  }
}
