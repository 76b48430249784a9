// Connects the parts: the link, the stage, the time line, the panel, keys and buttons.

import { Film } from "./film.js";
import { connect } from "./link.js";
import { Live } from "./live.js";
import { LAYERS } from "./overlay.js";
import { showFacts, showNotices, showRopes, showState, showStatus } from "./panel.js";
import { Plane } from "./plane.js";
import { Stage } from "./stage.js";
import { tinted } from "./mask.js";
import { Tuning } from "./tuning.js";
import { element } from "./words.js";

const by = (id) => document.getElementById(id);
/** Largest file that is accepted, in bytes. */
const MOST_BYTES = 24_000_000;
/** Number of a moment that belongs to no frame: a dropped picture. */
const DROPPED = 0;
let status = null;
let isConnected = false;
let shown = null;

const stage = new Stage(by("stage"), {
  hovers(pixel) {
    by("cursor").textContent = pixel ? pixel.map((c) => c.toFixed(0)).join(", ") : "";
  },
  clicks(pixel) {
    if (pixel && shown) tuning.click(pixel, shown.said);
  },
});
const width = () => Math.round(stage.width);

const link = connect({
  moment: (moment) => (moment.said.number === DROPPED ? showDropped(moment) : line.moment(moment)),
  undropped: ({ why }) => showNotices([why]),
  missing: () => line.missing(),
  status(said) {
    if (said.film && !status?.film) {
      line = new Film(link, width, show, said.film);
      line.connected();
    }
    tuning.of(said);
    status = said;
    showStatus(said, shown?.said.number === DROPPED);
    if (shown) showFacts(shown.said, said.fps);
    update();
  },
  state(connected) {
    isConnected = connected;
    if (connected) line.connected();
    update();
  },
});
const tuning = new Tuning(by("tuning"), by("stage"), link, (hears) => new Plane(by("stage"), stage, link, hears));
/** Shows a rig, until the server says that it shows a recording. */
let line = new Live(link, width, show);

async function show(moment) {
  const bitmap = moment.jpeg ? await createImageBitmap(moment.jpeg).catch(() => null) : null;
  const mask = moment.mask ? await tinted(moment.mask).catch(() => null) : null;
  shown = moment;
  stage.show(moment, bitmap, mask);
  showRopes(moment.said);
  showFacts(moment.said, status?.fps);
  document.documentElement.dataset.frame = moment.said.number;
  update();
}

/** Shows a picture that was dropped on the page, until something else is to be shown. */
async function showDropped(moment) {
  if (!line.isPaused) await line.pause();
  await show(moment);
  showNotices(moment.said.notice ? [moment.said.notice] : []);
}

/** Updates the state and the time line. */
function update() {
  if (!isConnected) showState("lost", "the server is gone; trying again");
  else if (shown?.said.number === DROPPED) showState("paused", "a picture");
  else if (status?.film) showState("paused", line.isPaused ? "a recording" : "playing");
  else if (line.isPaused) showState("paused", "paused");
  else if (!status || status.obstacle) showState("waiting", "waiting");
  else if (status.age_s > 2) showState("lost", `silent for ${status.age_s.toFixed(0)} s`);
  else showState("live", "live");
  const last = Math.max(0, line.length - 1);
  by("scrubber").max = last;
  by("scrubber").value = line.place;
  by("scrubber").style.setProperty("--part", `${last ? (100 * line.place) / last : 100}%`);
  by("when").textContent = line.label;
  document.documentElement.classList.toggle("is-paused", line.isPaused);
  by("back").disabled = line.place <= 0;
  by("forth").disabled = !line.isPaused || line.place >= last;
}

/** Returns a handler that changes the time line and updates the page. */
const act = (does) => () => {
  does();
  update();
};
const step = (frames) => act(() => line.goTo(line.place + frames));
const pause = act(() => (line.isPaused ? line.goOn() : line.pause()));

/** Saves the frame with its overlay as PNG, and what was seen in it as JSON. */
async function save() {
  if (!shown) return;
  const name = `${status?.rig ?? status?.film?.name ?? "lariat"}-${shown.said.frame}`;
  const png = await stage.still().convertToBlob({ type: "image/png" });
  const json = new Blob([`${JSON.stringify(shown.said, null, 2)}\n`], { type: "application/json" });
  for (const [blob, ending] of [[png, "png"], [json, "json"]]) {
    const address = URL.createObjectURL(blob);
    element("a", { href: address, download: `${name}.${ending}` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  }
}

/* Layers over the picture. */
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

/* Light or dark: as the system has it, until the user chooses. */
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

/* A picture file may be dropped anywhere. */
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("drops");
});
addEventListener("dragleave", (event) => event.relatedTarget ?? document.body.classList.remove("drops"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("drops");
  const [file] = event.dataTransfer.files;
  if (file && file.size <= MOST_BYTES) link.drop(file);
  else if (file) showNotices(["The file is too large: a picture of at most 24 MB can be traced here."]);
});

/* The tabs: figures or settings. */
function turnTo(tab) {
  for (const name of ["figures", "tuning"]) {
    by(name).hidden = name !== tab;
    by(`to-${name}`).setAttribute("aria-selected", name === tab);
  }
  if (tab === "tuning") tuning.look();
  else if (status) showStatus(status);
}
by("to-figures").onclick = () => turnTo("figures");
by("to-tuning").onclick = () => turnTo("tuning");

by("theme").onclick = switchTheme;
by("help").onclick = () => by("keys").showModal();
by("pause").onclick = pause;
by("back").onclick = step(-1);
by("forth").onclick = step(1);
by("save").onclick = save;
by("scrubber").oninput = ({ target }) => act(() => line.goTo(target.valueAsNumber))();

const KEYS = {
  " ": pause,
  ArrowLeft: step(-1),
  ArrowRight: step(1),
  Home: act(() => line.goTo(0)),
  End: act(() => line.end()),
  "+": () => stage.zoomBy(1.25),
  "=": () => stage.zoomBy(1.25),
  "-": () => stage.zoomBy(0.8),
  0: () => stage.whole(),
  s: save,
  f: () => turnTo("figures"),
  e: () => turnTo("tuning"),
  p: () => {
    turnTo("tuning");
    tuning.pick();
  },
  c: () => {
    turnTo("tuning");
    tuning.calibrate();
  },
  t: switchTheme,
  "?": () => by("keys").showModal(),
};
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || by("keys").open) return;
  if (event.target.matches("input, textarea, select") && event.target !== by("scrubber")) return;
  const layer = toggles[Number(event.key) - 1];
  const does = layer ? () => layer.click() : KEYS[event.key];
  if (!does) return;
  event.preventDefault();
  does();
});
update();
