// The canvas: the picture and its overlay, moved and zoomed.

import { draw, drawPlane } from "./overlay.js";

const MOST_ZOOM = 40;

export class Stage {
  #box;
  #canvas;
  #pen;
  #moment = null;
  #bitmap = null;
  #mask = null;
  #layers = new Set();
  #marks = null;
  /** Zoom relative to the size that fits, and the middle of the view in the image, from 0 to 1. */
  #zoom = 1;
  #middle = [0.5, 0.5];
  #due = false;

  /** @param {HTMLElement} box an element with a canvas in it */
  constructor(box, { hovers, clicks } = {}) {
    this.#box = box;
    this.#canvas = box.querySelector("canvas");
    this.#pen = this.#canvas.getContext("2d", { alpha: false });
    new ResizeObserver(() => this.redraw()).observe(box);
    box.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY * (event.deltaMode ? 0.06 : 0.0016)), this.#inside(event));
    }, { passive: false });
    this.#drag(clicks);
    box.addEventListener("pointermove", (event) => hovers?.(this.pixel(event)));
    box.addEventListener("pointerleave", () => hovers?.(null));
    box.addEventListener("dblclick", () => this.whole());
  }

  /**
   * Shows a moment with its decoded picture, which the stage owns from now on, and a drawing of its
   * mask.
   */
  show(moment, bitmap, mask) {
    this.#bitmap?.close();
    [this.#moment, this.#bitmap, this.#mask] = [moment, bitmap, mask];
    this.redraw();
  }

  set layers(layers) {
    this.#layers = layers;
    this.redraw();
  }

  /** Sets clicked points and lines of a grid, which are shown over every moment. */
  set marks(marks) {
    this.#marks = marks;
    this.redraw();
  }

  /** Width of the whole picture, in pixels of the screen. */
  get width() {
    const { scale } = this.#view();
    return scale * (this.#size()[0]) * devicePixelRatio;
  }

  whole() {
    this.#zoom = 1;
    this.#middle = [0.5, 0.5];
    this.redraw();
  }

  /** Zooms about a position in the box, by default its middle. */
  zoomBy(times, place = [this.#box.clientWidth / 2, this.#box.clientHeight / 2]) {
    const before = this.#image(place);
    this.#zoom = Math.min(MOST_ZOOM, Math.max(1, this.#zoom * times));
    const after = this.#image(place);
    const [width, height] = this.#size();
    this.#moveTo([
      this.#middle[0] + (before[0] - after[0]) / width,
      this.#middle[1] + (before[1] - after[1]) / height,
    ]);
  }

  /** Returns the pixel of the image under a pointer, or null outside the picture. */
  pixel(event) {
    const [x, y] = this.#image(this.#inside(event)).map((c) => c - 0.5);
    const [width, height] = this.#size();
    const isInside = this.#moment && x >= -0.5 && y >= -0.5 && x < width - 0.5 && y < height - 0.5;
    return isInside ? [x, y] : null;
  }

  redraw() {
    if (this.#due) return;
    this.#due = true;
    requestAnimationFrame(() => {
      this.#due = false;
      this.#draw();
    });
  }

  #size() {
    const said = this.#moment?.said;
    return [said?.width || 640, said?.height || 480];
  }

  /** Returns the mapping from the image's pixels, counted from the corner, to those of the box. */
  #view() {
    const [width, height] = this.#size();
    const [w, h] = [this.#box.clientWidth || 1, this.#box.clientHeight || 1];
    const scale = Math.min(w / width, h / height) * this.#zoom;
    const unit = parseFloat(getComputedStyle(document.documentElement).fontSize) / 15;
    return { scale, unit, x: w / 2 - this.#middle[0] * width * scale, y: h / 2 - this.#middle[1] * height * scale };
  }

  #inside(event) {
    const { left, top } = this.#box.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  #image([x, y]) {
    const view = this.#view();
    return [(x - view.x) / view.scale, (y - view.y) / view.scale];
  }

  /** Moves the view, and shows as little as possible of the space around the picture. */
  #moveTo(middle) {
    const [width, height] = this.#size();
    const { scale } = this.#view();
    const halves = [this.#box.clientWidth / width, this.#box.clientHeight / height].map((side) => side / scale / 2);
    this.#middle = middle.map((c, i) => (halves[i] >= 0.5 ? 0.5 : Math.min(1 - halves[i], Math.max(halves[i], c))));
    this.redraw();
  }

  #drag(clicks) {
    let from = null;
    this.#box.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      from = { x: event.clientX, y: event.clientY, middle: this.#middle, moved: false };
      this.#box.setPointerCapture(event.pointerId);
    });
    this.#box.addEventListener("pointermove", (event) => {
      if (!from) return;
      const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
      from.moved ||= Math.hypot(dx, dy) > 4;
      if (!from.moved) return;
      this.#box.classList.add("moves");
      const [width, height] = this.#size();
      const { scale } = this.#view();
      this.#moveTo([from.middle[0] - dx / scale / width, from.middle[1] - dy / scale / height]);
    });
    const end = (event) => {
      if (from && !from.moved && event.type === "pointerup") clicks?.(this.pixel(event), event);
      from = null;
      this.#box.classList.remove("moves");
    };
    this.#box.addEventListener("pointerup", end);
    this.#box.addEventListener("pointercancel", end);
  }

  #draw() {
    const ratio = devicePixelRatio;
    const [w, h] = [this.#box.clientWidth, this.#box.clientHeight];
    if (this.#canvas.width !== Math.round(w * ratio) || this.#canvas.height !== Math.round(h * ratio)) {
      [this.#canvas.width, this.#canvas.height] = [Math.round(w * ratio), Math.round(h * ratio)];
    }
    this.paint(this.#pen, ratio, [w, h], this.#view(), getComputedStyle(this.#box).backgroundColor);
  }

  /** Paints the moment with the mapping `view`. */
  paint(pen, ratio, [w, h], view, ground) {
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = ground;
    pen.fillRect(0, 0, w, h);
    if (!this.#moment) return;
    const [width, height] = this.#size();
    // Large pixels are shown as squares.
    pen.imageSmoothingEnabled = view.scale < 6;
    pen.imageSmoothingQuality = "high";
    const place = [view.x, view.y, width * view.scale, height * view.scale];
    if (this.#bitmap && this.#layers.has("picture")) pen.drawImage(this.#bitmap, ...place);
    if (this.#mask) pen.drawImage(this.#mask, ...place);
    draw(pen, this.#moment.said, view, this.#layers);
    if (this.#marks) drawPlane(pen, this.#marks, view);
  }

  /** Returns the whole picture in its own size, with its overlay, as a canvas. */
  still() {
    const [width, height] = this.#size();
    const canvas = new OffscreenCanvas(width, height);
    this.paint(canvas.getContext("2d"), 1, [width, height], { scale: 1, x: 0, y: 0 }, "#000");
    return canvas;
  }
}
