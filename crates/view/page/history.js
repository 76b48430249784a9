// The moments of the last 30 seconds, to go back to. Older moments are dropped, and so are moments
// over the memory limit.

const LONGEST_MS = 30_000;
const MOST_BYTES = 96 << 20;

export class History {
  #moments = [];
  #bytes = 0;

  /** Adds a moment. */
  add(moment) {
    const last = this.#moments.at(-1);
    // Another chain has another clock, and so has one that was restarted after a reboot.
    if (last && moment.said.exposed_ms < last.said.exposed_ms) this.clear();
    this.#moments.push(moment);
    this.#bytes += moment.bytes;
    while (this.#moments.length > 1 && (this.span() > LONGEST_MS || this.#bytes > MOST_BYTES)) {
      this.#bytes -= this.#moments.shift().bytes;
    }
  }

  /** Replaces a moment by another one of the same frame. */
  replace(place, moment) {
    this.#bytes += moment.bytes - this.#moments[place].bytes;
    this.#moments[place] = moment;
  }

  clear() {
    this.#moments = [];
    this.#bytes = 0;
  }

  get length() {
    return this.#moments.length;
  }

  at(place) {
    return this.#moments.at(place);
  }

  /** Time from the first moment to the last, in ms. */
  span() {
    return this.length ? this.at(-1).said.exposed_ms - this.at(0).said.exposed_ms : 0;
  }

  /** Time from this moment to the last, in s. */
  age(place) {
    return (this.at(-1).said.exposed_ms - this.at(place).said.exposed_ms) / 1000;
  }
}
