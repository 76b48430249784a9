// The figures next to the picture, and the line above it.

import { histogram, strip } from "./charts.js";
import { color } from "./overlay.js";
import { digits, element, micros, time } from "./words.js";

const by = (id) => document.getElementById(id);
const STAGES = ["capture", "extract", "fit", "sink"];

/**
 * Shows the status, which the server sends four times per second. `isOfOther`: true if the page
 * shows something other than what the status describes.
 */
export function showStatus(status, isOfOther) {
  by("rig").textContent = status.rig ?? status.film?.name ?? "";
  by("processes").hidden = Boolean(status.film);
  by("obstacle").hidden = !status.obstacle;
  by("obstacle").textContent = status.obstacle ?? "";
  if (!isOfOther) showNotices(status.notices ?? []);
  showLatency(status);
  by("stages").replaceChildren(...status.stages.map((stage) => stageRow(stage, status.lost)));
}

/** Shows notices about the picture, as sentences. */
export function showNotices(notices) {
  by("notices").hidden = !notices.length;
  by("notices").replaceChildren(...notices.map((text) => element("p", { textContent: text })));
}

function showLatency(status) {
  const whole = status.steps.find((step) => step.whole);
  for (const key of ["p50", "p99", "max"]) by(key).textContent = time(whole?.[key]);
  by("window").textContent = status.film ? "exposed → fitted" : `exposed → fitted, last ${status.window_s} s`;
  histogram(by("histogram"), status.histogram, whole?.p99 ?? Infinity);
  if (status.film) strip(by("strip"), status.strip, "from the first frame on", status.strip.length);
  else strip(by("strip"), status.strip, "the last minute", 60);
  const parts = status.steps.filter((step) => !step.whole);
  by("shares").replaceChildren(...parts.map((step) => {
    const share = element("i", { className: step.wait ? "wait" : "", title: `${step.name}: ${time(step.p50)}` });
    share.style.flexGrow = step.p50;
    return share;
  }));
  const head = element("tr", {}, element("th", { textContent: "µs" }),
    ...["p50", "p90", "p99"].map((text) => element("th", { textContent: text })));
  by("steps").replaceChildren(...(parts.length ? [head] : []), ...parts.map((step) => element("tr",
    { className: step.wait ? "wait" : "" },
    element("td", { textContent: step.name }),
    ...["p50", "p90", "p99"].map((key) => element("td", { textContent: micros(step[key]) })))));
  by("limit").textContent = status.limit ? `What limits it: ${status.limit}` : "";
}

function stageRow(stage, lost) {
  const after = { capture: lost.capture, extract: lost.extract, bridge: lost.bridge }[stage.stage];
  const cell = (text, className = "") => element("td", { textContent: text, className });
  const name = STAGES.includes(stage.stage) ? stage.stage : `+ ${stage.stage}`;
  return element("tr", { title: `process ${stage.pid}` },
    cell(name),
    cell(stage.fps == null ? "" : digits(stage.fps)),
    cell(after ?? "", after ? "lost" : ""),
    cell(stage.cpu_percent == null ? "" : `${stage.cpu_percent.toFixed(0)} %`),
    cell(stage.own_mb == null ? "" : stage.own_mb.toFixed(1)));
}

/** Shows the ropes of the moment that is shown. */
export function showRopes(said) {
  by("count").textContent = said.ropes.length ? `${said.ropes.length}` : "";
  const none = element("li", { className: "none", textContent: "no rope in this frame" });
  by("ropes").replaceChildren(...(said.ropes.length ? said.ropes.map((rope) => ropeItem(rope, said.unit)) : [none]));
}

function ropeItem(rope, unit) {
  const swatch = element("span", { className: "swatch" });
  swatch.style.borderColor = color(rope.track);
  const curve = `${rope.basis}, ${rope.control_points} control points`;
  const fit = rope.coarse ? "coarse" : `rms ${digits(rope.rms)}`;
  const status = rope.status === "lost" ? `lost for ${rope.age_s.toFixed(1)} s` : rope.status ?? "?";
  return element("li", {},
    swatch,
    element("span", {}, `${rope.track}  ${status}`, element("span", { className: "what", textContent: `  ${curve}, ${fit} ${rope.coarse ? "" : unit}` })),
    element("span", { textContent: `${digits(rope.length)} ${unit}` }),
    confidence(rope.confidence));
}

/** Shows the confidence as a bar and a number, highlighted below 0.5. */
function confidence(value) {
  const bar = element("i");
  bar.style.width = `${100 * value}%`;
  return element("span", { className: value >= 0.5 ? "confidence" : "confidence low", title: "confidence, 0 to 1" },
    element("span", {}, bar), element("b", { textContent: (value ?? NaN).toFixed(2) }));
}

/** Shows the line at the top: the moment that is shown, and the rate. */
export function showFacts(said, fps) {
  const fact = (name, value, unit = "") => element("div", {},
    element("dt", { textContent: name }), element("dd", {}, value, element("span", { textContent: unit })));
  const facts = [];
  if (said) {
    facts.push(fact("frame", said.frame.toLocaleString("en")));
    if (said.width) facts.push(fact("size", `${said.width} × ${said.height}`, " px"));
  }
  if (fps != null) facts.push(fact("rate", digits(fps), " frames/s"));
  by("facts").replaceChildren(...facts);
}

/** Shows the state of the connection and of the time line. */
export function showState(state, text) {
  by("state").dataset.state = state;
  by("state").querySelector("b").textContent = text;
}
