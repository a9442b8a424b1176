// A change of what the service runs with: what is asked before it, and how far it has come. Somebody else on the sensor
// makes it, and takes it back where the service does not come up with it.
import { element } from "./dom.js";
import { authorised } from "./feed.js";

const PROGRESS_MS = 400;
const ENDS = {
  up: ["good", "In force: the service runs with it"],
  unchanged: ["none", "Nothing to do: the file holds this already"],
  refused: ["bad", "Refused, and nothing was changed"],
  back: ["bad", "Taken back: the service runs as it did before"],
  failed: ["bad", "This did not work"],
};

export class Applying {
  // begun, ended: called with it; ended gets the answer's status, 202 where one that was begun is over
  constructor(id, { begun = () => {}, ended }) {
    Object.assign(this, { begun, ended, isAlive: true });
    this.isWatching = false;
    this.card = element("section.card.progress", { id, hidden: true });
    this.dialog = element("dialog.sure", { "aria-labelledby": "sure-title" });
  }

  end() {
    this.isAlive = false;
  }

  // Whether to do what it says: then `act`, which returns the answer to a request.
  ask(title, act) {
    const close = () => this.dialog.close();
    this.dialog.replaceChildren(element("h2", { id: "sure-title" }, title),
      element("p", {}, "The service is checked, restarted and watched. Meanwhile there is no position, and controllers lose their connection: about two seconds, or half a minute and more where it does not come up."),
      element("p", {}, "If it has not come up within 30 seconds the file as it is now is put back, and the service started with it."),
      element("div.tools", {}, element("button", { type: "button", id: "sure", onclick: () => { close(); this.begin(act); } }, "Apply and restart"), element("button", { type: "button", onclick: close }, "Not now")));
    this.dialog.showModal();
  }

  async begin(act) {
    this.tell({ state: "running", phase: "sending", lines: [] });
    this.card.scrollIntoView({ block: "nearest" });
    const response = await act().catch(() => null);
    if (response?.status === 202) return this.watch();
    const text = response ? (await response.text()).trim() : "ninedot-web does not answer.";
    this.tell({ state: "failed", phase: "", lines: [text] });
    this.ended(response?.status ?? 0);
  }

  async watch() {
    if (this.isWatching) return;
    this.isWatching = true;
    this.begun();
    while (this.isAlive) {
      const response = await authorised("/api/configuration/apply").catch(() => null);
      const apply = response?.ok ? await response.json() : null;
      if (apply) this.tell(apply);
      if (apply && apply.state !== "running") break;
      await new Promise((resolve) => setTimeout(resolve, PROGRESS_MS));
    }
    this.isWatching = false;
    if (this.isAlive) this.ended(202);
  }

  tell({ state, phase, lines }) {
    this.card.hidden = false;
    const [kind, title] = ENDS[state] ?? ["none", `Under way: ${phase} ...`];
    const verdict = element(`div.verdict.${kind}`, { role: "status" }, title);
    this.card.replaceChildren(verdict, element("ol.log", {}, ...lines.map((line) => {
      const [word, ...rest] = line.split(": ");
      return element(`li${ENDS[word] && ENDS[word][0] === "bad" ? ".bad" : ""}`, {}, element("span.soft", {}, rest.length ? word : ""), element("span", {}, rest.length ? rest.join(": ") : line));
    })));
    this.card.dataset.state = state;
  }
}
