// What the key at the cursor means, from the table that the service's own reader goes by.
import { element } from "./dom.js";

// {table, key} of a line of TOML, by the header above it; key: "" on a header
export function placeOf(text, line) {
  const lines = text.split("\n").slice(0, line);
  const header = /^\s*#?\s*\[\[?([\w.]+)\]\]?\s*(#.*)?$/;
  const key = /^\s*#?\s*([\w]+)\s*=/.exec(lines.at(-1) ?? "");
  for (let i = lines.length - 1; i >= 0; --i) {
    const found = header.exec(lines[i]);
    if (found) return { table: found[1], key: i === lines.length - 1 ? "" : key?.[1] ?? "" };
  }
  return { table: "", key: key?.[1] ?? "" };
}

// `words` in code.
const marked = (text) => text.split("`").map((part, i) => (i % 2 ? element("code", {}, part) : part));
const headerOf = (table) => (table.list ? `[[${table.name}]]` : table.name ? `[${table.name}]` : "above all tables");

export function keyHelp(keys, { table: name, key: wanted }) {
  const table = keys.tables.find((one) => one.name === name);
  if (!table) return [element("p.soft", {}, `[${name}] is no table of the configuration.`)];
  const key = keys.keys.find((one) => one.table === name && one.name === wanted);
  if (!key) {
    const names = keys.keys.filter((one) => one.table === name).flatMap((one) => [element("code", {}, one.name), " "]);
    return [element("h3", {}, element("code", {}, headerOf(table))), element("p", {}, ...marked(table.meaning)), element("p.names", {}, "Its keys: ", ...names)];
  }
  const row = (title, text) => (text ? [element("tr", {}, element("th", {}, title), element("td", {}, text))] : []);
  return [element("h3", {}, element("code", {}, key.name), ` of ${headerOf(table)}`), element("p", {}, ...marked(key.meaning)),
    element("table.facts", {}, ...row("unit", key.unit), ...row("may be", key.range), ...row("default", key.default))];
}
