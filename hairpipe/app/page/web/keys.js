"use strict";
// Keys of the live page, as in Blender. None is taken from a field in which one types.

/** Nodes that a key is for: those that are chosen; the selected one where nothing is chosen. @returns {string[]} */
function subjects() {
  const chosen = [...app.chosen].filter((name) => app.nodeNamed(name));
  return app.chosen.size ? chosen : app.node ? [app.node] : [];
}

/** The frame or note that is chosen. */
const chosenAnnotation = () => annotationNamed([...app.chosen][0]);

/** What is done by a key, or by the menu of a node or of the graph. In a field in which one types only some keys are taken.
 * @typedef {{press: string[], name: string, menu?: "node" | "graph", typing?: boolean, can?: (names: string[]) => boolean, does: (names: string[], at: {x: number, y: number}) => unknown}} Action */

const isSome = (/** @type {string[]} */ names) => names.length > 0;
const isBelow = (/** @type {string} */ id) => Boolean(document.getElementById(id)?.matches(":hover"));

/** The first of those with a key that can be done is done. @type {Action[]} */
const ACTIONS = [
  { press: ["ctrl+enter"], name: "run to this node", menu: "node", can: isSome, does: (names) => edit("run", { to: names }) },
  { press: ["g"], name: "move", menu: "node", can: isSome, does: grabNodes },
  { press: ["f2"], name: "rename", menu: "node", can: isSome, does: ([name], { x, y }) => askName(name, x, y) },
  { press: ["shift+d"], name: "duplicate", menu: "node", can: isSome, does: duplicateNodes },
  { press: ["m"], name: "mute or unmute", menu: "node", can: isSome, does: (names) => edit("mute", { nodes: names, on: !names.every((name) => app.nodeNamed(name).muted) }) },
  { press: ["h"], name: "fold or unfold", menu: "node", can: isSome, does: foldNodes },
  { press: ["f"], name: "frame around", menu: "node", can: isSome, does: askFrame },
  { press: ["x", "delete"], name: "remove note or frame", can: () => Boolean(chosenAnnotation()), does: () => edit("annotate", { name: chosenAnnotation()?.name, value: null }) },
  { press: ["x", "delete"], name: "delete", menu: "node", can: isSome, does: (names) => edit("remove", { nodes: names }) },
  { press: ["shift+a"], name: "add node", menu: "graph", does: (_, at) => openAdd(at) },
  { press: ["n"], name: "note", menu: "graph", does: askNote },
  { press: ["a"], name: "choose all or none", menu: "graph", does: () => ((app.chosen = app.chosen.size ? new Set() : new Set(app.graph.nodes.map((/** @type {any} */ node) => node.name))), paintGraph()) },
  { press: ["b"], name: "choose in a box", menu: "graph", does: () => ((boxNext = true), sayControls("drag a box around nodes")) },
  { press: ["l"], name: "lay out again", menu: "graph", does: layOutAgain },
  { press: ["home"], name: "show all, below the pointer", can: () => isBelow("stage"), does: () => viewer?.frameAll() },
  { press: ["home"], name: "show all", menu: "graph", does: () => showAll() },
  { press: ["tab"], name: "paint, over the viewport", can: () => isBelow("stage") && (Boolean(brush.texels) || canPaint()), does: () => togglePainting() },
  { press: ["tab"], name: "settings, over the graph", can: () => isBelow("graph"), does: () => (Object.assign(panes, { side: panes.side ? 0 : PRESETS.edit.side, preset: "" }), sizePanes()) },
  { press: ["ctrl+z"], name: "undo", menu: "graph", does: () => edit("undo") },
  { press: ["ctrl+shift+z", "ctrl+y"], name: "redo", does: () => edit("redo") },
  { press: ["ctrl+s"], name: "save", typing: true, does: () => saveGraph(false) },
  { press: ["ctrl+shift+s"], name: "save as", typing: true, does: () => saveGraph(true) },
  { press: ["?"], name: "this list", does: () => showKeys() },
];

/** Gestures, and keys of other files, for the list. @type {[string, string][]} */
const GESTURES = [
  ["drag, middle drag", "turn the view"], ["Shift drag, right drag", "move the view"], ["wheel", "zoom"], ["double click", "show all"], ["right click", "menu of a node, or of the graph"], ["Space, ← →", "play, step"],
  ["drag, Shift drag", "move nodes, choose in a box"], ["Ctrl-C, X, V", "copy, cut, paste"], ["[ ], Ctrl drag, Escape", "radius of the brush, the opposite value, end of painting"],
];

/** Key as it is printed. @param {string} press such as ctrl+shift+z */
const keyText = (press) => press.split("+").map((part) => part[0].toUpperCase() + part.slice(1)).join("-");

/** @param {KeyboardEvent} event */
async function keyOf(event) {
  const typing = event.target instanceof HTMLElement && event.target.matches("input:not([type=range]), select, textarea"), key = event.key.toLowerCase();
  const press = [event.ctrlKey || event.metaKey ? "ctrl" : "", event.shiftKey && key !== "?" ? "shift" : "", key].filter(Boolean).join("+"), names = subjects();
  if (grabbed && key === "escape") return dropNodes();
  const found = ACTIONS.find((action) => action.press.includes(press) && (!typing || action.typing) && (action.can?.(names) ?? true));
  if (!found) return;
  event.preventDefault();
  await found.does(names, pointer);
}

/** Open the menu of the node below the pointer, or of the graph. @param {MouseEvent} event */
function openActions(event) {
  const { node } = graphTarget(event), at = { x: event.clientX, y: event.clientY };
  event.preventDefault();
  pointer = at;
  if (node && !app.chosen.has(node)) app.chosen = new Set([node]);
  if (node) selectNode(node), paintGraph();
  const names = subjects(), shown = ACTIONS.filter((action) => action.menu === (node ? "node" : "graph"));
  openMenu({ ...at, items: shown.map(({ name, press, does }) => ({ name, key: keyText(press[0]), does: () => does(names, at) })) });
}

/** Open or close the list of keys. */
function showKeys() {
  const open = document.getElementById("keys"), keys = ACTIONS.map(({ press, name }) => [press.map(keyText).join(", "), name]);
  if (open) return open.remove();
  document.body.append(element("div", { id: "keys", onclick: () => showKeys() }, element("dl", {}, ...[...keys, ...GESTURES].flatMap(([key, what]) => [element("dt", {}, key), element("dd", {}, what)]))));
}

/** Draw the heads of nodes alone, or all of them. @param {string[]} names */
function foldNodes(names) {
  const unfold = names.every((name) => app.folded.has(name));
  for (const name of names) unfold ? app.folded.delete(name) : app.folded.add(name);
  drawGraph();
}

/** Copy nodes to the lower right. @param {string[]} names */
async function duplicateNodes(names) {
  const at = Object.fromEntries(names.map((name) => [name, [boxOfNode(name).x + 40, boxOfNode(name).y + boxOfNode(name).height + 20]]));
  const before = new Set(app.graph.nodes.map((/** @type {any} */ node) => node.name));
  app.awaited = () => app.graph.nodes.find((/** @type {any} */ node) => !before.has(node.name))?.name;
  await edit("duplicate", { nodes: names, at });
}

/** Forget all positions, also those in the file, and lay the graph out. */
async function layOutAgain() {
  const placed = Object.keys(app.graph.layout ?? {}).filter((name) => app.nodeNamed(name));
  app.places = {};
  if (placed.length) await edit("move", { positions: Object.fromEntries(placed.map((name) => [name, null])) });
  app.fresh = true;
  drawGraph();
}

/** Save, or ask for a name within the project. @param {boolean} as */
async function saveGraph(as = false) {
  if (app.graph.saved && !as) return edit("save");
  openPopup({ x: innerWidth / 2 - 160, y: 80, text: "", hint: "name of a new file, such as fringe.toml", done: (name) => edit("save_as", { name }) });
}
