// A service with a simulated head before a landmark that hangs still, and what the tests do with it.
import fs from "node:fs";
import path from "node:path";

import { Modbus, STANDING_ROBOT, Stage, get, pause, until } from "./stage.mjs";

export const TOKEN = "0123456789abcdef0123456789abcdef";
const PAN = 37, COMMAND = 100, PAN_SET_POINT = 105, HEAD_STATE = 146;
export const POINT = 2, PARK = 3, HOLD = 5;

export class HeadStage {
  // options: {web: more of [web], writes: false, modbus: text under [modbus.tcp], follow: text under [pan_tilt]}
  static async open(options = {}) {
    const own = new HeadStage();
    own.folder = fs.mkdtempSync("/dev/shm/ninedot-token-");
    fs.writeFileSync(path.join(own.folder, "token"), `${TOKEN}\n`, { mode: 0o600 });
    own.stage = await Stage.open({
      camera: 'source = "simulated"\nwidth_px = 320\nheight_px = 240\nrate_hz = 35.0',
      web: options.token === false ? "" : `token_file = "${own.folder}/token"`,
      extra: `[modbus]
allow_writes = ${options.writes ?? true}
[[landmarks]]
id = 1
position_mm = [0.0, 0.0, 1200.0]
[pan_tilt]
driver = "${options.driver ?? "simulated"}"
${options.head ?? ""}
[pan_tilt.pan]
min_deg = -60
max_deg = 60
slew_deg_per_s = 350
[pan_tilt.tilt]
min_deg = -30
max_deg = 30
slew_deg_per_s = 350
${STANDING_ROBOT}[simulation.servo]
speed_deg_s = 353.0
acceleration_deg_s2 = 6000.0
delay_ms = 20.0
`,
    });
    own.modbus = await Modbus.open(own.stage.modbusPort);
    await until("frames come", async () => (await own.modbus.read(2, 1))[0] > 3);
    return own;
  }

  get port() {
    return this.stage.port;
  }

  async head() {
    const [pan, tilt] = await this.modbus.read(PAN, 2);
    const [command, sequence, , , , setPan, setTilt] = await this.modbus.read(COMMAND, 7);
    const [state] = await this.modbus.read(HEAD_STATE, 1);
    return { pan: pan / 100, tilt: tilt / 100, command, sequence, setPan: setPan / 100, setTilt: setTilt / 100, state };
  }

  // As a page asks, but for what is changed of it.
  async post(body, { token = TOKEN, headers = {} } = {}) {
    const answer = await get(this.port, "/api/aim", { method: "POST", body,
      headers: { Origin: `http://127.0.0.1:${this.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": Buffer.byteLength(body),
        ...(token ? { Authorization: `Bearer ${token}` } : {}), ...headers } });
    const text = answer.body.toString();
    return { status: answer.status, text, state: text.startsWith("{") ? JSON.parse(text) : null };
  }

  async take(viewer) {
    return until(`${viewer} has the head`, async () => {
      await this.post(`take ${viewer}`);  // refused while whoever had it last gives it back
      const { state } = await this.post(`jog ${viewer} 0 0 0 0`);
      return state.phase === "held" && state.mine && state;
    });
  }

  // What registers said from now on for `ms`, each millisecond or so, of a connection of its own: [{at, pan, setPan}]
  async watch(ms, what = async () => {}) {
    const client = await Modbus.open(this.stage.modbusPort);
    const seen = [];
    const started = performance.now();
    let isOver = false;
    const watching = (async () => {
      while (!isOver) {
        const [words, points] = await Promise.all([client.read(PAN, 1), client.read(PAN_SET_POINT, 1)]);
        seen.push({ at: performance.now(), pan: words[0] / 100, setPan: points[0] / 100 });
        await pause(1);
      }
    })();
    const at = await what();
    await pause(Math.max(0, ms - (performance.now() - started)));
    isOver = true;
    await watching;
    client.close();
    return { seen, at };
  }

  async close() {
    this.modbus.close();
    const status = await this.stage.close();
    fs.rmSync(this.folder, { recursive: true });
    return status;
  }
}

// When the last change was, of what `pick` tells of each, counted from `at` [ms]; and by how much after it.
export function lastChange(seen, at, pick) {
  let last = at, first = null;
  for (let i = 1; i < seen.length; ++i) {
    if (seen[i].at < at) continue;
    first ??= pick(seen[i - 1]);
    if (Math.abs(pick(seen[i]) - pick(seen[i - 1])) > 0.005) last = seen[i].at;
  }
  return { ms: last - at, deg: Math.abs(pick(seen.at(-1)) - (first ?? pick(seen.at(-1)))) };
}
