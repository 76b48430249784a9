// Charts of latency as SVG: a histogram, and a strip of the last minute.

import { time } from "./words.js";

const SVG = "http://www.w3.org/2000/svg";

function make(name, about, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(about)) made.setAttribute(key, value);
  if (text != null) made.textContent = text;
  return made;
}

/** Returns width and height of a chart in its own pixels, and the height of a line of text. */
function room(svg) {
  const { width, height } = svg.getBoundingClientRect();
  const line = parseFloat(getComputedStyle(document.documentElement).fontSize) * 0.95;
  svg.setAttribute("viewBox", `0 0 ${width || 1} ${height || 1}`);
  return { width, height, line };
}

/**
 * Draws bars over a logarithmic axis of time, those beyond the 99th percentile in another color.
 *
 * @param {{least_us: number, bars_per_octave: number, counts: number[]}} of
 */
export function histogram(svg, of, p99) {
  const { width, height, line } = room(svg);
  const low = line + 3;
  const bottom = height - low;
  const used = of.counts.flatMap((count, place) => (count ? [place] : []));
  const parts = [make("path", { class: "axis", d: `M0 ${bottom + 0.5}H${width}` })];
  if (used.length) {
    // Show at least four octaves, so that the bars do not jump about.
    const octave = of.bars_per_octave;
    let from = Math.floor(used[0] / octave) * octave;
    let to = Math.ceil((used.at(-1) + 1) / octave) * octave;
    while (to - from < 4 * octave) {
      to += octave;
      if (to - from < 4 * octave && from >= octave) from -= octave;
    }
    const most = Math.max(...of.counts);
    const each = width / (to - from);
    const us = (place) => of.least_us * 2 ** (place / octave);
    for (const place of used) {
      const tall = Math.max(1, (Math.sqrt(of.counts[place] / most)) * (bottom - 2));
      parts.push(make("rect", {
        class: us(place) > p99 ? "bar tail" : "bar",
        x: (place - from) * each + 0.75,
        y: bottom - tall,
        width: Math.max(1, each - 1.5),
        height: tall,
        rx: 1,
      }));
    }
    const octaves = (to - from) / octave;
    const step = Math.max(1, Math.ceil(octaves / 5));
    for (let i = 0; i < octaves; i += step) {
      const x = i * octave * each;
      parts.push(make("text", { x, y: height - 2 }, time(us(from + i * octave))));
    }
  }
  svg.replaceChildren(...parts);
}

/**
 * Draws the median and 99th percentile of each of the last seconds, or of parts of a recording.
 * There is room for `length` of them, the newest at the right.
 */
export function strip(svg, seconds, name, length) {
  const { width, height, line } = room(svg);
  const most = Math.max(1, ...seconds.flatMap((second) => (second ? [second[1]] : [])));
  const x = (place) => ((length - seconds.length + place) / Math.max(1, length - 1)) * width;
  const y = (us) => height - 1.5 - (us / most) * (height - line - 4);
  const path = (which) => {
    let pen = "M";
    return seconds.map((second, place) => {
      if (!second) {
        pen = "M";
        return "";
      }
      const part = `${pen}${x(place).toFixed(1)} ${y(second[which]).toFixed(1)}`;
      pen = "L";
      return part;
    }).join("");
  };
  svg.replaceChildren(
    make("path", { class: "axis", d: `M0 ${height - 0.5}H${width}` }),
    make("path", { class: "p99", d: path(1) }),
    make("path", { class: "p50", d: path(0) }),
    make("text", { x: 0, y: line - 3 }, name),
    make("text", { x: width, y: line - 3, "text-anchor": "end" }, time(most)),
  );
}
