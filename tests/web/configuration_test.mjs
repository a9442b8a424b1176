// The configuration in the page: edited, checked, compared, applied to a running service and taken back, and who may.
import assert from "node:assert/strict";
import fs from "node:fs";
import net from "node:net";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { ConfigurationStage, TOKEN } from "./configuration_stage.mjs";
import { PICTURES, SOURCE, Stage, browser, freePort, get, openPage, pause, until } from "./stage.mjs";

const linked = { hash: `#token=${TOKEN}` };
let own, chrome;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  own = await ConfigurationStage.open();
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
});
afterEach(() => Promise.all(chrome.contexts().map((context) => context.close())));

// Whose machine a picture was made on is nobody's business.
const neutral = (text) => [[own.stage.config, "/etc/ninedot/ninedot.toml"], [own.stage.folder, "/run/ninedot-tap"], [own.folder, "/etc/ninedot"], [path.join(SOURCE, "tests"), "/usr/share/ninedot"],
  [`port = ${own.stage.modbusPort}`, "port = 1502"], [`port = ${own.port}`, "port = 8090"]].reduce((so_far, [from, to]) => so_far.replaceAll(from, to), text);

async function openConfiguration(options = {}) {
  const opened = await openPage(chrome, options.on ?? own, "configuration", { ...linked, ...options });
  if (options.isPicture)
    await opened.page.route("**/api/configuration", async (route) => {
      const response = await route.fetch();
      await route.fulfill({ response, body: neutral(await response.text()) });
    });
  await opened.page.evaluate(() => { location.hash = "configuration"; });
  await verdictIs(opened.page, "Nothing is wrong");
  return opened;
}

const textOf = (page) => page.locator("#configuration-text").inputValue();
const write = (page, text) => page.locator("#configuration-text").fill(text);
const verdictIs = (page, words) => page.waitForFunction((wanted) => document.querySelector("#configuration-verdict")?.textContent.includes(wanted), words);
const ends = (page, state) => page.waitForFunction((wanted) => document.querySelector("#configuration-progress")?.dataset.state === wanted, state, { timeout: 60000 });
const changed = (text) => text.replace("rate_hz = 35.0", "rate_hz = 30.0");

for (const theme of ["light", "dark"])
  for (const size of ["desktop", "phone"])
    test(`configuration is shown, ${theme}, on a ${size}`, async () => {
      const { page, close } = await openConfiguration({ theme, size, isPicture: true });
      const text = neutral(own.text);
      assert.equal(await textOf(page), text);
      await write(page, `${changed(text).trimEnd()}\npictures_per_second = 5\n\n[pan_tilt]\ndriver = "hydraulic"\n`);
      await verdictIs(page, "2 things are wrong");
      await page.locator("#configuration-messages button").first().click();
      await page.waitForFunction(() => /\[web\]/.test(document.querySelector("#configuration-help").textContent));
      await page.evaluate(() => window.scrollTo(0, 0));
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
      await page.screenshot({ path: path.join(PICTURES, `configuration-${theme}-${size}.png`), fullPage: true });
      await close();
    });

test("what is wrong is said at its line, as `ninedot check` says it, and a click leads there", async () => {
  const { page, close } = await openConfiguration();
  const text = `${own.text}rate = 3\n[pan_tilt]\ndriver = "hydraulic"\n`;
  await write(page, text);
  await verdictIs(page, "2 things are wrong");
  const lines = text.split("\n");
  const wrong = [lines.indexOf("rate = 3") + 1, lines.indexOf('driver = "hydraulic"') + 1];
  const marked = await page.locator(".gutter .bad").allTextContents();
  assert.deepEqual(marked.map(Number), wrong);
  const messages = page.locator("#configuration-messages button");
  assert.match(await messages.first().textContent(), new RegExp(`^line ${wrong[0]} unknown key 'rate'`));
  await messages.nth(1).click();
  const selected = () => page.evaluate(() => { const t = document.querySelector("#configuration-text"); return t.value.slice(t.selectionStart, t.selectionEnd); });
  assert.equal(await selected(), 'driver = "hydraulic"');
  await page.keyboard.press("F8");
  assert.equal(await selected(), "rate = 3", "and round again");
  assert.ok(await page.locator("#configuration-apply").isDisabled());
  await write(page, `${own.text}[camera\n`);
  await verdictIs(page, "One thing is wrong");
  await write(page, own.text);
  await verdictIs(page, "Nothing is wrong");
  assert.equal(await page.locator(".gutter .bad").count(), 0);
  await close();
});

test("the difference to the file is shown with signs, and counted", async () => {
  const { page, close } = await openConfiguration();
  await write(page, `# first\n${changed(own.text)}`);
  await page.waitForFunction(() => /2 lines added, 1 line removed/.test(document.querySelector("#configuration-count").textContent));
  assert.deepEqual(await page.locator("#configuration-difference .added td:last-child").allTextContents(), ["# first", "rate_hz = 30.0"]);
  assert.deepEqual(await page.locator("#configuration-difference .removed td:last-child").allTextContents(), ["rate_hz = 35.0"]);
  assert.deepEqual(await page.locator("#configuration-difference .sign").evaluateAll((cells) => cells.map((cell) => cell.textContent).filter((sign) => sign !== " ")), ["+", "-", "+"]);
  await page.click("#configuration-undo");
  assert.equal(await textOf(page), own.text);
  await page.click("#configuration-redo");
  assert.match(await textOf(page), /^# first/);
  await close();
});

test("edits stay when the view is left or the page is loaded anew", async () => {
  const { page, close } = await openConfiguration();
  const text = changed(own.text);
  await write(page, text);
  await page.getByRole("link", { name: "Live" }).click();
  await page.getByRole("link", { name: "Configuration" }).click();
  await verdictIs(page, "Nothing is wrong");
  assert.equal(await textOf(page), text);
  await page.reload();
  await verdictIs(page, "Nothing is wrong");
  assert.equal(await textOf(page), text);
  await close();
});

test("the key at the cursor is explained, and the keyboard gets in and out", async () => {
  const { page, close } = await openConfiguration();
  await page.evaluate(() => { const t = document.querySelector("#configuration-text"); t.focus(); t.selectionStart = t.selectionEnd = t.value.indexOf("rate_hz"); });
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => /rate_hz of \[camera\].*0\.1 \.\. 1000/s.test(document.querySelector("#configuration-help").textContent));
  await page.keyboard.press("Tab");
  assert.notEqual(await page.evaluate(() => document.activeElement.id), "configuration-text");
  await page.locator("#configuration-text").focus();
  await page.keyboard.press("End");
  await page.keyboard.type(" # 1");
  await page.waitForFunction(() => !document.querySelector("#configuration-apply").disabled);
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => document.activeElement.id), "configuration-apply");
  assert.equal(await page.evaluate(() => location.hash), "#configuration", "a digit in the text changes no view");
  await close();
});

test("a change is applied after it was asked for once more, and is in force", async (t) => {
  const { page, close } = await openConfiguration();
  const port = await freePort();
  const text = own.text.replace(`port = ${own.stage.modbusPort}`, `port = ${port}`);
  await write(page, text);
  await page.waitForFunction(() => !document.querySelector("#configuration-apply").disabled);
  await page.click("#configuration-apply");
  assert.match(await page.locator("dialog.sure").textContent(), /1 line added, 1 line removed/);
  await page.screenshot({ path: path.join(PICTURES, "configuration-sure.png") });
  await page.getByRole("button", { name: "Not now" }).click();
  assert.equal(own.file(), own.text, "not yet");
  await page.click("#configuration-apply");
  const started = performance.now();
  await page.click("#sure");
  await ends(page, "up");
  t.diagnostic(`applied within ${((performance.now() - started) / 1000).toFixed(1)} s, three of them watching`);
  assert.equal(own.file(), text);
  await own.runs(port);
  await page.screenshot({ path: path.join(PICTURES, "configuration-applied.png"), fullPage: true });
  await page.waitForFunction(() => /No difference/.test(document.querySelector("#configuration-count").textContent));
  assert.equal((await own.state()).before, own.text);
  // The page's own process goes by the new file as well; the page finds it again.
  await own.servedAnew();
  await page.click("#configuration-before");
  await verdictIs(page, "Nothing is wrong");
  await page.waitForFunction(() => !document.querySelector("#configuration-apply").disabled);
  await page.click("#configuration-apply");
  await page.click("#sure");
  await page.waitForFunction((was) => document.querySelector("#configuration-progress").dataset.state === "up" && document.querySelector("#configuration-text").value === was && document.querySelector("#configuration-undo").disabled, own.text, { timeout: 60000 });
  assert.equal(own.file(), own.text);
  await own.runs();
  await own.servedAnew();
  await close();
});

test("a change with which the service does not come up is taken back, and says why", async () => {
  const { page, close } = await openConfiguration();
  const other = await Stage.open();  // a ninedotd on that port is what the check takes for the service itself
  const text = own.text.replace(`port = ${own.stage.modbusPort}`, `port = ${other.modbusPort}`);
  await write(page, text);
  await page.waitForFunction(() => !document.querySelector("#configuration-apply").disabled);
  await page.click("#configuration-apply");
  await page.click("#sure");
  await ends(page, "back");
  await other.close();
  assert.match(await page.locator("#configuration-progress").textContent(), /Taken back.*Address already in use/s);
  await page.screenshot({ path: path.join(PICTURES, "configuration-back.png"), fullPage: true });
  assert.equal(own.file(), own.text);
  assert.equal(await textOf(page), text, "the edits are kept");
  await own.runs();
  await close();
});

test("a file by which the page itself can't be served leaves it as it was, and the way back open", async () => {
  const other = await ConfigurationStage.open();
  const bad = other.text.replace(/token_file = .*/, 'token_file = "/nowhere/token"');
  assert.equal((await other.post("apply", bad, { headers: { "If-Match": (await other.state()).tag } })).status, 202);
  assert.equal((await other.ended()).state, "up", "the service has no token");
  await until("it says so", async () => /\/nowhere\/token: .*: the page goes on as it was/.test(other.stage.log("ninedot-web")));
  const { tag, before } = await until("it is back", () => other.state());
  assert.equal((await other.post("apply", before, { headers: { "If-Match": tag } })).status, 202);
  assert.equal((await other.ended()).state, "up");
  assert.equal(other.file(), other.text);
  assert.deepEqual(await other.close(), [0, 0]);
});

test("what only the full check finds is refused, at the sensor itself", async () => {
  const taken = net.createServer().listen(0, "127.0.0.1");
  const { tag } = await own.state();
  assert.equal((await own.post("apply", own.text.replace(`port = ${own.stage.modbusPort}`, `port = ${taken.address().port}`), { headers: { "If-Match": tag } })).status, 202);
  const { state, lines } = await own.ended();
  taken.close();
  assert.equal(state, "refused");
  assert.match(lines.at(-1), /Address already in use/);
  assert.equal(own.file(), own.text);
});

test("a file that was changed meanwhile is not written over", async () => {
  const { page, close } = await openConfiguration();
  await write(page, changed(own.text));
  await page.waitForFunction(() => !document.querySelector("#configuration-apply").disabled);
  fs.writeFileSync(own.stage.config, `# by hand\n${own.text}`);
  await page.click("#configuration-apply");
  await page.click("#sure");
  await ends(page, "failed");
  assert.match(await page.locator("#configuration-progress").textContent(), /has been changed since/);
  await page.waitForFunction(() => /by hand/.test(document.querySelector("#configuration-difference").textContent));
  assert.match(own.file(), /^# by hand/);
  fs.writeFileSync(own.stage.config, own.text);
  await close();
});

test("where nothing may be changed it is checked, and said why", async () => {
  for (const [options, words, hash] of [[{ permitted: false }, /systemctl enable --now ninedot-apply\.socket/, linked.hash], [{ token: false }, /token_file/, "#configuration"]]) {
    const other = await ConfigurationStage.open(options);
    const { page, close } = await openConfiguration({ on: other, hash });
    await write(page, `${other.text}x = 1\n`);
    await verdictIs(page, "One thing is wrong");
    await write(page, changed(other.text));
    await verdictIs(page, "Nothing is wrong");
    assert.match(await page.locator("#configuration-why-not").textContent(), words);
    assert.ok(await page.locator("#configuration-apply").isDisabled());
    assert.equal((await other.post("apply", changed(other.text))).status, 403);
    assert.equal(other.file(), other.text);
    await close();
    assert.deepEqual(await other.close(), [0, 0]);
  }
});

test("whatever is posted by whomever, but by the page itself with the token: the file stays as it is", async () => {
  const { tag } = await own.state();
  const good = changed(own.text);
  const refused = async (status, what, body, { headers = {}, ...options } = {}) =>
    assert.equal((await own.post("apply", body, { headers: { "If-Match": tag, ...headers }, ...options })).status, status, what);
  await refused(401, "no token", good, { token: null });
  await refused(401, "another token", good, { token: "0123456789abcdef0123456789abcdeF" });
  for (const origin of ["http://evil.example", "null", ""]) await refused(403, `origin ${origin}`, good, { headers: { Origin: origin } });
  await refused(403, "another site", good, { headers: { "Sec-Fetch-Site": "cross-site" } });
  await refused(421, "another name", good, { headers: { Host: "evil.example", Origin: "http://evil.example" } });
  await refused(413, "long", "#".repeat(256 * 1024 + 1));
  for (const other of ["", "0".repeat(16), "*", `"${tag}"`]) await refused(412, `tag ${other}`, good, { headers: { "If-Match": other } });
  for (const what of ["check", "apply"]) {
    assert.equal((await own.post(what, good, { token: null })).status, 401, what);
    assert.equal((await own.post(what, good, { headers: { Origin: "http://evil.example" } })).status, 403, what);
  }
  for (const target of ["/api/configuration", "/api/configuration/keys", "/api/configuration/check/", "/api/configuration%2fapply"])
    assert.equal((await get(own.port, target, { method: "POST", headers: { Authorization: `Bearer ${TOKEN}`, "Content-Length": 0 } })).status, 405, target);
  assert.equal((await get(own.port, "/api/configuration/keys")).status, 401);
  assert.equal((await get(own.port, "/api/configuration")).status, 401);
  assert.equal((await get(own.port, "/api/configuration/none", { headers: { Authorization: `Bearer ${TOKEN}` } })).status, 404);
  assert.equal((await own.state()).apply.number <= 5, true);
  assert.equal(own.file(), own.text);
  assert.ok(!(await own.state()).text.includes(TOKEN));
});

test("one long request at a time; whoever holds the place loses it after ten seconds", async () => {
  const body = "#".repeat(100000);
  const head = `POST /api/configuration/check HTTP/1.1\r\nHost: 127.0.0.1:${own.port}\r\nOrigin: http://127.0.0.1:${own.port}\r\nAuthorization: Bearer ${TOKEN}\r\nContent-Length: ${body.length}\r\n\r\n`;
  const slow = net.connect(own.port, "127.0.0.1");
  slow.on("error", () => {});
  slow.write(head + body.slice(0, 50000));
  await pause(300);
  assert.equal((await own.post("check", body)).status, 503);
  const started = Date.now();
  while ((await own.post("check", body)).status === 503) await pause(300);
  assert.ok(Date.now() - started < 14000, `${Date.now() - started} ms`);
  slow.destroy();
});

test("texts that are made to cost much cost little", async (t) => {
  const most = 256 * 1024;
  const fill = (unit) => unit.repeat(Math.floor((most - 100) / unit.length));
  const numbered = Array.from({ length: 20000 }, (_, i) => `k${i}=1`).join("\n");
  const texts = { "deep lists": `a=${fill("[")}`, "long list": `a=[${fill("1,")}]`, "many keys": numbered, "many tables": Array.from({ length: 15000 }, (_, i) => `[t${i}]`).join("\n"),
    "many landmarks": fill("[[landmarks]]\nid=1\n"), "deep keys": `${fill("a.")}b=1`, noise: Buffer.from(Array.from({ length: most }, (_, i) => (i * 7919 + 13) % 256)),
    "a device as map": 'map = "/dev/zero"\n', "a terminal as map": 'map = "/dev/stdin"\n' };
  const rss = () => Number(/VmHWM:\s+(\d+)/.exec(fs.readFileSync(`/proc/${own.stage.web.pid}/status`, "utf8"))[1]) / 1024;
  for (const [what, text] of Object.entries(texts)) {
    const started = performance.now();
    const answer = await own.post("check", text);
    const ms = performance.now() - started;
    assert.equal(answer.status, 200, what);
    assert.ok(JSON.parse(answer.body).count > 0, what);
    t.diagnostic(`${what}: ${ms.toFixed(0)} ms, at most ${rss().toFixed(0)} MB so far`);
    assert.ok(ms < 5000, `${what}: ${ms} ms`);
    assert.ok(rss() < 60, `${what}: ${rss()} MB, and the unit allows 64`);
  }
});

async function openExposure(on = own) {
  const opened = await openPage(chrome, on, "focus", linked);
  await opened.page.evaluate(() => { location.hash = "focus"; });
  await opened.page.waitForFunction(() => !document.querySelector("#set-gain").disabled || !document.querySelector("#exposure-why-not").hidden);
  return opened;
}

// Asked after a check of its own; the one before is still in the page.
const asked = (page) => page.locator("dialog.sure[open] #sure-title").textContent();

test("exposure and gain are set from the focus view, in the file and in the service, and nothing else is touched", async () => {
  const before = own.file();
  const { page, close } = await openExposure();
  assert.ok(await page.locator("#set-exposure").isDisabled(), "there is nothing to set yet");
  await page.fill("#set-exposure_us", "4000");
  await page.fill("#set-gain", "2.5");
  await page.click("#set-exposure");
  assert.equal(await asked(page), "Set exposure_us = 4000 and gain = 2.5?");
  await page.click("#sure");
  assert.ok(await page.locator("#set-gain").isDisabled(), "what is typed now would be lost");
  const state = () => page.locator("#exposure-applying").getAttribute("data-state");
  await until("it ended", async () => !["running", null].includes(await state()));
  assert.equal(await state(), "up", await page.locator("#exposure-applying").textContent());
  assert.equal(own.file(), before.replace("[camera]\n", "[camera]\nexposure_us = 4000\ngain = 2.5\n"));
  await own.runs();
  await own.servedAnew();
  await page.waitForFunction(() => !document.querySelector("#set-gain").disabled);  // it goes by the new file
  assert.deepEqual([await page.inputValue("#set-exposure_us"), await page.inputValue("#set-gain")], ["4000", "2.5"]);
  await page.fill("#set-exposure_us", "");
  await page.click("#set-exposure");
  assert.equal(await asked(page), "Set exposure_us = automatic?");
  await page.click("#sure");
  await until("it is in the file", async () => own.file().includes("exposure_us = 0\n"));
  await until("it ended", async () => (await state()) === "up");
  await own.servedAnew();
  await close();
});

test("an exposure beyond the limits, and one that the page may not set, change nothing", async () => {
  const before = own.file();
  const { page, close } = await openExposure();
  await page.fill("#set-exposure_us", "2000000");
  await page.click("#set-exposure");
  assert.equal(await page.evaluate(() => document.querySelector("#set-exposure_us").validity.rangeOverflow), true);
  // A browser that lets it pass.
  await page.evaluate(() => { document.querySelector("#set-exposure").form.noValidate = true; });
  await page.click("#set-exposure");
  await page.waitForFunction(() => /'exposure_us' is 2000000/.test(document.querySelector("#exposure-note").textContent));
  assert.equal(await page.evaluate(() => document.querySelector("dialog.sure").open), false);
  assert.equal(own.file(), before);
  await close();
  const other = await ConfigurationStage.open({ permitted: false });
  const closed = await openExposure(other);
  assert.match(await closed.page.locator("#exposure-why-not").textContent(), /systemctl enable --now ninedot-apply.socket/);
  assert.ok(await closed.page.locator("#set-gain").isDisabled());
  await closed.close();
  assert.deepEqual(await other.close(), [0, 0]);
});

test("keys are set where they stand, and found where only TOML finds them", async () => {
  const { page, close } = await openExposure();
  const results = await page.evaluate(async () => {
    const { valuesIn, withValues } = await import("./exposure.js");
    const text = "top = 1\n[pan_tilt]\ngain = 0.4\n  [camera] # left\n# gain = 7\n gain=3.0# dim\nrate_hz = 35\n[[landmarks]]\nexposure_us = 9\n";
    return { read: valuesIn(text, "camera", ["gain", "exposure_us"]), set: withValues(text, "camera", { gain: 4, exposure_us: 500 }), none: withValues("[web]\n", "camera", { gain: 1 }),
      list: withValues("[[camera]]\n", "camera", { gain: 1 }) };
  });
  assert.deepEqual(results.read, { gain: "3.0" });
  assert.equal(results.set, "top = 1\n[pan_tilt]\ngain = 0.4\n  [camera] # left\nexposure_us = 500\n# gain = 7\n gain=4# dim\nrate_hz = 35\n[[landmarks]]\nexposure_us = 9\n");
  assert.equal(results.none, null);
  assert.equal(results.list, null);
  await close();
});
