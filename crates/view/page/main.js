// Brings the parts together: the link, the stage, the history, the panel, keys and buttons.

import { History } from "./history.js";
import { connect } from "./link.js";
import { LAYERS } from "./overlay.js";
import { showFacts, showRopes, showState, showStatus } from "./panel.js";
import { Stage } from "./stage.js";
import { element } from "./words.js";

const by = (id) => document.getElementById(id);
const history = new History();
let status = null;
let isConnected = false;
/** Set while paused: which moment of the history is shown, from 0. */
let place = null;
let shown = null;

const stage = new Stage(by("stage"), {
  hovers(pixel) {
    by("cursor").textContent = pixel ? pixel.map((c) => c.toFixed(0)).join(", ") : "";
  },
});

const link = connect({
  async moment(moment) {
    history.add(moment);
    if (place == null) await show(moment);
    else updateTime();
    // Not before it is on the screen, and not at all while nobody looks.
    requestAnimationFrame(() => place == null && link.next(stage.width));
  },
  status(said) {
    status = said;
    showStatus(said);
    if (shown) showFacts(shown.said, said.fps);
    updateState();
  },
  answer() {},
  state(connected) {
    isConnected = connected;
    updateState();
    if (connected && place == null) link.next(stage.width);
  },
});

async function show(moment) {
  const bitmap = moment.jpeg ? await createImageBitmap(moment.jpeg).catch(() => null) : null;
  shown = moment;
  stage.show(moment, bitmap);
  showRopes(moment.said);
  showFacts(moment.said, status?.fps);
  updateTime();
  document.documentElement.dataset.frame = moment.said.number;
}

function updateState() {
  if (!isConnected) showState("lost", "the server is gone; trying again");
  else if (place != null) showState("paused", "paused");
  else if (!status || status.obstacle) showState("waiting", "waiting");
  else if (status.age_s > 2) showState("lost", `silent for ${status.age_s.toFixed(0)} s`);
  else showState("live", "live");
}

function updateTime() {
  const last = Math.max(0, history.length - 1);
  const scrubber = by("scrubber");
  scrubber.max = last;
  scrubber.value = place ?? last;
  by("when").textContent = place == null ? "live" : place === last ? "newest" : `−${history.age(place).toFixed(2)} s`;
  document.documentElement.classList.toggle("is-paused", place != null);
  by("back").disabled = (place ?? last) <= 0;
  by("forth").disabled = place == null || place >= last;
}

/** Shows a moment of the history, and stays there. */
function goTo(wanted) {
  if (!history.length) return;
  place = Math.min(history.length - 1, Math.max(0, wanted));
  show(history.at(place));
  updateState();
}

function goOn() {
  if (place == null) return;
  place = null;
  updateTime();
  updateState();
  link.next(stage.width);
}

const step = (by) => goTo((place ?? history.length - 1) + by);
const pause = () => (place == null ? goTo(history.length - 1) : goOn());

/** The frame with what is drawn over it as PNG, and what was seen in it as JSON. */
async function save() {
  if (!shown) return;
  const name = `${status?.rig ?? "lariat"}-${shown.said.frame}`;
  const png = await stage.still().convertToBlob({ type: "image/png" });
  const json = new Blob([`${JSON.stringify(shown.said, null, 2)}\n`], { type: "application/json" });
  for (const [blob, ending] of [[png, "png"], [json, "json"]]) {
    const address = URL.createObjectURL(blob);
    element("a", { href: address, download: `${name}.${ending}` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  }
}

/* What is drawn over the picture. */
const layers = new Set(LAYERS.filter(({ on }) => on).map(({ name }) => name));
const toggles = LAYERS.map(({ name, label }, i) => {
  const toggle = element("button", { textContent: label, title: `${label} (${i + 1})` });
  toggle.dataset.layer = name;
  toggle.onclick = () => {
    layers[layers.has(name) ? "delete" : "add"](name);
    showLayers();
  };
  return toggle;
});
function showLayers() {
  toggles.forEach((toggle) => toggle.setAttribute("aria-pressed", layers.has(toggle.dataset.layer)));
  stage.layers = layers;
}
by("layers").append(...toggles);
showLayers();

/* Light or dark: as the system has it, until it is chosen. */
function turn(theme) {
  document.documentElement.dataset.theme = theme;
  by("theme").textContent = theme === "light" ? "Dark" : "Light";
  stage.redraw();
  if (status) showStatus(status);
}
const system = matchMedia("(prefers-color-scheme: light)");
const chosen = () => localStorage.getItem("theme");
turn(chosen() ?? (system.matches ? "light" : "dark"));
system.onchange = () => chosen() ?? turn(system.matches ? "light" : "dark");
function switchTheme() {
  const theme = document.documentElement.dataset.theme === "light" ? "dark" : "light";
  localStorage.setItem("theme", theme);
  turn(theme);
}

by("theme").onclick = switchTheme;
by("help").onclick = () => by("keys").showModal();
by("pause").onclick = pause;
by("back").onclick = () => step(-1);
by("forth").onclick = () => step(1);
by("save").onclick = save;
by("scrubber").oninput = ({ target }) => goTo(target.valueAsNumber);

const KEYS = {
  " ": pause,
  ArrowLeft: () => step(-1),
  ArrowRight: () => place != null && step(1),
  Home: () => goTo(0),
  End: goOn,
  "+": () => stage.zoomBy(1.25),
  "=": () => stage.zoomBy(1.25),
  "-": () => stage.zoomBy(0.8),
  0: () => stage.whole(),
  s: save,
  t: switchTheme,
  "?": () => by("keys").showModal(),
};
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || by("keys").open) return;
  if (event.target.matches("input, textarea, select") && event.target !== by("scrubber")) return;
  const layer = toggles[Number(event.key) - 1];
  const act = layer ? () => layer.click() : KEYS[event.key];
  if (!act) return;
  event.preventDefault();
  act();
});
updateTime();
