// How the service is, what of it is not as it should be, and what to do about that.
import { duration, element, fixed, setText } from "./dom.js";
import { reader } from "./decode.js";
import { bars, lines } from "./plot.js";

const RANK = ["none", "good", "warn", "bad"];
const SIGNS = { good: "✓", warn: "!", bad: "×", none: "–" };

export const worstOf = (list) => list.reduce((worst, one) => (RANK.indexOf(one.kind) > RANK.indexOf(worst) ? one.kind : worst), "none");

// [{name, value, kind, advice}]; advice only where something is to be done.
export function verdicts(message, shared) {
  if (!message.service || !shared.registers) {
    return [{ name: "Service", value: message.problem ? "not there" : "waiting", kind: message.problem ? "bad" : "none", advice: message.problem ?? "" }];
  }
  const value = reader(shared.registers, message.service);
  const { camera, frame, service } = message;
  const list = [];
  const add = (name, text, kind, advice = "") => list.push({ name, value: text, kind, advice: kind === "good" || kind === "none" ? "" : advice });

  const rate = value("frame_rate");
  const share = rate / camera.rate_hz;
  add("Frame rate", `${fixed(rate, 1)} of ${fixed(camera.rate_hz, 1)} Hz`, value("uptime") < 3 ? "none" : share > 0.95 ? "good" : share > 0.8 ? "warn" : "bad",
    rate === 0 ? "No frame comes: see the camera below and the log." : "The camera lowers its rate in the dark (more light, shorter exposure), or the board can't keep up: look at latency and drops.");
  const dropped = shared.history.gained("dropped");
  const processed = shared.history.gained("processed");
  const lost = dropped === null ? null : dropped / Math.max(1, dropped + processed);
  add("Dropped frames", dropped === null ? "counting" : `${dropped} in the last minute, ${value("frames_dropped")} since the start`,
    lost === null ? "none" : lost < 0.002 ? "good" : lost < 0.05 ? "warn" : "bad",
    "The board was busy when a frame came: give the service its real-time priority, lower rate_hz, or take work from the board.");
  const failed = shared.history.gained("failed");
  add("Unreadable frames", `${value("frames_failed")} since the start`, failed ? "bad" : value("frames_failed") ? "warn" : "good",
    "Damaged pictures: check the camera's cable and supply, and that its size is the calibration's.");
  const p99 = value("latency_p99");
  add("Latency", `median ${fixed(value("latency_median"), 1)}, 99 % ${fixed(p99, 1)}, most ${fixed(value("latency_max"), 1)} ms`,
    p99 < 1000 / camera.rate_hz ? "good" : p99 < 2000 / camera.rate_hz ? "warn" : "bad",
    "One frame in a hundred is later than the next one comes: real-time priority, a shorter exposure, or a smaller picture.");
  add("Camera", frame && frame.reason === 4 ? "lost" : `${value("camera_restarts")} restarts`, (frame?.reason === 4 || value("reason") === 4) ? "bad" : value("camera_restarts") ? "warn" : "good",
    "It was lost and opened again: cable, supply, or a USB hub that saves power. The log says when.");
  const flags = value("health_flags");
  add("Real time", flags & 1 ? "SCHED_FIFO" : "ordinary priority", flags & 1 ? "good" : "warn",
    "Other programs can hold up frames: LimitRTPRIO= of the unit, or `ulimit -r`; realtime_priority of [service].");
  add("Memory", flags & 2 ? "locked" : "not locked", flags & 2 ? "good" : "warn", "Pages may be fetched from disk in the middle of a frame: LimitMEMLOCK=infinity, lock_memory of [service].");
  const temperature = value("temperature");
  add("Board temperature", Number.isNaN(temperature) ? "unknown" : `${fixed(temperature, 1)} °C`, Number.isNaN(temperature) ? "none" : temperature < 75 ? "good" : temperature < 85 ? "warn" : "bad",
    "Boards slow down at 80 to 85 °C: a heat sink, air, or a lower rate_hz.");
  const errors = value("bus_errors");
  add("Modbus", `${value("connected_clients")} connected, ${errors} bus errors, ${value("exceptions")} exceptions`, errors > 0 || value("exceptions") > 0 ? "warn" : "good",
    errors > 0 ? "Broken frames on the serial line: baud, parity, cable, termination." : "A client asks for what there is not: address, quantity or function code. The log names it.");
  const disputed = value("landmarks_disputed");
  const rejected = value("landmarks_rejected");
  const first = value("disputed_id_1");
  const [said, verdict, advice] = disputed > 1 ? [`landmarks ${first} and ${value("disputed_id_2")} contradict each other`, "bad",
    "One of them does not hang where the map says, and neither places the camera alone: measure both, or map the room anew."]
    : disputed ? [`landmark ${first} contradicted another one`, "bad", "It does not place the camera alone until it has agreed with others: measure its place, or map the room anew."]
    : rejected ? [`landmark ${value("last_rejected_id")} hangs elsewhere`, "warn", "Poses are made without it: measure its place, or map the room anew."]
    : ["as it is seen", "good"];
  add("Map", said, verdict, advice);
  const cut = frame ? Object.values(frame.cut).reduce((sum, count) => sum + count, 0) : 0;
  add("Search", cut ? `${cut} left out since the start` : "nothing left out", cut ? "warn" : "good", "The picture is full of things that look like dots: a calmer background, or less of it in view.");
  const uptime = value("uptime");
  add("Up", duration(uptime * 1000), "good");
  return list;
}

export class HealthView {
  constructor(main, shared) {
    this.shared = shared;
    this.summary = element("h1", { role: "status" });
    this.checks = element("div.grid", { id: "checks" });
    this.histogram = element("canvas", { role: "img", "aria-label": "histogram of the latency" });
    this.rates = element("canvas", { role: "img", "aria-label": "dropped frames over the last minute" });
    this.clients = element("tbody");
    this.log = element("ul.log", { id: "log" });
    main.append(this.summary, this.checks,
      element("div.wide", {},
        element("section.card", {}, element("h2", {}, "Latency of all frames since the start (heights by the root)"), this.histogram),
        element("section.card", {}, element("h2", {}, "Frames per second, last minute"), this.rates),
        element("section.card", {}, element("h2", {}, "Modbus clients"), element("div.scroll", {}, element("table", {},
          element("thead", {}, element("tr", {}, element("th", {}, "address"), element("th.n", {}, "requests"), element("th.n", {}, "connected"), element("th.n", {}, "silent"))), this.clients))),
        element("section.card", {}, element("h2", {}, "Log"), this.log)));
  }

  update(message) {
    const list = verdicts(message, this.shared);
    const worst = worstOf(list);
    const count = list.filter((one) => one.kind === "warn" || one.kind === "bad").length;
    setText(this.summary, worst === "good" ? "All is well." : worst === "none" ? "Waiting for the service." : `${count} thing${count === 1 ? "" : "s"} to look at`);
    this.summary.className = worst === "none" ? "soft" : worst;
    const order = [...list].sort((a, b) => RANK.indexOf(b.kind) - RANK.indexOf(a.kind));
    const signature = JSON.stringify(order);
    if (signature !== this.signature) {
      this.signature = signature;
      this.checks.replaceChildren(...order.map((one) => element("section.card.check", { "data-kind": one.kind },
        element(`span.lamp.${one.kind}`, { "aria-label": one.kind }, SIGNS[one.kind]),
        element("div", {}, element("div.name", {}, one.name), element("div.value", {}, one.value)),
        ...(one.advice ? [element("p.advice", {}, one.advice)] : []))));
    }
    if (message.frame) bars(this.histogram, message.frame.latency_bins, (i) => edge(i), "ms");
    this.drawRates(message.received);
    if (!message.service) return;
    this.clients.replaceChildren(...(message.service.clients.length ? message.service.clients.map((client) => element("tr", {}, element("td", {}, client.address),
      element("td.n", {}, String(client.requests)), element("td.n", {}, duration(client.connected_ms)), element("td.n", {}, duration(client.silent_ms))))
      : [element("tr", {}, element("td.soft", { colspan: 4 }, "none is connected"))]));
    const log = message.service.log;
    this.log.replaceChildren(...log.slice().reverse().map((line) => element("li", {}, element("span.soft", {}, `${duration(line.ago_ms)}${line.ago_ms >= 1000 ? " ago" : ""}`), element("span", {}, line.text))));
  }

  drawRates(now) {
    const counts = this.shared.history.counts;
    const values = [];
    // By the frame counters, over a second each.
    for (let from = 0, to = 0; to < counts.length; ++to) {
      while (counts[to].t - counts[from].t > 1000) ++from;
      const elapsed = counts[to].t - counts[from].t;
      if (elapsed > 700) values.push({ t: counts[to].t, y: (1000 * (counts[to].processed - counts[from].processed)) / elapsed });
    }
    lines(this.rates, [{ colour: "--accent", values }], { now, least: 10, zero: true });
  }
}

// Upper edge of a latency bin, in ms: docs/tap.md.
const edge = (i) => {
  const ms = 0.1 * 2 ** (i / 4);
  return ms < 10 ? ms.toFixed(1) : ms.toFixed(0);
};
