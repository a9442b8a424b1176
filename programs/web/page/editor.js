// A text with numbered lines, and marks at those that something is said of. Tab leaves it, as everywhere on this page.
import { element } from "./dom.js";

export class Editor {
  constructor(onEdit, onCursor) {
    this.onCursor = onCursor;
    this.count = 0;
    this.marked = new Map();
    this.gutter = element("div.gutter", { "aria-hidden": "true" });
    this.text = element("textarea", { id: "configuration-text", wrap: "off", spellcheck: "false", autocapitalize: "off", autocomplete: "off", "aria-label": "Configuration", "aria-describedby": "configuration-keys",
      oninput: () => { this.number(); onEdit(); }, onscroll: () => this.follow() });
    for (const event of ["keyup", "click", "focus", "input"]) this.text.addEventListener(event, () => onCursor());
    this.node = element("div.editor", {}, this.gutter, this.text);
  }

  get value() {
    return this.text.value;
  }

  set value(text) {
    this.text.value = text;
    this.number();
  }

  // Of the cursor, from 1.
  get line() {
    return this.value.slice(0, this.text.selectionStart).split("\n").length;
  }

  lineText(line) {
    return this.value.split("\n")[line - 1] ?? "";
  }

  number() {
    const count = this.value.split("\n").length;
    if (count === this.count) return;
    this.count = count;
    this.gutter.replaceChildren(...Array.from({ length: count }, (_, i) => element("span", { onclick: () => this.goTo(i + 1) }, String(i + 1))));
    this.mark(this.marked);
  }

  // marked: Map of line -> {kind: "bad" | "warn", what}
  mark(marked) {
    for (const line of this.marked.keys()) this.markOne(line, null);
    this.marked = marked;
    for (const [line, mark] of marked) this.markOne(line, mark);
    this.text.setAttribute("aria-invalid", String([...marked.values()].some(({ kind }) => kind === "bad")));
  }

  markOne(line, mark) {
    const number = this.gutter.children[Math.min(line, this.count) - 1];
    if (!number) return;
    number.className = mark?.kind ?? "";
    number.title = mark?.what ?? "";
  }

  goTo(line) {
    const lines = this.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0);
    this.text.focus({ preventScroll: true });
    this.text.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
    const height = this.text.scrollHeight / Math.max(1, this.count);
    this.text.scrollTop = Math.max(0, (line - 1) * height - this.text.clientHeight / 3);
    this.text.scrollLeft = 0;
    this.node.scrollIntoView({ block: "nearest" });
    this.follow();
    this.onCursor();
  }

  follow() {
    this.gutter.scrollTop = this.text.scrollTop;
  }
}
