// A running service with its page, and a browser to look at it: for the tests beside it.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import net from "node:net";
import path from "node:path";

export const SOURCE = process.env.NINEDOT_SOURCE_DIR ?? path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), "../..");
export const BIN = process.env.NINEDOT_BIN_DIR ?? path.join(SOURCE, "build/release/bin");
export const PICTURES = process.env.NINEDOT_WEB_PICTURES ?? path.join(BIN, "../web");
const PATIENCE_MS = 20000;

export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export async function until(what, condition) {
  const deadline = Date.now() + PATIENCE_MS;
  for (;;) {
    const value = await condition().catch(() => false);
    if (value) return value;
    if (Date.now() > deadline) throw new Error(`never came true: ${what}`);
    await pause(50);
  }
}

export const freePort = () => new Promise((resolve) => {
  const server = net.createServer().listen(0, "127.0.0.1", () => {
    const { port } = server.address();
    server.close(() => resolve(port));
  });
});

export function get(port, target, { method = "GET", headers = {}, body = null, host = "127.0.0.1" } = {}) {
  return new Promise((resolve, reject) => {
    const request = http.request({ host, port, path: target, method, headers, agent: false, timeout: PATIENCE_MS }, (response) => {
      const parts = [];
      response.on("data", (part) => parts.push(part));
      response.on("end", () => resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(parts) }));
      response.on("error", reject);
    });
    request.on("error", reject);
    request.on("timeout", () => request.destroy(new Error("no answer")));
    request.end(body);
  });
}

// The service's registers as any controller reads and writes them.
export class Modbus {
  constructor(port) {
    Object.assign(this, { port, number: 0, asked: new Map() });
  }

  static async open(port) {
    const client = new Modbus(port);
    await client.connect();
    return client;
  }

  connect() {
    this.rest = Buffer.alloc(0);
    return new Promise((resolve, reject) => {
      this.socket = net.connect(this.port, "127.0.0.1", resolve).setNoDelay(true).on("error", reject);
      this.socket.on("data", (data) => this.hear(data));
      this.socket.on("close", () => {
        for (const { reject: forget } of this.asked.values()) forget(new Error("the service closed the connection"));
        this.asked.clear();
      });
    });
  }

  hear(data) {
    this.rest = Buffer.concat([this.rest, data]);
    while (this.rest.length >= 6 && this.rest.length >= 6 + this.rest.readUInt16BE(4)) {
      const reply = this.rest.subarray(0, 6 + this.rest.readUInt16BE(4));
      this.rest = this.rest.subarray(reply.length);
      this.asked.get(reply.readUInt16BE(0))?.resolve(reply.subarray(7));
      this.asked.delete(reply.readUInt16BE(0));
    }
  }

  async request(pdu) {
    if (this.socket.destroyed) await this.connect();  // one that was idle for a minute is closed
    const head = Buffer.alloc(7);
    this.number = (this.number + 1) & 0xffff;
    head.writeUInt16BE(this.number, 0);
    head.writeUInt16BE(pdu.length + 1, 4);
    const reply = new Promise((resolve, reject) => this.asked.set(this.number, { resolve, reject }));
    this.socket.write(Buffer.concat([head, pdu]));
    return reply;
  }

  async read(first, count) {
    const reply = await this.request(Buffer.from([3, first >> 8, first & 255, 0, count]));
    return Array.from({ length: count }, (_, i) => reply.readInt16BE(2 + 2 * i));
  }

  write(first, values) {
    return this.request(Buffer.from([16, first >> 8, first & 255, 0, values.length, 2 * values.length, ...values.flatMap((v) => [(v >> 8) & 255, v & 255])]));
  }

  close() {
    this.socket.destroy();
  }
}

// Looks straight at a landmark that hangs at x and y 0, 1200 mm high.
export const STANDING_ROBOT = `[simulation]
duration_s = 3600.0
camera_delay_ms = 20.0
[[simulation.robot]]
t_s = 0.0
x_mm = 0.0
y_mm = 1500.0
z_mm = 1200.0
heading_deg = -90.0
`;

const started = new Set();
process.once("exit", () => started.forEach((child) => child.kill("SIGKILL")));

// options: {recording, camera: text under [camera] in its place, web: text under [web], extra: further configuration, arguments: of ninedot-web}
export class Stage {
  static async open(options = {}) {
    const stage = new Stage();
    stage.folder = fs.mkdtempSync(path.join("/dev/shm", "ninedot-web-test-"));
    stage.port = await freePort();
    stage.modbusPort = await freePort();
    stage.config = path.join(stage.folder, "config.toml");
    const recording = path.join(SOURCE, "tests/recordings", options.recording ?? "approach");
    const camera = options.camera ?? `source = "recording"\ndevice = "${recording}"\nrate_hz = 35.0`;
    fs.writeFileSync(stage.config, `${options.top ?? ""}
[camera]
${camera}
[modbus.tcp]
port = ${stage.modbusPort}
[tap]
enabled = true
path = "${stage.folder}/tap"
[web]
port = ${stage.port}
${options.web ?? ""}
${options.extra ?? ""}
`);
    stage.service = stage.start("ninedotd");
    stage.web = stage.start("ninedot-web", options.arguments);
    await until("the page answers", async () => (await get(stage.port, "/")).status === 200);
    await until("the service gives frames", async () => fs.existsSync(path.join(stage.folder, "tap")));
    return stage;
  }

  start(program, more = []) {
    const log = fs.openSync(path.join(this.folder, `${program}.log`), "a");
    const child = spawn(path.join(BIN, program), ["--config", this.config, ...more], { stdio: ["ignore", log, log] });
    fs.closeSync(log);
    // A test that failed leaves its programs running: they keep nobody waiting, and end with the tests.
    child.unref();
    started.add(child);
    return child;
  }

  log(program) {
    return fs.readFileSync(path.join(this.folder, `${program}.log`), "utf8");
  }

  async end(child) {
    if (child.exitCode !== null || child.signalCode !== null) return child.exitCode;
    child.ref();
    const ended = new Promise((resolve) => child.once("exit", resolve));
    child.kill("SIGTERM");
    return ended;
  }

  async close() {
    const status = [await this.end(this.web), await this.end(this.service)];
    fs.rmSync(this.folder, { recursive: true, force: true });
    return status;
  }

  async live(viewer = "tests0001", headers = {}) {
    const { status, body } = await get(this.port, `/api/live?viewer=${viewer}&picture=0`, { headers });
    return status === 200 ? JSON.parse(body.subarray(4, 4 + body.readUInt32BE(0))) : { status };
  }
}

// draws: the browser is to have WebGL, by its own processor's work alone
export async function browser({ draws = false } = {}) {
  const { chromium } = await import("playwright-core");
  return chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: ["--headless", "--no-sandbox", ...(draws ? ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-gpu", "--disable-3d-apis"]), "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
}

export const SIZES = { desktop: { width: 1360, height: 900 }, phone: { width: 390, height: 844 } };

// A page whose every mistake is the test's: errors, refused content, requests that lead elsewhere.
export async function openPage(chrome, on, view, { theme = "light", size = "desktop", hash = `#${view}`, touch = false } = {}) {
  const context = await chrome.newContext({ viewport: SIZES[size], colorScheme: theme, deviceScaleFactor: size === "phone" ? 2 : 1, hasTouch: touch });
  const page = await context.newPage();
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error" && !/40[139]|412|429|503|ERR_CONNECTION|ERR_SOCKET_NOT_CONNECTED|ERR_EMPTY_RESPONSE|ERR_INTERNET/.test(message.text())) wrong.push(message.text()); });
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (!["blob:", "data:"].includes(url.protocol) && url.port !== String(on.port)) wrong.push(`fetched from outside: ${url}`);
  });
  await page.goto(`http://127.0.0.1:${on.port}/${hash}`);
  return { page, context, wrong, close: async () => { await context.close(); assert.deepEqual(wrong, []); } };
}
