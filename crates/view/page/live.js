// The time line of a rig: the newest moment, or, paused, one of the last 30 seconds.

import { History } from "./history.js";

export class Live {
  #history = new History();
  #place = null;
  #link;
  #show;
  #width;

  /**
   * @param link to the server
   * @param {() => number} width of the picture on the screen, in its pixels
   * @param {(moment) => Promise} show puts a moment on the screen
   */
  constructor(link, width, show) {
    [this.#link, this.#width, this.#show] = [link, width, show];
  }

  get length() {
    return this.#history.length;
  }

  /** Which of them is shown, from 0. */
  get place() {
    return this.#place ?? Math.max(0, this.length - 1);
  }

  get isPaused() {
    return this.#place != null;
  }

  get label() {
    if (!this.isPaused) return "live";
    return this.#place === this.length - 1 ? "newest" : `−${this.#history.age(this.#place).toFixed(2)} s`;
  }

  connected() {
    if (!this.isPaused) this.#link.say({ type: "next", width: this.#width() });
  }

  async moment(moment) {
    if (moment.said.number === this.#history.at(this.place)?.said.number) {
      // The one that is shown, with another mask.
      this.#history.replace(this.place, moment);
      await this.#show(moment);
      return;
    }
    if (this.isPaused) return;
    this.#history.add(moment);
    await this.#show(moment);
    // Not before it is on the screen, and not at all while nobody looks.
    requestAnimationFrame(() => this.connected());
  }

  async goTo(place) {
    if (!this.length) return;
    this.#place = Math.min(this.length - 1, Math.max(0, place));
    await this.#show(this.#history.at(this.#place));
  }

  pause() {
    return this.goTo(this.place);
  }

  goOn() {
    this.#place = null;
    this.connected();
  }

  end() {
    if (this.isPaused) this.goOn();
  }
}
