// A service whose configuration the page may change: what systemd does between ninedot-web and `ninedot apply` is done here.
import { spawn } from "node:child_process";
import fs from "node:fs";
import net from "node:net";
import path from "node:path";

import { BIN, Modbus, Stage, get, until } from "./stage.mjs";

export const TOKEN = "0123456789abcdef0123456789abcdef";

// As systemctl with a service of Type=notify.
const RESTART = `#!/bin/bash
cd "$(dirname "$0")"
kill "$(cat pid)" 2> /dev/null; while kill -0 "$(cat pid)" 2> /dev/null; do sleep 0.02; done
setsid "${BIN}/ninedotd" --config config.toml < /dev/null > /dev/null 2> restarted.log & pid=$!
echo "$pid" > pid
for _ in $(seq 1000); do
  grep -q "read the position with" restarted.log && exit 0
  kill -0 "$pid" 2> /dev/null || { tail -n 1 restarted.log >&2; exit 1; }
  sleep 0.02
done
`;

export class ConfigurationStage {
  // options: {token: false: none, permitted: false: nobody listens, web: lines of [web], and those of Stage}
  static async open(options = {}) {
    const own = new ConfigurationStage();
    own.folder = fs.mkdtempSync("/dev/shm/ninedot-apply-");
    own.socket = path.join(own.folder, "socket");
    fs.writeFileSync(path.join(own.folder, "token"), `${TOKEN}\n`, { mode: 0o600 });
    own.stage = await Stage.open({ ...options,
      web: `${options.token === false ? "" : `token_file = "${own.folder}/token"`}\n${options.web ?? ""}`,
      arguments: ["--apply-socket", own.socket],
    });
    own.script = path.join(own.stage.folder, "restart.sh");
    fs.writeFileSync(own.script, RESTART, { mode: 0o755 });
    fs.writeFileSync(path.join(own.stage.folder, "pid"), String(own.stage.service.pid));
    own.text = fs.readFileSync(own.stage.config, "utf8");
    if (options.permitted !== false) await own.permit();
    return own;
  }

  // In the place of ninedot-apply.socket and ninedot-apply@.service.
  permit() {
    this.server = net.createServer({ allowHalfOpen: true }, (connection) => {
      const command = spawn(path.join(BIN, "ninedot"), ["apply", "--page", "--config", this.stage.config, "--restart", this.script], { stdio: ["pipe", "pipe", "ignore"] });
      connection.on("error", () => {});
      command.stdin.on("error", () => {});
      connection.pipe(command.stdin);
      command.stdout.pipe(connection);
    });
    return new Promise((resolve) => this.server.listen(this.socket, resolve));
  }

  get port() {
    return this.stage.port;
  }

  file() {
    return fs.readFileSync(this.stage.config, "utf8");
  }

  async state() {
    return JSON.parse((await get(this.port, "/api/configuration", { headers: { Authorization: `Bearer ${TOKEN}` } })).body);
  }

  post(what, body, { token = TOKEN, headers = {} } = {}) {
    return get(this.port, `/api/configuration/${what}`, { method: "POST", body,
      headers: { Origin: `http://127.0.0.1:${this.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": Buffer.byteLength(body),
        ...(token ? { Authorization: `Bearer ${token}` } : {}), ...headers } });
  }

  ended() {
    return until("it ended", async () => {
      const { apply } = await this.state();
      return apply.state !== "running" && apply;
    });
  }

  async runs(port = this.stage.modbusPort) {
    const modbus = await until(`a service answers at ${port}`, () => Modbus.open(port));
    await until("frames come", async () => (await modbus.read(2, 1))[0] > 3);
    modbus.close();
  }

  // To be called after each apply that ended up: ninedot-web serves by the new file a moment later, and whoever asks just then gets no answer.
  servedAnew() {
    this.served = (this.served ?? 1) + 1;
    return until("it is served anew", async () => this.stage.log("ninedot-web").match(/http:/g).length === this.served);
  }

  async close() {
    this.server?.close();
    const pid = Number(fs.readFileSync(path.join(this.stage.folder, "pid"), "utf8"));
    if (pid !== this.stage.service.pid) process.kill(pid, "SIGTERM");
    const status = await this.stage.close();
    fs.rmSync(this.folder, { recursive: true });
    return status;
  }
}
