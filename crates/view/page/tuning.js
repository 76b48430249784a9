// Settings that can be changed while the chain runs: a rope's color, picked from the picture, the
// table's plane, and some others. `lariat config init` lists all settings and what each does.

import { element } from "./words.js";

/**
 * Settings, each shown as a slider, a switch or a choice. An `even` slider has a logarithmic scale,
 * and spans decades.
 */
const SETTINGS = [
  { title: "Rope", of: [
    { name: "extract.ropes", label: "Ropes at most", from: 1, to: 24, step: 1 },
    { name: "extract.points", label: "Points of a centerline", from: 8, to: 256, step: 1 },
    { name: "extract.min_confidence", label: "Warn below confidence", from: 0, to: 1, step: 0.01 },
    { name: "extract.keep_lost_s", label: "Keep a lost rope", unit: "s", from: 0, to: 10, step: 0.1 },
    { name: "extract.method", label: "Mask to centerline", choice: ["skeleton", "kmeans", "som", "gmm", "fcm"] },
  ] },
  { title: "Curve", of: [
    { name: "fit.basis", label: "Basis", choice: ["auto", "bezier", "bspline", "rational", "points", "mass"] },
    { name: "fit.control_points", label: "Control points", from: 2, to: 21, step: 1 },
    { name: "fit.tolerance", label: "Tolerance", unit: "widths", from: 0.01, to: 1, step: 0.01 },
    { name: "fit.tolerance_px", label: "Tolerance of wide ropes", unit: "px", from: 0.25, to: 10, step: 0.25 },
    { name: "fit.robust", label: "Far points weigh less", toggle: true },
    { name: "fit.pin_ends", label: "Ends on the rope's ends", toggle: true },
    { name: "fit.filter", label: "Filter in time", toggle: true },
    { name: "fit.acceleration_px_s2", label: "Acceleration for the filter", unit: "px/s²", from: 10, to: 100000, even: true },
  ] },
];

export class Tuning {
  #box;
  #stage;
  #link;
  #rig = null;
  #isFilm = false;
  /** Changes made here, by the name of their setting. */
  #changed = new Map();
  /**
   * Clicked points, the number of their moment, the mask made of them, and whether clicks are
   * points.
   */
  #points = [];
  #number = null;
  #mask = null;
  #picks = false;
  #plane;
  #said = element("p", { className: "said" });
  #colour = element("section");
  #controls = element("div", { className: "cards" });
  #keep = element("section");

  /**
   * @param {HTMLElement} box holds everything
   * @param {HTMLElement} stage the element to click in
   * @param {(hears) => Plane} makePlane makes the calibration of the table's plane, which is part
   * of this tab
   */
  constructor(box, stage, link, makePlane) {
    [this.#box, this.#stage, this.#link] = [box, stage, link];
    this.#plane = makePlane({
      begins: () => this.pick(false),
      wrote: (change) => {
        this.#changed.set("camera.plane", change);
        this.look();
      },
    });
    box.append(this.#colour, this.#plane.section, this.#controls, this.#keep);
    this.#showColour();
  }

  /** Takes the server's status. */
  of(status) {
    this.#isFilm = Boolean(status.film);
    this.#plane.hasChain = !this.#isFilm;
    if (status.rig === this.#rig) return;
    this.#rig = status.rig;
    this.#changed.clear();
    if (!this.#box.hidden) this.look();
  }

  /** Asks for the current settings, and shows them. */
  async look() {
    if (this.#isFilm) return;
    try {
      this.#show(await this.#link.ask({ wish: "settings" }));
    } catch (why) {
      this.#controls.replaceChildren(element("section", {}, element("p", { className: "hint", textContent: why.message })));
      this.#keep.hidden = true;
    }
  }

  /** Starts or stops taking clicks as points on a rope. */
  pick(picks = !this.#picks) {
    if (picks) this.#plane.turn(false);
    this.#picks = picks;
    this.#points = [];
    this.#stage.classList.toggle("picks", picks);
    this.#showColour();
  }

  /** Starts or stops taking clicks as points of the table. */
  calibrate() {
    this.#plane.turn();
  }

  /** Takes a click on a pixel of a moment. */
  async click(pixel, said) {
    if (this.#plane.isOn) this.#plane.click(pixel, said);
    if (!this.#picks) return;
    const { number } = said;
    // Only points of the same picture belong together.
    if (number !== this.#number) this.#points = [];
    this.#number = number;
    this.#points.push(pixel);
    try {
      this.#mask = await this.#link.ask({ wish: "pick", number, at: this.#points });
      this.#showColour();
    } catch (why) {
      this.#points.pop();
      this.#showColour(why.message);
    }
  }

  #showColour(refused) {
    const act = (textContent, onclick, pressed) => {
      const button = element("button", { className: "wide", textContent, onclick });
      if (pressed != null) button.setAttribute("aria-pressed", pressed);
      return button;
    };
    const parts = [
      element("h2", { textContent: "Rope's colour" }),
      element("p", {
        className: "hint",
        textContent: this.#picks
          ? "Click on the rope; while paused, once more for each other colour that it has, or for its shaded side."
          : "Where lariat takes the wrong thing for a rope, show it the rope's colour.",
      }),
      element("div", { className: "row" },
        act(this.#picks ? "Done" : "Pick in the picture", () => this.pick(), this.#picks),
        ...(this.#mask ? [
          ...(this.#isFilm ? [] : [act("Use it", () => this.#set("extract.mask", this.#mask.mask))]),
          act("Hide the mask", () => this.#drop()),
        ] : []),
        ...(this.#isFilm ? [] : [act("Automatic", () => this.#set("extract.mask", "auto"))])),
    ];
    if (this.#mask) parts.push(element("code", { textContent: `[extract]\nmask = ${this.#mask.mask}` }));
    const doubt = refused ?? this.#mask?.doubt;
    if (doubt) parts.push(element("p", { className: "said refused", textContent: doubt }));
    this.#colour.replaceChildren(...parts);
  }

  #drop() {
    this.#mask = null;
    this.pick(false);
    this.#link.ask({ wish: "mask", mask: null }).catch(() => {});
  }

  #show(settings) {
    this.#keep.hidden = false;
    this.#controls.replaceChildren(...SETTINGS.map(({ title, of }) => element("section", {},
      element("h2", { textContent: title }),
      ...of.map((about) => this.#control(about, about.name.split(".").reduce((table, key) => table?.[key], settings))))));
    this.#showKeep();
  }

  #control(about, value) {
    const label = element("label", { className: "setting" }, element("span", { textContent: about.label, title: about.name }));
    label.classList.toggle("is-changed", this.#changed.has(about.name));
    const set = (text) => this.#set(about.name, text);
    if (about.toggle) {
      label.append(element("input", { type: "checkbox", checked: value === true, onchange: ({ target }) => set(target.checked) }));
    } else if (about.choice) {
      const options = about.choice.map((name) => element("option", { textContent: name, selected: name === value }));
      label.append(element("select", { onchange: ({ target }) => set(target.value) }, ...options));
    } else {
      this.#slide(label, about, value, set);
    }
    return label;
  }

  #slide(label, about, value, set) {
    const shown = element("output");
    const [from, to] = about.even ? [Math.log10(about.from), Math.log10(about.to)] : [about.from, about.to];
    const at = typeof value === "number" ? (about.even ? Math.log10(value) : value) : from;
    const slider = element("input", { type: "range", min: from, max: to, step: about.even ? 0.05 : about.step });
    slider.value = at;
    const number = () => {
      const x = about.even ? 10 ** slider.valueAsNumber : slider.valueAsNumber;
      return about.even ? Number(x.toPrecision(2)) : x;
    };
    const tell = (x) => {
      shown.textContent = x == null ? "by itself" : `${x} ${about.unit ?? ""}`;
      slider.style.setProperty("--part", `${(100 * (slider.valueAsNumber - from)) / (to - from)}%`);
    };
    slider.oninput = () => tell(number());
    slider.onchange = () => set(number());
    label.append(shown, slider);
    tell(value);
  }

  /** Changes a setting of the running chain. */
  async #set(name, value) {
    const change = `${name}=${value}`;
    try {
      this.#tell(await this.#link.ask({ wish: "set", changes: [change] }));
      this.#changed.set(name, change);
    } catch (why) {
      this.#tell(why.message, true);
    }
    this.look();
  }

  #showKeep() {
    const count = this.#changed.size;
    const button = element("button", {
      className: "wide",
      textContent: "Write to lariat.toml",
      disabled: !count,
      onclick: async () => {
        try {
          this.#tell(await this.#link.ask({ wish: "keep", changes: [...this.#changed.values()] }));
          this.#changed.clear();
          this.look();
        } catch (why) {
          this.#tell(why.message, true);
        }
      },
    });
    const hint = count
      ? `${[...this.#changed.values()].join("\n")}`
      : "What is changed here holds until the chain ends, unless it is written down.";
    this.#keep.replaceChildren(
      element("h2", { textContent: "Keep" }),
      count ? element("code", { textContent: hint }) : element("p", { className: "hint", textContent: hint }),
      element("div", { className: "row" }, button),
      this.#said);
  }

  #tell(text, refused = false) {
    this.#said.textContent = text;
    this.#said.classList.toggle("refused", refused);
  }
}
