// The page's frame: which view is shown, what it is fed with, and what is said when nothing comes.
import { Feed, authorised, setToken } from "./feed.js";
import { History } from "./history.js";
import { LiveView } from "./live.js";
import { FocusView } from "./focus.js";
import { CalibrateView } from "./calibrate.js";
import { HealthView, verdicts, worstOf } from "./health.js";
import { RegistersView } from "./registers.js";
import { MapView } from "./map.js";
import { AimView } from "./aim.js";
import { RecordingsView } from "./recordings.js";
import { ArView } from "./ar.js";
import { ConfigurationView } from "./configuration.js";

const $ = (id) => document.getElementById(id);
const VIEWS = { live: LiveView, focus: FocusView, calibrate: CalibrateView, health: HealthView, registers: RegistersView, map: MapView, aim: AimView, recordings: RecordingsView, ar: ArView,
  configuration: ConfigurationView };
const THEMES = ["system", "light", "dark"];

const history = new History();
const shared = { history, registers: null, map: [], session: null };
let view = null;
let name = "";

function readHash() {
  const hash = location.hash.slice(1);
  const token = /^token=(.+)$/.exec(hash);
  if (token) {
    setToken(decodeURIComponent(token[1]));
    window.history.replaceState(null, "", location.pathname + "#live");
  }
  return VIEWS[hash] ? hash : "live";
}

function show(next) {
  if (next === name) return;
  view?.leave?.();
  name = next;
  const main = $("view");
  main.replaceChildren();
  view = new VIEWS[name](main, shared);
  feed.wantsPicture = Boolean(view.wantsPicture);
  feed.wantsEvery = Boolean(view.wantsEvery);
  for (const link of document.querySelectorAll("nav a")) {
    if (link.dataset.view === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${document.querySelector(`nav a[data-view=${name}]`).firstChild.textContent} – ninedot`;
  if (feed.newest) view.update(feed.newest);
}

function say(text, kind = "bad") {
  const banner = $("banner");
  banner.hidden = !text;
  banner.className = kind;
  if (banner.textContent !== text) banner.textContent = text;
}

function onMessage(message) {
  if (message.problem) say(message.problem);
  else if (message.service?.over) say("The recording is over: no frame will follow. Start ninedotd again, or let it loop.", "warn");
  else if (shared.session && !shared.session.loopback && !shared.session.tls)
    say("Not encrypted: whoever shares this network can read token and pictures. Give [web] a certificate and a key.", "warn");
  else say("");
  history.add(message);
  view?.update(message);
  if (message.frame && message.camera)
    $("about").textContent = `ninedotd ${message.camera.software}, ${message.camera.width} x ${message.camera.height}`;
  const worst = worstOf(verdicts(message, shared));
  const mark = $("health-mark");
  mark.hidden = worst === "good" || worst === "none";
  mark.className = `mark ${worst}`;
  mark.title = worst === "bad" ? "something is wrong" : "something deserves a look";
}

const feed = new Feed({ onMessage, onTrouble: (text) => say(text), onToken: askForToken });
shared.viewer = feed.viewer;

function askForToken(problem) {
  $("token-problem").textContent = problem;
  $("token-problem").hidden = !problem;
  if (!$("token-dialog").open) $("token-dialog").showModal();
}

$("token-form").addEventListener("submit", (event) => {
  event.preventDefault();
  setToken($("token-input").value.trim());
  $("token-input").value = "";
  $("token-dialog").close();
  start();
});
$("token-dialog").addEventListener("cancel", (event) => event.preventDefault());

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem("theme", theme);
  $("theme").textContent = `Theme: ${theme}`;
}
const nextTheme = () => setTheme(THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + 1) % THEMES.length]);
setTheme(THEMES.includes(localStorage.getItem("theme")) ? localStorage.getItem("theme") : "system");
$("theme").addEventListener("click", nextTheme);

window.addEventListener("hashchange", () => show(readHash()));
window.addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  const index = /^[0-9]$/.test(event.key) ? (Number(event.key) + 9) % 10 : -1;  // 0 is the tenth
  if (index >= 0 && index < Object.keys(VIEWS).length) location.hash = Object.keys(VIEWS)[index];
  else if (event.key === "t") nextTheme();
  else if (view?.onKey?.(event.key)) event.preventDefault();
});

async function start() {
  const session = await authorised("/api/session");
  if (!session.ok) return feed.troubled();
  shared.session = await session.json();
  const registers = await authorised("/api/registers");
  if (registers.status === 401 || registers.status === 429) return askForToken(feed.hasTried ? await registers.text() : "");
  shared.registers = await registers.json();
  const loadMap = async () => {
    const map = await authorised("/api/map").catch(() => null);
    if (map?.ok) shared.map = await map.json();
  };
  await loadMap();
  setInterval(loadMap, 5000);
  feed.start();
}

show(readHash());
const tryToStart = () => start().catch(() => {
  say("ninedot-web does not answer: is it running? Trying again.");
  setTimeout(tryToStart, 1000);
});
tryToStart();
