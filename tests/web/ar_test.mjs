// The AR view in a browser that draws by its processor alone: is the model where the picture shows what it stands on?
// Read back from the pixels that it saves, with markers of a pure colour on the landmark's dots.
import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";

import { DOTS, discsGltf, drawRecording, looking, pixelOf, radiusOf, truthOf } from "./drawn.mjs";
import { PICTURES, SIZES, SOURCE, Stage, browser, get, openPage, pause, until } from "./stage.mjs";

// What the picture shows and where the marker is drawn, at most.
const WITHIN_PX = 1;
const MAGENTA = [1, 0, 1];
const CYAN = [0, 1, 1];
let stage, chrome, folder;

before(async () => {
  fs.mkdirSync(PICTURES, { recursive: true });
  folder = fs.mkdtempSync(path.join(os.tmpdir(), "ninedot-ar-test-"));
  stage = await Stage.open();
  chrome = await browser({ draws: true });
});
after(async () => {
  await chrome?.close();
  if (stage) assert.deepEqual(await stage.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(folder, { recursive: true });
});

const open = async ({ on = stage, using = chrome, ...options } = {}) => {
  const opened = await openPage(using, on, "ar", options);
  await opened.page.waitForFunction(() => !/^(|Loading.*)$/.test(document.querySelector("#ar-state")?.textContent ?? ""));
  return opened;
};
const standing = (page) => page.waitForFunction(() => /Standing on landmark/.test(document.querySelector("#ar-state").textContent) && document.querySelector("#picture").dataset.frame > 0 && /triangles[1-9]/.test(document.querySelector("#ar-facts").textContent));
const state = (page) => page.locator("#ar-state").textContent();
const shownFrame = (page) => page.locator("#picture").getAttribute("data-frame");

// What is shown, as the page saves it: {width, height, data}.
async function saved(page) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("s")]);
  const png = fs.readFileSync(await download.path()).toString("base64");
  const { width, height, text } = await page.evaluate(async (file) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(file), (letter) => letter.charCodeAt(0))]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let letters = "";
    for (let i = 0; i < data.length; i += 0x8000) letters += String.fromCharCode(...data.subarray(i, i + 0x8000));
    return { width: bitmap.width, height: bitmap.height, text: btoa(letters) };
  }, png);
  return { width, height, data: Buffer.from(text, "base64") };
}

async function give(page, name, text) {
  const file = path.join(folder, name);
  fs.writeFileSync(file, text);
  await page.setInputFiles("#ar-file", file);
}

async function giveDiscs(page, name, discs) {
  await give(page, name, discsGltf(discs));
  await page.waitForFunction((wanted) => document.querySelector("#ar-model").selectedOptions[0].textContent === wanted, name);
  await page.locator("#ar-true").check();
}

// The middle of those pixels within `radius` of `at` that `pick` takes.
function middle({ width, height, data }, at, radius, pick) {
  const sum = [0, 0, 0];
  for (let v = Math.max(0, Math.ceil(at[1] - radius)); v <= Math.min(height - 1, at[1] + radius); ++v)
    for (let u = Math.max(0, Math.ceil(at[0] - radius)); u <= Math.min(width - 1, at[0] + radius); ++u) {
      if (Math.hypot(u - at[0], v - at[1]) > radius || !pick(data.subarray(4 * (v * width + u)))) continue;
      [u, v, 1].forEach((value, i) => { sum[i] += value; });
    }
  return [sum[0] / sum[2], sum[1] / sum[2]];  // not a number: there is nothing
}

const isMagenta = ([r, g, b]) => r > 190 && g < 90 && b > 190;
const isCyan = ([r, g, b]) => r < 90 && g > 190 && b > 190;
const apart3 = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));
const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// Where the picture is half as dark as ink on paper, near a dot.
function darkMiddle(picture, at, radius) {
  const greys = [];
  middle(picture, at, radius, ([r]) => greys.push(r));
  const half = (Math.min(...greys) + Math.max(...greys)) / 2;
  return middle(picture, at, radius, ([r]) => r < half);
}

// A dot's radius in the picture.
const sizeOf = (lens, pose, i) => apart(pixelOf(lens, pose, DOTS[i]), pixelOf(lens, pose, DOTS[i].map((value, axis) => value + (axis === 2 ? radiusOf(i) : 0))));

const STRONG = {
  plumb_bob: { model: "plumb_bob", k: [-0.28, 0.09, 0.001, -0.0008, 0], f: 400, width: 640, height: 480, at: [250, 0, -150] },
  rational_polynomial: { model: "rational_polynomial", k: [0.9, 0.12, 0.0006, -0.0004, 0.005, 1.3, 0.4, 0.04], f: 420, width: 640, height: 480, at: [-300, 0, -180] },
  equidistant: { model: "equidistant", k: [0.03, -0.012, 0.004, 0], f: 300, width: 640, height: 480, at: [400, 0, 260] },
};
const PLAIN = { model: "plumb_bob", k: [0, 0, 0, 0, 0], f: 720, width: 640, height: 480 };
const CASES = {
  "from the side": { recording: "tilt", lens: PLAIN },
  "a landmark near the border of a lens": { recording: "distorted", above: [40, 70, -30], lens: { ...PLAIN, k: [-0.12, 0.05, 0.0008, -0.0005, 0] } },
  ...Object.fromEntries(Object.entries(STRONG).map(([model, lens]) => [`a strong lens, ${model}, near the corner`, { lens }])),
};

// A walk past the sheet, which stays near the picture's corner.
function walk({ at }) {
  return Array.from({ length: 12 }, (_, i) => [60 - 10 * i, 520 + 14 * i, 30 + 6 * i]).map((mm) => looking(mm, mm.map((value, i) => (i === 1 ? 0 : value + at[i]))));
}

for (const [name, { recording, lens, above: told }] of Object.entries(CASES))
  test(`what stands on a dot is drawn where the picture shows the dot: ${name}`, async (t) => {
    let own = path.join(SOURCE, "tests/recordings", recording ?? "");
    let truth;
    if (!recording) {
      own = path.join(folder, lens.model);
      truth = walk(lens);
      drawRecording(own, lens, truth);
    } else truth = truthOf(own);
    const on = await Stage.open({ camera: `source = "recording"\ndevice = "${own}"\nrate_hz = 6.0` });
    const { page, close } = await open({ on });
    await standing(page);
    // One in front of the sheet, where it hides no dot and is in the picture.
    const above = told ?? (lens.at ? [130 * Math.sign(lens.at[0]), 70, 60 * Math.sign(lens.at[2])] : [0, 70, -150]);
    const worst = { seen: 0, truth: 0, corner: 0 };
    for (let round = 0; round < 3; ++round) {
      if (round) {
        const was = await shownFrame(page);
        await page.keyboard.press("f");
        await page.waitForFunction((before_) => Number(document.querySelector("#picture").dataset.frame) > Number(before_) + 1, was);
      }
      await page.locator("h1").click();  // off the inputs, which take the keys
      await page.keyboard.press("f");
      await giveDiscs(page, "points.gltf", [...DOTS.map((at) => ({ at, radius: 8, colour: MAGENTA })), { at: above, radius: 8, colour: CYAN }]);
      await page.locator("h1").click();
      const points = await saved(page);
      await giveDiscs(page, "discs.gltf", DOTS.map((at, i) => ({ at, radius: radiusOf(i), colour: MAGENTA })));
      await page.locator("h1").click();
      const discs = await saved(page);
      await page.keyboard.press("m");
      const picture = await saved(page);
      await page.keyboard.press("m");
      assert.deepEqual([picture.width, picture.height], [lens.width, lens.height]);
      // The pose that was true of this very frame: the one whose dots the picture shows.
      const offOf = (pose) => Math.max(...DOTS.map((at, i) => {
        const pixel = pixelOf(lens, pose, at);
        const off = apart(pixel, darkMiddle(picture, pixel, 1.5 * sizeOf(lens, pose, i)));
        return Number.isNaN(off) ? Infinity : off;
      }));
      const pose = truth.reduce((best, one) => (offOf(one) < offOf(best) ? one : best));
      assert.ok(offOf(pose) <= WITHIN_PX, `no true pose has its dots where the picture shows them: ${offOf(pose)} px at best`);
      DOTS.forEach((at, i) => {
        const expected = pixelOf(lens, pose, at);
        const size = sizeOf(lens, pose, i);
        worst.seen = Math.max(worst.seen, apart(darkMiddle(picture, expected, 1.5 * size), middle(discs, expected, 1.5 * size, isMagenta)));
        worst.truth = Math.max(worst.truth, apart(expected, middle(points, expected, 1.5 * size, isMagenta)));
        worst.corner = Math.max(worst.corner, apart(expected, [319.5, 239.5]));
      });
      worst.truth = Math.max(worst.truth, apart(pixelOf(lens, pose, above), middle(points, pixelOf(lens, pose, above), 14, isCyan)));
    }
    t.diagnostic(`${name}: at most ${worst.seen.toFixed(2)} px from where the picture shows it, ${worst.truth.toFixed(2)} px from the truth, up to ${worst.corner.toFixed(0)} px off the picture's middle`);
    assert.ok(worst.seen <= WITHIN_PX, `${worst.seen} px from where the picture shows it`);
    assert.ok(worst.truth <= WITHIN_PX, `${worst.truth} px from where it truly is`);
    await close();
    await on.close();
  });

for (const theme of ["light", "dark"])
  for (const size of Object.keys(SIZES))
    test(`the view is shown, ${theme}, on a ${size}`, async () => {
      // So slow that the near frame can be held.
      const near = await Stage.open({ camera: `source = "recording"\ndevice = "${path.join(SOURCE, "tests/recordings/positions")}"\nrate_hz = 1.0` });
      const { page, close } = await open({ on: near, theme, size });
      await standing(page);
      await page.getByText("Upright").click();
      await page.locator("h1").click();
      await until("a near one", async () => Number(/distance([\d]+)/.exec(await page.locator("#ar-facts").textContent())[1]) < 800);
      await page.keyboard.press("f");
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.ok(overflow <= 0, `${overflow} px wider than the screen`);
      await page.screenshot({ path: path.join(PICTURES, `ar-${theme}-${size}.png`), fullPage: true });
      await close();
      await near.close();
    });

test("every frame comes to who looks at AR, some to who looks elsewhere, and to AR no longer when it is left", async (t) => {
  const seconds = 3;
  // How many pictures a second, and of how many frames.
  const watched = async (viewer, every) => {
    const frames = new Set();
    let pictures = 0;
    for (const until_ = Date.now() + 1000 * seconds; Date.now() < until_;) {
      const { body } = await get(stage.port, `/api/live?viewer=${viewer}&picture=1${every ? "&every=1" : ""}`);
      const length = body.readUInt32BE(0);
      if (body.length > 4 + length) ++pictures;
      frames.add(JSON.parse(body.subarray(4, 4 + length)).frame?.number);
    }
    return { pictures: pictures / seconds, frames: frames.size / seconds };
  };
  const [every, some] = await Promise.all([watched("everyframe", true), watched("someframes", false)]);
  t.diagnostic(`of 35 frames/s: AR is given ${every.frames.toFixed(1)}, another view ${some.frames.toFixed(1)}`);
  assert.ok(every.frames > 15 && every.frames > 1.5 * some.frames && Math.abs(every.pictures - every.frames) < 1, `${every.pictures} pictures of ${every.frames} frames a second`);
  assert.ok(some.frames < 12.5 && some.pictures > 5, `${some.pictures} pictures a second for a view that wants some`);
  const left = await watched("everyframe", false);
  assert.ok(left.frames < 12.5, `${left.frames} a second when AR is left`);
});

test("without a landmark there is no model, and it is said why", async () => {
  const bare = await Stage.open({ recording: "negative" });
  const { page, close } = await open({ on: bare });
  await page.waitForFunction(() => document.querySelector("#picture").dataset.frame > 0 && /No pose, no model.{10}/.test(document.querySelector("#ar-state").textContent));
  await page.locator("h1").click();
  const { data } = await saved(page);
  let coloured = 0;
  for (let i = 0; i < data.length; i += 4) coloured += Math.abs(data[i] - data[i + 2]) > 40 ? 1 : 0;
  assert.equal(coloured, 0, "a grey camera's picture");
  await close();
  await bare.close();
});

test("models that can't be shown are refused in one line, and the one before stays", async () => {
  const { page, close } = await open();
  await standing(page);
  const disc = { at: [0, 0, 0], radius: 40, colour: MAGENTA };
  const good = JSON.parse(discsGltf([disc]));
  const changed = (change) => JSON.stringify({ ...good, ...change });
  const cut = Buffer.alloc(64);
  [0x46546c67, 2, 1000, 900, 0x4e4f534a].forEach((word, i) => cut.writeUInt32LE(word, 4 * i));
  for (const [name, text, said] of [
    ["noise.glb", "noise", /no glTF 2\.0 file/], ["cut.glb", cut, /cut short/], ["empty.gltf", changed({ meshes: [] }), /nothing in it/],
    ["outside.gltf", changed({ buffers: [{ byteLength: 4, uri: "http://elsewhere.example/a.bin" }] }), /in another file.*export it as one \.glb/],
    ["texture.gltf", changed({ images: [{ uri: "wood.png" }] }), /texture of it is in another file/],
    ["draco.gltf", changed({ extensionsRequired: ["KHR_draco_mesh_compression"] }), /without compression/],
    ["claims.gltf", changed({ accessors: [{ componentType: 5126, count: 1e9, type: "VEC3" }] }), /too detailed/],
    ["large.glb", Buffer.alloc(33e6), /larger than 32 MB/], ["damaged.gltf", changed({ nodes: [{ mesh: 7 }] }), /damaged/],
  ]) {
    await give(page, name, text);
    await page.waitForFunction((wanted) => document.querySelector("#ar-problem").textContent.startsWith(wanted), `${name} can't be shown: `);
    const line = await page.locator("#ar-problem").textContent();
    assert.match(line, said);
    assert.ok(line.length < 160 && !line.includes("\n"), line);
    assert.equal(await page.locator("#ar-model").inputValue(), "light");
  }
  await give(page, "good.gltf", discsGltf([disc]));
  await page.waitForFunction(() => document.querySelector("#ar-problem").hidden && document.querySelector("#ar-model").value === "own");
  await close();
});

test("a texture in a model is shown, and nothing is fetched for it", async () => {
  const near = await Stage.open({ recording: "positions" });
  const { page, close } = await open({ on: near });
  await standing(page);
  const uri = await page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 4, height: 4 });
    Object.assign(canvas.getContext("2d"), { fillStyle: "#00ffff" }).fillRect(0, 0, 4, 4);
    return canvas.toDataURL("image/png");
  });
  await give(page, "textured.gltf", discsGltf([{ at: [0, 0, 0], radius: 60, colour: MAGENTA }], { images: [{ uri }], textures: [{ source: 0 }] }));
  await page.waitForFunction(() => document.querySelector("#ar-model").value === "own");
  await page.locator("h1").click();
  const { data } = await saved(page);
  let cyan = 0;
  for (let i = 0; i < data.length; i += 4) cyan += isCyan(data.subarray(i, i + 3)) ? 1 : 0;
  assert.ok(cyan > 40, `${cyan} pixels of the texture's colour`);
  await close();
  await near.close();
});

test("a model stands upright where the sheet hangs, as large and as high as it is told", async () => {
  const { page, close } = await open();
  await standing(page);
  const axes = await page.evaluate(async () => {
    const { axesOf } = await import("./ar_scene.js");
    const half = Math.SQRT1_2;
    const hanging = { in_landmark: { q: [half, -half, 0, 0] }, in_world: { q: [half, -half, 0, 0] } };
    // A sheet that lies with its face up: the world sees the camera turned a quarter more about x.
    const lying = { in_landmark: { q: [half, -half, 0, 0] }, in_world: { q: [1, 0, 0, 0] } };
    return { sheet: axesOf("sheet", hanging), hanging: axesOf("upright", hanging), lying: axesOf("upright", lying), nowhere: axesOf("upright", { ...hanging, in_world: { q: [null, null, null, null] } }) };
  });
  const near = (axis, wanted) => assert.ok(apart3(axis, wanted) < 1e-9, `${axis} is not ${wanted}`);
  near(axes.sheet[1], [0, 1, 0]);
  near(axes.hanging[1], [0, 0, 1]);
  near(axes.hanging[2], [0, 1, 0]);
  near(axes.nowhere[1], [0, 0, 1]);
  near(axes.lying[1], [0, 1, 0]);
  near(axes.lying[2], [0, 0, -1]);
  await page.keyboard.press("f");
  const coloured = async () => {
    await page.locator("h1").click();
    const { width, data } = await saved(page);
    const seen = { count: 0, v: 0 };
    for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - data[i + 2]) > 30) { ++seen.count; seen.v += Math.floor(i / 4 / width); }
    return { count: seen.count, v: seen.v / seen.count };
  };
  await page.getByText("Upright").click();
  const first = await coloured();
  await page.locator("#ar-size").focus();
  for (let i = 0; i < 10; ++i) await page.keyboard.press("ArrowRight");
  const larger = await coloured();
  assert.ok(larger.count > 1.3 * first.count, `${larger.count} pixels after ${first.count}`);
  await page.locator("#ar-raise").focus();
  for (let i = 0; i < 20; ++i) await page.keyboard.press("ArrowRight");
  const raised = await coloured();
  assert.ok(raised.v < larger.v - 8, `row ${raised.v} after ${larger.v}`);
  await close();
});

test("what it draws with is given back whenever the view is left", async () => {
  const context = await chrome.newContext();
  const page = await context.newPage();
  const warned = [];
  page.on("console", (message) => { if (/WebGL/i.test(message.text())) warned.push(message.text()); });
  await page.addInitScript(() => {
    window.made = [];
    const get_ = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      const made = get_.call(this, kind, ...rest);
      if (kind === "webgl2" && made && !window.made.includes(made)) window.made.push(made);
      return made;
    };
  });
  await page.goto(`http://127.0.0.1:${stage.port}/#ar`);
  for (let i = 0; i < 20; ++i) {
    await page.waitForFunction((count) => window.made.length === count, i + 1);
    if (i % 5 === 0) await page.waitForFunction(() => document.querySelector("#picture")?.dataset.frame > 0);
    await page.click("nav a[data-view=map]");
    await page.waitForSelector("#plan");
    await page.click("nav a[data-view=ar]");
  }
  await page.waitForFunction(() => window.made.length === 21);
  assert.deepEqual(await page.evaluate(() => window.made.map((one) => one.isContextLost()).filter((isLost) => !isLost).length), 1, "contexts that are still held");
  assert.ok(!warned.some((text) => /too many/i.test(text)), warned.join("; "));
  await context.close();
});

test("a browser without WebGL, and a build without three.js, are told in one line", async () => {
  const flat = await browser();
  const without = await openPage(flat, stage, "ar");
  await without.page.waitForFunction(() => /No AR here.*no WebGL 2/.test(document.querySelector("#ar-state").textContent));
  assert.equal(await without.page.locator("#picture:visible, .controls:visible").count(), 0);
  await without.page.click("nav a[data-view=live]");
  await without.page.waitForFunction(() => document.querySelector("#verdict"));
  await without.close();
  await flat.close();
  const context = await chrome.newContext();
  const page = await context.newPage();
  await page.route("**/three.js", (route) => route.fulfill({ path: path.join(SOURCE, "programs/web/ar/absent/three.js"), contentType: "text/javascript" }));
  await page.goto(`http://127.0.0.1:${stage.port}/#ar`);
  await page.waitForFunction(() => /No AR here.*\.\/dev ar/.test(document.querySelector("#ar-state").textContent));
  await context.close();
});

test("what is held is what was shown, though the next picture was about to be drawn", async () => {
  const { page, close } = await open();
  await standing(page);
  await page.evaluate(() => {
    window.planned = [];
    window.requestAnimationFrame = (draw) => window.planned.push(draw);
  });
  await page.waitForFunction(() => window.planned.length > 0);
  const shown = await shownFrame(page);
  await page.keyboard.press("f");
  await page.evaluate(() => window.planned.forEach((draw) => draw()));
  assert.equal(await shownFrame(page), shown);
  await close();
});

test("it draws 3,000 and 40,000 triangles", async (t) => {
  const { page, close } = await open();
  await standing(page);
  for (const [choice, count] of [["light", "3,000"], ["fine", "40,000"]]) {
    await page.selectOption("#ar-model", choice);
    await page.waitForFunction((wanted) => document.querySelector("#ar-facts").textContent.includes(`triangles${wanted}age`), count);
    await pause(4000);
    t.diagnostic(`${count} triangles: ${await page.locator("#picture").getAttribute("data-rate")} pictures/s, drawn by the processor`);
  }
  assert.match(await state(page), /same frame/);
  await close();
});
