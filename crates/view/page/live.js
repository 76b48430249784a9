// The time line of a rig: the newest moment or, while paused, one of the last 30 seconds.

import { History } from "./history.js";

export class Live {
  #history = new History();
  #place = null;
  #link;
  #show;
  #width;

  /**
   * @param link the connection to the server
   * @param {() => number} width returns the width of the picture on the screen, in its pixels
   * @param {(moment) => Promise} show puts a moment on the screen
   */
  constructor(link, width, show) {
    [this.#link, this.#width, this.#show] = [link, width, show];
  }

  get length() {
    return this.#history.length;
  }

  /** Index of the moment that is shown, from 0. */
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
      // This is the moment that is shown, with another mask.
      this.#history.replace(this.place, moment);
      await this.#show(moment);
      return;
    }
    if (this.isPaused) return;
    this.#history.add(moment);
    await this.#show(moment);
    // Ask for the next moment when this one is on the screen, but not while the page is hidden.
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
