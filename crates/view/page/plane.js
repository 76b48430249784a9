// The table's plane, from points that are clicked in the picture and measured on the table. The
// server computes it.

import { digits, element } from "./words.js";

/** Corners of a sheet of A4, which is usually at hand. The user may enter other points. */
const SHEET = [[0, 0], [297, 0], [297, 210], [0, 210]];
const LEAST = 4;

export class Plane {
  section = element("section");
  #box;
  #stage;
  #link;
  #hears;
  #isOn = false;
  #hasChain = false;
  /** Points with their `pixel` and `mm`, in pictures of this size. */
  #points = [];
  #size = null;
  /** The server's judgment of the points, and the number of the newest question. */
  #judged = null;
  #asked = 0;
  #rows = element("tbody");
  #sum = element("p", { className: "hint" });
  #said = element("p", { className: "said" });
  #click;
  #write;
  #clear;

  /**
   * @param {HTMLElement} box the element to click in
   * @param {Stage} stage shows points and grid
   * @param hears handlers: `begins` when clicking begins, and `wrote` with the change of the
   * settings when a plane was written
   */
  constructor(box, stage, link, hears) {
    [this.#box, this.#stage, this.#link, this.#hears] = [box, stage, link, hears];
    const button = (textContent, onclick) => element("button", { className: "wide", textContent, onclick });
    this.#click = button("Click points", () => this.turn());
    this.#write = button("Use it", () => this.#use());
    this.#clear = button("Clear", () => this.#take([]));
    const heads = ["", "x px", "X mm", "Y mm", "off mm", ""].map((textContent) => element("th", { scope: "col", textContent }));
    this.section.append(
      element("h2", { textContent: "Table's plane" }),
      element("p", {
        className: "hint",
        textContent: "Millimetres on the table: click four points or more that you have measured, such as the corners of a sheet of paper, "
          + "and write down where they are.",
      }),
      element("table", { className: "points" }, element("thead", {}, element("tr", {}, ...heads)), this.#rows),
      this.#sum,
      element("div", { className: "row" }, this.#click, this.#write, this.#clear),
      this.#said);
    this.#take([]);
  }

  get isOn() {
    return this.#isOn;
  }

  /** Sets whether there is a chain that can use a plane. */
  set hasChain(hasChain) {
    if (hasChain === this.#hasChain) return;
    this.#hasChain = hasChain;
    this.#show();
  }

  /** Starts or stops taking clicks as points. */
  turn(isOn = !this.#isOn) {
    if (isOn) this.#hears.begins();
    this.#isOn = isOn;
    this.#box.classList.toggle("picks", isOn);
    this.#show();
  }

  /** Takes a click on a pixel of a moment. */
  click(pixel, { width, height }) {
    const isOther = !this.#size || this.#size[0] !== width || this.#size[1] !== height;
    this.#size = [width, height];
    const before = isOther ? [] : this.#points;
    const point = { pixel: pixel.map((c) => Math.round(10 * c) / 10), mm: SHEET[before.length] ?? [0, 0] };
    this.#take([...before, { ...point, mm: [...point.mm] }]);
  }

  #take(points) {
    this.#points = points;
    this.#tell("");
    this.#rows.replaceChildren(...points.map((point, i) => this.#row(point, i)));
    this.#judge();
  }

  #row(point, i) {
    const cell = (child) => element("td", {}, child);
    const field = (axis) => element("input", {
      type: "number",
      step: "any",
      value: point.mm[axis],
      ariaLabel: `${"XY"[axis]} of point ${i + 1}, mm`,
      oninput: ({ target }) => {
        point.mm[axis] = target.valueAsNumber;
        this.#judge();
      },
    });
    const remove = element("button", {
      textContent: "×",
      title: `Remove point ${i + 1}`,
      onclick: () => this.#take(this.#points.toSpliced(i, 1)),
    });
    return element("tr", {}, cell(`${i + 1}`), cell(point.pixel.map((c) => c.toFixed(0)).join(", ")),
      cell(field(0)), cell(field(1)), cell("–"), cell(remove));
  }

  /** Asks for the plane of the points. Only the answer to the newest question counts. */
  async #judge() {
    this.#asked += 1;
    const asked = this.#asked;
    this.#judged = null;
    const isWhole = this.#points.length >= LEAST && this.#points.every(({ mm }) => mm.every(Number.isFinite));
    if (isWhole) {
      try {
        const judged = await this.#link.ask({ wish: "plane", ...this.#wish() });
        if (asked !== this.#asked) return;
        this.#judged = judged;
        this.#tell("");
      } catch (why) {
        if (asked !== this.#asked) return;
        this.#tell(why.message, true);
      }
    }
    this.#show();
  }

  #wish() {
    return { points: this.#points, size: this.#size };
  }

  async #use() {
    try {
      const { said, change } = await this.#link.ask({ wish: "write_plane", ...this.#wish() });
      this.turn(false);
      this.#tell(said);
      this.#hears.wrote(change);
    } catch (why) {
      this.#tell(why.message, true);
    }
  }

  /** Shows what can be done, and what is known. */
  #show() {
    this.#click.textContent = this.#isOn ? "Done" : "Click points";
    this.#click.setAttribute("aria-pressed", this.#isOn);
    this.#write.hidden = !this.#hasChain;
    this.#write.disabled = !this.#judged;
    this.#clear.hidden = !this.#points.length;
    this.section.querySelector("table").hidden = !this.#points.length;
    this.#points.forEach((_, i) => {
      const off = this.#judged?.off[i];
      const cell = this.#rows.children[i].children[4];
      cell.textContent = off?.[0] == null ? "–" : off[0].toFixed(2);
      cell.title = off?.[1] == null ? "" : `${off[1].toFixed(2)} px`;
    });
    this.#sum.textContent = this.#summary();
    const { lines } = this.#judged?.grid ?? { lines: [] };
    this.#stage.marks = { points: this.#points.map(({ pixel }) => pixel), lines };
  }

  #summary() {
    if (!this.#points.length) return "";
    if (this.#points.length < LEAST) return `${LEAST - this.#points.length} more.`;
    if (!this.#judged) return "";
    const { rms_mm: rms, most_mm: most, mm_per_px: pixel, grid, undistorted } = this.#judged;
    return [
      rms == null
        ? "Four points determine the plane and leave nothing to tell their errors by: a fifth would."
        : `Off by ${rms.toFixed(2)} mm (root of the mean square), at most ${most.toFixed(2)} mm.`,
      `The grid's lines are ${digits(grid.step_mm)} mm apart${pixel == null ? "" : `; a pixel at the middle is ${digits(pixel)} mm`}.`,
      undistorted ? "" : "Without a lens calibration the lens counts as free of distortion.",
    ].join(" ");
  }

  #tell(text, refused = false) {
    this.#said.textContent = text;
    this.#said.classList.toggle("refused", refused);
  }
}
