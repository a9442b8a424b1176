// The Aim view against a service with a simulated head: what turns it, what stops it and how soon, and who may.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before, test } from "node:test";

import { HOLD, HeadStage, PARK, POINT, TOKEN, lastChange } from "./head.mjs";
import { PICTURES, browser, openPage, pause, until } from "./stage.mjs";

// All that a hand may wait for: until the head stands, by what it reports itself, some tens of milliseconds late.
const STOPS_WITHIN_MS = 200;
const SPEED = 15;
const following = (head) => head.state >= 1 && head.state <= 4;
const linked = { hash: `#token=${TOKEN}` };
let own, chrome;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  own = await HeadStage.open();
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (own) assert.deepEqual(await own.close(), [0, 0], "both ended as they were asked to");
});

// Of one that failed no page is left that has the head.
afterEach(() => Promise.all(chrome.contexts().map((context) => context.close())));

async function openAim(options = {}) {
  const opened = await openPage(chrome, options.on ?? own, "aim", { ...linked, ...options });
  const { page } = opened;
  await page.evaluate(() => { location.hash = "aim"; });
  await page.waitForFunction(() => document.querySelector("#aim-owner")?.textContent && document.querySelector("#reach"));
  return opened;
}

const ownerIs = (page, words) => page.waitForFunction((wanted) => document.querySelector("#aim-owner")?.textContent.includes(wanted), words);

async function take(page, speed = SPEED) {
  await page.waitForFunction(() => !document.querySelector("#take").disabled);
  await page.click("#take");
  await page.waitForFunction(() => !document.querySelector(".pad button").disabled);
  await page.getByRole("button", { name: `${speed} °/s`, exact: true }).click();
}

const moves = (from) => until("the head moves", async () => { const { pan } = await own.head(); return Math.abs(pan - from) > 1; });

// When the browser was told: how long it takes a loaded machine to tell it is no matter of the head's.
const LETTING_GO = ["pointerup", "pointermove", "pointercancel", "keyup", "focusout", "blur", "visibilitychange"];
const noteLettingGo = (page) => page.evaluate((names) => {
  window.letGo = 0;
  const note = (event) => { window.letGo ||= performance.timeOrigin + event.timeStamp; };
  for (const name of names) window.addEventListener(name, note, { capture: true, once: true });
}, LETTING_GO);

// Holds `press`, ends it with `end`; how soon set-point and head stood after that, and how far the head still went.
async function stopped(press, end, page = null) {
  const from = (await own.head()).pan;
  const pressed = performance.now();
  await press();
  await moves(from);
  const { seen, at: ended } = await own.watch(900, async () => {
    await pause(200);
    if (page) await noteLettingGo(page);
    const before_ = performance.now();
    const began = await end();
    return { before_, began: typeof began === "function" ? began : page && (() => page.evaluate(() => window.letGo)) };
  });
  // What takes a while to begin tells by itself when it did.
  const at = ended.began ? (await ended.began()) - performance.timeOrigin : ended.before_;
  // Sent no further than it may turn meanwhile: what is ahead would be done without anybody's hand.
  const way = Math.abs(seen.at(-1).setPan - from);
  assert.ok(way <= (SPEED * (at + STOPS_WITHIN_MS - pressed)) / 1000, `sent ${way} deg away within ${at - pressed} ms`);
  return { command: lastChange(seen, at, (one) => one.setPan), head: lastChange(seen, at, (one) => one.pan) };
}

function assertStops(t, how, { command, head }) {
  t.diagnostic(`${how}: set-point stands after ${command.ms.toFixed(0)} ms, the head's report after ${head.ms.toFixed(0)} ms, ${head.deg.toFixed(2)} deg further`);
  assert.ok(command.ms <= STOPS_WITHIN_MS, `${how}: set-points for ${command.ms} ms`);
  assert.ok(head.ms <= STOPS_WITHIN_MS, `${how}: it turned for ${head.ms} ms`);
}

for (const theme of ["light", "dark"])
  for (const size of ["desktop", "phone"])
    test(`the view is shown with a head, ${theme}, on a ${size}`, async () => {
      const { page, close } = await openAim({ theme, size });
      await page.waitForFunction(() => document.querySelector("#picture")?.dataset.frame > 0 && /TRACK/.test(document.querySelector("#aim-state").textContent));
      await ownerIs(page, "The service has the head");
      await page.waitForFunction(() => /-60° to 60°/.test(document.querySelector("#aim-facts").textContent));
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
      await page.screenshot({ path: path.join(PICTURES, `aim-${theme}-${size}.png`), fullPage: true });
      await close();
    });

test("a button that is held turns the head, and the head stops with it", async (t) => {
  const { page, close } = await openAim();
  await take(page);
  assert.equal((await own.head()).command, POINT, "it waits for this page");
  for (const [name, axis, sign] of [["left", "pan", 1], ["right", "pan", -1], ["up", "tilt", 1], ["down", "tilt", -1]]) {
    const from = await own.head();
    await page.locator(`.pad .${name}`).hover();
    await page.mouse.down();
    await until(`it turns ${name}`, async () => sign * ((await own.head())[axis] - from[axis]) > 1.5);
    await page.mouse.up();
    await pause(300);
    const other = axis === "pan" ? "tilt" : "pan";
    assert.ok(Math.abs((await own.head())[other] - from[other]) < 0.1, "along its axis");
  }
  for (let i = 0; i < 4; ++i) {
    await page.locator(`.pad .${i % 2 ? "right" : "left"}`).hover();
    assertStops(t, "mouse up", await stopped(() => page.mouse.down(), () => page.mouse.up(), page));
  }
  await page.click("#follow");
  await until("it follows", async () => following(await own.head()));
  await close();
});

test("arrow keys turn it while the pad has the focus, and whatever takes the focus stops it", async (t) => {
  const { page, close } = await openAim();
  await take(page);
  await page.locator("#pad").focus();
  assertStops(t, "key up", await stopped(() => page.keyboard.down("ArrowLeft"), () => page.keyboard.up("ArrowLeft"), page));
  assertStops(t, "focus lost", await stopped(() => page.keyboard.down("ArrowRight"), () => page.locator("#theme").focus(), page));
  await page.keyboard.up("ArrowRight");
  const from = await own.head();
  await page.keyboard.down("ArrowLeft");
  await pause(400);
  await page.keyboard.up("ArrowLeft");
  assert.equal((await own.head()).pan, from.pan, "keys elsewhere turn nothing");
  await page.locator("#pad").focus();
  assertStops(t, "window left", await stopped(() => page.keyboard.down("ArrowLeft"), () => page.evaluate(() => window.dispatchEvent(new Event("blur"))), page));
  await page.keyboard.up("ArrowLeft");
  assertStops(t, "window hidden", await stopped(() => page.keyboard.down("ArrowRight"), () => page.evaluate(() => document.dispatchEvent(new Event("visibilitychange"))), page));
  await page.keyboard.up("ArrowRight");
  await close();
});

test("a finger turns it, and stops it when it slides off or is taken away", async (t) => {
  const { page, context, close } = await openAim({ size: "phone", touch: true });
  await take(page);
  const touch = await context.newCDPSession(page);
  const at = async (name) => { const { x, y, width, height } = await page.locator(`.pad .${name}`).boundingBox(); return { x: x + width / 2, y: y + height / 2 }; };
  const say = (type, ...touchPoints) => touch.send("Input.dispatchTouchEvent", { type, touchPoints });
  await page.locator("#pad").scrollIntoViewIfNeeded();
  const [left, right] = [await at("left"), await at("right")];
  assertStops(t, "finger up", await stopped(() => say("touchStart", left), () => say("touchEnd"), page));
  assertStops(t, "finger slides off", await stopped(() => say("touchStart", right), () => say("touchMove", { x: right.x, y: right.y + 90 }), page));
  await say("touchEnd");
  assertStops(t, "touch cancelled", await stopped(() => say("touchStart", left), () => say("touchCancel"), page));
  await close();
});

test("a page that is closed, cut off or frozen stops it, and the head follows again", async (t) => {
  for (const [how, end] of [
    ["page closed", ({ page }) => page.close()],
    ["network gone", ({ context }) => context.setOffline(true)],
    ["script hangs", ({ page }) => {
      const hung = page.evaluate(() => {
        const began = Date.now();
        while (Date.now() < began + 1500);
        return began;
      });
      return () => hung;
    }],
  ]) {
    const opened = await openAim();
    await take(opened.page);
    await opened.page.locator(".pad .left").hover();
    // A page that goes gives the head back at once, if it still can: what counts is that it was not turned further.
    const { command, head } = await stopped(() => opened.page.mouse.down(), () => end(opened));
    if (how !== "page closed") assertStops(t, how, { command, head });
    else assert.ok(command.ms <= STOPS_WITHIN_MS, `set-points for ${command.ms} ms`);
    await opened.context.close();
    await until("it follows again", async () => following(await own.head()));
    assert.deepEqual(opened.wrong, []);
  }
});

test("the process behind the page is killed: nothing more comes, and the next one lets the head follow", async (t) => {
  const { page, context } = await openAim();
  await take(page);
  await page.locator(".pad .left").hover();
  assertStops(t, "ninedot-web killed", await stopped(() => page.mouse.down(), async () => void own.stage.web.kill("SIGKILL")));
  assert.equal((await own.head()).state, HOLD, "it stands");
  await context.close();
  own.stage.web = own.stage.start("ninedot-web");
  await until("it follows again", async () => following(await own.head()));
});

test("the network holds keep-alives back and lets all go at once: nothing moves by them", async () => {
  const viewer = "burst0001";
  const { now } = await own.take(viewer);
  await pause(400);
  const from = await own.head();
  for (let i = 1; i < 12; ++i) assert.equal((await own.post(`jog ${viewer} ${i} ${now + 10 * i} 30 0`)).status, 200);
  await pause(150);
  assert.equal((await own.head()).setPan, from.setPan);
  await own.post(`give ${viewer}`);
});

test("a second page is told who has the head, and can't take it", async () => {
  const first = await openAim();
  await take(first.page);
  const second = await openAim();
  await ownerIs(second.page, "Another page has the head, at 127.0.0.1");
  assert.ok(await second.page.locator("#take").isDisabled());
  assert.ok(await second.page.locator("#follow").isDisabled());
  assert.ok(await second.page.locator(".pad .left").isDisabled());
  for (const verb of ["take", "give", "follow"]) assert.equal((await own.post(`${verb} second001`)).status, 409, verb);
  assert.equal((await own.post(`jog second001 1 0 30 0`)).status, 409);
  await first.page.getByRole("link", { name: "Live" }).click();
  await ownerIs(second.page, "The service has the head");
  await take(second.page);
  await second.close();
  await first.close();
  await until("it follows again", async () => following(await own.head()));
});

test("a controller is not fought: it takes the head at any time, and keeps it until somebody says otherwise", async () => {
  const { page, close } = await openAim();
  await take(page);
  await page.locator(".pad .left").hover();
  await page.mouse.down();
  await moves((await own.head()).pan);
  await own.modbus.write(105, [-2000, 500]);
  await own.modbus.write(100, [POINT, 4711]);
  await ownerIs(page, "A controller has the head: it sent it to -20.00°, 5.00°");
  await page.waitForFunction(() => /no longer the page's/.test(document.querySelector("#aim-note").textContent));
  await page.mouse.up();
  await pause(1200);
  const head = await own.head();
  assert.deepEqual([head.pan, head.tilt, head.sequence], [-20, 5, 4711], "where the controller sent it");
  assert.ok(await page.locator("#take").isDisabled());
  assert.equal((await own.post("take another01")).status, 200);
  await until("it is refused", async () => /A controller sent/.test((await own.post("jog another01 1 0 0 0")).state.note));
  await own.modbus.write(100, [PARK, 4712]);
  await ownerIs(page, "A controller has the head: it parked it");
  await page.click("#follow");
  assert.equal((await own.head()).command, PARK, "asked twice");
  await page.getByRole("button", { name: "Really take it from the controller?" }).click();
  await until("it follows again", async () => following(await own.head()));
  await ownerIs(page, "The service has the head");
  await own.modbus.write(100, [POINT, 4713]);
  await until("a controller's next number is its own", async () => (await own.head()).state === HOLD);
  await own.modbus.write(100, [1, 4714]);
  await close();
});

test("it turns no further than its limits", async () => {
  const viewer = "limits0001";
  let { now } = await own.take(viewer);
  let number = 0;
  await until("the end is reached", async () => {
    for (let i = 0; i < 40; ++i) ({ state: { now } } = await own.post(`jog ${viewer} ${++number} ${now} 1000 0`));
    return (await own.head()).setPan === 60;
  });
  await until("the head is there", async () => (await own.head()).pan === 60);
  await own.post(`give ${viewer}`);
});

test("without a token, writes or a head the view says what is missing, and nothing can be moved", async () => {
  for (const [options, words, status] of [[{ token: false }, /token_file/, 403], [{ writes: false }, /allow_writes/, 409]]) {
    const other = await HeadStage.open(options);
    const { page, close } = await openAim({ on: other, hash: options.token === false ? "#aim" : linked.hash });
    await page.waitForFunction(() => /TRACK/.test(document.querySelector("#aim-state").textContent));
    assert.match(await page.locator("#aim-refused").textContent(), words);
    assert.ok(await page.locator("#take").isHidden());
    for (const text of ["take viewer0001", "follow viewer0001", "jog viewer0001 1 0 5 0"]) assert.equal((await other.post(text)).status, status);
    assert.equal((await other.head()).command, 0);
    await close();
    assert.deepEqual(await other.close(), [0, 0]);
  }
});
