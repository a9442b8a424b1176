// The whole register map, live, as a controller sees it; and the same as a table for the controller's own tool.
import { element, setText } from "./dom.js";
import { decode, shown } from "./decode.js";

const S7_TYPES = { int16: "Int", int32: "DInt", uint16: "UInt", uint32: "UDInt", counter16: "UInt", counter32: "UDInt", float32: "Real", bits: "Word" };
const hex = (word) => word.toString(16).toUpperCase().padStart(4, "0");

// Tables that paste into a spreadsheet or an editor; columns by tabs.
export const TABLES = {
  s7: { name: "Siemens S7", make: (entries) => [["Name", "Data type", "MB_DATA_ADDR", "MB_DATA_LEN", "Factor", "Unit", "Comment"],
    ...entries.map((e) => [e.name, S7_TYPES[e.type] ?? "Word", 40001 + e.address, e.words, e.step, e.unit, e.meaning])] },
  ur: { name: "Universal Robots", make: (entries) => [["# URScript: one signal per register (type 2 = input register); 32-bit values: high * 65536 + low"],
    ...entries.flatMap((e) => Array.from({ length: e.words }, (_, i) =>
      [`modbus_add_signal("SENSOR_ADDRESS", 255, ${e.address + i}, 2, "${e.name}${e.words > 1 ? (i ? "_low" : "_high") : ""}")  # step ${e.step} ${e.unit}`.trimEnd()]))] },
  fanuc: { name: "FANUC", make: (entries) => [["Register", "Words", "Signal", "Signed", "Factor", "Unit", "Name", "Comment"],
    ...entries.flatMap((e) => Array.from({ length: e.words }, (_, i) =>
      [e.address + i, 1, `GI[${e.address + i + 1}]`, /^int/.test(e.type) && i === 0 ? "yes" : "no", e.step, e.unit, e.words > 1 ? `${e.name}.${i ? "low" : "high"}` : e.name, e.meaning]))] },
};
export const tableText = (kind, entries) => TABLES[kind].make(entries).map((row) => row.join("\t")).join("\n") + "\n";

// What a word of bits or a code says now; empty where it is a plain number.
function inWords(map, entry, word) {
  const bits = { status: map.status_bits, health_flags: map.health_bits }[entry.name];
  if (bits) return bits.filter((one) => word & (1 << one.bit)).map((one) => one.name).join(", ") || "no bit is set";
  const codes = { reason: map.reasons, pose_content: map.pose_contents, euler_convention: map.euler_conventions, command: map.commands }[entry.name];
  return codes?.find((one) => one.code === word)?.meaning ?? "";
}

export class RegistersView {
  constructor(main, shared) {
    this.shared = shared;
    this.filter = element("input", { type: "search", placeholder: "Filter by name, address or meaning", "aria-label": "Filter", oninput: () => this.applyFilter() });
    this.copied = element("span.soft", { role: "status" });
    this.body = element("tbody");
    main.append(element("h1", {}, "Registers, as a Modbus client reads them"),
      element("div.tools", {}, this.filter, element("span", {}, "Copy as a table for"),
        ...Object.entries(TABLES).map(([kind, table]) => element("button", { type: "button", "data-table": kind, onclick: () => this.copy(kind) }, table.name)), this.copied),
      element("section.card.scroll", {}, element("table.registers", {}, element("thead", {}, element("tr", {},
        element("th.n", {}, "address"), element("th", {}, "name"), element("th.raw", {}, "raw"), element("th.n", {}, "high word first"), element("th.n", {}, "low word first"),
        element("th", {}, "unit"), element("th.m", {}, "meaning"))), this.body)));
    this.rows = [];
  }

  build() {
    this.rows = this.shared.registers.registers.map((entry) => {
      const cells = { raw: element("td.raw"), high: element("td.n"), low: element("td.n"), meaning: element("td.m", {}, entry.meaning.replace(/,? see below/, "")) };
      const row = element("tr", {}, element("td.n", {}, entry.words > 1 ? `${entry.address}–${entry.address + 1}` : String(entry.address)), element("td", {}, entry.name),
        cells.raw, cells.high, cells.low, element("td", {}, entry.unit), cells.meaning);
      return { entry, row, cells, changedAt: 0 };
    });
    this.body.replaceChildren(...this.rows.map((one) => one.row));
    this.applyFilter();
  }

  applyFilter() {
    const text = this.filter.value.toLowerCase();
    for (const { entry, row } of this.rows)
      row.hidden = Boolean(text) && ![entry.name, String(entry.address), entry.meaning.toLowerCase()].some((part) => part.includes(text));
  }

  update(message) {
    if (!this.shared.registers || !message.service) return;
    if (!this.rows.length) this.build();
    const { registers, float_low_first: floatLowFirst, step_mm: stepMm } = message.service;
    const now = message.received;
    for (const one of this.rows) {
      const { entry, cells } = one;
      const words = registers.slice(entry.address, entry.address + entry.words);
      const step = entry.step_is_configured ? stepMm : entry.step;
      const raw = words.map(hex).join(" ");
      if (cells.raw.textContent !== raw) {
        if (cells.raw.textContent) one.changedAt = now;
        cells.raw.textContent = raw;
        setText(cells.high, shown(entry, decode(entry, words, false, step)));
        setText(cells.low, entry.words > 1 ? shown(entry, decode(entry, words, true, step)) : "");
        const sentence = inWords(this.shared.registers, entry, words[0]);
        if (sentence) setText(cells.meaning, sentence);
      }
      const isLow = entry.type === "float32" && floatLowFirst;
      cells.high.className = isLow && entry.words > 1 ? "n dim" : "n";
      cells.low.className = isLow ? "n" : "n dim";
      one.row.classList.toggle("changed", now - one.changedAt < 600);
    }
  }

  async copy(kind) {
    const visible = this.rows.filter((one) => !one.row.hidden).map((one) => one.entry);
    const text = tableText(kind, visible);
    // Over plain HTTP from another machine browsers give no clipboard: then it is shown to be copied by hand.
    try {
      await navigator.clipboard.writeText(text);
      setText(this.copied, `${visible.length} registers copied for ${TABLES[kind].name}`);
    } catch {
      this.area?.remove();
      this.area = element("textarea", { rows: 8, readonly: true, "aria-label": `Table for ${TABLES[kind].name}` });
      this.area.value = text;
      this.copied.after(this.area);
      this.area.select();
      setText(this.copied, "press Ctrl-C");
    }
  }
}
