"use strict";
// Panes with bars between them, three presets of their sizes; both are kept in the browser.

/** Sizes: share of the viewport in the height above the time line, width of the settings and height of the time line [px], which is 0 where it is that of its rows. */
const PRESETS = {
  edit: { stage: 0.52, side: 370, time: 0, compare: false },
  look: { stage: 1, side: 0, time: 0, compare: false },
  compare: { stage: 1, side: 360, time: 0, compare: true },
};
/** Name by which the browser keeps the sizes; another one than before the time line had the height of its rows, which all had kept. */
const KEPT = "hairpipe sizes";

/** @typedef {{stage: number, side: number, time: number, compare: boolean, preset: string}} Panes */

/** @type {Panes} */
const panes = { ...PRESETS.edit, preset: "edit" };

/** Take the sizes of the last visit, and listen to the bars. */
function listenToPanes() {
  let kept = /** @type {any} */ ({});
  try {
    kept = JSON.parse(keptItem(KEPT) || "{}") ?? {};
  } catch { /* not written by this page */ }
  for (const [name, value] of Object.entries(PRESETS.edit)) if (typeof kept[name] === typeof value) Object.assign(panes, { [name]: kept[name] });
  if (kept.preset in PRESETS) panes.preset = kept.preset;
  dragBar("bar-side", (event, frame) => (panes.side = frame.right - event.clientX));
  dragBar("bar-time", (event, frame) => (panes.time = frame.bottom - event.clientY));
  dragBar("bar-stage", (event, frame) => (panes.stage = (event.clientY - frame.top) / (frame.height - timeHeight() - 12)));
  sizePanes();
}

/** @param {string} id @param {(event: PointerEvent, frame: DOMRect) => void} move */
function dragBar(id, move) {
  const bar = /** @type {HTMLElement} */ (document.getElementById(id)), main = /** @type {HTMLElement} */ (document.getElementById("panes"));
  bar.addEventListener("pointerdown", (event) => bar.setPointerCapture(event.pointerId));
  bar.addEventListener("pointermove", (event) => {
    if (!bar.hasPointerCapture(event.pointerId)) return;
    move(event, main.getBoundingClientRect());
    panes.preset = "";
    sizePanes();
  });
  bar.addEventListener("dblclick", () => choosePreset("edit"));
}

/** @param {string} name */
function choosePreset(name) {
  Object.assign(panes, /** @type {any} */ (PRESETS)[name], { preset: name });
  sizePanes();
  if (app.state) drawStrip();
  app.set({ compare: panes.compare });
}

/** Give the panes their sizes, within what the window has room for, and keep them. */
function sizePanes() {
  const main = /** @type {HTMLElement} */ (document.getElementById("panes"));
  panes.side = panes.side < 120 ? 0 : Math.min(panes.side, innerWidth - 240);
  panes.time = panes.time && Math.max(36, Math.min(panes.time, innerHeight - 260));
  panes.stage = panes.stage > 0.92 ? 1 : Math.max(0.12, panes.stage);
  main.style.setProperty("--stage", `${panes.stage}fr`);
  main.style.setProperty("--graph", `${1 - panes.stage}fr`);
  main.style.setProperty("--side", `${panes.side}px`);
  main.style.setProperty("--time", panes.time ? `${panes.time}px` : `fit-content(${app.wedge ? 45 : 35}vh)`);
  main.classList.toggle("no-graph", panes.stage === 1);
  main.classList.toggle("no-side", panes.side === 0);
  for (const button of document.querySelectorAll("#presets button")) button.classList.toggle("on", button.textContent === panes.preset);
  keepItem(KEPT, JSON.stringify(panes));
}

/** Keep a text in the browser. @param {string} name @param {string} text */
function keepItem(name, text) {
  try {
    localStorage.setItem(name, text);
  } catch { /* a page in a file has no storage in some browsers */ }
}

/** A text that the browser has kept, or an empty one. @param {string} name */
function keptItem(name) {
  try {
    return localStorage.getItem(name) ?? "";
  } catch {
    return "";
  }
}

/** Height of the time line [px]. */
const timeHeight = () => document.getElementById("time")?.offsetHeight ?? 0;

/** Buttons of the presets. @returns {HTMLElement} */
function presetButtons() {
  return element("span", { id: "presets" }, ...Object.keys(PRESETS).map((name) =>
    element("button", { class: name === panes.preset ? "on" : "", title: `panes to ${name}`, onclick: () => choosePreset(name) }, name)));
}
