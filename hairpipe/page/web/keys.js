"use strict";
// Keys of the live page, as in Blender. None is taken from a field in which one types.

/** Nodes that a key is for: those that are chosen; the selected one where nothing is chosen. @returns {string[]} */
function subjects() {
  const chosen = [...app.chosen].filter((name) => app.nodeNamed(name));
  return app.chosen.size ? chosen : app.node ? [app.node] : [];
}

/** The frame or note that is chosen. */
const chosenAnnotation = () => annotationNamed([...app.chosen][0]);

/** @param {KeyboardEvent} event */
async function keyOf(event) {
  const typing = event.target instanceof HTMLElement && event.target.matches("input:not([type=range]), select, textarea");
  const command = event.ctrlKey || event.metaKey, key = event.key.toLowerCase(), names = subjects();
  const [x, y] = [pointer.x, pointer.y];
  /** @type {Array<[boolean, () => unknown]>} */
  const keys = [
    [command && key === "s", () => saveGraph(event.shiftKey)],
    [!typing && command && key === "z", () => edit(event.shiftKey ? "redo" : "undo")],
    [!typing && command && key === "y", () => edit("redo")],
    [!typing && !command && event.shiftKey && key === "a", () => openAdd({ x, y })],
    [!typing && !command && event.shiftKey && key === "d" && names.length > 0, () => duplicateNodes(names)],
    [!typing && !command && (key === "x" || key === "delete") && Boolean(chosenAnnotation()), () => edit("annotate", { name: chosenAnnotation()?.name, value: null })],
    [!typing && !command && !event.shiftKey && key === "f" && names.length > 0, () => askFrame(names)],
    [!typing && !command && !event.shiftKey && key === "n", askNote],
    [!typing && !command && (key === "x" || key === "delete") && names.length > 0, () => edit("remove", { nodes: names })],
    [!typing && !command && key === "m" && names.length > 0, () => edit("mute", { nodes: names, on: !names.every((name) => app.nodeNamed(name).muted) })],
    [!typing && key === "f2" && Boolean(app.node), () => askName(app.node, x, y)],
    [!typing && !command && !event.shiftKey && key === "a", () => ((app.chosen = app.chosen.size ? new Set() : new Set(app.graph.nodes.map((/** @type {any} */ n) => n.name))), paintGraph())],
    [!typing && !command && key === "l", layOutAgain],
    [!typing && key === "home", () => (document.getElementById("stage")?.matches(":hover") ? viewer?.frameAll() : showAll())],
    [!typing && !command && key === "b", () => (boxNext = true, sayControls("drag a box around nodes"))],
    [!typing && event.key === "?", showKeys],
  ];
  const found = keys.find(([holds]) => holds);
  if (!found) return;
  event.preventDefault();
  await found[1]();
}

/** Keys and gestures of the page. */
const KEYS = [
  ["drag, middle drag", "turn the view"], ["Shift drag, right drag", "move the view"], ["wheel", "zoom"], ["Home, double click", "show all, in the view or the graph below the pointer"], ["Space, ← →", "play, step"],
  ["Shift-A", "add a node"], ["drag, B", "move nodes, choose nodes in a box"], ["A", "choose all or none"], ["X, M, Shift-D, F2", "delete, mute, duplicate, rename"], ["F, N, L", "frame, note, lay out again"],
  ["Ctrl-C, X, V", "copy, cut, paste"], ["Ctrl-Z, Ctrl-Shift-Z, Ctrl-S", "undo, redo, save"], ["[ ], Ctrl drag, Escape", "radius of the brush, the opposite value, end of painting"], ["?", "this list"],
];

/** Open or close the list of keys. */
function showKeys() {
  const open = document.getElementById("keys");
  if (open) return open.remove();
  document.body.append(element("div", { id: "keys", onclick: () => showKeys() }, element("dl", {}, ...KEYS.flatMap(([keys, what]) => [element("dt", {}, keys), element("dd", {}, what)]))));
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
