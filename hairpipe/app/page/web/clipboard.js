"use strict";
// Nodes on the clipboard: their TOML, as text for any other program, and their places for another page.

const PLACES = "application/x-hairpipe-places";

function listenToClipboard() {
  const idle = () => !(document.activeElement instanceof HTMLElement && document.activeElement.matches("input, select, textarea")) && getSelection()?.isCollapsed !== false;
  document.addEventListener("copy", (event) => idle() && copyNodes(event));
  document.addEventListener("cut", (event) => idle() && copyNodes(event) && void edit("remove", { nodes: subjects() }));
  document.addEventListener("paste", (event) => idle() && void pasteNodes(event));
}

/** Put the chosen nodes on the clipboard, in the order of the file; whether there are any. @param {ClipboardEvent} event */
function copyNodes(event) {
  const names = subjects(), nodes = app.graph.nodes.filter((/** @type {any} */ node) => names.includes(node.name));
  if (!nodes.length) return false;
  event.preventDefault();
  event.clipboardData?.setData("text/plain", nodes.map((/** @type {any} */ node) => node.text).join("\n"));
  event.clipboardData?.setData(PLACES, JSON.stringify(Object.fromEntries(names.map((name) => [name, [boxOfNode(name).x, boxOfNode(name).y]]))));
  return true;
}

/** Add the nodes of the clipboard, the first at the pointer. @param {ClipboardEvent} event */
async function pasteNodes(event) {
  const text = event.clipboardData?.getData("text/plain") ?? "", kept = JSON.parse(event.clipboardData?.getData(PLACES) || "{}");
  event.preventDefault();
  const places = Object.values(kept), [x, y] = graphPlace(pointer.x, pointer.y);
  const [left, top] = [0, 1].map((axis) => Math.min(...places.map((/** @type {any} */ place) => place[axis])));
  const at = Object.fromEntries(Object.entries(kept).map(([name, place]) => [name, [place[0] - left + x, place[1] - top + y]]));
  const before = new Set(app.graph.nodes.map((/** @type {any} */ node) => node.name));
  const added = () => app.graph.nodes.map((/** @type {any} */ node) => node.name).filter((/** @type {string} */ name) => !before.has(name));
  app.awaited = () => added()[0];
  if (await edit("paste", { text, at })) app.awaited = null;
}
