// Four arrows that turn the head while one of them is held: by mouse, finger or arrow key.
import { element } from "./dom.js";

const ARROWS = [
  ["ArrowUp", "▲", "up", [0, 1]],
  ["ArrowLeft", "◀", "left", [1, 0]],
  ["ArrowRight", "▶", "right", [-1, 0]],
  ["ArrowDown", "▼", "down", [0, -1]],
];
const directionOf = new Map(ARROWS.map(([key, , , direction]) => [key, direction]));

export class JogPad {
  // onTurn(pan, tilt): -1, 0 or 1 each
  constructor(onTurn) {
    this.onTurn = onTurn;
    this.keys = new Set();
    this.pointer = null;
    this.node = element("div.pad", { id: "pad", tabindex: 0, role: "group", "aria-label": "Jog: hold an arrow key or a button",
      onpointerdown: (event) => this.press(event), onpointermove: (event) => this.slide(event), oncontextmenu: (event) => event.preventDefault(),
      onkeydown: (event) => this.key(event, true), onkeyup: (event) => this.key(event, false), onfocusout: () => this.release() },
    ...ARROWS.map(([key, sign, name]) => element(`button.${name}`, { type: "button", tabindex: -1, "data-key": key, "aria-label": `turn ${name}`, disabled: true }, sign)));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
      this.node.addEventListener(name, (event) => event.pointerId === this.pointer?.id && this.release());
    // A window that is left, or covered, gets no keyup.
    this.letGo = () => this.release();
    window.addEventListener("blur", this.letGo);
    document.addEventListener("visibilitychange", this.letGo);
  }

  end() {
    window.removeEventListener("blur", this.letGo);
    document.removeEventListener("visibilitychange", this.letGo);
  }

  enable(isEnabled) {
    if (this.isEnabled === isEnabled) return;
    this.isEnabled = isEnabled;
    for (const button of this.node.children) button.disabled = !isEnabled;
    if (!isEnabled) this.release();
  }

  press(event) {
    const button = event.target.closest("button");
    if (!button || button.disabled || event.button !== 0 || this.pointer) return;
    event.preventDefault();
    this.node.focus({ preventScroll: true });
    button.setPointerCapture(event.pointerId);
    this.pointer = { id: event.pointerId, key: button.dataset.key, place: button.getBoundingClientRect() };
    this.turn();
  }

  // A finger that slides off its button has let go of it.
  slide(event) {
    if (event.pointerId !== this.pointer?.id) return;
    const { left, right, top, bottom } = this.pointer.place;
    if (event.clientX < left || event.clientX > right || event.clientY < top || event.clientY > bottom) this.release();
  }

  key(event, isDown) {
    if (!directionOf.has(event.key) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (event.repeat || !this.isEnabled) return;
    this.keys[isDown ? "add" : "delete"](event.key);
    this.turn();
  }

  release() {
    this.keys.clear();
    this.pointer = null;
    this.turn();
  }

  turn() {
    const held = [...this.keys, ...(this.pointer ? [this.pointer.key] : [])];
    for (const button of this.node.children) button.classList.toggle("held", held.includes(button.dataset.key));
    this.onTurn(...[0, 1].map((axis) => Math.sign(held.reduce((sum, key) => sum + directionOf.get(key)[axis], 0))));
  }
}
