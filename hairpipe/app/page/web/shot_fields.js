"use strict";
// Frames and frame rate of the shot, above all nodes.

const SHOT_OPEN = "shot";

/** @returns {HTMLElement} */
function shotFields() {
  const { frames, fps, preroll } = app.graph;
  const set = async (/** @type {string} */ name, /** @type {string} */ text) => {
    if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
    await edit("shot", { name, text });
  };
  /** @type {HTMLInputElement[]} */
  const lines = [0, 1].map((i) => lineOf(String(frames[i]), i ? "last" : "first", () => set("frames", `[${lines[0].value}, ${lines[1].value}]`)));
  const row = (/** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ unit, /** @type {HTMLElement[]} */ ...inner) =>
    element("div", { class: "row", title, "data-shot": name }, element("b", {}, name), element("span", { class: "vector" }, ...inner), element("small", {}, unit));
  const box = element("details", { class: "shot", ...(openTables.has(SHOT_OPEN) && { open: "" }), ontoggle: () => (/** @type {HTMLDetailsElement} */ (box).open ? openTables.add(SHOT_OPEN) : openTables.delete(SHOT_OPEN)) },
    element("summary", {}, "shot"),
    row("frames", "first and last frame", "", ...lines),
    row("fps", "frame rate", "1/s", lineOf(String(fps), "24", (text) => set("fps", text))),
    row("preroll", "frames before the first, which simulations compute alone", "", lineOf(String(preroll), "0", (text) => set("preroll", text))));
  return box;
}
