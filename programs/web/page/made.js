// What `ninedot` made for the page, a calibration or a map: its file to be fetched, and its use.
import { element, saveAs } from "./dom.js";
import { authorised } from "./feed.js";

// For a wizard that has to wait: kind, title, words.
export const MAP_FIRST = ["none", "A map is being built", "It can be cancelled in the view Map; then this may start."];

// path: of the desk that had it made
export async function download(path, name, file) {
  const response = await authorised(`${path}/${name}/${file}`).catch(() => null);
  if (response?.ok) saveAs(file, await response.blob());
}

// By a button where changes from here are permitted, else by a command that does the same.
// id: of the elements; where: in words, what it takes the place of; option: of `ninedot apply`
export function placing({ use, folder, config, name }, { path, id, file, option, where, question, applying }) {
  const words = element("p", {}, where);
  if (!use) {
    const post = () => authorised(path, { method: "POST", body: `use ${name}` });
    return [words, element("div.tools", {}, element("button", { type: "button", id: `${id}-use`, onclick: () => applying.ask(question, post) }, "Use this ..."))];
  }
  return [words, element("p.soft", {}, `Not from here: ${use}. On the sensor, as root:`),
    element("pre.commands", { id: `${id}-commands` }, `ninedot apply ${option} ${folder}/${name}/${file} --config ${config}`)];
}
