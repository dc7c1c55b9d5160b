"use strict";
// Places of nodes and ways of wires: laid out in columns, or as the file and the page have them.

/** @typedef {{x: number, y: number, height: number, inputs: string[], outputs: string[], folded: boolean}} Box */

const BOX = { width: 158, head: 24, line: 15, gap: 26, column: 48 };

/** @type {Map<string, Box>} */
let drawnBoxes = new Map();

/** Lay the nodes out in columns, and lead each wire through the columns between; y of the wire in each.
 * @param {any} graph @param {Map<string, number[]>} [moved] @returns {{boxes: Map<string, Box>, wires: Array<{edge: any, node: string, through: Array<{x: number, y: number}>}>, width: number, height: number}} */
function layOut(graph, moved) {
  const layout = new dagre.graphlib.Graph({ multigraph: true });
  layout.setGraph({ rankdir: "LR", nodesep: BOX.gap, edgesep: 14, ranksep: BOX.column, marginx: 16, marginy: 16 });
  layout.setDefaultEdgeLabel(() => ({}));
  /** @type {Map<string, Box>} */
  const boxes = new Map();
  for (const node of graph.nodes) {
    const inputs = inputsOf(node), outputs = Object.keys(node.type.outputs);
    const folded = app.folded.has(node.name), height = BOX.head + (folded ? 0 : BOX.line * Math.max(inputs.length + outputs.length, 1) + 8);
    boxes.set(node.name, { x: 0, y: 0, height, inputs, outputs, folded });
    layout.setNode(node.name, { width: BOX.width, height });
  }
  for (const node of graph.nodes) for (const edge of node.edges) if (boxes.has(edge.node)) layout.setEdge(edge.node, node.name, {}, `${edge.output} ${edge.plug}`);
  dagre.layout(layout);
  for (const [name, box] of boxes) Object.assign(box, { x: layout.node(name).x, y: layout.node(name).y });
  if (placeBoxes(graph, boxes, moved)) return placedGraph(graph, boxes);
  const columns = new Set([...boxes.values()].map((box) => Math.round(box.x)));
  const wires = graph.nodes.flatMap((/** @type {any} */ node) => node.edges.map((/** @type {any} */ edge) => {
    const { points } = layout.edge(edge.node, node.name, `${edge.output} ${edge.plug}`);
    const between = points.slice(1, -1).filter((/** @type {any} */ p) => columns.has(Math.round(p.x)));
    return { edge, node: node.name, through: between };
  }));
  const { width, height } = layout.graph();
  return { boxes, wires, width, height };
}

/** Names of the inputs of a node; live also of those without an edge, and of one more where many are taken. @param {any} node @returns {string[]} */
function inputsOf(node) {
  const plugs = node.edges.map((/** @type {any} */ edge) => edge.plug);
  if (!app.live) return plugs;
  return node.type.sockets.flatMap((/** @type {any} */ socket) => {
    const own = plugs.filter((/** @type {string} */ plug) => plug.split(".")[0] === socket.name);
    return own.length && !socket.many ? own : [...own, socket.name];
  });
}

/** Move boxes to the places of the file or of this page, and by what a drag adds; whether any was moved.
 * @param {any} graph @param {Map<string, Box>} boxes @param {Map<string, number[]>} [moved] */
function placeBoxes(graph, boxes, moved) {
  let any = false;
  for (const [name, box] of boxes) {
    const place = graph.layout?.[name] ?? (app.live ? app.places[name] : null), by = moved?.get(name);
    any ||= Boolean(by) || (place && (place[0] !== box.x || place[1] !== box.y));
    if (place) [box.x, box.y] = place;
    if (app.live && !by) app.places[name] = [box.x, box.y];
    if (by) [box.x, box.y] = [box.x + by[0], box.y + by[1]];
  }
  return any;
}

/** Wires between boxes that were moved: straight from socket to socket. @param {any} graph @param {Map<string, Box>} boxes */
function placedGraph(graph, boxes) {
  const wires = graph.nodes.flatMap((/** @type {any} */ node) => node.edges.filter((/** @type {any} */ edge) => boxes.has(edge.node))
    .map((/** @type {any} */ edge) => ({ edge, node: node.name, through: [] })));
  const all = [...boxes.values()], right = Math.max(0, ...all.map((box) => box.x + BOX.width / 2)), low = Math.max(0, ...all.map((box) => box.y + box.height / 2));
  return { boxes, wires, width: right + 16, height: low + 16 };
}

/** Box of a node as it was drawn last. @param {string} name @returns {Box} */
const boxOfNode = (name) => drawnBoxes.get(name) ?? { x: 0, y: 0, height: 0, inputs: [], outputs: [], folded: false };

/** Height of a socket in its box; in a folded one all lie on its head. @param {Box} box @param {string} name @param {boolean} isOutput */
function socketHeight(box, name, isOutput) {
  if (box.folded) return box.y;
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
