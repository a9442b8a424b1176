// element("td.n", {title: "..."}, child or text, ...)
export function element(tag, attributes = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const made = document.createElement(name);
  if (classes.length) made.className = classes.join(" ");
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

export const setText = (node, text) => {
  if (node.textContent !== text) node.textContent = text;
};

// What a view says first. kind: good, warn, bad or none. What has not changed is left: screen readers would say it again.
export function tellVerdict(node, kind, title, words = "") {
  const said = JSON.stringify([kind, title, words]);
  if (node.dataset.said === said) return;
  node.dataset.said = said;
  node.className = `verdict ${kind}`;
  node.replaceChildren(title, ...(words ? [element("small", {}, words)] : []));
}

export const tellNoFrame = (node, problem) => tellVerdict(node, "bad", problem ? "No service" : "Waiting for a frame", problem ?? "");

// As many decimals as leave two digits of the uncertainty: more would be noise.
export function decimalsFor(sigma) {
  if (!(sigma > 0) || !Number.isFinite(sigma)) return 1;
  return Math.min(3, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
}

export const fixed = (value, decimals) => (value === null || !Number.isFinite(value) ? "?" : value.toFixed(decimals));

export function duration(ms) {
  const s = Math.floor(ms / 1000);
  if (s < 1) return "now";
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${s % 60} s`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
  return `${Math.floor(s / 86400)} d ${Math.floor((s % 86400) / 3600)} h`;
}

export function saveAs(name, blob) {
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
