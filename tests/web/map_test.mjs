// A map built in the page from recordings that it keeps, on a service that knows its landmarks but not where they hang.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { ConfigurationStage, TOKEN } from "./configuration_stage.mjs";
import { PICTURES, Stage, browser, get, openPage, until } from "./stage.mjs";
import { SHEETS, fromTheFirst, landmarks, recordWall } from "./wall_recording.mjs";

const PATH = "/api/map/build";
const authorised = { Authorization: `Bearer ${TOKEN}` };
let folder, kept, names, own, chrome;

const cameraOf = (name) => `source = "recording"\ndevice = "${path.join(kept, name)}"\nrate_hz = 20`;
const state = async (on = own) => JSON.parse((await get(on.port, PATH, { headers: authorised })).body);
const post = (body, { token = TOKEN, headers = {}, on = own } = {}) => get(on.port, PATH, { method: "POST", body,
  headers: { Origin: `http://127.0.0.1:${on.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": Buffer.byteLength(body), ...(token ? { Authorization: `Bearer ${token}` } : {}), ...headers } });
const maps = () => (fs.existsSync(path.join(kept, "maps")) ? fs.readdirSync(path.join(kept, "maps")) : []);

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  folder = fs.mkdtempSync("/dev/shm/ninedot-map-");
  fs.writeFileSync(path.join(folder, "token"), `${TOKEN}\n`, { mode: 0o600 });
  kept = path.join(folder, "kept");
  names = await recordWall(kept, TOKEN);
  own = await ConfigurationStage.open({ camera: cameraOf(names.walk), extra: landmarks(SHEETS, false), web: `recordings = "${kept}"`, permitted: false });
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(folder, { recursive: true, force: true });
});
afterEach(async () => {
  await Promise.all(chrome.contexts().map((context) => context.close()));
  await post("cancel");
  await until("nothing is under way", async () => (await state()).phase !== "running");
});

async function open(options = {}) {
  const opened = await openPage(chrome, options.on ?? own, "map", { hash: `#token=${TOKEN}`, ...options });
  await opened.page.evaluate(() => { location.hash = "map"; });
  await opened.page.waitForFunction(() => !/^Asking/.test(document.querySelector("#map-state")?.textContent ?? "Asking"));
  return opened;
}
const says = (page, words, timeout = 120000) => page.waitForFunction((text) => new RegExp(text).test(document.querySelector("#map-state").textContent), words, { timeout });
// Something is on the plan beside the grid.
const drawn = (page) => page.waitForFunction(() => {
  const canvas = document.querySelector("#map-drawing");
  if (!canvas?.width) return false;
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let green = 0;
  for (let i = 0; i < data.length; i += 4) green += data[i + 3] > 200 && data[i + 1] > data[i] + 40 && data[i + 1] > data[i + 2] + 10 ? 1 : 0;
  return green > 30;
});
const ends = async (on = own) => {
  for (;;) {
    const now = await state(on);
    if (now.phase !== "running") return now;
    await new Promise((resolve) => setTimeout(resolve, 200));
  }
};

test("who may not begins nothing, and names lead nowhere else", async () => {
  const good = `start 1 ${names.walk}`;
  for (const [why, answer, status] of [
    ["no token", await post(good, { token: null }), 401],
    ["a foreign page", await post(good, { headers: { Origin: "http://elsewhere.example" } }), 403],
    ["a foreign site", await post(good, { headers: { "Sec-Fetch-Site": "cross-site" } }), 403],
    ["another name", await post(good, { headers: { Host: "evil.example", Origin: "http://evil.example" } }), 421],
    ["a path", await post(`start 1 ../kept/${names.walk}`), 400],
    ["a path behind", await post(`start 1 ${names.walk}/../../token`), 400],
    ["an option", await post(`start 1 --out=/etc/passwd`), 400],
    ["an option as origin", await post(`start --camera ${names.walk}`), 400],
    ["a line more", await post(`${good}\nuse x`), 400],
    ["the same twice", await post(`${good} ${names.walk}`), 400],
    ["no recording", await post("start 1"), 400],
    ["one that is not there", await post("start 1 20200101-000000-asked"), 404],
    ["too much", await post("x".repeat(6145)), 413],
    ["as much as fits", await post("x".repeat(6144)), 400],
    ["nothing to cancel", await post("cancel"), 409],
    ["one of elsewhere", await post("use ../../token"), 400],
    ["one that was never made", await post("use 20200101-000000"), 409],
  ]) assert.equal(answer.status, status, `${why}: ${answer.body}`);
  assert.equal((await get(own.port, PATH, { method: "PUT", headers: authorised })).status, 405);
  assert.equal((await get(own.port, PATH)).status, 401, "nor does anybody see it without the token");
  for (const target of ["20261123-121415/../../../token", "../token", "%2e%2e/token", "20261123-121415/map.toml%00", "20261123-121415/", "x/plan.svg", ""])
    assert.equal((await get(own.port, `${PATH}/${target}`, { headers: authorised })).status, 404, target);
  const { phase } = await state();
  assert.equal(phase, "idle");
  assert.deepEqual(maps(), []);
});

test("an unknown landmark is no origin, and one at a time is told apart from none", async () => {
  const why = async (text) => {
    assert.equal((await post(text)).status, 200);
    const { phase, news, why: other } = await ends();
    assert.equal(phase, "failed", other);
    return news.why;
  };
  assert.match(await why(`start 9 ${names.walk}`), /--origin 9: .* has no such landmark; it has 1, 2, 3, 4/);
  assert.match(await why(`start measured ${names.walk}`), /no landmark with a measured place/);
  const { page, close } = await open();
  await page.uncheck(`input[value="${names.walk}"]`);
  assert.ok(await page.locator("#map-start").isDisabled(), "nothing is chosen");
  await page.check(`input[value="${names.alone}"]`);
  await page.click("#map-start");
  await says(page, "No map came of it.*no picture shows two landmarks together, seen one at a time: 1");
  assert.ok(!(await page.locator("#map-state").textContent()).includes(folder), "folders are nobody's concern");
  await close();
  assert.deepEqual(maps(), [], "of what failed nothing is kept");
});

test("two who press at once begin one, a calibration waits for it, and a cancelled one leaves nothing", async () => {
  const answers = await Promise.all(Array.from({ length: 5 }, () => post(`start 1 ${names.walk}`)));
  const statuses = answers.map(({ status }) => status);
  assert.equal(statuses.filter((status) => status === 200).length, 1, String(statuses));
  assert.ok(statuses.every((status) => [200, 409, 503].includes(status)), String(statuses));
  const calibration = await get(own.port, "/api/calibrate", { method: "POST", body: "start camera", headers: { ...authorised, Origin: `http://127.0.0.1:${own.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": 12 } });
  assert.equal(calibration.status, 409);
  assert.match(String(calibration.body), /A map is being built: cancel it first/);
  // It is held, once it has said how far it is: a fast machine would be through before the page asks.
  await until("it says how far it is", async () => {
    const { news } = await state();
    return news?.frame > 0.06 * news?.frames;
  });
  process.kill(Number(fs.readdirSync("/proc").find((pid) => /^\d+$/.test(pid) && fs.readFileSync(`/proc/${pid}/cmdline`, "utf8").includes(`${kept}/maps`))), "SIGSTOP");
  const { page, close } = await open();
  await says(page, "Looking for landmarks.*picture \\d+ of \\d+");
  await page.waitForFunction(() => document.querySelector("#map-progress").value > 0.02);
  await page.click("#map-cancel");
  await says(page, "Cancelled");
  await close();
  await until("nothing is left", async () => maps().length === 0);
});

test("a killed page's process takes the work along", async () => {
  const other = await Stage.open({ camera: cameraOf(names.walk), extra: landmarks(SHEETS, false), web: `token_file = "${folder}/token"\nrecordings = "${folder}/other"` });
  await other.end(other.web);
  fs.cpSync(path.join(kept, names.walk), path.join(folder, "other", names.walk), { recursive: true });
  other.web = other.start("ninedot-web", []);
  await until("it lists it", async () => (await post(`start 1 ${names.walk}`, { on: other })).status === 200);
  const child = await until("it runs", async () => fs.readdirSync("/proc").find((pid) => /^\d+$/.test(pid) && fs.readFileSync(`/proc/${pid}/cmdline`, "utf8").includes(`${folder}/other/maps`)));
  other.web.kill("SIGKILL");
  await until("it is gone", async () => !fs.existsSync(`/proc/${child}`) || /^State:\tZ/m.test(fs.readFileSync(`/proc/${child}/status`, "utf8")));
  await other.close();
});

test("where nothing is kept, or nothing recorded, the view says what to do", async () => {
  const none = await Stage.open({ web: `token_file = "${folder}/token"` });
  let { page, close } = await open({ on: none });
  await says(page, "set `recordings` of \\[web\\]");
  assert.ok(await page.locator("#map-start").isDisabled());
  assert.equal((await post(`start 1 ${names.walk}`, { on: none })).status, 403);
  await close();
  await none.close();
  const empty = await Stage.open({ web: `token_file = "${folder}/token"\nrecordings = "${folder}/empty"` });
  ({ page, close } = await open({ on: empty }));
  await page.waitForFunction(() => /Nothing has been recorded yet/.test(document.querySelector("#map-build").innerText));
  assert.ok(await page.locator("#map-start").isDisabled());
  assert.ok(await page.locator("#map-new").isChecked(), "no landmark is configured: those of the dictionary are looked for");
  assert.ok(await page.locator("#map-origin-id").isVisible());
  await close();
  await empty.close();
});

test("the whole way: a map is built, is right, and is put in force; again, what was given keeps its place", async (t) => {
  const before_ = own.file();
  let { page, close } = await open();
  await page.waitForFunction(() => !document.querySelector("#map-start").disabled);
  assert.ok(await page.locator(`input[value="${names.walk}"]`).isChecked(), "the newest is chosen");
  assert.equal(await page.locator("#map-origin").inputValue(), "1", "the first one is given");
  const started = Date.now();
  await page.click("#map-start");
  await says(page, "Built|No map");
  const { phase, name, news } = await state();
  assert.equal(phase, "done", JSON.stringify(news));
  t.diagnostic(`${((Date.now() - started) / 1000).toFixed(1)} s: ${news.summary}`);
  assert.deepEqual(news.placed.map(({ id }) => id), [1, 2, 3, 4]);
  for (const sheet of SHEETS) {
    const { mm, sigma_mm: sigma } = news.placed.find(({ id }) => id === sheet.id);
    const off = Math.hypot(...fromTheFirst(sheet).map((value, i) => value - mm[i]));
    t.diagnostic(`landmark ${sheet.id}: ${off.toFixed(2)} mm off, 1-sigma ${sigma}`);
    assert.ok(off < 12, `landmark ${sheet.id} is ${off} mm off`);
    assert.ok(off <= 4 * Math.hypot(...sigma) + 0.01, `landmark ${sheet.id} is ${off} mm off, and sure to ${sigma}`);
  }
  await drawn(page);
  assert.equal(await page.locator("#map-placed tr").count(), 5);
  assert.equal(await page.locator("#map-commands").textContent(), `ninedot apply --map ${kept}/maps/${name}/map.toml --config ${own.stage.config}`);
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#download-map-toml")]);
  const toml = fs.readFileSync(await download.path(), "utf8");
  assert.equal(toml, fs.readFileSync(path.join(kept, "maps", name, "map.toml"), "utf8"));
  const svg = await get(own.port, `${PATH}/${name}/plan.svg`, { headers: authorised });
  assert.equal(svg.headers["content-type"], "image/svg+xml");
  assert.equal((await get(own.port, `${PATH}/${name}/plan.svg`)).status, 401);
  await close();

  await own.permit();
  ({ page, close } = await open());
  await page.click("#map-use");
  await page.click("#sure");
  await page.waitForFunction(() => /^(up|back|refused|failed)$/.test(document.querySelector("#map-applying").dataset.state), null, { timeout: 60000 });
  assert.equal(await page.locator("#map-applying").getAttribute("data-state"), "up", await page.locator("#map-applying").textContent());
  await page.screenshot({ path: path.join(PICTURES, "map-used.png"), fullPage: true });
  assert.equal(own.file(), `map = "map.toml"\n${before_.slice(0, before_.indexOf("[[landmarks]]"))}${before_.slice(before_.lastIndexOf("RKBGGKRB\"\n") + 10).replace(/^\n/, "")}`);
  assert.equal(fs.readFileSync(path.join(own.stage.folder, "map.toml"), "utf8"), toml);
  await own.runs();
  await until("the service is placed by it", async () => (await own.stage.live("mapbuildtest", authorised)).frame?.valid);
  await own.servedAnew();
  assert.ok((await state()).map.endsWith("/map.toml"), "the page goes by the new configuration");
  await close();

  ({ page, close } = await open());
  await page.waitForFunction(() => !document.querySelector("#map-start").disabled && document.querySelector("#map-origin").value === "measured");
  assert.equal(await page.locator("#map-origin option:checked").textContent(), "Landmark 1, as configured");
  await page.click("#map-start");
  await says(page, "Built|No map");
  const again = await state();
  assert.equal(again.phase, "done", JSON.stringify(again.news));
  t.diagnostic(`again: ${again.news.summary}`);
  for (const one of again.news.placed) {
    const first = news.placed.find(({ id }) => id === one.id);
    t.diagnostic(`again, landmark ${one.id}: 1-sigma ${one.sigma_mm} from ${one.sightings} sightings, ${first.sightings} before`);
    assert.ok(Math.max(...one.sigma_mm) >= 0.8 * Math.max(...first.sigma_mm), "the same pictures do not count twice");
  }
  assert.equal((await post(`use ${again.name}`)).status, 202);
  const end = await own.ended();
  assert.equal(end.state, "up", JSON.stringify(end));
  assert.equal(fs.readFileSync(path.join(own.stage.folder, "map.toml.before"), "utf8"), toml);
  await own.runs();
  await own.servedAnew();
  await close();
});

for (const [theme, size] of [["light", "desktop"], ["dark", "desktop"], ["light", "phone"], ["dark", "phone"]])
  test(`the built map is shown, ${theme}, on a ${size}`, async () => {
    const { page, close } = await open({ theme, size });
    await page.waitForFunction(() => !document.querySelector("#map-start").disabled);
    if ((await state()).phase !== "done") await page.click("#map-start");
    await says(page, "Built");
    await drawn(page);
    await page.evaluate(() => window.scrollTo(0, 0));
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
    await page.screenshot({ path: path.join(PICTURES, `map-build-${theme}-${size}.png`), fullPage: true });
    await close();
  });
