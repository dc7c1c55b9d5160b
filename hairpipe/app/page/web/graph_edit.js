"use strict";
// Gestures on the graph: select, move, wire, cut, and keys for all else. Each is an edit of the graph file.

/** @type {{kind: string, x: number, y: number, moved: boolean, names: string[], wire: any} | null} */
let held = null;

/** Ask for an edit; why it is refused is shown and returned. @param {string} verb @param {any} given @returns {Promise<string>} */
async function edit(verb, given = {}) {
  const fault = await act(verb, given);
  sayControls(fault);
  document.body.dataset.refused = fault;
  return fault;
}

/** Place of the page in the drawing. @param {number} x @param {number} y @returns {number[]} */
function graphPlace(x, y) {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.getElementById("graph")));
  const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM()?.inverse());
  return [Math.round(at.x), Math.round(at.y)];
}

/** What is below the pointer. @param {PointerEvent | MouseEvent} event */
function graphTarget(event) {
  const found = /** @type {Element | null} */ (document.elementFromPoint(event.clientX, event.clientY));
  const socket = /** @type {SVGElement | null} */ (found?.closest(".socket") ?? null), node = /** @type {SVGElement | null} */ (found?.closest(".node") ?? null);
  return { socket: socket?.dataset, node: node?.dataset.node ?? null, annotation: annotationNamed(found?.closest(".annotation")?.getAttribute("data-annotation")), wire: /** @type {SVGElement | null} */ (found?.closest(".wire") ?? null) };
}

function listenToEdits() {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.getElementById("graph")));
  svg.addEventListener("pointerdown", (event) => beginGesture(svg, event));
  svg.addEventListener("pointermove", (event) => held && moveGesture(event));
  svg.addEventListener("pointerup", (event) => held && void endGesture(event));
  svg.addEventListener("dblclick", (event) => {
    const { node, annotation } = graphTarget(event);
    if (node) askName(node, event.clientX, event.clientY);
    else if (annotation) askAnnotation(annotation, event.clientX, event.clientY);
  });
  svg.addEventListener("pointermove", (event) => (pointer = { x: event.clientX, y: event.clientY }));
  svg.addEventListener("contextmenu", openActions);
  document.addEventListener("keydown", (event) => void keyOf(event));
}

/** Whether nodes follow the pointer without a button, until a click. */
let grabbed = false;

/** Let nodes follow the pointer. @param {string[]} names @param {{x: number, y: number}} at */
function grabNodes(names, { x, y }) {
  held = { kind: "move", x, y, moved: false, names, wire: null };
  grabbed = true;
}

/** Put nodes that follow the pointer back. */
function dropNodes() {
  held = null;
  grabbed = false;
  drawGraph();
}

/** Whether the next drag chooses nodes in a box. */
let boxNext = false;

/** Last place of the pointer on the graph. */
let pointer = { x: 300, y: 300 };

/** @param {SVGSVGElement} svg @param {PointerEvent} event */
function beginGesture(svg, event) {
  if (grabbed && event.button !== 0) return dropNodes();
  if (event.button !== 0) return;
  if (grabbed) return; // its release ends the move
  svg.focus({ preventScroll: true });
  const { socket, node, wire, annotation } = graphTarget(event);
  const start = { x: event.clientX, y: event.clientY, moved: false, names: /** @type {string[]} */ ([]), wire: /** @type {any} */ (null) };
  if (boxNext) [boxNext, held] = [false, { ...start, kind: "box" }];
  else if (socket) held = { ...start, kind: "wire", wire: wireAt(socket) };
  else if (node) {
    if (event.shiftKey) app.chosen.has(node) ? app.chosen.delete(node) : app.chosen.add(node);
    else if (!app.chosen.has(node)) app.chosen = new Set([node]);
    held = { ...start, kind: "move", names: [...app.chosen].filter((name) => app.nodeNamed(name)) };
  } else if (annotation && !wire && !event.shiftKey) {
    app.chosen = new Set([annotation.name]);
    held = { ...start, kind: "move", names: draggedWith(annotation) };
  } else if (event.shiftKey) held = { ...start, kind: "box" };
  else {
    if (!wire) app.chosen = new Set();
    return paintGraph();
  }
  svg.setPointerCapture(event.pointerId);
  paintGraph();
}

/** The loose end of a wire: from an output, or of the edge at an input, which is cut. @param {DOMStringMap} socket */
function wireAt(socket) {
  const node = app.nodeNamed(socket.owner ?? ""), name = socket.name ?? "", type = socket.type ?? "";
  if (socket.side === "out") return { source: { text: sourceText(node, type, name), node: node.name, type } };
  const edge = node.edges.find((/** @type {any} */ one) => one.plug === name);
  if (!edge) return { feeds: { node: node.name, socket: name.split(".")[0], type } };
  return { source: { text: sourceText(app.nodeNamed(edge.node), type, edge.output), node: edge.node, type }, cut: { node: node.name, plug: name } };
}

/** @param {PointerEvent} event */
function moveGesture(event) {
  const gesture = /** @type {NonNullable<typeof held>} */ (held);
  if (!gesture.moved && Math.hypot(event.clientX - gesture.x, event.clientY - gesture.y) < 4) return;
  gesture.moved = true;
  const [fx, fy] = graphPlace(gesture.x, gesture.y), [tx, ty] = graphPlace(event.clientX, event.clientY);
  if (gesture.kind === "move") drawGraph(new Map(gesture.names.map((name) => [name, [tx - fx, ty - fy]])));
  const draft = gesture.kind === "wire"
    ? drawn("path", { class: "wire draft", d: `M${fx} ${fy}C${(fx + tx) / 2} ${fy} ${(fx + tx) / 2} ${ty} ${tx} ${ty}`, stroke: typeColour((gesture.wire.source ?? gesture.wire.feeds).type) })
    : gesture.kind === "box" ? drawn("rect", { class: "lasso", x: Math.min(fx, tx), y: Math.min(fy, ty), width: Math.abs(tx - fx), height: Math.abs(ty - fy) }) : null;
  document.querySelector("#graph .draft, #graph .lasso")?.remove();
  if (draft) document.getElementById("graph")?.append(draft);
  if (gesture.kind === "wire") for (const socket of document.querySelectorAll("#graph .socket")) socket.classList.toggle("fits", refusal(gesture.wire, /** @type {SVGElement} */ (socket).dataset) === "");
}

/** Why a wire does not fit a socket; empty where it does. @param {any} wire @param {DOMStringMap} socket */
function refusal(wire, socket) {
  const mine = wire.source ?? wire.feeds, wants = wire.source ? "in" : "out";
  if (socket.side !== wants) return `connect an output to an input`;
  if (socket.owner === mine.node) return "a node does not feed itself";
  return socket.type === mine.type ? "" : `${socket.owner}.${socket.name || "output"} ${wants === "in" ? "takes" : "gives"} ${socket.type}, not ${mine.type}`;
}

/** @param {PointerEvent} event */
async function endGesture(event) {
  const gesture = /** @type {NonNullable<typeof held>} */ (held), [x, y] = graphPlace(event.clientX, event.clientY);
  held = null;
  grabbed = false;
  document.querySelector("#graph .draft, #graph .lasso")?.remove();
  document.querySelectorAll("#graph .fits").forEach((socket) => socket.classList.remove("fits"));
  const [fx, fy] = graphPlace(gesture.x, gesture.y);
  const note = annotationNamed(gesture.names[0]);
  if (gesture.kind === "move" && gesture.moved && note?.at) {
    const { name, ...value } = note;
    if (await edit("annotate", { name, value: { ...value, at: [note.at[0] + x - fx, note.at[1] + y - fy] } })) drawGraph();
  } else if (gesture.kind === "move" && gesture.moved) {
    const moved = Object.fromEntries(gesture.names.map((name) => [name, [boxOfNode(name).x + x - fx, boxOfNode(name).y + y - fy]]));
    Object.assign(app.places, moved);
    if (await edit("move", { positions: moved })) drawGraph();
  } else if (gesture.kind === "move" && graphTarget(event).node) selectNode(graphTarget(event).node ?? "");
  else if (gesture.kind === "box") {
    const inside = (/** @type {any} */ node) => { const box = boxOfNode(node.name); return box.x > Math.min(x, fx) && box.x < Math.max(x, fx) && box.y > Math.min(y, fy) && box.y < Math.max(y, fy); };
    app.chosen = new Set(app.graph.nodes.filter(inside).map((/** @type {any} */ node) => node.name));
    paintGraph();
  } else if (gesture.kind === "wire" && gesture.moved) await endWire(gesture.wire, event);
}

/** @param {any} wire @param {PointerEvent} event */
async function endWire(wire, event) {
  const target = graphTarget(event), node = target.node && app.nodeNamed(target.node);
  const fitting = node && wire.source && node.type.sockets.find((/** @type {any} */ s) => s.type === wire.source.type);
  const socket = target.socket ?? (fitting && { side: "in", owner: node.name, name: fitting.name, type: fitting.type });
  if (!socket && !node && !wire.cut) return void openAdd({ x: event.clientX, y: event.clientY }, wire);
  if (!socket && !node) return void edit("disconnect", wire.cut);
  const reason = socket ? refusal(wire, socket) : `${node.name} takes no ${(wire.source ?? wire.feeds).type}`;
  if (reason) return void sayControls(document.body.dataset.refused = reason);
  const [source, to] = wire.source ? [wire.source.text, { node: socket.owner, socket: socket.name.split(".")[0] }]
    : [sourceText(app.nodeNamed(socket.owner), socket.type, socket.name), wire.feeds];
  if (wire.cut && wire.cut.node === to.node && wire.cut.plug.split(".")[0] === to.socket) return;
  if (wire.cut) await edit("disconnect", wire.cut);
  await edit("connect", { node: to.node, socket: to.socket, source });
}

/** @param {string} node @param {number} x @param {number} y */
function askName(node, x, y) {
  openPopup({ x, y, text: node, hint: "name of the node", done: async (name) => {
    if (name === node) return;
    app.places[name] = app.places[node] ?? [boxOfNode(node).x, boxOfNode(node).y];
    app.awaited = () => app.nodeNamed(name)?.name;
    await edit("rename", { node, name });
  } });
}
