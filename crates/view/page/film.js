// The time line of a recording. Each frame is requested when it is to be shown.

/** Interval between two frames without times, and the longest pause that is kept, in ms. */
const FRAME_MS = 1000 / 30;
const LONGEST_MS = 1000;

export class Film {
  #link;
  #width;
  #show;
  /** The frame that is shown, the one that is requested, and when the next is due. */
  #shown = null;
  #asked = null;
  #due = null;
  #plays = false;
  place = 0;

  constructor(link, width, show, { frames }) {
    [this.#link, this.#width, this.#show, this.length] = [link, width, show, frames];
  }

  get isPaused() {
    return !this.#plays;
  }

  get label() {
    return `${(this.place + 1).toLocaleString("en")} of ${this.length.toLocaleString("en")}`;
  }

  connected() {
    this.#asked = null;
    this.#ask(this.place);
  }

  async moment(moment) {
    this.#asked = null;
    const place = moment.said.number - 1;
    if (place !== this.place && !this.#plays) {
      // The user has moved on in the meantime.
      this.#ask(this.place);
      return;
    }
    if (this.#plays && this.#due != null) await new Promise((resolve) => setTimeout(resolve, this.#due - performance.now()));
    const before = this.#shown?.said;
    [this.#shown, this.place] = [moment, place];
    await this.#show(moment);
    if (!this.#plays) return;
    // Play at the pace of the recording.
    const took = before ? moment.said.exposed_ms - before.exposed_ms : FRAME_MS;
    const pace = took > 0 && took < LONGEST_MS ? took : FRAME_MS;
    this.#due = Math.max(performance.now(), (this.#due ?? performance.now()) + pace);
    this.#next();
  }

  /** Skips a frame that does not exist or is damaged. */
  missing() {
    this.#asked = null;
    if (this.#plays) this.#next();
  }

  goTo(place) {
    this.#plays = false;
    this.place = Math.min(this.length - 1, Math.max(0, place));
    this.#ask(this.place);
  }

  pause() {
    this.goTo(this.place);
  }

  goOn() {
    this.#plays = true;
    this.#due = null;
    this.#ask(this.place >= this.length - 1 ? 0 : this.place + 1);
  }

  end() {
    this.goTo(this.length - 1);
  }

  #next() {
    if (this.place + 1 < this.length) this.#ask(this.place + 1);
    else this.pause();
  }

  #ask(place) {
    if (this.#plays) this.place = place;
    if (this.#asked != null) return;
    this.#asked = place;
    this.#link.say({ type: "frame", place, width: Math.round(this.#width()) });
  }
}
