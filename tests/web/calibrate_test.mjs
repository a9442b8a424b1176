// The wizard in the page, on a running service whose camera sees a sheet that is held as somebody does who calibrates.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { HEIGHT, WIDTH, movingSheet } from "./moving_sheet.mjs";
import { authorised, calibrationDesk } from "./calibration_desk.mjs";
import { ConfigurationStage, TOKEN } from "./configuration_stage.mjs";
import { PICTURES, Stage, browser, get, openPage, pause, until } from "./stage.mjs";

const SCENE = movingSheet();
let folder, own, stage, chrome, post, state;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  folder = fs.mkdtempSync("/dev/shm/ninedot-calibrate-");
  fs.writeFileSync(path.join(folder, "token"), `${TOKEN}\n`, { mode: 0o600 });
  own = await ConfigurationStage.open({ camera: SCENE.camera, extra: SCENE.simulation, web: `recordings = "${folder}/recordings"`, permitted: false });
  stage = own.stage;
  ({ post, state } = calibrationDesk(stage));
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(folder, { recursive: true });
});
afterEach(async () => {
  await Promise.all(chrome.contexts().map((context) => context.close()));
  await post("cancel");
  await until("nothing is under way", async () => (await state()).phase !== "running");
});

const open = async (options = {}) => {
  const opened = await openPage(chrome, options.on ?? stage, "calibrate", { hash: `#token=${TOKEN}`, ...options });
  await opened.page.evaluate(() => { location.hash = "calibrate"; });
  return opened;
};
const live = () => until("a frame comes", async () => {
  const message = await stage.live("calibratetest", authorised);
  return message.frame && message;
});
const calibrations = () => fs.readdirSync(path.join(folder, "recordings/calibrations"));
// Children of ninedot-web, by the kernel's own list.
const children = () => fs.readFileSync(`/proc/${stage.web.pid}/task/${stage.web.pid}/children`, "utf8").trim().split(" ").filter(Boolean).length
  + fs.readdirSync(`/proc/${stage.web.pid}/task`).filter((task) => task !== String(stage.web.pid)).reduce((sum, task) => sum + fs.readFileSync(`/proc/${stage.web.pid}/task/${task}/children`, "utf8").trim().split(" ").filter(Boolean).length, 0);

for (const [theme, size] of [["light", "desktop"], ["dark", "desktop"], ["light", "phone"], ["dark", "phone"]])
  test(`calibrate is shown, ${theme}, on a ${size}`, async () => {
    const { page, close } = await open({ theme, size });
    await page.waitForFunction(() => /Ready|Cancelled/.test(document.querySelector("#calibrate-state").textContent));
    await page.click("#calibrate-start");
    await page.waitForFunction(() => /^[5-9] views|^\d\d views/.test(document.querySelector("#calibrate-wanted").textContent), null, { timeout: 60000 });
    await page.waitForFunction(() => document.querySelector("#picture").dataset.ghost && !/No sheet/.test(document.querySelector("#calibrate-looked").textContent));
    await page.evaluate(() => window.scrollTo(0, 0));
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
    await page.screenshot({ path: path.join(PICTURES, `calibrate-${theme}-${size}.png`), fullPage: true });
    await page.click("#calibrate-cancel");
    await page.waitForFunction(() => /Cancelled/.test(document.querySelector("#calibrate-state").textContent));
    assert.equal(await page.locator("#calibrate-result").isVisible(), false);
    await close();
    await until("the child is gone", async () => children() === 0);
    assert.deepEqual(calibrations(), [], "a cancelled one leaves nothing");
  });

test("who may not begins nothing, and paths lead nowhere else", async () => {
  for (const [why, answer, status] of [
    ["no token", await post("start camera", { token: null }), 401],
    ["a foreign page", await post("start camera", { headers: { Origin: "http://elsewhere.example" } }), 403],
    ["a foreign site", await post("start camera", { headers: { "Sec-Fetch-Site": "cross-site" } }), 403],
    ["nothing of ours", await post("start camera; reboot"), 400],
    ["too long", await post("x".repeat(129)), 413],
    ["nothing to cancel", await post("cancel"), 409],
    ["nothing to finish", await post("finish"), 409],
  ]) assert.equal(answer.status, status, why);
  assert.equal((await get(stage.port, "/api/calibrate", { method: "PUT", headers: authorised })).status, 405);
  for (const target of ["20261123-121415/../../../token", "../token", "%2e%2e/token", "20261123-121415/camera.yaml%00", "20261123-121415/", "x/camera.svg", "20261123-121415/camera-views/camera.yaml", ""])
    assert.equal((await get(stage.port, `/api/calibrate/${target}`, { headers: authorised })).status, 404, target);
  assert.equal(children(), 0);
});

test("two who press at once begin one", async () => {
  const answers = await Promise.all(Array.from({ length: 6 }, () => post("start camera")));
  assert.deepEqual(answers.map(({ status }) => status).sort(), [200, 409, 409, 409, 409, 409]);
  assert.equal(children(), 1);
});

test("a killed page's process takes the wizard along", async () => {
  const other = await Stage.open({ camera: SCENE.camera, extra: SCENE.simulation, web: `token_file = "${folder}/token"\nrecordings = "${folder}/other"` });
  assert.equal((await post("start camera", { port: other.port })).status, 200);
  const child = await until("it runs", async () => fs.readdirSync("/proc").find((pid) => /^\d+$/.test(pid) && fs.readFileSync(`/proc/${pid}/cmdline`, "utf8").includes(`${folder}/other/calibrations`)));
  other.web.kill("SIGKILL");
  await until("it is gone", async () => !fs.existsSync(`/proc/${child}`) || /^State:\tZ/m.test(fs.readFileSync(`/proc/${child}/status`, "utf8")));
  await other.close();
});

test("without a folder the view says what to set", async () => {
  const other = await Stage.open({ camera: SCENE.camera, extra: SCENE.simulation, web: `token_file = "${folder}/token"` });
  const { page, close } = await open({ on: other });
  await page.waitForFunction(() => /set `recordings` of \[web\]/.test(document.querySelector("#calibrate-state").textContent));
  assert.ok(await page.locator("#calibrate-start").isDisabled());
  assert.equal((await post("start camera", { port: other.port })).status, 403);
  await close();
  await other.close();
});

// The service gets the new calibration, and its configuration names it.
async function useIt(name, yaml) {
  const config = own.file();
  await own.permit();
  const { page, close } = await open();
  await page.click("#calibrate-use");
  await page.click("#sure");
  await page.waitForFunction(() => /^(up|back|refused|failed)$/.test(document.querySelector("#calibrate-applying").dataset.state), null, { timeout: 60000 });
  assert.equal(await page.locator("#calibrate-applying").getAttribute("data-state"), "up", await page.locator("#calibrate-applying").textContent());
  assert.equal(own.file(), config.replace("[camera]\n", '[camera]\ncalibration = "camera.yaml"\n'));
  assert.equal(fs.readFileSync(path.join(stage.folder, "camera.yaml"), "utf8"), yaml);
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.screenshot({ path: path.join(PICTURES, "calibrate-used.png"), fullPage: true });
  await own.runs();
  await own.servedAnew();
  await close();
  assert.equal((await post(`use ${name}`)).status, 202, "the same again");
  const again = await own.ended();
  assert.equal(again.state, "unchanged", JSON.stringify(again));
  assert.equal((await post("use 20200101-000000")).status, 409);
}

test("the whole way: coverage grows, each view is asked for, and what comes of it is the camera's lens", async (t) => {
  const { page, close } = await open();
  await page.waitForFunction(() => !document.querySelector("#calibrate-start").disabled);
  const before = await live();
  await page.keyboard.press("3");
  await page.locator("#calibrate-start").focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => /Bring the sheet to the dashed outline/.test(document.querySelector("#calibrate-state").textContent), null, { timeout: 20000 });
  const seen = [];
  let { news } = await state();
  assert.equal(news.ghost.outlines.length, 10, "the sheet and its nine dots");
  for (const [u, v] of news.ghost.outlines.slice(1).flat()) assert.ok(u > -2 && v > -2 && u < WIDTH + 1 && v < HEIGHT + 1, "the ghost's dots are in the picture");
  await until("views come", async () => {
    ({ news } = await state());
    const sum = news?.parts?.reduce((a, b) => a + b, 0);
    if (sum !== undefined && sum !== seen.at(-1)) seen.push(sum);
    return seen.length >= 6;
  });
  assert.deepEqual(seen, [...seen].sort((a, b) => a - b), "coverage only grows");
  const label = await page.locator("#coverage").getAttribute("aria-label");
  assert.match(label, /views in the nine parts, row by row: (\d+, ){8}\d+/);
  // The scene looks at the sheet from above or below in no view: those two tilts stay wanted.
  const deadline = Date.now() + 240000;
  do {
    await pause(500);
    ({ news } = await state());
  } while (!(news.state === "gathering" && news.views >= 24 && news.parts.every((count) => count > 0) && !/tilted to the/.test(news.wanted.join())) && Date.now() < deadline);
  await page.click("#calibrate-finish");
  await page.waitForFunction(() => /Calibrated|No calibration/.test(document.querySelector("#calibrate-state").textContent), null, { timeout: 240000 });
  const end = await state();
  assert.equal(end.phase, "done", JSON.stringify(end).slice(0, 500));
  t.diagnostic(`${end.news.views} views: focal length ${end.news.focal_px[0]} px of 720, directions to ${end.news.directions_px} px`);
  assert.ok(Math.abs(end.news.focal_px[0] - 720) < 0.7, `a tenth of a percent: ${end.news.focal_px[0]}`);
  await page.waitForFunction(() => document.querySelector("#calibrate-drawing")?.naturalWidth > 100);
  assert.equal(await page.locator("#calibrate-commands").textContent(), `ninedot apply --calibration ${folder}/recordings/calibrations/${end.name}/camera.yaml --config ${stage.config}`);
  assert.equal(await page.locator("#calibrate-use").count(), 0, "nobody has permitted it");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#calibrate-download")]);
  const yaml = fs.readFileSync(await download.path(), "utf8");
  assert.equal(yaml, fs.readFileSync(path.join(folder, "recordings/calibrations", end.name, "camera.yaml"), "utf8"));
  assert.match(yaml, /distortion_model/);
  assert.ok(fs.readdirSync(path.join(folder, "recordings/calibrations", end.name, "camera-views/frames")).length >= 24, "its views are kept");
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.screenshot({ path: path.join(PICTURES, "calibrate-result.png"), fullPage: true });
  for (const size of ["camera.svg", "camera.yaml"]) assert.equal((await get(stage.port, `/api/calibrate/${end.name}/${size}`, { headers: authorised })).status, 200);
  assert.equal((await get(stage.port, `/api/calibrate/${end.name}/camera.svg`)).status, 401, "not without the token");
  const svg = await get(stage.port, `/api/calibrate/${end.name}/camera.svg`, { headers: authorised });
  assert.equal(svg.headers["content-type"], "image/svg+xml");
  assert.match(svg.headers["content-security-policy"], /default-src 'none'/);
  const later = await live();
  assert.ok(later.frame.number > before.frame.number, "the service went on meanwhile");
  await close();
  await useIt(end.name, yaml);
});
