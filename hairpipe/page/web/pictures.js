"use strict";
// Pictures as a flipbook, two of them side by side below a slider.

/** Address of the picture of an output at a frame, or null. @param {string} node @param {string} output @param {number} [frame] @param {any} [nodes] */
function pictureOf(node, output, frame = app.frame, nodes = app.state.nodes) {
  const cell = cellOf(nodes, node, frame), suffix = cell?.pictures?.[output], object = cell?.outputs?.[output];
  return suffix && object ? hairpipe.picture(object, suffix) : null;
}

/** What is kept for comparison: at its own frame if node and variant are the selected ones, else at the selected frame; null for nothing.
 * @returns {{node: string, output: string, frame: number, variant: number} | null} */
function pinnedResult() {
  const [node, output, frame, variant] = app.pinned.split("\n"), same = node === app.node && Number(variant) === app.variant;
  return app.nodeNamed(node) ? { node, output, frame: same ? Number(frame) : app.frame, variant: Number(variant) } : null;
}

/** Button that keeps what is shown, to compare other frames, variants and nodes with it. @returns {HTMLElement} */
const pinButton = () => element("button", {
  class: "pin", title: "keep this frame of this variant for comparison",
  onclick: () => app.set({ pinned: app.pinned ? "" : [app.node, app.output, app.frame, app.variant].join("\n") }),
}, app.pinned ? "end comparison" : "compare with ...");

/** What a picture is of. @param {string} node @param {string | number} frame @param {number} variant */
function labelOf(node, frame, variant) {
  return `${node}@${frame}${app.wedge && variant >= 0 ? ` ${app.wedge.variants[variant].name}` : ""}`;
}

/** What is left and right of the slider. */
function comparisonLabel() {
  const pinned = pinnedResult();
  return `${pinned ? labelOf(pinned.node, pinned.frame, pinned.variant) : "before the edit"} | ${labelOf(app.node, app.frame, app.variant)}`;
}

/** @param {HTMLElement} stage */
function showPictures(stage) {
  const address = pictureOf(app.node, app.output);
  if (!address) return false;
  const pinned = pinnedResult(), other = pinned && pictureOf(pinned.node, pinned.output, pinned.frame, stateOf(pinned.variant).nodes);
  const image = (/** @type {string} */ src, /** @type {string} */ kind) => element("img", { src, class: kind, draggable: "false" });
  const book = element("div", { class: "book" }, image(address, "now"), pinButton());
  if (other) {
    const knife = element("input", { type: "range", min: 0, max: 1000, value: 500, class: "knife", "aria-label": "comparison" });
    const left = image(other, "then");
    const cut = () => (left.style.clipPath = `inset(0 ${100 - Number(/** @type {HTMLInputElement} */ (knife).value) / 10}% 0 0)`);
    knife.addEventListener("input", cut);
    cut();
    book.append(left, knife, element("span", { class: "which" }, comparisonLabel()));
  }
  stage.append(book);
  return true;
}
