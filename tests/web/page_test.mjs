// Each view against a running service on a bundled recording; pictures of each, in both themes, for a desk and a phone.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";

import { drawRecording, looking } from "./drawn.mjs";
import { PICTURES, SIZES, SOURCE, Stage, browser, openPage, pause, until } from "./stage.mjs";

let stage, chrome;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  stage = await Stage.open();
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  if (stage) assert.deepEqual(await stage.close(), [0, 0], "both ended as they were asked to");
});

const open = (view, { on = stage, ...options } = {}) => openPage(chrome, on, view, options);

// Whose machine a picture was made on is nobody's business: the log names files and ports, and is written anew all the time.
const hideThisMachine = (page) => page.evaluate((names) => {
  const hide = () => {
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) texts.currentNode.data = names.reduce((text, [from, to]) => text.replaceAll(from, to), texts.currentNode.data);
  };
  new MutationObserver(hide).observe(document.body, { childList: true, subtree: true });
  hide();
}, [[path.join(SOURCE, "tests"), "/usr/share/ninedot"], [stage.folder, "/run/ninedot"], [`-p ${stage.modbusPort}`, "-p 1502"]]);

const shown = {
  live: (page) => page.waitForFunction(() => document.querySelector("#picture")?.dataset.frame > 0 && /\d/.test(document.querySelector("#pose")?.textContent)),
  focus: (page) => page.waitForFunction(() => document.querySelector("#picture")?.dataset.frame > 0 && /\d px/.test(document.querySelector("#blur")?.textContent)),
  health: (page) => page.waitForFunction(() => document.querySelectorAll("#checks .check").length > 8),
  registers: (page) => page.waitForFunction(() => document.querySelectorAll(".registers tbody tr").length > 60),
  map: (page) => page.waitForFunction(() => /Camera at x/.test(document.querySelector("#place")?.textContent)),
  aim: (page) => page.waitForFunction(() => /No head/.test(document.querySelector("#aim-state")?.textContent) && /No pan\/tilt head is configured/.test(document.querySelector("#aim-refused")?.textContent)),
};

for (const view of Object.keys(shown))
  for (const theme of ["light", "dark"])
    for (const size of Object.keys(SIZES))
      test(`${view} is shown, ${theme}, on a ${size}`, async () => {
        const { page, close } = await open(view, { theme, size });
        await shown[view](page);
        await hideThisMachine(page);
        await pause(view === "registers" || process.env.CI ? 300 : 2500);  // a few seconds of plots
        const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
        await page.screenshot({ path: path.join(PICTURES, `${view}-${theme}-${size}.png`), fullPage: view !== "registers" });
        await close();
      });

test("live shows what the service says of the frame in the picture", async () => {
  const { page, close } = await open("live");
  await shown.live(page);
  await page.getByRole("button", { name: "Freeze" }).click();
  const number = await page.locator("#picture").getAttribute("data-frame");
  await pause(500);
  assert.equal(await page.locator("#picture").getAttribute("data-frame"), number, "frozen");
  await page.keyboard.press("f");
  await page.waitForFunction((was) => document.querySelector("#picture").dataset.frame !== was, number);
  assert.match(await page.locator("#verdict").textContent(), /Landmark 0 found/);
  await close();
});

test("the overlay puts each disc where its dot was seen", async () => {
  const { page, close } = await open("live");
  await shown.live(page);
  // A dot may be lost in a shadow for a frame; what is drawn is judged where all nine were seen.
  const far = [];
  for (let seen = 0, last = -1; seen < 12;) {
    const message = await until("all nine are seen in another frame", async () => {
      const { camera, frame } = await stage.live("overlaytest");
      return frame.valid && frame.number !== last && frame.dots.every((dot) => dot[5] > 0) && { camera, frame };
    });
    last = message.frame.number;
    ++seen;
    far.push(...await page.evaluate(async ({ camera, frame }) => {
      const { projector, dotCentre } = await import("./projection.js");
      const project = projector(camera, frame.in_landmark);
      return frame.dots.map(([u, v], dot) => Math.hypot(project(dotCentre(camera, dot))[0] - u, project(dotCentre(camera, dot))[1] - v));
    }, message));
  }
  // Shadows across a dot pull what is seen of it aside, by a pixel, in some frames by a pixel in half of them; a wrong axis or a wrong dot is tens of them.
  const median = far.sort((one, other) => one - other)[far.length / 2];
  assert.ok(median < 0.3 && far.at(-1) < 3, `pixels from disc to dot: median ${median}, most ${far.at(-1)}`);
  await close();
});

// Pixels of the picture that are of about this colour.
const coloured = (page, colour) => page.evaluate((wanted) => {
  const canvas = document.querySelector("#picture");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += wanted.every((value, k) => Math.abs(data[i + k] - value) < 30) ? 1 : 0;
  return count;
}, colour);

test("the picture is the recording's, and the overlay is drawn into it", async () => {
  const { page, close } = await open("live");
  await shown.live(page);
  const count = () => page.evaluate(() => {
    const canvas = document.querySelector("#picture");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let coloured = 0, bright = 0;
    for (let i = 0; i < data.length; i += 4) {
      coloured += Math.abs(data[i] - data[i + 1]) > 60 ? 1 : 0;
      bright += data[i] > 60 ? 1 : 0;
    }
    return { coloured, bright };
  });
  const drawn = await count();
  assert.ok(drawn.coloured > 300 && drawn.bright > 100000, JSON.stringify(drawn));
  await page.getByRole("button", { name: "Freeze" }).click();
  await page.getByRole("button", { name: "Overlay" }).click();
  assert.equal((await count()).coloured, 0, "a grey camera's picture");
  await close();
});

// A view of a service that sees one drawn picture again and again. more: of drawRecording
async function openOnDrawing(t, view, pose, more = {}) {
  const folder = fs.mkdtempSync("/dev/shm/ninedot-drawn-");
  drawRecording(folder, { model: "plumb_bob", k: [0, 0, 0, 0, 0], f: 720, width: 640, height: 480 }, [pose], more);
  const stage = await Stage.open({ camera: `source = "recording"\ndevice = "${folder}"\nrate_hz = 35.0` });
  const { page, close } = await open(view, { on: stage });
  t.after(async () => {
    await close();
    await stage.close();
    fs.rmSync(folder, { recursive: true });
  });
  return { page, stage };
}

test("the map lists what is in sight, and what it is worth, as the service reports it", async (t) => {
  const { page, stage: still } = await openOnDrawing(t, "map", looking([320, 1000, -80], [60, 0, -20]));
  await page.waitForFunction(() => document.querySelector("#sightings")?.hidden === false);
  const { landmarks: [landmark] } = await until("a frame", async () => (await still.live("sightings01")).frame);
  assert.equal(landmark.reason, 0);
  assert.ok(Math.abs(Math.hypot(...landmark.candidates[landmark.chosen].mm) - Math.hypot(320, 1000, 80)) < 5, "its distance, by the drawing");
  const wanted = ["0", "1.05", "9", String(landmark.quality), landmark.candidates[landmark.chosen].rms_px.toFixed(3), "counts"];
  const cells = () => page.evaluate(() => [...document.querySelectorAll("#sightings tr:nth-child(2) > *")].map((cell) => cell.textContent));
  await until(`the row says ${wanted}`, async () => JSON.stringify(await cells()) === JSON.stringify(wanted));
});

// A dark disc on paper, its edge blurred by a Gaussian of sigma_x and sigma_y px.
const drawnDisc = (sigmaX, sigmaY, ink, paper) => ({ sigmaX, sigmaY, ink, paper });

test("the focus view's blur is that of the picture", async () => {
  const { page, close } = await open("focus");
  const judged = (disc) => page.evaluate(async ({ sigmaX, sigmaY, ink, paper }) => {
    const { greyOf, sharpnessOf } = await import("./sharpness.js");
    const { judgement } = await import("./focus.js");
    const [size, middle, radius, fine] = [96, 47.6, 22, 4];
    // A sharp disc, four times as fine, smoothed by the Gaussian, and each pixel the mean of its sixteen.
    const wide = size * fine;
    let plane = Float64Array.from({ length: wide * wide }, (_, i) => {
      const [x, y] = [((i % wide) + 0.5) / fine - 0.5, (Math.floor(i / wide) + 0.5) / fine - 0.5];
      return Math.hypot(x - middle, y - middle) < radius ? ink : paper;
    });
    for (const [sigma, step] of [[sigmaX * fine, 1], [sigmaY * fine, wide]]) {
      const reach = Math.ceil(4 * sigma);
      const kernel = Array.from({ length: 2 * reach + 1 }, (_, k) => Math.exp(-((k - reach) ** 2) / (2 * sigma * sigma)));
      const sum = kernel.reduce((a, b) => a + b, 0);
      plane = plane.map((value, i) => {
        const along = step === 1 ? i % wide : Math.floor(i / wide);
        let smooth = 0;
        kernel.forEach((weight, k) => { smooth += (weight / sum) * plane[i + step * (Math.min(wide - 1, Math.max(0, along + k - reach)) - along)]; });
        return smooth;
      });
    }
    const data = new Uint8ClampedArray(4 * size * size);
    for (let y = 0; y < size; ++y)
      for (let x = 0; x < size; ++x) {
        let sum = 0;
        for (let j = 0; j < fine; ++j) for (let i = 0; i < fine; ++i) sum += plane[(y * fine + j) * wide + x * fine + i];
        data.fill(Math.round(sum / fine / fine), 4 * (y * size + x), 4 * (y * size + x) + 3);
      }
    const sharp = sharpnessOf(greyOf({ width: size, height: size, data }), [[middle, middle, radius, radius, 0, 1]]);
    return { ...sharp, judgement: judgement(sharp, { exposure_ms: 5 }) };
  }, disc);
  for (const sigma of [0.6, 1, 2]) {
    const { blur, ink, paper } = await judged(drawnDisc(sigma, sigma, 30, 200));
    const whole = Math.hypot(sigma, Math.sqrt(1 / 12));  // and the pixel's own width
    assert.ok(Math.abs(blur - whole) < 0.08 * whole, `${blur} of ${whole}`);
    assert.ok(Math.abs(ink - 30) < 4 && Math.abs(paper - 200) < 4, `${ink} ${paper}`);
  }
  const said = async (...disc) => (await judged(drawnDisc(...disc))).judgement[1];
  assert.equal(await said(0.6, 0.6, 30, 200), "Sharp and well exposed");
  assert.equal(await said(2.5, 2.5, 30, 200), "Not sharp");
  assert.equal(await said(2.5, 0.6, 30, 200), "Blurred by motion");
  assert.equal(await said(0.6, 0.6, 60, 255), "Over-exposed");
  assert.equal(await said(0.6, 0.6, 20, 75), "Dark");
  assert.equal(await said(0.6, 0.6, 150, 185), "Little contrast");
  await close();
});

test("the focus view marks what is over- and under-exposed, and turns by detail where there is no landmark", async () => {
  const bare = await Stage.open({ recording: "negative" });
  const { page, close } = await open("focus", { on: bare });
  await page.waitForFunction(() => /detail/.test(document.querySelector("#blur")?.textContent));
  assert.match(await page.locator("#verdict").textContent(), /No landmark to judge by/);
  await close();
  await bare.close();
  const marked = await open("focus");
  await shown.focus(marked.page);
  const coloured = () => marked.page.evaluate(() => {
    const canvas = document.querySelector("#picture");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += data[i] !== data[i + 2] ? 1 : 0;
    return count;
  });
  const claimed = await marked.page.evaluate(() => [...document.querySelectorAll(".facts tr")].filter((tr) => /exposed/.test(tr.textContent)).map((tr) => parseFloat(tr.children[1].textContent)));
  const share = (100 * (await coloured())) / (640 * 480);
  assert.ok(Math.abs(share - claimed[0] - claimed[1]) < 0.5, `${share} % marked, ${claimed} said`);
  await marked.page.keyboard.press("m");
  const frame = await marked.page.locator("#picture").getAttribute("data-frame");
  await marked.page.waitForFunction((was) => Number(document.querySelector("#picture").dataset.frame) > Number(was) + 1, frame);
  assert.equal(await coloured(), 0, "marks are off");
  await marked.close();
});

test("save gives a PNG of the picture", async () => {
  const { page, close } = await open("live");
  await shown.live(page);
  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("s")]);
  assert.match(download.suggestedFilename(), /^ninedot-frame-\d+\.png$/);
  assert.equal(fs.readFileSync(await download.path()).subarray(1, 4).toString(), "PNG");
  await close();
});

test("registers decode as the service's own table says, in both word orders", async () => {
  const { page, close } = await open("registers");
  await shown.registers(page);
  const row = async (name) => page.evaluate((wanted) => {
    const found = [...document.querySelectorAll(".registers tbody tr")].find((tr) => tr.children[1].textContent === wanted);
    return [...found.children].map((td) => td.textContent);
  }, name);
  await until("values are there", async () => (await row("magic"))[2] === "9D09");
  assert.deepEqual((await row("probe_int32")).slice(2, 5), ["FFFF FFFF", "-1", "-1"]);
  assert.deepEqual((await row("probe_word_order")).slice(2, 5), ["1234 5678", String(0x12345678), String(0x56781234)]);
  assert.deepEqual((await row("probe_float")).slice(2, 4), ["47F1 2000", "123456"]);
  await page.getByRole("searchbox").fill("probe_");
  assert.equal(await page.locator(".registers tbody tr:visible").count(), 3);
  await close();
});

test("health names the landmarks that contradict each other, and one that hangs elsewhere", async () => {
  const { page, close } = await open("health");
  await shown.health(page);
  const found = await page.evaluate(async () => {
    const { verdicts } = await import("./health.js");
    const map = await (await fetch("/api/registers")).json();
    const of = (values) => {
      const registers = new Array(map.registers.at(-1).address + 1).fill(0);
      for (const [name, word] of Object.entries(values)) registers[map.registers.find((entry) => entry.name === name).address] = word;
      const shared = { registers: map, history: { gained: () => null } };
      return verdicts({ service: { registers }, camera: { rate_hz: 30 }, frame: null }, shared).find((check) => check.name === "Map");
    };
    return [
      of({ last_rejected_id: 7 }),
      of({ last_rejected_id: 7, landmarks_rejected: 1 }),
      of({ last_rejected_id: 7, landmarks_disputed: 2, disputed_id_1: 8, disputed_id_2: 9 }),
      of({ last_rejected_id: 7, landmarks_disputed: 1, disputed_id_1: 9, disputed_id_2: 65535 }),
    ].map(({ kind, value, advice = "" }) => `${kind}: ${value}; ${/^.*?(?=:|$)/.exec(advice)[0]}`);
  });
  assert.deepEqual(found, ["good: as it is seen; ", "warn: landmark 7 hangs elsewhere; Poses are made without it",
    "bad: landmarks 8 and 9 contradict each other; One of them does not hang where the map says, and neither places the camera alone",
    "bad: landmark 9 contradicted another one; It does not place the camera alone until it has agreed with others"]);
  await close();
});

test("tables for controllers name each register at its address", async () => {
  const { page, close } = await open("registers");
  await shown.registers(page);
  const tables = await page.evaluate(async () => {
    const { tableText } = await import("./registers.js");
    const map = await (await fetch("/api/registers")).json();
    return Object.fromEntries(["s7", "ur", "fanuc"].map((kind) => [kind, tableText(kind, map.registers.filter((e) => ["x_32", "age"].includes(e.name)))]));
  });
  assert.match(tables.s7, /^x_32\tDInt\t40017\t2\t0\.001\tmm\t/m);
  assert.match(tables.s7, /^age\tUInt\t40009\t1\t/m);
  assert.match(tables.ur, /^modbus_add_signal\("SENSOR_ADDRESS", 255, 16, 2, "x_32_high"\).*\nmodbus_add_signal\("SENSOR_ADDRESS", 255, 17, 2, "x_32_low"\)/m);
  assert.match(tables.fanuc, /^16\t1\tGI\[17\]\tyes\t0\.001\tmm\tx_32\.high\t/m);
  await close();
});

test("the keyboard is enough", async () => {
  const { page, close } = await open("live");
  await shown.live(page);
  for (const [key, view] of [["2", "focus"], ["4", "health"], ["5", "registers"], ["6", "map"], ["7", "aim"], ["1", "live"]]) {
    await page.keyboard.press(key);
    await shown[view](page);
    assert.equal(await page.locator("nav a[aria-current]").getAttribute("data-view"), view);
  }
  await page.keyboard.press("Tab");
  const focused = await page.evaluate(() => document.activeElement.tagName);
  assert.ok(["A", "BUTTON"].includes(focused), focused);
  await page.keyboard.press("t");
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "light");
  await close();
});

test("nothing found is said, and why, and what to do", async (t) => {
  const { page } = await openOnDrawing(t, "live", looking([120, 620, -80], [60, 0, -20]), { lacks: 8 });
  await page.waitForFunction(() => /no landmark.*nearest.*no ninth dot.*middle/is.test(document.querySelector("#verdict.bad, #verdict.warn")?.textContent));
  await page.waitForFunction(() => document.querySelector("#picture")?.dataset.frame > 0);
  const [spot, found, lacking] = [[0x40, 0xd0, 0xff], [0xff, 0xb0, 0x20], [0xff, 0x8c, 0x28]];
  assert.ok(await coloured(page, spot) > 1000, "the dark spots");
  assert.ok(await coloured(page, found) > 300, "the eight that are there");
  assert.ok(await coloured(page, lacking) > 20, "the one that is not");
  await page.screenshot({ path: path.join(PICTURES, "live-nothing.png"), fullPage: true });
  await page.getByRole("button", { name: "Other readings" }).click();
  assert.equal(await coloured(page, spot), 0);
});

test("a service that ends and comes back is told, and the page goes on by itself", async () => {
  const own = await Stage.open();
  const { page, close } = await open("health", { on: own });
  await shown.health(page);
  await own.end(own.service);
  await page.waitForFunction(() => /no tap|has ended/.test(document.querySelector("#banner").textContent));
  await page.screenshot({ path: path.join(PICTURES, "health-no-service.png") });
  own.service = own.start("ninedotd");
  await page.waitForFunction(() => document.querySelector("#banner").hidden);
  await shown.health(page);
  await close();
  await own.close();
});

test("a picture that is not of now does not look as if it were", async () => {
  const own = await Stage.open();
  const { page, close } = await open("live", { on: own });
  await shown.live(page);
  assert.equal(await page.locator("#picture.stale").count(), 0);
  await own.end(own.service);
  await page.waitForSelector("#picture.stale");
  assert.equal(await page.locator("#pose.stale").count(), 1);
  assert.match(await page.locator("#verdict").textContent(), /No service/);
  await close();
  await own.close();
});

test("a page with a token asks for it, and takes it from its address", async () => {
  const token = "0123456789abcdef0123456789abcdef";
  const file = path.join(fs.mkdtempSync("/dev/shm/ninedot-token-"), "token");
  fs.writeFileSync(file, `${token}\n`, { mode: 0o600 });
  const own = await Stage.open({ web: `token_file = "${file}"` });
  const asked = await open("live", { on: own });
  await asked.page.waitForSelector("#token-dialog[open]");
  await asked.page.screenshot({ path: path.join(PICTURES, "token.png") });
  await asked.page.fill("#token-input", token);
  await asked.page.keyboard.press("Enter");
  await shown.live(asked.page);
  await asked.close();
  const linked = await open("live", { on: own, hash: `#token=${token}` });
  await shown.live(linked.page);
  assert.ok(!linked.page.url().includes(token), "out of the address bar");
  await linked.close();
  await own.close();
  fs.rmSync(path.dirname(file), { recursive: true });
});

test("the seventeenth viewer is told so", async () => {
  const own = await Stage.open();
  const names = Array.from({ length: 16 }, (_, i) => `viewer${100 + i}`);
  assert.ok((await Promise.all(names.map((name) => own.live(name)))).every((message) => message.number > 0));
  const { page, close } = await open("live", { on: own });
  await page.waitForFunction(() => /Sixteen pages/.test(document.querySelector("#banner").textContent));
  await close();
  await own.close();
});

test("the page is small", () => {
  const folder = path.join(path.dirname(new URL(import.meta.url).pathname), "../../programs/web/page");
  const bytes = fs.readdirSync(folder).reduce((sum, name) => sum + fs.statSync(path.join(folder, name)).size, 0);
  assert.ok(bytes <= 300 * 1024, `${bytes} bytes`);
});
