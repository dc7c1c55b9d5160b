"use strict";
// The page begins: documents first, then every view.

window.addEventListener("error", (event) => fault(event.message));
window.addEventListener("unhandledrejection", (event) => fault(String(event.reason)));

/** @param {string} message */
function fault(message) {
  document.body.dataset.errors = String(Number(document.body.dataset.errors) + 1);
  document.getElementById("verdict")?.append(element("p", { class: "failure" }, message));
}

/** Take new documents of the graph and its state in. */
async function refresh() {
  const [graph, base] = await Promise.all([hairpipe.plain("graph"), hairpipe.plain("state")]);
  const wedge = base.wedge ? await hairpipe.plain("wedge") : null, chosen = app.graph ? app.variant : 0; // a wedge begins with its first variant
  const variant = wedge?.variants[chosen] ? chosen : -1, before = app.trial ? app.base : app.state;
  Object.assign(app, { base, wedge });
  if (!trying.wanted && graph.revision >= app.answered) app.trial = null;
  const state = stateOf(variant);
  if (before) keepPast(before.nodes, state.nodes);
  const frame = app.frame >= graph.frames[0] && app.frame <= graph.frames[1] ? app.frame : frameToShow(graph, state);
  resolveTypes(graph);
  const node = graph.nodes.some((/** @type {any} */ one) => one.name === app.node) ? app.node : "";
  app.set({ state, graph, frame, node, variant });
  const awaited = app.awaited?.();
  if (awaited) {
    app.chosen = new Set([awaited]);
    app.awaited = null;
    selectNode(awaited);
    paintGraph();
  }
  drawWedge();
  if (!app.node) selectNode(nodeToShow());
}

/** Keep results that an edit has changed, to show them until there are new ones, and to compare. @param {any} before @param {any} after */
function keepPast(before, after) {
  for (const [name, { cells }] of Object.entries(before)) {
    const now = new Map((after[name]?.cells ?? []).map((/** @type {Cell} */ cell) => [cell.frame, cell]));
    for (const cell of cells) {
      const other = now.get(cell.frame);
      if (cell.outputs && JSON.stringify(cell.outputs) !== JSON.stringify(other?.outputs)) app.past.set(`${name}@${cell.frame ?? ""}`, cell);
    }
  }
}

/** Give each node its type in place of the name of it. @param {any} graph */
function resolveTypes(graph) {
  for (const node of graph.nodes) node.type = graph.types[node.type] ?? node.type;
}

/** The first frame that has been simulated, or the first. @param {any} graph @param {any} state @returns {number} */
function frameToShow(graph, state) {
  const done = graph.nodes.filter((/** @type {any} */ node) => node.per_frame).flatMap((/** @type {any} */ node) => (state.nodes[node.name]?.cells ?? []).filter((/** @type {Cell} */ cell) => cell.outputs));
  return done.length ? Math.max(graph.frames[0], Math.min(...done.map((/** @type {Cell} */ cell) => cell.frame ?? Infinity))) : graph.frames[0];
}

/** The node to begin with: the last that gives strands, else the last that gives pictures, else the last; empty without nodes. */
function nodeToShow() {
  const { nodes } = app.graph;
  const strands = nodes.filter((/** @type {any} */ node) => Object.keys(node.kinds).some((output) => app.document(node.name, output, "strands")));
  const pictures = nodes.filter((/** @type {any} */ node) => Object.keys(app.cell(node.name)?.pictures ?? {}).length);
  return [...strands.slice(-1), ...pictures.slice(-1), ...nodes.slice(-1)][0]?.name ?? "";
}

async function begin() {
  app.live = document.body.dataset.live === "true";
  listenToPanes();
  app.compare = panes.compare;
  app.strands = STRANDS_SHOWN.find((count) => String(count) === keptItem(STRANDS_KEPT)) ?? STRANDS_SHOWN[0];
  takeBackdrop(keptItem(BACKDROP_KEPT));
  await refresh();
  sizePanes(); // of a wedge with room for its pictures
  app.fresh = true;
  drawGraph();
  document.title = `${app.graph.name} - hairpipe`;
  listenToGraph();
  listenToStrip();
  listenToTimeline();
  if (app.live) listenToEdits();
  if (app.live) listenToClipboard();
  if (app.live) listenToBrush();
  if (app.live) follow();
  await showStage();
  document.body.dataset.state = "ready";
}

begin().catch((reason) => fault(String(reason)));
