// The service's configuration: edited, checked while one types, compared with the file, and applied by whoever on the
// sensor may do so. This page only asks for it.
import { Applying } from "./applying.js";
import { element, setText, tellVerdict } from "./dom.js";
import { reader } from "./decode.js";
import { counted, difference, shortened } from "./difference.js";
import { Editor } from "./editor.js";
import { authorised } from "./feed.js";
import { keyHelp, placeOf } from "./keyhelp.js";

const CHECK_AFTER_MS = 350;
const DRAFT = "configuration-draft";
const lineCount = (count) => `${count} ${count === 1 ? "line" : "lines"}`;

export class ConfigurationView {
  constructor(main, shared) {
    this.shared = shared;
    this.isAlive = true;
    this.file = null;
    this.problems = [];
    this.editor = new Editor(() => this.edited(), () => this.tellKey());
    this.verdict = element("div.verdict.none", { id: "configuration-verdict", role: "status" }, "Reading the file ...");
    this.messages = element("ul.messages", { id: "configuration-messages", "aria-label": "Messages" });
    this.help = element("section.card.help", { id: "configuration-help", "aria-label": "The key at the cursor" });
    this.note = element("p.warn", { id: "configuration-note", hidden: true, role: "status" });
    this.changes = element("h2", { id: "configuration-count" });
    this.table = element("tbody");
    this.applying = new Applying("configuration-progress", { begun: () => this.tellButtons(), ended: (status) => this.ended(status) });
    this.whyNot = element("p.soft", { id: "configuration-why-not", hidden: true });
    const button = (id, text, act) => element("button", { type: "button", id, disabled: true, onclick: act }, text);
    this.applyButton = button("configuration-apply", "Apply ...", () => this.ask());
    this.undoButton = button("configuration-undo", "Undo my edits", () => this.swap(this.file.text));
    this.beforeButton = button("configuration-before", "The one before", () => this.swap(this.file.before));
    this.redoButton = button("configuration-redo", "My edits again", () => this.swap(this.setAside));
    main.append(element("h1", { id: "configuration-title" }, "Configuration"), this.note, this.applying.card,
      element("div.configuration", {},
        element("section.card.text", {}, element("div.tools", {}, this.applyButton, this.undoButton, this.beforeButton, this.redoButton), this.whyNot, this.editor.node,
          element("p.soft", { id: "configuration-keys" }, "Tab leaves the text; F8 goes to the next message; Escape goes back to the buttons.")),
        element("div.aside", {}, element("section.card", {}, this.verdict, this.messages), this.help),
        element("section.card.difference", {}, this.changes, element("div.scroll", {}, element("table.lines", { id: "configuration-difference" }, this.table)))),
      this.applying.dialog);
    this.editor.node.addEventListener("keydown", (event) => this.onEditorKey(event));
    this.load();
  }

  leave() {
    this.isAlive = false;
    this.applying.end();
    clearTimeout(this.timer);
  }

  onEditorKey(event) {
    if (event.key === "Escape") this.applyButton.disabled ? this.undoButton.focus() : this.applyButton.focus();
    if (event.key !== "F8" || !this.problems.length) return;
    event.preventDefault();
    const lines = this.problems.map(({ line }) => line);
    this.editor.goTo(lines.find((line) => line > this.editor.line) ?? lines[0]);
  }

  // Also when the server was away for a moment.
  async load() {
    while (this.isAlive) {
      try {
        const [file, keys] = await Promise.all([authorised("/api/configuration"), this.keys ?? authorised("/api/configuration/keys")]);
        if (file.ok && (this.keys || keys.ok)) {
          this.keys ??= await keys.json();
          return this.take(await file.json());
        }
      } catch {
        // Asked again.
      }
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  }

  take(file) {
    const isFirst = this.file === null;
    const hadEdits = !isFirst && this.editor.value !== this.file.text;
    const draft = isFirst ? JSON.parse(sessionStorage.getItem(DRAFT) ?? "null") : hadEdits && { text: this.editor.value, tag: this.file.tag };
    this.file = file;
    this.loadedAt = performance.now();
    setText(document.getElementById("configuration-title"), `Configuration: ${file.path}`);
    this.editor.value = draft ? draft.text : file.text;
    this.isOfAnother = Boolean(draft) && draft.tag !== file.tag && draft.text !== file.text;
    this.whyNot.hidden = !file.why_not;
    setText(this.whyNot, `It can be edited and checked here, but not applied: ${file.why_not}.`);
    if (file.problem) this.say("bad", "The file can't be read", file.problem);
    if (file.apply.state === "running") this.applying.watch();
    else if (isFirst && file.apply.state !== "none") this.applying.tell(file.apply);
    this.edited(0);
    this.tellKey();
  }

  edited(delay = CHECK_AFTER_MS) {
    if (!this.file) return;
    const { value } = this.editor;
    if (value === this.file.text) sessionStorage.removeItem(DRAFT);
    else sessionStorage.setItem(DRAFT, JSON.stringify({ text: value, tag: this.file.tag }));
    this.isChecked = false;
    this.tellDifference();
    this.tellButtons();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.check(), delay);
  }

  async check() {
    const text = this.editor.value;
    let answer = null;
    let problem = "ninedot-web does not answer: the check is tried again.";
    try {
      const response = await authorised("/api/configuration/check", { method: "POST", body: text, signal: AbortSignal.timeout(8000) });
      if (response.ok) answer = await response.json();
      else problem = (await response.text()).trim();
    } catch {
      // As above.
    }
    if (!this.isAlive || text !== this.editor.value) return;
    if (answer) return this.tellMessages(answer);
    this.say("warn", "Not checked", problem);
    this.timer = setTimeout(() => this.check(), 2000);
  }

  tellMessages({ problems, notes, count }) {
    this.isChecked = true;
    this.problems = problems;
    const marks = new Map();
    for (const [kind, list] of [["warn", notes], ["bad", problems]])
      for (const { line, what, file } of list) if (!file) marks.set(line, { kind, what });
    this.editor.mark(marks);
    const item = (kind, { line, what, file }) => {
      const text = file ? `${file}, line ${line}: ${what}` : what;
      if (file) return element(`li.${kind}`, {}, text);
      return element("li", {}, element(`button.${kind}`, { type: "button", onclick: () => this.editor.goTo(line) }, element("b", {}, `line ${line}`), ` ${text}`));
    };
    this.messages.replaceChildren(...problems.map((one) => item("bad", one)), ...notes.map((one) => item("warn", one)));
    if (count === 0) this.say("good", "Nothing is wrong with it", "What devices and ports say to it is seen when it is applied.");
    else this.say("bad", count === 1 ? "One thing is wrong" : `${count} things are wrong`, count > problems.length ? `The first ${problems.length}:` : "");
    this.tellButtons();
  }

  say(kind, title, words) {
    tellVerdict(this.verdict, kind, title, words);
  }

  tellDifference() {
    const rows = difference(this.file.text, this.editor.value);
    this.counts = counted(rows);
    const { added, removed } = this.counts;
    setText(this.changes, added + removed ? `Difference to the file: ${lineCount(added)} added, ${lineCount(removed)} removed` : "No difference to the file");
    const names = { "+": "added", "-": "removed", " ": "same" };
    this.table.replaceChildren(...shortened(rows).map((row) => (row === null
      ? element("tr.gap", {}, element("td", { colspan: 4 }, "···"))
      : element(`tr.${names[row.sign]}`, {}, element("td.n", {}, String(row.was ?? "")), element("td.n", {}, String(row.is ?? "")),
        element("td.sign", { "aria-label": names[row.sign] }, row.sign), element("td", {}, row.text)))));
  }

  tellButtons() {
    const { file, editor } = this;
    const isSame = editor.value === file.text;
    this.applyButton.disabled = isSame || Boolean(file.why_not) || !this.isChecked || this.problems.length > 0 || this.applying.isWatching;
    this.undoButton.disabled = isSame;
    this.beforeButton.disabled = file.before === null || editor.value === file.before;
    this.redoButton.disabled = !this.setAside || this.setAside === editor.value;
    const notes = [];
    if (this.isOfAnother) notes.push("The file has been changed since these edits were begun: the difference below is to the file as it is now.");
    if (this.runsOlder) notes.push("The file has been changed since the service started: what runs is older.");
    setText(this.note, notes.join(" "));
    this.note.hidden = notes.length === 0;
  }

  // What stood here is kept for a second thought.
  swap(text) {
    if (this.editor.value !== this.file.text && this.editor.value !== this.file.before) this.setAside = this.editor.value;
    this.editor.value = text;
    this.edited(0);
  }

  ask() {
    const { added, removed } = this.counts;
    this.applying.ask(`Apply ${lineCount(added)} added, ${lineCount(removed)} removed?`, () =>
      authorised("/api/configuration/apply", { method: "POST", body: this.editor.value, headers: { "If-Match": this.file.tag } }));
  }

  ended(status) {
    this.tellButtons();
    // Over, or the file is another one by now.
    if (status === 202 || status === 412) this.load();
  }

  tellKey() {
    if (this.keys) this.help.replaceChildren(element("h2", {}, "At the cursor"), ...keyHelp(this.keys, placeOf(this.editor.value, this.editor.line)));
  }

  update(message) {
    if (!this.file || !message.service || !this.shared.registers) return;
    const uptime = reader(this.shared.registers, message.service)("uptime");
    const changedAgo = this.file.changed_s + (performance.now() - this.loadedAt) / 1000;
    const isOlder = changedAgo + 2 < uptime;
    if (isOlder !== Boolean(this.runsOlder)) {
      this.runsOlder = isOlder;
      this.tellButtons();
    }
  }
}
