// The head's wizard in the page, on a running service whose head is made otherwise than its configuration says.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { calibrationDesk } from "./calibration_desk.mjs";
import { ConfigurationStage, TOKEN } from "./configuration_stage.mjs";
import { Modbus, PICTURES, Stage, browser, openPage, until } from "./stage.mjs";

const CAMERA = 'source = "simulated"\nwidth_px = 320\nheight_px = 240\nrate_hz = 60';
const CAMERA_MM = [30, -8, 20];
const HEAD = `[modbus]
allow_writes = true
[body]
tilt_axis_mm = [0, 0, 40] # as drawn
[pan_tilt]
driver = "simulated"
[pan_tilt.pan]
min_deg = -16
max_deg = 16
slew_deg_per_s = 200
[pan_tilt.tilt]
min_deg = -14
max_deg = 14
slew_deg_per_s = 200
[simulation]
duration_s = 3000
[[simulation.robot]]
t_s = 0
y_mm = 1100
heading_deg = -90
[simulation.head]
camera_mm = [${CAMERA_MM}]
camera_rpy_deg = [1.0, -2.0, 1.5]
pan_calibration = [[-63.6, 900], [63.6, 2100]]
tilt_calibration = [[-54, 900], [54, 2100]]
[simulation.servo]
backlash_deg = 0.4
delay_ms = 20
`;
const HEAD_STATE = 146, HOLD = 5;
let folder, own, modbus, chrome, post, state;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  folder = fs.mkdtempSync("/dev/shm/ninedot-calibrate-");
  own = await ConfigurationStage.open({ camera: CAMERA, extra: HEAD, web: `recordings = "${folder}/recordings"`, permitted: false });
  ({ post, state } = calibrationDesk(own));
  modbus = await Modbus.open(own.stage.modbusPort);
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  modbus?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(folder, { recursive: true });
});
afterEach(async () => {
  await Promise.all(chrome.contexts().map((context) => context.close()));
  await post("cancel");
  await until("nothing is under way", async () => (await state()).phase !== "running");
});

const headState = async () => (await modbus.read(HEAD_STATE, 1))[0];
const follows = () => until("the head follows", async () => [1, 2, 3, 4].includes(await headState()));

async function openHead(options = {}) {
  const opened = await openPage(chrome, options.on ?? own, "calibrate", { hash: `#token=${TOKEN}`, ...options });
  await opened.page.evaluate(() => { location.hash = "calibrate"; });
  return opened;
}

async function start(page) {
  await page.click("#head-start");
  await page.waitForSelector("dialog[open] #head-sure-title");
  await page.click("#head-sure");
}

for (const [theme, size] of [["light", "desktop"], ["dark", "desktop"], ["light", "phone"], ["dark", "phone"]])
  test(`the head's calibration is shown, ${theme}, on a ${size}`, async () => {
    const { page, close } = await openHead({ theme, size });
    await start(page);
    await page.waitForFunction(() => /^Stop \d+ of \d+/.test(document.querySelector("#head-state").textContent) && document.querySelector("#head-stops").dataset.stops >= 8, null, { timeout: 60000 });
    assert.equal(await headState(), HOLD);
    await page.evaluate(() => window.scrollTo(0, 0));
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
    await page.screenshot({ path: path.join(PICTURES, `calibrate-head-${theme}-${size}.png`), fullPage: true });
    await page.click("#head-cancel");
    await page.waitForFunction(() => /Cancelled/.test(document.querySelector("#head-state").textContent));
    await follows();
    assert.deepEqual(fs.readdirSync(path.join(folder, "recordings/calibrations")), [], "a cancelled one leaves nothing");
    await close();
  });

test("who may not moves nothing", async () => {
  for (const [why, answer, status] of [
    ["no token", await post("start pan-tilt", { token: null }), 401],
    ["a foreign page", await post("start pan-tilt", { headers: { Origin: "http://elsewhere.example" } }), 403],
    ["a foreign site", await post("start pan-tilt", { headers: { "Sec-Fetch-Site": "cross-site" } }), 403],
    ["more than that", await post("start pan-tilt --stops 25x25"), 400],
  ]) assert.equal(answer.status, status, why);
  await follows();
  const other = await Stage.open({ web: `token_file = "${own.folder}/token"\nrecordings = "${folder}/other"` });
  const { page, close } = await openHead({ on: other });
  await page.waitForFunction(() => /set `driver` of \[pan_tilt\]/.test(document.querySelector("#head-state").textContent));
  assert.ok(await page.locator("#head-start").isDisabled());
  assert.equal((await post("start pan-tilt", { port: other.port })).status, 403);
  await close();
  await other.close();
});

test("one that a controller has is not taken, and it is said whose it is", async () => {
  const [sequence] = await modbus.read(101, 1);
  await modbus.write(105, [300, 0]);
  await modbus.write(100, [2, sequence + 1]);
  await until("it stands there", async () => (await modbus.read(103, 1))[0] === 2 || (await headState()) === HOLD);
  const { page, close } = await openHead();
  await start(page);
  await page.waitForFunction(() => /a controller has sent the head where it is/.test(document.querySelector("#head-state").textContent));
  assert.equal(await headState(), HOLD);
  await modbus.write(100, [1, sequence + 2]);
  await follows();
  await close();
});

test("the whole way: the head goes from stop to stop by itself, and what comes of it is put to use", async (t) => {
  const before = own.file();
  const { page, close } = await openHead();
  await start(page);
  await until("it is under way", async () => (await state()).phase === "running");
  // Until its first news the view tells how the one before ended.
  await page.waitForFunction(() => /^Stop \d+ of/.test(document.querySelector("#head-state").textContent), null, { timeout: 60000 });
  await page.waitForFunction(() => /Calibrated|No calibration/.test(document.querySelector("#head-state").textContent), null, { timeout: 300000 });
  const end = await state();
  assert.equal(end.phase, "done", JSON.stringify(end).slice(0, 500));
  t.diagnostic(`${end.news.stops} stops: directions foretold to ${end.news.foretold_deg} deg, ${end.news.before_deg} before`);
  assert.ok(end.news.stops >= 40 && end.news.foretold_deg < 0.4 && end.news.before_deg > 1, JSON.stringify(end.news));
  await follows();
  assert.equal(await page.locator("#head-commands").textContent(), `ninedot apply --head ${folder}/recordings/calibrations/${end.name}/head.toml --config ${own.stage.config}`);
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#head-download")]);
  const toml = fs.readFileSync(await download.path(), "utf8");
  const camera = /camera_mm = \[(.*?)\]/.exec(toml)[1].split(",").map(Number);
  for (const [i, value] of CAMERA_MM.entries()) assert.ok(Math.abs(camera[i] - value) < 4, `camera_mm is ${camera}, and in truth ${CAMERA_MM}`);
  await close();
  await own.permit();
  const again = await openHead();
  await again.page.click("#head-use");
  await again.page.click("#sure");
  await again.page.waitForFunction(() => /^(up|back|refused|failed)$/.test(document.querySelector("#calibrate-applying").dataset.state), null, { timeout: 60000 });
  assert.equal(await again.page.locator("#calibrate-applying").getAttribute("data-state"), "up", await again.page.locator("#calibrate-applying").textContent());
  assert.ok(own.file().includes(`camera_mm = [${/camera_mm = \[(.*?)\]/.exec(toml)[1]}]`), own.file());
  assert.ok(own.file().startsWith(before.slice(0, before.indexOf("[body]"))), "nothing else is touched");
  assert.match(own.file(), /\] # as drawn/);
  await again.page.evaluate(() => window.scrollTo(0, 0));
  await again.page.screenshot({ path: path.join(PICTURES, "calibrate-head-used.png"), fullPage: true });
  await own.runs();
  await own.servedAnew();
  await again.close();
});
