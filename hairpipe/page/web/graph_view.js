"use strict";
// The graph as in Blender: nodes with coloured sockets, wires that pass no node.

const BOX = { width: 158, head: 24, line: 15, gap: 26, column: 64 };
const SVG = "http://www.w3.org/2000/svg";

/** @typedef {{x: number, y: number, height: number, inputs: string[], outputs: string[]}} Box */

/** Make an element of a drawing. @param {string} tag @param {Record<string, any>} given @param {Array<Node | string>} inner @returns {SVGElement} */
function drawn(tag, given, inner = []) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(given)) made.setAttribute(name, String(value));
  made.append(...inner);
  return made;
}

/** Lay the nodes out in columns, and lead each wire through the columns between; y of the wire in each.
 * @param {any} graph @returns {{boxes: Map<string, Box>, wires: Array<{edge: any, node: string, through: Array<{x: number, y: number}>}>, width: number, height: number}} */
function layOut(graph) {
  const layout = new dagre.graphlib.Graph({ multigraph: true });
  layout.setGraph({ rankdir: "LR", nodesep: BOX.gap, edgesep: 14, ranksep: BOX.column, marginx: 16, marginy: 16 });
  layout.setDefaultEdgeLabel(() => ({}));
  /** @type {Map<string, Box>} */
  const boxes = new Map();
  for (const node of graph.nodes) {
    const inputs = node.edges.map((/** @type {any} */ edge) => edge.plug), outputs = Object.keys(node.type.outputs);
    const height = BOX.head + BOX.line * Math.max(inputs.length + outputs.length, 1) + 8;
    boxes.set(node.name, { x: 0, y: 0, height, inputs, outputs });
    layout.setNode(node.name, { width: BOX.width, height });
  }
  for (const node of graph.nodes) for (const edge of node.edges) layout.setEdge(edge.node, node.name, {}, `${edge.output} ${edge.plug}`);
  dagre.layout(layout);
  for (const [name, box] of boxes) Object.assign(box, { x: layout.node(name).x, y: layout.node(name).y });
  const columns = new Set([...boxes.values()].map((box) => Math.round(box.x)));
  const wires = graph.nodes.flatMap((/** @type {any} */ node) => node.edges.map((/** @type {any} */ edge) => {
    const { points } = layout.edge(edge.node, node.name, `${edge.output} ${edge.plug}`);
    const between = points.slice(1, -1).filter((/** @type {any} */ p) => columns.has(Math.round(p.x)));
    return { edge, node: node.name, through: between };
  }));
  const { width, height } = layout.graph();
  return { boxes, wires, width, height };
}

/** Height of a socket in its box. @param {Box} box @param {string} name @param {boolean} isOutput */
function socketHeight(box, name, isOutput) {
  const place = isOutput ? box.outputs.indexOf(name) : box.outputs.length + box.inputs.indexOf(name);
  return box.y - box.height / 2 + BOX.head + BOX.line * (place + 0.5) + 2;
}

/** Path of a wire: straight through the columns, where dagre keeps room for it, and curved between them alone.
 * @param {Array<{x: number, y: number}>} through @param {[number, number]} from @param {[number, number]} to */
function wirePath(through, from, to) {
  const half = BOX.width / 2;
  let [x, y] = from, path = `M${x} ${y}`;
  for (const end of [...through.map((p) => ({ x: p.x - half, y: p.y, over: BOX.width })), { x: to[0], y: to[1], over: 0 }]) {
    const middle = (x + end.x) / 2;
    path += `C${middle} ${y} ${middle} ${end.y} ${end.x} ${end.y}H${end.x + end.over}`;
    [x, y] = [end.x + end.over, end.y];
  }
  return path;
}

function drawGraph() {
  const svg = /** @type {any} */ (document.getElementById("graph"));
  const { boxes, wires, width, height } = layOut(app.graph);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const half = BOX.width / 2;
  svg.replaceChildren(...wires.map(({ edge, node, through }) => {
    const source = /** @type {Box} */ (boxes.get(edge.node)), target = /** @type {Box} */ (boxes.get(node));
    const type = app.nodeNamed(edge.node).type.outputs[edge.output];
    const path = wirePath(through, [source.x + half, socketHeight(source, edge.output, true)],
      [target.x - half, socketHeight(target, edge.plug, false)]);
    return drawn("path", { class: "wire", d: path, stroke: typeColour(type), "data-from": edge.node, "data-to": node });
  }), ...app.graph.nodes.map((/** @type {any} */ node) => drawNode(node, /** @type {Box} */ (boxes.get(node.name)))));
  paintGraph();
}

/** Zoom with the wheel, and move by dragging; a double click shows all. */
function listenToGraph() {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.getElementById("graph")));
  const show = (/** @type {number[]} */ box) => svg.setAttribute("viewBox", box.join(" "));
  const shown = () => /** @type {string} */ (svg.getAttribute("viewBox")).split(" ").map(Number);
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [x, y, width, height] = shown(), factor = Math.exp(event.deltaY * 0.0012), frame = svg.getBoundingClientRect();
    const scale = Math.max(width / frame.width, height / frame.height);
    const at = [x + width / 2 + (event.clientX - frame.left - frame.width / 2) * scale, y + height / 2 + (event.clientY - frame.top - frame.height / 2) * scale];
    show([at[0] + (x - at[0]) * factor, at[1] + (y - at[1]) * factor, width * factor, height * factor]);
  }, { passive: false });
  svg.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    const [x, y, width, height] = shown(), frame = svg.getBoundingClientRect();
    const scale = Math.max(width / frame.width, height / frame.height);
    show([x - event.movementX * scale, y - event.movementY * scale, width, height]);
  });
  svg.addEventListener("dblclick", drawGraph);
}

/** @param {any} node @param {Box} box */
function drawNode(node, box) {
  const left = box.x - BOX.width / 2, top = box.y - box.height / 2;
  const label = (/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y, /** @type {string} */ kind) =>
    drawn("text", { class: kind, x, y }, [text]);
  const socket = (/** @type {string} */ name, /** @type {boolean} */ isOutput, /** @type {string} */ type) => {
    const y = socketHeight(box, name, isOutput), x = isOutput ? left + BOX.width : left;
    return [drawn("circle", { class: "socket", cx: x, cy: y, r: 4.5, fill: typeColour(type) }, [drawn("title", {}, [type])]),
      label(name || type, isOutput ? x - 9 : x + 9, y + 4, isOutput ? "out" : "in")];
  };
  const group = drawn("g", { class: "node", tabindex: 0, "data-node": node.name }, [
    drawn("rect", { class: "box", x: left, y: top, width: BOX.width, height: box.height, rx: 5 }),
    drawn("rect", { class: "head", x: left, y: top, width: BOX.width, height: BOX.head, rx: 5 }),
    label(node.name, left + 8, top + 16, "name"),
    drawn("text", { class: "seconds", x: left + BOX.width - 8, y: top + 16 }),
    ...box.outputs.flatMap((name) => socket(name, true, node.type.outputs[name])),
    ...box.inputs.flatMap((name) => socket(name, false, typeOfPlug(node, name))),
    drawn("title", {}, [`${node.type.name}: ${node.type.summary}`]),
  ]);
  group.addEventListener("click", () => selectNode(node.name));
  group.addEventListener("keydown", (event) => /** @type {KeyboardEvent} */ (event).key === "Enter" && selectNode(node.name));
  return group;
}

/** Type that a plug takes. @param {any} node @param {string} plug @returns {string} */
function typeOfPlug(node, plug) {
  const socket = plug.split(".")[0];
  return node.type.sockets.find((/** @type {any} */ s) => s.name === socket)?.type ?? "";
}

/** Select a node, at a frame that it has, and its output that shows most. @param {string} name */
function selectNode(name) {
  const node = app.nodeNamed(name);
  const outputs = Object.keys(node.type.outputs);
  const kept = outputs.find((output) => Object.values(app.cell(name)?.pictures ?? {}).length || node.kinds[output][0] !== "value");
  app.set({ node: name, output: kept ?? outputs[0] });
}

/** Colour the nodes by their state, without another layout. */
function paintGraph() {
  for (const group of document.querySelectorAll("#graph .node")) {
    const name = /** @type {HTMLElement} */ (/** @type {unknown} */ (group)).dataset.node ?? "", state = worstState(name);
    const cells = app.state.nodes[name].cells;
    const seconds = cells.reduce((/** @type {number} */ all, /** @type {Cell} */ cell) => all + (cell.seconds ?? 0), 0);
    group.classList.toggle("selected", name === app.node);
    group.querySelector(".head")?.setAttribute("fill", stateColour(state));
    /** @type {Element} */ (group.querySelector(".seconds")).textContent = seconds ? timeText(seconds) : WORDS[state];
  }
}

app.on(["graph"], drawGraph);
app.on(["state", "node"], () => app.graph && paintGraph());
