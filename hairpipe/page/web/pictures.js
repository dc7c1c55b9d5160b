"use strict";
// Pictures as a flipbook, two of them side by side below a slider.

/** Address of the picture of an output at a frame, or null. @param {string} node @param {string} output @param {number} [frame] */
function pictureOf(node, output, frame = app.frame) {
  const cell = app.cell(node, frame), suffix = cell?.pictures?.[output], object = cell?.outputs?.[output];
  return suffix && object ? hairpipe.picture(object, suffix) : null;
}

/** @param {HTMLElement} stage */
function showPictures(stage) {
  const address = pictureOf(app.node, app.output);
  if (!address) return false;
  const [node, output, frame] = app.pinned.split("\n");
  const other = app.pinned ? pictureOf(node, output, node === app.node ? Number(frame) : app.frame) : null;
  const image = (/** @type {string} */ src, /** @type {string} */ kind) => element("img", { src, class: kind, draggable: "false" });
  const pin = element("button", {
    class: "pin", title: "keep this picture for comparison",
    onclick: () => app.set({ pinned: app.pinned ? "" : `${app.node}\n${app.output}\n${app.frame}` }),
  }, app.pinned ? "end comparison" : "compare with ...");
  const book = element("div", { class: "book" }, image(address, "now"), pin);
  if (other) {
    const knife = element("input", { type: "range", min: 0, max: 1000, value: 500, class: "knife", "aria-label": "comparison" });
    const left = image(other, "then");
    const cut = () => (left.style.clipPath = `inset(0 ${100 - Number(/** @type {HTMLInputElement} */ (knife).value) / 10}% 0 0)`);
    knife.addEventListener("input", cut);
    cut();
    book.append(left, knife, element("span", { class: "which" }, `${node}${node === app.node ? `@${frame}` : ""} | ${app.node}@${app.frame}`));
  }
  stage.append(book);
  return true;
}
