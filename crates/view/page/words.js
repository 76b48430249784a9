// Formats numbers, and makes elements.

/** Formats microseconds for people: three digits, in µs, ms or s. */
export function time(us) {
  if (us == null || !Number.isFinite(us)) return "–";
  if (us < 1000) return `${digits(us)} µs`;
  if (us < 1e6) return `${digits(us / 1e3)} ms`;
  return `${digits(us / 1e6)} s`;
}

/** Formats microseconds for a table of µs: without a unit below 100,000 µs. */
export function micros(us) {
  if (us == null) return "–";
  return us < 1e5 ? digits(us) : time(us);
}

/** Formats a number with three digits. */
export function digits(x) {
  if (x == null || !Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size >= 1000) return Math.round(x).toLocaleString("en");
  return x.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2);
}

/** Makes an element with properties, and with text or children. */
export function element(name, about = {}, ...children) {
  const made = Object.assign(document.createElement(name), about);
  made.append(...children);
  return made;
}
