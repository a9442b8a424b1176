// Whatever reaches the page's port: the service's latency does not show it, the page goes on, and nothing is given away.
import assert from "node:assert/strict";
import fs from "node:fs";
import net from "node:net";
import path from "node:path";
import { after, before, test } from "node:test";

import { HeadStage } from "./head.mjs";
import { Stage, get, pause, until } from "./stage.mjs";

const TOKEN = "0123456789abcdef0123456789abcdef";
let stage, tokenFile;

before(async () => {
  tokenFile = path.join(fs.mkdtempSync("/dev/shm/ninedot-token-"), "token");
  fs.writeFileSync(tokenFile, `${TOKEN}\n`, { mode: 0o600 });
  stage = await Stage.open({ web: `token_file = "${tokenFile}"` });
});
after(async () => {
  if (stage) assert.deepEqual(await stage.close(), [0, 0], "both ended as they were asked to");
  fs.rmSync(path.dirname(tokenFile), { recursive: true });
});

const authorised = { Authorization: `Bearer ${TOKEN}` };
const live = () => stage.live("hostiletest", authorised);
// The first message after a rest may come before the first frame.
const liveFrame = () => until("the page is there, and a frame", async () => { const message = await live(); return message.frame && message; });

// Sends bytes as they are; resolves with what came back, once the other side has closed or `ms` are over.
const raw = (bytes, ms = 3000, port = stage.port) => new Promise((resolve) => {
  const socket = net.connect(port, "127.0.0.1");
  let answer = "";
  const done = () => { socket.destroy(); resolve(answer); };
  socket.on("data", (data) => { answer += data.toString("latin1"); });
  socket.on("error", done);
  socket.on("close", done);
  setTimeout(done, ms);
  socket.write(bytes);
});
const status = (answer) => Number(/^HTTP\/1\.\d (\d+)/.exec(answer)?.[1] ?? 0);

test("without the token nothing is told but the page itself", async () => {
  assert.equal((await get(stage.port, "/")).status, 200);
  for (const target of ["/api/live?viewer=abcdefgh", "/api/registers", "/api/map"]) {
    const { status: code, body } = await get(stage.port, target);
    assert.equal(code, 401, target);
    assert.ok(body.length < 100);
  }
});

test("every answer forbids what a page could be made to do", async () => {
  for (const target of ["/", "/page.js", "/nothing", "/api/map"]) {
    const { headers } = await get(stage.port, target);
    assert.match(headers["content-security-policy"], /^default-src 'none'; script-src 'self'; style-src 'self';/);
    assert.doesNotMatch(headers["content-security-policy"], /unsafe|\*|http/);
    assert.equal(headers["x-content-type-options"], "nosniff");
    assert.equal(headers["referrer-policy"], "no-referrer");
  }
});

test("another page, another name, another method: refused, token or not", async () => {
  const asked = (options) => get(stage.port, "/api/map", { ...options, headers: { ...authorised, ...options.headers } }).then((answer) => answer.status);
  assert.equal(await asked({}), 200);
  assert.equal(await asked({ headers: { Origin: "http://evil.example" } }), 403);
  assert.equal(await asked({ headers: { Origin: "null" } }), 403);
  assert.equal(await asked({ headers: { "Sec-Fetch-Site": "cross-site" } }), 403);
  assert.equal(await asked({ headers: { Host: "evil.example" } }), 421);
  for (const method of ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"]) assert.equal(await asked({ method }), 405, method);
});

test("no path leads out of the page's files", async () => {
  const secret = "root:";
  for (const target of ["/../../etc/passwd", "/..%2f..%2fetc%2fpasswd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/....//etc/passwd", "/page.js%00.html",
    "/\\..\\..\\etc\\passwd", "/api/../../etc/passwd", `/${"a/".repeat(2000)}`]) {
    const answer = await raw(`GET ${target} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n`);
    assert.ok([301, 400, 401, 404, 414, 431, 0].includes(status(answer)), `${target}: ${status(answer)}`);
    assert.ok(!answer.includes(secret), target);
  }
});

test("no name of a recording leads out of their folder, and no post makes one of another name", async () => {
  const kept = fs.mkdtempSync("/dev/shm/ninedot-kept-");
  const own = await Stage.open({ web: `token_file = "${tokenFile}"\nrecordings = "${kept}"` });
  const name = "20261123-121415-asked";
  const secret = path.join(kept, name);
  fs.mkdirSync(secret);
  fs.writeFileSync(path.join(secret, "frames.csv"), "root:");
  for (const target of ["..", "../", "%2e%2e/frames.csv", "..%2f..%2fetc%2fpasswd", "../../etc/passwd", `${name}/../${name}/frames.csv`, `${name}%2fframes.csv`, `${name}/frames.csv%00`, `${name}/frames.csv`,
    `${name}/download`, `${name}/download/..`, `${name}//etc/passwd`, `${name}/frames/../../x.png`, `${name}/frames/..%2f..%2f00.png`, `${name}/frames/00000/.png`, `.${name}/download`, `.doomed-${name}/frames.csv`,
    `${"a".repeat(9000)}/download`, `${name}/frames/${"0".repeat(9000)}.png`, "\u00e4/download".normalize("NFD"), "", "/", "?name=.."]) {
    const answer = await raw(`GET /api/recordings/${target} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer ${TOKEN}\r\nConnection: close\r\n\r\n`, 2000, own.port);
    assert.ok([400, 404, 414, 431, 0].includes(status(answer)), `${target}: ${status(answer)}`);
    assert.ok(!answer.includes("root:"), target);
  }
  const posted = async (body) => status(await raw(`POST /api/recordings HTTP/1.1\r\nHost: 127.0.0.1:${own.port}\r\nOrigin: http://127.0.0.1:${own.port}\r\nAuthorization: Bearer ${TOKEN}\r\nContent-Length: ${body.length}\r\nConnection: close\r\n\r\n${body}`, 2000, own.port));
  for (const body of ["delete ..", "delete ../../etc", `delete ${name}/..`, `delete ${name}\0`, `delete ${name}\n`, "start ../x", "start\n", "{}", "delete *", `DELETE ${name}`]) assert.equal(await posted(body), 400, JSON.stringify(body));
  assert.equal(await posted(`delete ${name}`), 404, "it came there after the start, and is none of ours");
  assert.equal(await posted("x".repeat(129)), 413);
  assert.ok(fs.existsSync(path.join(secret, "frames.csv")));
  assert.deepEqual(fs.readdirSync(kept), [name]);
  assert.deepEqual(await own.close(), [0, 0]);
  fs.rmSync(kept, { recursive: true });
});

test("an archive that nobody takes holds its place for a minute at most, and two of them are all", async () => {
  const kept = fs.mkdtempSync("/dev/shm/ninedot-kept-");
  const own = await Stage.open({ web: `token_file = "${tokenFile}"\nrecordings = "${kept}"` });
  const state = async () => JSON.parse((await get(own.port, "/api/recordings", { headers: authorised })).body);
  const post = (body) => get(own.port, "/api/recordings", { method: "POST", body, headers: { ...authorised, Origin: `http://127.0.0.1:${own.port}`, "Content-Length": body.length } });
  await post("start");
  await until("a recording that no socket's buffer takes", async () => (await state()).running?.frames > 80);
  await post("stop");
  const [{ name }] = await until("it is kept", async () => { const { recordings } = await state(); return recordings.length && recordings; });
  const target = `/api/recordings/${name}/download`;
  const sockets = [0, 1].map(() => net.connect(own.port, "127.0.0.1").on("error", () => {}));
  for (const socket of sockets) {
    socket.pause();
    socket.write(`GET ${target} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer ${TOKEN}\r\n\r\n`);
  }
  await until("the third is told to wait", async () => (await get(own.port, target, { headers: authorised })).status === 503);
  assert.ok((await own.live("hostile002", authorised)).number > 0, "all else goes on");
  for (const socket of sockets) socket.destroy();
  await until("who left holds no place", async () => (await get(own.port, target, { headers: authorised })).status === 200);
  assert.deepEqual(await own.close(), [0, 0]);
  fs.rmSync(kept, { recursive: true });
});

test("five wrong tokens from an address, and no more are looked at for a while", async () => {
  const own = await Stage.open({ web: `token_file = "${tokenFile}"` });
  const tried = async (token) => (await get(own.port, "/api/map", { headers: { Authorization: `Bearer ${token}` } })).status;
  for (let i = 0; i < 5; ++i) assert.equal(await tried(`guess${i}`), 401);
  assert.equal(await tried("guess6"), 429);
  assert.equal(await tried(TOKEN), 429, "or guessing would go on");
  await own.close();
});

test("a token that others may read, a public address without one: refused before anything is served", async () => {
  const { spawnSync } = await import("node:child_process");
  const { BIN } = await import("./stage.mjs");
  const config = path.join(path.dirname(tokenFile), "config.toml");
  const refused = (web) => {
    fs.writeFileSync(config, `[tap]\nenabled = true\n[web]\nport = 1\n${web}`);
    const { status: code, stderr } = spawnSync(path.join(BIN, "ninedot-web"), ["--config", config], { encoding: "utf8", timeout: 10000 });
    assert.equal(code, 2, stderr);
    assert.equal(stderr.trim().split("\n").length, 1, stderr);
    return stderr;
  };
  assert.match(refused('listen = "0.0.0.0"\n'), /config\.toml:\d+: 'listen' is '0\.0\.0\.0'.*token_file/);
  const open = path.join(path.dirname(tokenFile), "open");
  fs.writeFileSync(open, `${TOKEN}\n`, { mode: 0o644 });
  assert.match(refused(`token_file = "${open}"\n`), /chmod 600/);
  assert.match(refused(`certificate = "${open}"\n`), /both 'certificate' and 'key'/);
  // Else the token would cross the network in the clear, under an address that says https.
  const empty = path.join(path.dirname(tokenFile), "empty.pem");
  fs.writeFileSync(empty, "", { mode: 0o600 });
  assert.match(refused(`certificate = "${open}"\nkey = "${empty}"\n`), /empty\.pem: is empty/);
});

test("slow heads are closed after ten seconds, though a byte comes each second", async () => {
  const started = Date.now();
  const socket = net.connect(stage.port, "127.0.0.1");
  let isClosed = false;
  socket.on("close", () => { isClosed = true; });
  socket.on("error", () => {});
  socket.write("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n");
  while (!isClosed && Date.now() - started < 25000) {
    if (!socket.destroyed) socket.write("X");
    await pause(1000);
  }
  assert.ok(isClosed && Date.now() - started < 16000, `${Date.now() - started} ms`);
});

test("whatever is posted by whomever, but by the page itself with the token: the head is not moved by it", async () => {
  const own = await HeadStage.open();
  const good = "take hostile01";
  const refused = async (status_, what, body, options) => assert.equal((await own.post(body, options)).status, status_, what);
  await refused(401, "no token", good, { token: null });
  await refused(401, "another token", good, { token: "0123456789abcdef0123456789abcdeF" });
  await refused(401, "a cookie", good, { token: null, headers: { Cookie: `token=${TOKEN}` } });
  await refused(401, "the token of a form", good, { token: null, headers: { Authorization: `Basic ${TOKEN}` } });
  for (const origin of ["http://evil.example", "null", `https://127.0.0.1:${own.port}`, `http://127.0.0.1:${own.port + 1}`, `http://localhost:${own.port}`, ""])
    await refused(403, `origin ${origin}`, good, { headers: { Origin: origin } });
  for (const site of ["cross-site", "same-site", "none", "x"]) await refused(403, `fetched from ${site}`, good, { headers: { "Sec-Fetch-Site": site } });
  await refused(421, "another name", good, { headers: { Host: "evil.example", Origin: "http://evil.example" } });
  await refused(413, "long", "x".repeat(129));
  for (const body of ["", "take", "take x", "take  hostile01", `${good}\n`, `${good}\0`, "jog hostile01 1 0 nan 0", "jog hostile01 1 0 1e999 0", "jog hostile01 -1 0 5 5", "{}",
    "viewer=hostile01", "\u{1f600}".repeat(20), "jog hostile01 99999999999 0 1 1", "a ".repeat(60)]) await refused(400, body, body);
  await refused(409, "who has no head jogs none", "jog hostile01 1 0 30 30");
  await refused(409, "nor gives one", "give hostile01");

  const request = (lines, body = "") => `POST /api/aim HTTP/1.1\r\nHost: 127.0.0.1:${own.port}\r\nOrigin: http://127.0.0.1:${own.port}\r\nAuthorization: Bearer ${TOKEN}\r\n${lines}\r\n\r\n${body}`;
  const answered = async (bytes) => status(await raw(bytes, 700, own.port));
  assert.equal(await answered(request("Content-Length: 100000000000", "x".repeat(1e5))), 413);
  assert.equal(await answered(request("Transfer-Encoding: chunked", `e\r\n${good}\r\n0\r\n\r\n`)), 411);
  assert.equal(await answered(request("Accept: */*")), 411, "of no length");
  assert.ok([400, 413].includes(await answered(request("Content-Length: -1", good))));
  assert.ok([400, 411, 0].includes(await answered(request(`Content-Length: ${good.length}\r\nTransfer-Encoding: chunked`, good))), "smuggled");
  assert.equal(await answered(request(`Content-Length: ${good.length + 40}`, good)), 0, "the rest never comes: nothing is done");
  assert.equal(await answered(request(`Content-Length: ${good.length}`, good).replace("/api/aim", "/api/aim/")), 405);
  assert.equal(await answered(request(`Content-Length: ${good.length}`, good).replace("/api/aim", "/api%2faim")), 405);
  const idle = JSON.parse((await get(own.port, "/api/aim?viewer=hostile01", { headers: authorised })).body);
  assert.deepEqual([idle.phase, idle.mine], ["free", false]);
  const head = await own.head();
  assert.deepEqual([head.command, head.sequence, head.setPan], [0, 0, 0], "nothing of it reached the head");
  assert.equal((await own.post(good)).status, 200, "what the page itself asks is done");
  assert.deepEqual(await own.close(), [0, 0]);
});

test("a storm of posts moves nothing, and the one who has the head jogs on", async (t) => {
  const own = await HeadStage.open();
  let { now } = await own.take("steady0001");
  let isOver = false;
  const texts = ["take hostile01", "follow hostile01", "jog hostile01 1 0 30 30", "x".repeat(100000)];
  const storm = texts.map(async (text) => {
    while (!isOver) {
      await own.post(text).catch(() => {});
      await pause(5);
    }
  });
  const from = (await own.head()).pan;
  let number = 0, inTime = 0;
  for (const end = Date.now() + 2000; Date.now() < end; await pause(20)) {
    const { status: code, state } = await own.post(`jog steady0001 ${++number} ${now} 10 0`);
    assert.equal(code, 200);
    inTime += state.now - now < 100 ? 1 : 0;
    now = state.now;
  }
  isOver = true;
  await Promise.all(storm);
  const head = await own.head();
  // On a machine that answers too late nothing turns, as it should.
  t.diagnostic(`${number} keep-alives, ${inTime} of them in time; ${head.pan} deg`);
  assert.ok(inTime < 20 || head.pan > from + 1, `${head.pan} deg`);
  assert.equal(head.tilt, 0);
  assert.deepEqual(await own.close(), [0, 0]);
});

// Median and 99 % of the frames between two states of the service's own histogram, as bins.
function quantileBin(before_, after_, share) {
  const counts = after_.frame.latency_bins.map((count, i) => count - before_.frame.latency_bins[i]);
  const total = counts.reduce((sum, count) => sum + count, 0);
  let below = 0;
  return { bin: counts.findIndex((count) => (below += count) >= share * total), total };
}

test("a storm of them leaves the service's latency as it was, and the page there for who has the token", async (t) => {
  const seconds = 8;
  const calm = [await liveFrame()];
  for (const end = Date.now() + seconds * 1000; Date.now() < end;) await live();
  calm.push(await liveFrame());

  const storm = [calm[1]];
  let isOver = false;
  const sockets = [];
  const connect = (first) => {
    const socket = net.connect(stage.port, "127.0.0.1");
    socket.on("error", () => {});
    socket.on("connect", () => first && socket.write(first));
    sockets.push(socket);
  };
  // A thousand connections: some silent, some slow, some with half a head.
  for (let i = 0; i < 1000; ++i) connect(["", "GET / HT", `GET /${"x".repeat(500)}`][i % 3]);
  const attack = async (work) => {
    while (!isOver) {
      await work().catch(() => {});
      await pause(20);
    }
  };
  const noise = Buffer.from(Array.from({ length: 20000 }, (_, i) => (i * 7919 + 13) % 256));
  const attacks = [
    attack(() => raw(`POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100000000000\r\n\r\n${"x".repeat(1e6)}`, 200)),
    attack(() => raw(noise, 200)),
    attack(() => raw(`GET / HTTP/1.1\r\n${"A: b\r\n".repeat(5000)}\r\n`, 200)),
    attack(() => raw("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\nFFFFFFFFFFFFFFFF\r\n", 200)),
    attack(() => get(stage.port, "/", { headers: { Origin: "http://evil.example" } })),
    attack(() => get(stage.port, "/api/live?viewer=abcdefgh")),
  ];
  await pause(seconds * 1000);
  isOver = true;
  await Promise.all(attacks);
  for (const socket of sockets) socket.destroy();
  storm.push(await liveFrame());

  for (const share of [0.5, 0.99]) {
    const a = quantileBin(...calm, share);
    const b = quantileBin(...storm, share);
    const ms = (bin) => (0.1 * 2 ** (bin / 4)).toFixed(2);
    t.diagnostic(`${100 * share} % of the frames within ${ms(a.bin)} ms without, ${ms(b.bin)} ms with the storm (${a.total} and ${b.total} frames)`);
    // Bins are a fifth of a doubling wide; on a machine that others use as well a few of them are chance.
    assert.ok(b.bin <= a.bin + (share === 0.5 ? 3 : 6), `latency of ${share}: bin ${a.bin} became ${b.bin}`);
  }
  assert.equal(storm[1].frame.failed, 0);
  assert.equal(stage.service.exitCode, null);
  assert.equal(stage.web.exitCode, null);
});

test("each answered within a second again", async () => {
  const started = Date.now();
  assert.equal((await get(stage.port, "/")).status, 200);
  assert.ok((await live()).number > 0);
  assert.ok(Date.now() - started < 1000);
});

test("one viewer costs little", async (t) => {
  const ticks = () => {
    const fields = fs.readFileSync(`/proc/${stage.web.pid}/stat`, "utf8").split(") ")[1].split(" ");
    return Number(fields[11]) + Number(fields[12]);
  };
  await live();
  const before_ = ticks();
  const started = Date.now();
  let count = 0;
  while (Date.now() - started < 8000) {
    await get(stage.port, "/api/live?viewer=oneviewer1&picture=1", { headers: authorised });
    ++count;
  }
  const percent = (ticks() - before_) / ((Date.now() - started) / 1000);
  t.diagnostic(`${percent.toFixed(2)} % of a processor at ${(count / 8).toFixed(1)} pictures a second of 640 x 480`);
  assert.ok(count > 60 && percent < 4, `${percent} % for ${count}`);
});
