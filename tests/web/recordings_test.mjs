// The Recordings view against a running service: start, stop, replay, download, delete, and what a lost landmark leaves.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { BIN, PICTURES, SOURCE, STANDING_ROBOT, Stage, browser, get, openPage, pause, until } from "./stage.mjs";

const TOKEN = "0123456789abcdef0123456789abcdef";
const PATH = "/api/recordings";
const authorised = { Authorization: `Bearer ${TOKEN}` };
let folder, own, chrome;

// options: {web, camera, extra} as of Stage
async function openStage(name, options = {}) {
  const kept = path.join(folder, name);
  const stage = await Stage.open({ ...options, web: `token_file = "${folder}/token"\nrecordings = "${kept}"\n${options.web ?? ""}` });
  return Object.assign(stage, { kept });
}

const state = async (on = own) => JSON.parse((await get(on.port, PATH, { headers: authorised })).body);
const post = (body, { token = TOKEN, headers = {}, on = own } = {}) => get(on.port, PATH, { method: "POST", body,
  headers: { Origin: `http://127.0.0.1:${on.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": Buffer.byteLength(body), ...(token ? { Authorization: `Bearer ${token}` } : {}), ...headers } });
const ready = (on = own) => until("a frame", async () => (await on.live("readytest1", authorised)).frame);

// The name of one that was recorded until `frames` were in it.
async function record(frames, on = own) {
  const before_ = new Set((await state(on)).recordings.map(({ name }) => name));
  assert.equal((await post("start", { on })).status, 200);
  await until(`${frames} frames`, async () => (await state(on)).running?.frames >= frames);
  assert.equal((await post("stop", { on })).status, 200);
  return until("it is kept", async () => (await state(on)).recordings.find(({ name }) => !before_.has(name)));
}

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  folder = fs.mkdtempSync("/dev/shm/ninedot-recordings-");
  fs.writeFileSync(path.join(folder, "token"), `${TOKEN}\n`, { mode: 0o600 });
  own = await openStage("kept");
  await ready();
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(folder, { recursive: true, force: true });
});
afterEach(() => Promise.all(chrome.contexts().map((context) => context.close())));

async function openView(options = {}) {
  const opened = await openPage(chrome, options.on ?? own, "recordings", { hash: `#token=${TOKEN}`, ...options });
  await opened.page.evaluate(() => { location.hash = "recordings"; });
  await opened.page.waitForFunction(() => document.querySelector("#recording-room")?.textContent);
  return opened;
}

const shownFrame = (page, number) => page.waitForFunction((wanted) => document.querySelector("#replay-picture")?.dataset.frame === String(wanted), number);

test("what a button started and stopped is listed, replayed with what was found, and deleted when asked twice", async () => {
  const { page, close } = await openView();
  await page.waitForFunction(() => !document.querySelector("#record").disabled);
  await page.click("#record");
  await page.waitForFunction(() => /Recording.*frames/.test(document.querySelector("#recording-state").textContent));
  await until("enough", async () => (await state()).running?.frames >= 30);
  await page.keyboard.press("r");
  await page.waitForFunction(() => document.querySelectorAll("#recordings li").length === 1);
  const [one] = (await state()).recordings;
  assert.equal(one.why, "asked");
  assert.equal(one.ended, "stopped by hand");
  assert.ok(Math.abs(one.ms - ((one.frames + one.missed - 1) * 1000) / 35) < 200, JSON.stringify(one));

  await page.getByRole("button", { name: "Replay" }).click();
  await shownFrame(page, 0);
  const coloured = () => page.evaluate(() => {
    const canvas = document.querySelector("#replay-picture");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += Math.abs(data[i] - data[i + 1]) > 60 ? 1 : 0;
    return count;
  });
  assert.ok((await coloured()) > 300, "the overlay is drawn");
  assert.match(await page.locator("#replay-what").textContent(), /Landmark 0: x .* of 9 dots/);
  await page.keyboard.press("o");
  assert.equal(await coloured(), 0, "a grey camera's picture");
  await page.keyboard.press("o");
  await page.keyboard.press(".");
  await shownFrame(page, 1);
  await page.keyboard.press("ArrowRight");
  await shownFrame(page, 2);
  await page.keyboard.press(",");
  await shownFrame(page, 1);
  const last = Number(/(\d+)$/.exec(await page.locator("#replay-slider").getAttribute("max"))[1]);
  await page.locator("#replay-slider").fill(String(last));
  await page.waitForFunction(() => document.querySelector("#replay-picture").dataset.frame > 20);
  await page.keyboard.press("Home");
  await page.locator("#replay-rate").selectOption("2");
  const started = Date.now();
  await page.keyboard.press(" ");
  await page.waitForFunction(() => document.querySelector("#replay-play").textContent === "Play" && document.querySelector("#replay-slider").value === document.querySelector("#replay-slider").max);
  const took = Date.now() - started;
  assert.ok(took > one.ms / 2 - 100 && took < one.ms / 2 + 3000, `${took} ms for ${one.ms} ms at twice the rate`);

  const deletes = page.getByRole("button", { name: /^Delete|^Really/ });
  await deletes.click();
  assert.equal(await deletes.textContent(), "Really delete?");
  await pause(1500);
  assert.equal((await state()).recordings.length, 1, "not yet");
  await deletes.click();
  await page.waitForFunction(() => document.querySelectorAll("#recordings li").length === 0 && document.querySelector("#replay").hidden);
  await until("gone from the disk", async () => fs.readdirSync(own.kept).length === 0);
  await close();
});

test("what is shown in the replay is what the service reported of that very picture", async () => {
  const one = await record(10);
  const file = async (name) => (await get(own.port, `${PATH}/${one.name}/${name}`, { headers: authorised }));
  const report = JSON.parse((await file("reports/000004.json")).body);
  const csv = (await file("frames.csv")).body.toString().trim().split("\n");
  const at = Number(csv.find((row) => row.startsWith("4,")).split(",")[1]) / 1e6;
  assert.ok(Math.abs(report.at_ms - at) < 14, `${report.at_ms} of a frame of ${at}: another one is 28 ms away`);
  const picture = await file("frames/000004.png");
  assert.equal(picture.headers["content-type"], "image/png");
  assert.ok(picture.body.equals(fs.readFileSync(path.join(own.kept, one.name, "frames/000004.png"))));
  assert.equal(JSON.parse((await file("camera.json")).body).width, 640);
});

test("a download replays to the poses that the service reported", async () => {
  const { page, close } = await openView();
  const { name, frames } = await record(20);
  const row = page.locator(`#recordings li[data-name="${name}"]`);
  const [download] = await Promise.all([page.waitForEvent("download"), row.getByRole("button", { name: "Download" }).click()]);
  assert.equal(download.suggestedFilename(), `${name}.tar`);
  const out = fs.mkdtempSync(path.join(folder, "out-"));
  await download.saveAs(path.join(out, "a.tar"));
  execFileSync("tar", ["-xf", "a.tar"], { cwd: out });
  execFileSync(path.join(BIN, "ninedot"), ["replay", name, "--out", "poses.csv"], { cwd: out });
  const [header, ...rows] = fs.readFileSync(path.join(out, "poses.csv"), "utf8").trim().split("\n").map((row) => row.split(","));
  const column = (row, key) => Number(row[header.indexOf(key)]);
  assert.ok(rows.length >= frames - 2, `${rows.length} of ${frames}`);
  let compared = 0;
  for (const row of rows) {
    const report = JSON.parse(fs.readFileSync(path.join(out, name, "reports", `${row[header.indexOf("frame")].padStart(6, "0")}.json`)));
    // The service tracked; a replay begins with a full search, and its first frames have no track.
    if (!report.valid || !column(row, "valid")) continue;
    const off = ["x_mm", "y_mm", "z_mm"].map((key, i) => Math.abs(column(row, key) - report.in_landmark.mm[i]) / report.in_landmark.sigma_mm[i]);
    assert.ok(Math.max(...off) < 1.5, `frame ${row[0]}: ${off} sigma from the service's`);
    ++compared;
  }
  assert.ok(compared > rows.length / 2, `${compared} of ${rows.length}`);
  await close();
});

test("who has no token sees nothing and changes nothing; nor does another page, or another name", async () => {
  const one = await record(3);
  for (const target of [PATH, `${PATH}/${one.name}/download`, `${PATH}/${one.name}/frames/000000.png`])
    assert.equal((await get(own.port, target)).status, 401, target);
  const refused = async (status, what, body, options) => assert.equal((await post(body, options)).status, status, what);
  for (const body of ["start", "stop", `delete ${one.name}`]) {
    await refused(401, "no token", body, { token: null });
    await refused(401, "another token", body, { token: "0123456789abcdef0123456789abcdeF" });
    for (const origin of ["http://evil.example", "null", "", `http://localhost:${own.port}`]) await refused(403, `origin ${origin}`, body, { headers: { Origin: origin } });
    for (const site of ["cross-site", "none"]) await refused(403, `fetched from ${site}`, body, { headers: { "Sec-Fetch-Site": site } });
    await refused(421, "another name", body, { headers: { Host: "evil.example", Origin: "http://evil.example" } });
  }
  const { phase, recordings } = await state();
  assert.equal(phase, "idle");
  assert.ok(recordings.some(({ name }) => name === one.name));
  const open = await Stage.open({ web: `recordings = "${folder}/open"` });
  assert.equal((await get(open.port, PATH, { method: "POST", body: "start", headers: { Origin: `http://127.0.0.1:${open.port}`, "Content-Length": 5 } })).status, 403, "where there is no token");
  assert.equal((await get(open.port, PATH)).status, 200);
  await open.close();
});

test("a recording ends with the service, and what is there stays", async () => {
  const stage = await openStage("ended");
  await ready(stage);
  await post("start", { on: stage });
  await until("some frames", async () => (await state(stage)).running?.frames > 5);
  await stage.end(stage.service);
  const said = await until("it ended by itself", async () => { const now = await state(stage); return now.phase === "idle" && now; });
  assert.match(said.note, /ended by itself.*start ninedotd|ended by itself.*is ninedotd running/);
  assert.ok(said.recordings[0].frames > 5);
  await stage.close();
});

test("what a killed ninedot-web left is mended when it starts again, and said to be cut off", async () => {
  const stage = await openStage("killed");
  await ready(stage);
  await post("start", { on: stage });
  await until("some frames", async () => (await state(stage)).running?.frames > 5);
  const ended = new Promise((resolve) => stage.web.once("exit", resolve));
  stage.web.kill("SIGKILL");
  await ended;
  stage.web = stage.start("ninedot-web");
  const [one] = await until("it is listed", async () => (await state(stage)).recordings);
  assert.match(one.ended, /cut off/);
  execFileSync(path.join(BIN, "ninedot"), ["replay", path.join(stage.kept, one.name)]);
  await stage.close();
});

// A simulated robot whose landmark is covered every now and then.
const HIDING = {
  camera: 'source = "simulated"\nwidth_px = 320\nheight_px = 240\nrate_hz = 35.0',
  web: "loss_seconds = 2\n",
  extra: `[[landmarks]]
id = 1
position_mm = [0.0, 0.0, 1200.0]
${STANDING_ROBOT}[[simulation.hidden]]
from_s = 6.0
to_s = 9.0
`,
};

test("a landmark that is lost leaves what was seen before, as a recording", async (t) => {
  const stage = await openStage("losses", HIDING);
  const loss = await until("a loss is kept", async () => (await state(stage)).recordings.find(({ why }) => why === "loss"));
  t.diagnostic(`${loss.frames} frames, ${loss.missed} left out, ${loss.ms} ms, ${loss.bytes} bytes: ${loss.ended}`);
  assert.ok(loss.ms > 2500 && loss.ms < 3300, `${loss.ms} ms`);
  assert.ok(loss.frames > 70, `${loss.frames} frames`);
  const reports = fs.readdirSync(path.join(stage.kept, loss.name, "reports")).sort().map((file) => JSON.parse(fs.readFileSync(path.join(stage.kept, loss.name, "reports", file))));
  const valid = reports.filter((report) => report.valid);
  const at = (report) => report.at_ms - valid.at(-1).at_ms;
  assert.ok(valid.length > 50 && reports.slice(-20).every((report) => !report.valid), `${valid.length} of ${reports.length}`);
  assert.ok(at(reports[0]) < -1900 && at(reports.at(-1)) > 950, `from ${at(reports[0])} to ${at(reports.at(-1))} ms of the loss`);

  const { page, close } = await openView({ on: stage });
  await page.getByRole("button", { name: "Replay" }).first().click();
  await shownFrame(page, 0);
  await page.keyboard.press("End");
  await page.waitForFunction(() => /Not valid: .*(dark spot|comes nearest)/.test(document.querySelector("#replay-what").textContent));
  await close();
  await stage.close();
});

// What was asked for and what a loss left, as they lie there when ninedot-web starts.
let shown = null;
async function stageOfBoth() {
  if (shown) return shown;
  const { name } = await record(40);
  const kept = path.join(folder, "shown");
  for (const [as, why] of [["20261123-081502-asked", "60 s, `recording_s` of [web], are over"], ["20261123-093012-loss", "complete"], ["20261123-101933-loss", "complete"]]) {
    fs.cpSync(path.join(own.kept, name), path.join(kept, as), { recursive: true });
    fs.writeFileSync(path.join(kept, as, "ended.txt"), why);
  }
  shown = await openStage("shown", { web: "loss_seconds = 3\n" });
  await until("it watches", async () => { const { loss } = await state(shown); return loss.phase === "watching" && loss.memory > 0; });
  return shown;
}
after(async () => { if (shown) await shown.close(); });

for (const theme of ["light", "dark"])
  for (const size of ["desktop", "phone"])
    test(`the view is shown with a replay, ${theme}, on a ${size}`, async () => {
      const { page, close } = await openView({ theme, size, on: await stageOfBoth() });
      await page.getByRole("button", { name: "Replay" }).first().click();
      await shownFrame(page, 0);
      await page.keyboard.press(".");
      await shownFrame(page, 1);
      await page.waitForFunction(() => /Ready/.test(document.querySelector("#recording-state").textContent));
      await page.evaluate(() => window.scrollTo(0, 0));
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
      await page.screenshot({ path: path.join(PICTURES, `recordings-${theme}-${size}.png`), fullPage: true });
      await close();
    });

// Median and 99 % of the frames between two states of the service's own histogram, as bins.
const quantileBin = (from, to, share) => {
  const counts = to.latency_bins.map((count, i) => count - from.latency_bins[i]);
  const total = counts.reduce((sum, count) => sum + count, 0);
  let below = 0;
  return counts.findIndex((count) => (below += count) >= share * total);
};
const ticksOf = (child) => {
  const fields = fs.readFileSync(`/proc/${child.pid}/stat`, "utf8").split(") ")[1].split(" ");
  return Number(fields[11]) + Number(fields[12]);
};
const residentOf = (child) => Number(/VmRSS:\s+(\d+)/.exec(fs.readFileSync(`/proc/${child.pid}/status`, "utf8"))[1]) / 1024;

test("what it costs: nothing while nobody asks; no latency of the service while it records and watches", async (t) => {
  const stage = await openStage("costs", { web: "loss_seconds = 3\n" });
  const idle = await openStage("idle");
  await Promise.all([ready(stage), ready(idle)]);
  const SECONDS = 6;
  const measure = async (on) => {
    const from = { frame: await ready(on) };
    await pause(6000);  // who looked has left
    const ticks = ticksOf(on.web);
    await pause(SECONDS * 1000);
    const percent = (ticksOf(on.web) - ticks) / SECONDS;
    const frame = await ready(on);
    return { percent, p50: quantileBin(from.frame, frame, 0.5), p99: quantileBin(from.frame, frame, 0.99), mb: residentOf(on.web), failed: frame.failed };
  };
  const ms = (bin) => (0.1 * 2 ** (bin / 4)).toFixed(2);
  const tell = (what, one) => t.diagnostic(`${what}: ${one.percent.toFixed(2)} % of a processor, ${one.mb.toFixed(0)} MB, latency median ${ms(one.p50)} ms, 99 % ${ms(one.p99)} ms`);
  const calm = await measure(idle);
  tell("nobody asks", calm);
  const watching = await measure(stage);
  tell("3 s before a loss are kept", watching);
  await post("start", { on: stage });
  const recording = await measure(stage);
  tell("that and a recording", recording);
  const { running } = await state(stage);
  t.diagnostic(`${running.frames} frames recorded, ${running.missed} missed, ${(running.bytes / running.frames / 1000).toFixed(0)} kB each`);
  assert.ok(calm.percent < 0.5, `${calm.percent} % while nobody asks`);
  assert.ok(watching.percent < 8, `${watching.percent} % while nothing is lost`);
  assert.ok(recording.mb < 110, `${recording.mb} MB of the unit's 128`);
  assert.ok(recording.p50 <= calm.p50 + 3, `median: bin ${calm.p50} became ${recording.p50}`);
  assert.equal(recording.failed, 0);
  await Promise.all([stage.close(), idle.close()]);
});
