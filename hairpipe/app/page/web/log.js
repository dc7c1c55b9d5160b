"use strict";
// Warnings and failures with the frames at which they occurred: each frame is a link that goes there.

/** Frames of a message that are listed; the others are counted. */
const MOST_LINKS = 12;

/** @typedef {{node: string, text: string, frames: Array<number | null>}} Warning */

/** Warnings of all results, those of a node and of the same words together. @returns {Warning[]} */
function warningsOf() {
  /** @type {Map<string, Warning>} */
  const found = new Map();
  for (const [node, { cells }] of /** @type {Array<[string, {cells: Cell[]}]>} */ (Object.entries(app.state.nodes))) {
    for (const cell of cells) {
      for (const text of cell.warnings ?? []) {
        const known = found.get(`${node} ${text}`) ?? { node, text, frames: [] };
        known.frames.push(cell.frame);
        found.set(`${node} ${text}`, known);
      }
    }
  }
  return [...found.values()];
}

/** Warnings below a line that counts them. @returns {HTMLElement[]} */
function warningLog() {
  const warnings = warningsOf(), before = document.getElementById("log"), open = before instanceof HTMLDetailsElement && before.open;
  if (!warnings.length) return [];
  const lines = warnings.map(({ node, text, frames }) => element("p", {},
    ...frames.slice(0, MOST_LINKS).flatMap((frame) => [frameLink(node, frame), " "]), ...(frames.length > MOST_LINKS ? [`and ${frames.length - MOST_LINKS} more `] : []), text));
  return [element("details", { id: "log", ...(open && { open: "" }) }, element("summary", {}, `${warnings.length} warning${warnings.length > 1 ? "s" : ""}`), element("div", { class: "list" }, ...lines))];
}

/** A failure, its frame a link. @param {string} failure @returns {HTMLElement} */
function failureLine(failure) {
  const [, node, frame, text] = failure.match(/^([^@:\s]+)(?:@(-?\d+))?(:[^]*)$/) ?? [];
  const parts = app.nodeNamed(node ?? "") ? [frameLink(node, frame === undefined ? null : Number(frame)), text] : [failure];
  return element("p", { class: "failure" }, ...parts);
}

/** @param {string} node @param {number | null} frame @returns {HTMLElement} */
function frameLink(node, frame) {
  const go = (/** @type {Event} */ event) => {
    event.preventDefault();
    if (frame !== null) app.set({ frame: Math.max(app.graph.frames[0], Math.min(app.graph.frames[1], frame)) });
    selectNode(node);
  };
  return element("a", { href: "#", "data-frame": frame ?? "", onclick: go }, frame === null ? node : `${node}@${frame}`);
}
