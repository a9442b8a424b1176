// Exposure and gain, set where they stand: in the service's configuration, which is applied with its way back. What the
// camera itself does not take the service does not come up with.
import { Applying } from "./applying.js";
import { element, setText } from "./dom.js";
import { authorised } from "./feed.js";

const PATH = "/api/configuration";
const KEYS = [["exposure_us", "Exposure, us"], ["gain", "Gain"]];
const patience = () => ({ signal: AbortSignal.timeout(8000) });

const lineOf = (key) => new RegExp(`^(\\s*${key}\\s*=\\s*)([^#]*?)(\\s*(?:#.*)?)$`);

// Indices of a table's lines: its head, and the lines of its keys by their names.
function tableIn(lines, table, keys) {
  const found = { head: -1, at: {} };
  let isInside = false;
  lines.forEach((line, i) => {
    const head = /^\s*(\[\[?)\s*([\w.]+)\s*\]\]?\s*(#.*)?$/.exec(line);
    if (head) isInside = head[1] === "[" && head[2] === table;
    if (head && isInside) found.head = i;
    if (isInside) for (const key of keys) if (lineOf(key).test(line)) found.at[key] = i;
  });
  return found;
}

// {key: text as it is written}; without those that are not there
export function valuesIn(text, table, keys) {
  const lines = text.split("\n");
  return Object.fromEntries(Object.entries(tableIn(lines, table, keys).at).map(([key, i]) => [key, lineOf(key).exec(lines[i])[2]]));
}

// The text with these keys of a table; nothing else in it is touched. null: it has no such table.
export function withValues(text, table, values) {
  const lines = text.split("\n");
  const { head, at } = tableIn(lines, table, Object.keys(values));
  if (head < 0) return null;
  const added = [];
  for (const [key, value] of Object.entries(values))
    if (key in at) lines[at[key]] = lines[at[key]].replace(lineOf(key), (_, before, old, after) => `${before}${value}${after}`);
    else added.push(`${key} = ${value}`);
  lines.splice(head + 1, 0, ...added);
  return lines.join("\n");
}

export class Exposure {
  constructor() {
    this.isAlive = true;
    this.inputs = Object.fromEntries(KEYS.map(([key]) => [key, element("input", { id: `set-${key}`, type: "number", min: 0, step: "any", placeholder: "automatic", disabled: true, oninput: () => this.tell() })]));
    this.button = element("button", { type: "submit", id: "set-exposure", disabled: true }, "Set ...");
    this.note = element("p.warn", { id: "exposure-note", role: "status", hidden: true });
    this.whyNot = element("p.soft", { id: "exposure-why-not", hidden: true });
    this.applying = new Applying("exposure-applying", { ended: () => this.load() });
    this.node = element("section.card.exposure", {}, element("h2", {}, "Exposure and gain"),
      element("form.fields", { onsubmit: (event) => { event.preventDefault(); this.ask(); } }, ...KEYS.map(([key, name]) => element("label", {}, `${name} `, this.inputs[key])), this.button),
      element("p.soft", {}, "Empty: automatic. Kept in the configuration; the service restarts with it, about four seconds, and goes back where the camera does not take it."),
      this.note, this.whyNot, this.applying.card, this.applying.dialog);
    this.load();
  }

  leave() {
    this.isAlive = false;
    this.applying.end();
  }

  // Also when the server is away for a moment, as after an apply.
  async load() {
    while (this.isAlive) {
      try {
        const [file, keys] = await Promise.all([authorised(PATH, patience()), this.keys ?? authorised(`${PATH}/keys`, patience())]);
        if (file.ok && (this.keys || keys.ok)) {
          this.keys ??= (await keys.json()).keys.filter(({ table }) => table === "camera");
          return this.take(await file.json());
        }
      } catch {
        // Asked again.
      }
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  }

  take(file) {
    this.file = file;
    const values = valuesIn(file.text, "camera", Object.keys(this.inputs));
    for (const [key, input] of Object.entries(this.inputs)) {
      input.value = Number(values[key] ?? 0) || "";
      input.max = /\.\. (\S+)$/.exec(this.keys.find(({ name }) => name === key).range)[1];
    }
    this.whyNot.hidden = !file.why_not;
    setText(this.whyNot, `Not from here: ${file.why_not}.`);
    this.tell();
  }

  // What is written now, where it is another one than in the file. An empty field and a key that is not there are both 0.
  changes() {
    const values = valuesIn(this.file.text, "camera", Object.keys(this.inputs));
    return Object.fromEntries(Object.entries(this.inputs).map(([key, { value }]) => [key, Number(value)]).filter(([key, value]) => value !== Number(values[key] ?? 0)));
  }

  tell() {
    const isClosed = !this.file || Boolean(this.file.why_not);
    for (const input of Object.values(this.inputs)) input.disabled = isClosed;
    this.button.disabled = isClosed || Object.keys(this.changes()).length === 0;
  }

  say(text) {
    setText(this.note, text);
    this.note.hidden = !text;
  }

  async ask() {
    const changes = this.changes();
    const { tag } = this.file;
    const text = withValues(this.file.text, "camera", changes);
    if (text === null) return this.say("The configuration has no line [camera]: set them in the view Configuration.");
    const checked = await authorised(`${PATH}/check`, { method: "POST", body: text, ...patience() }).catch(() => null);
    const problems = checked?.ok ? (await checked.json()).problems : [{ what: "ninedot-web does not answer: nothing was done." }];
    this.say(problems.length ? problems[0].what : "");
    if (problems.length) return;
    const words = Object.entries(changes).map(([key, value]) => `${key} = ${value || "automatic"}`);
    this.applying.ask(`Set ${words.join(" and ")}?`, () => this.apply(text, tag));
  }

  // What was typed meanwhile would be overwritten by the file that is loaded after it.
  apply(text, tag) {
    this.file = null;
    this.tell();
    return authorised(`${PATH}/apply`, { method: "POST", body: text, headers: { "If-Match": tag } });
  }
}
