"use strict";
// Pictures as a flipbook, two of them side by side below a slider.

/** Address of the picture of an output at a frame, or null. @param {string} node @param {string} output @param {number} [frame] @param {any} [nodes] */
function pictureOf(node, output, frame = app.frame, nodes = app.state.nodes) {
  const cell = cellOf(nodes, node, frame), suffix = cell?.pictures?.[output], object = cell?.outputs?.[output];
  return suffix && object ? hairpipe.picture(object, suffix) : null;
}

/** An output that is kept, with the graph and the results of that moment: results are named by their content, so edits and runs leave it as it was.
 * @typedef {{node: string, output: string, frame: number, variant: number, name: string, graph: any, state: any}} Pinned */

/** What is kept for comparison: at its own frame if node and variant are the selected ones, else at the selected frame; null for nothing. @returns {Pinned | null} */
function pinnedResult() {
  const kept = app.pinned, same = kept?.node === app.node && kept.variant === app.variant;
  return kept && { ...kept, frame: same ? kept.frame : app.frame };
}

/** Keep what is selected. @returns {Pinned} */
function pinSelected() {
  const { node, output, frame, variant, graph, state } = app;
  return { node, output, frame, variant, name: variantName(), graph, state };
}

/** Button that keeps what is shown, to compare other frames, variants and nodes with it. @returns {HTMLElement} */
const pinButton = () => element("button", {
  class: "pin", title: "keep this frame of this variant for comparison",
  onclick: () => app.set({ pinned: app.pinned ? null : pinSelected() }),
}, app.pinned ? "end comparison" : "keep for comparison");

/** Name of the selected variant; empty for the graph file. @returns {string} */
const variantName = () => app.wedge?.variants[app.variant]?.name ?? "";

/** What is left and right of the slider. @param {Pinned | null} pinned null for what was before an edit */
function comparisonLabel(pinned) {
  const label = (/** @type {string} */ node, /** @type {number} */ frame, /** @type {string} */ name) => `${node}@${frame}${name && ` ${name}`}`;
  return `${pinned ? `kept ${label(pinned.node, pinned.frame, pinned.name)}` : "before the edit"} | ${label(app.node, app.frame, variantName())}`;
}

/** @param {HTMLElement} stage */
function showPictures(stage) {
  const address = pictureOf(app.node, app.output);
  if (!address) return false;
  const pinned = pinnedResult(), other = pinned && pictureOf(pinned.node, pinned.output, pinned.frame, pinned.state.nodes);
  const image = (/** @type {string} */ src, /** @type {string} */ kind) => element("img", { src, class: kind, draggable: "false" });
  const book = element("div", { class: "book" }, image(address, "now"), pinButton());
  if (other) {
    const knife = element("input", { type: "range", min: 0, max: 1000, value: 500, class: "knife", "aria-label": "comparison" });
    const left = image(other, "then");
    const cut = () => (left.style.clipPath = `inset(0 ${100 - Number(/** @type {HTMLInputElement} */ (knife).value) / 10}% 0 0)`);
    knife.addEventListener("input", cut);
    cut();
    book.append(left, knife, element("span", { class: "which" }, comparisonLabel(pinned)));
  }
  stage.append(book);
  return true;
}
