// The moments of the last 30 seconds, so that one can go back to them. What is older, or too much, is forgotten.

const LONGEST_MS = 30_000;
const MOST_BYTES = 96 << 20;

export class History {
  #moments = [];
  #bytes = 0;

  /** Keeps one more. */
  add(moment) {
    const last = this.#moments.at(-1);
    // Another chain, or one that was restarted after a reboot: its clock is another.
    if (last && moment.said.exposed_ms < last.said.exposed_ms) this.clear();
    this.#moments.push(moment);
    this.#bytes += moment.bytes;
    while (this.#moments.length > 1 && (this.span() > LONGEST_MS || this.#bytes > MOST_BYTES)) {
      this.#bytes -= this.#moments.shift().bytes;
    }
  }

  /** Has another of the same frame in its place. */
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

  /** From the first to the last, in ms. */
  span() {
    return this.length ? this.at(-1).said.exposed_ms - this.at(0).said.exposed_ms : 0;
  }

  /** How long before the last this one was, in s. */
  age(place) {
    return (this.at(-1).said.exposed_ms - this.at(place).said.exposed_ms) / 1000;
  }
}
