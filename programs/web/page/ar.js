// A model that stands on the landmark, in the live picture, by the pose of that very picture.
import { potGlb } from "./ar_pot.js";
import { ArScene } from "./ar_scene.js";
import { element, fixed, saveAs, setText, tellNoFrame, tellVerdict } from "./dom.js";
import { MOST_MB, readModel } from "./glb.js";

// A picture that is older is not shown as if it were new.
const STALE_MS = 1500;
// Over how long pictures are counted.
const COUNTED_MS = 2000;
// Cells around and along: two triangles each.
const POTS = { light: ["Pot, 3,000 triangles", 50, 30], fine: ["Pot, 40,000 triangles", 200, 100] };
const STANCES = { sheet: ["On the sheet", "Its foot on P9, upwards out of the sheet: for a sheet that lies"], upright: ["Upright", "Its foot at the height of P9, before the sheet, upwards in the world: for a sheet that hangs"] };

export class ArView {
  constructor(main, shared) {
    this.shared = shared;
    this.wantsPicture = true;
    this.wantsEvery = true;
    this.shownAt = [];
    this.freshAt = 0;
    this.place = { stance: "sheet", isTrueSize: false, size_mm: 200, turn_deg: 0, raise_mm: 0 };
    this.hasModel = true;
    const button = (text, title, act, more = {}) => element("button", { type: "button", title, onclick: act, ...more }, text);
    this.canvas = element("canvas", { id: "picture", role: "img", "aria-label": "the newest picture, with a model that stands on the landmark", width: 640, height: 480 });
    this.freezeButton = button("Freeze", "Hold this picture (f)", () => this.freeze(), { "aria-pressed": "false" });
    this.modelButton = button("Model", "Show the model, or the picture alone (m)", () => this.toggleModel(), { "aria-pressed": "true" });
    this.age = element("span.soft");
    this.verdict = element("div.verdict", { id: "ar-state", role: "status" });
    this.problem = element("p.bad", { id: "ar-problem", role: "alert", hidden: true });
    this.facts = element("table.facts", { id: "ar-facts" });
    this.stage = element("section.card.stage", {}, this.canvas, element("div.tools", {}, this.freezeButton, this.modelButton,
      button("Save", "As PNG, as it is shown (s)", () => this.save()), element("span.spacer"), this.age));
    this.controls = element("div.controls", {}, ...this.modelControls(), ...this.placeControls());
    main.append(element("h1", {}, "AR"), element("div.live", {}, this.stage, element("section.card", {}, this.verdict, this.controls, this.facts,
      element("p.soft", {}, "Nothing is taken to hide the model: it is drawn over whatever stands before it. Files are read in this browser alone, and sent nowhere."))));
    this.begin().catch((error) => this.giveUp(error.message));
  }

  modelControls() {
    const names = Object.entries(POTS).map(([key, [name]]) => element("option", { value: key }, name));
    this.ownName = element("option", { value: "own", hidden: true });
    this.choice = element("select", { id: "ar-model", onchange: () => this.choose() }, ...names, this.ownName);
    const file = element("input", { id: "ar-file", type: "file", accept: ".glb,.gltf,model/gltf-binary,model/gltf+json", onchange: (event) => this.takeFile(event.target) });
    return [element("label", {}, "Model ", this.choice), element("label", {}, `Your own, .glb or .gltf with everything in it, up to ${MOST_MB} MB `, file), this.problem];
  }

  placeControls() {
    const { place } = this;
    const slider = (name, text, from, to, value, told, put) => {
      const output = element("output", { for: `ar-${name}` }, told(value));
      const input = element("input", { id: `ar-${name}`, type: "range", min: from, max: to, step: name === "size" ? 0.01 : 5, value, oninput: () => {
        put(Number(input.value));
        setText(output, told(Number(input.value)));
        this.redraw();
      } });
      return [input, element("label", {}, element("span", {}, text, " ", output), input)];
    };
    const stances = Object.entries(STANCES).map(([key, [name, title]]) => element("label", { title }, element("input", { type: "radio", name: "ar-stance", value: key, checked: key === place.stance, onchange: () => {
      place.stance = key;
      this.redraw();
    } }), name));
    // Its logarithm: as fine at 20 mm as at 4 m.
    const sizeOf = (value) => Math.round(10 ** value);
    const [size, sizeLabel] = slider("size", "Longest side", 1.3, 3.6, Math.log10(place.size_mm), (value) => `${sizeOf(value)} mm`, (value) => { place.size_mm = sizeOf(value); });
    const [, turnLabel] = slider("turn", "Turned", -180, 180, 0, (value) => `${value}°`, (value) => { place.turn_deg = value; });
    const [, raiseLabel] = slider("raise", "Raised", -2000, 2000, 0, (value) => `${value} mm`, (value) => { place.raise_mm = value; });
    const isTrue = element("input", { id: "ar-true", type: "checkbox", onchange: () => {
      place.isTrueSize = isTrue.checked;
      size.disabled = isTrue.checked;
      this.redraw();
    } });
    return [element("fieldset", {}, element("legend", {}, "Stands"), ...stances), sizeLabel,
      element("label.check-line", { title: "Its own metres, and its own origin on P9" }, isTrue, "True size, by its own origin"), turnLabel, raiseLabel];
  }

  async begin() {
    tellVerdict(this.verdict, "none", "Loading ...", "");
    const three = await import("./three.js");
    if (this.hasLeft) return;
    if (three.isAbsent) throw new Error("This ninedot-web was built without the view AR: ./dev ar fetches what it needs; then build it again.");
    this.three = three;
    this.scene = new ArScene(three, this.canvas);
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      if (!this.hasLeft) this.giveUp("The browser has taken the graphics memory back: reload this page.");
    });
    await this.choose();
    this.plan();
  }

  giveUp(why) {
    this.isOver = true;
    this.stage.hidden = this.controls.hidden = this.facts.hidden = true;
    tellVerdict(this.verdict, "bad", "No AR here", why);
  }

  leave() {
    this.hasLeft = true;
    this.scene?.dispose();
    this.shown?.bitmap.close();
    this.next?.bitmap.close();
  }

  onKey(key) {
    const acts = { f: () => this.freeze(), s: () => this.save(), m: () => this.toggleModel() };
    acts[key]?.();
    return key in acts;
  }

  freeze() {
    this.isFrozen = !this.isFrozen;
    this.freezeButton.setAttribute("aria-pressed", String(this.isFrozen));
    setText(this.freezeButton, this.isFrozen ? "Go on" : "Freeze");
  }

  toggleModel() {
    this.hasModel = !this.hasModel;
    this.modelButton.setAttribute("aria-pressed", String(this.hasModel));
    this.redraw();
  }

  save() {
    this.redraw();  // what WebGL drew lasts no longer than this turn
    this.canvas.toBlob((blob) => blob && saveAs(`ninedot-ar-${this.canvas.dataset.frame ?? 0}.png`, blob), "image/png");
  }

  async choose() {
    const { value } = this.choice;
    if (value === "own") return this.show(this.own);
    const [, around, along] = POTS[value];
    return this.show(potGlb(around, along));
  }

  async takeFile(input) {
    const [file] = input.files;
    if (!file) return;
    try {
      if (file.size > MOST_MB * 1e6) throw new Error(`it is larger than ${MOST_MB} MB: reduce its detail or its textures`);
      const own = readModel(new Uint8Array(await file.arrayBuffer()));
      await this.show(own);
      this.own = own;
      Object.assign(this.ownName, { textContent: file.name, hidden: false });
      this.choice.value = "own";
    } catch (error) {
      this.complain(`${file.name} can't be shown: ${error.message}.`);
    }
    input.value = "";
  }

  complain(text) {
    setText(this.problem, text);
    this.problem.hidden = !text;
  }

  // Textures through <img>, which the content policy allows from this page's own memory; the loader's way would fetch them.
  async show(glb) {
    const loader = new this.three.GLTFLoader();
    loader.register((parser) => {
      parser.textureLoader = new this.three.TextureLoader();
      return { name: "ninedot" };
    });
    const { scene } = await loader.parseAsync(glb, "").catch(() => { throw new Error("it is damaged, or no glTF 2.0: export it again"); });
    if (this.hasLeft) return;
    const box = this.scene.setModel(scene);
    if (box.isEmpty()) throw new Error("there is nothing in it to be seen: export it with its meshes");
    this.complain("");
    this.redraw();
  }

  async update(message) {
    if (this.isOver || this.isFrozen) return;
    if (message.fresh) this.freshAt = message.received;
    this.canvas.classList.toggle("stale", message.received - this.freshAt > STALE_MS);
    if (this.scene) this.judge(message);
    if (!message.frame || !message.jpeg) return;
    const bitmap = await createImageBitmap(message.jpeg).catch(() => null);
    if (!bitmap) return;
    // Pictures may be ready in another order than they came.
    if (this.hasLeft || this.isFrozen || message.number < (this.next ?? this.shown)?.message.number) return bitmap.close();
    this.next?.bitmap.close();
    this.next = { message, bitmap };
    this.plan();
  }

  // Drawn when the browser is ready for it: one that draws slowly leaves pictures out, and has no queue of them.
  plan() {
    if (this.isPlanned || !this.next || !this.scene) return;
    this.isPlanned = true;
    requestAnimationFrame(() => {
      this.isPlanned = false;
      if (this.hasLeft || this.isOver || this.isFrozen || !this.next) return;
      this.shown?.bitmap.close();
      this.shown = this.next;
      this.next = null;
      this.redraw();
      this.count();
    });
  }

  redraw() {
    if (!this.shown || !this.scene || this.isOver || this.hasLeft) return;
    const { message: { camera, frame }, bitmap } = this.shown;
    this.scene.draw(bitmap, camera, frame, frame.valid && this.hasModel ? this.place : null);
    this.canvas.dataset.frame = frame.number;
    setText(this.age, `frame ${frame.number}`);
  }

  count() {
    const now = performance.now();
    const { message: { frame } } = this.shown;
    this.shownAt.push(now);
    while (now - this.shownAt[0] > COUNTED_MS) this.shownAt.shift();
    if (now - (this.toldAt ?? -Infinity) < 250) return;
    this.toldAt = now;
    const rate = ((this.shownAt.length - 1) * 1000) / (now - this.shownAt[0] || 1);
    const fact = (name, value) => element("tr", {}, element("th", {}, name), element("td.n", {}, value));
    this.facts.replaceChildren(fact("pictures shown", `${fixed(rate, 1)} /s`), fact("triangles", (this.scene.triangles ?? 0).toLocaleString("en")),
      fact("age of the pose", frame.age_ms === null ? "none yet" : `${fixed(frame.age_ms, 0)} ms`), fact("distance", frame.has_pose ? `${fixed(frame.distance_mm, 0)} mm` : "–"),
      fact("drawn by", this.scene.isSoftware ? "this browser's processor" : "graphics hardware"));
    this.canvas.dataset.rate = fixed(rate, 1);
  }

  judge({ frame, problem, received }) {
    if (!frame) return tellNoFrame(this.verdict, problem);
    if (received - this.freshAt > STALE_MS) return tellVerdict(this.verdict, "warn", "No new frame", "The picture is old: is the camera there?");
    if (frame.valid) return tellVerdict(this.verdict, frame.calibrated ? "good" : "warn", `Standing on landmark ${frame.landmark}`, frame.calibrated ? "Picture and pose are of the same frame." : "Not calibrated: run with a camera.yaml of this camera.");
    tellVerdict(this.verdict, "warn", "No pose, no model", `${frame.why}.`);
  }
}
