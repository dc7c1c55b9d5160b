"use strict";
// The graph as in Blender: nodes with coloured sockets, wires that pass no node.

const SVG = "http://www.w3.org/2000/svg";

/** Make an element of a drawing. @param {string} tag @param {Record<string, any>} given @param {Array<Node | string>} inner @returns {SVGElement} */
function drawn(tag, given, inner = []) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(given)) made.setAttribute(name, String(value));
  made.append(...inner);
  return made;
}

/** @param {Map<string, number[]>} [moved] what a drag adds to the places of nodes */
function drawGraph(moved) {
  const svg = /** @type {any} */ (document.getElementById("graph"));
  const { boxes, wires } = layOut(app.graph, moved);
  if (!moved) drawnBoxes = boxes;
  if (app.fresh || !app.live) showAll(LEGIBLE);
  const half = BOX.width / 2;
  svg.replaceChildren(...drawAnnotations(boxes, moved).filter((one) => one.matches(".frame")), ...wires.map(({ edge, node, through }) => {
    const source = /** @type {Box} */ (boxes.get(edge.node)), target = /** @type {Box} */ (boxes.get(node));
    const outputs = app.nodeNamed(edge.node).type.outputs, type = outputs[edge.output] ?? typeOfPlug(app.nodeNamed(node), edge.plug);
    const path = wirePath(through, [source.x + half, socketHeight(source, edge.output, true)],
      [target.x - half, socketHeight(target, edge.plug, false)]);
    return drawn("path", { class: "wire", d: path, stroke: typeColour(type), "data-from": edge.node, "data-to": node });
  }), ...app.graph.nodes.map((/** @type {any} */ node) => drawNode(node, /** @type {Box} */ (boxes.get(node.name)))), ...drawAnnotations(boxes, moved).filter((one) => one.matches(".note")));
  paintGraph();
}

/** Least scale at which a graph is first shown: its text is read, and what is beyond the pane comes by dragging or with Home. */
const LEGIBLE = 0.6;

/** Show all of the graph, or what a least scale leaves of it around the selected node. @param {number} [least] */
function showAll(least = 0) {
  const half = BOX.width / 2, nodes = [...drawnBoxes.values()].map((box) => ({ x: box.x - half, y: box.y - box.height / 2, width: BOX.width, height: box.height }));
  const all = [...nodes, ...annotations().flatMap((one) => annotationBox(one, drawnBoxes) ?? [])];
  const [left, top] = [Math.min(0, ...all.map((box) => box.x - 16)), Math.min(0, ...all.map((box) => box.y - 16))];
  const svg = document.getElementById("graph"), pane = svg?.getBoundingClientRect();
  const [wide, high] = [pane?.width || 640, pane?.height || 240]; // a small graph is not magnified
  const [right, low] = [Math.max(left + wide, ...all.map((box) => box.x + box.width + 16)), Math.max(top + high, ...all.map((box) => box.y + box.height + 16))];
  const middle = boxOfNode(app.node || nodeToShow());
  const part = (/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ at, /** @type {number} */ room) =>
    (least && to - from > room / least ? [Math.max(from, Math.min(at - room / least / 2, to - room / least)), room / least] : [from, to - from]);
  const [[x, width], [y, height]] = [part(left, right, middle.x, wide), part(top, low, middle.y, high)];
  svg?.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
  app.fresh = false;
}

/** Zoom with the wheel, and move by dragging; a double click shows all. */
function listenToGraph() {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.getElementById("graph")));
  const show = (/** @type {number[]} */ box) => svg.setAttribute("viewBox", box.join(" "));
  const shown = () => /** @type {string} */ (svg.getAttribute("viewBox")).split(" ").map(Number);
  const scaleOf = (/** @type {number} */ width, /** @type {number} */ height, /** @type {DOMRect} */ frame) => Math.max(width / frame.width, height / frame.height);
  let moved = false; // by hand
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    moved = true;
    const [x, y, width, height] = shown(), factor = Math.exp(event.deltaY * 0.0012), frame = svg.getBoundingClientRect(), scale = scaleOf(width, height, frame);
    const at = [x + width / 2 + (event.clientX - frame.left - frame.width / 2) * scale, y + height / 2 + (event.clientY - frame.top - frame.height / 2) * scale];
    show([at[0] + (x - at[0]) * factor, at[1] + (y - at[1]) * factor, width * factor, height * factor]);
  }, { passive: false });
  svg.addEventListener("pointermove", (event) => {
    if (!event.buttons || held) return;
    moved = true;
    const [x, y, width, height] = shown(), scale = scaleOf(width, height, svg.getBoundingClientRect());
    show([x - event.movementX * scale, y - event.movementY * scale, width, height]);
  });
  if (!app.live) new ResizeObserver(() => moved || showAll(LEGIBLE)).observe(svg);
  svg.addEventListener("dblclick", (event) => graphTarget(event).node || graphTarget(event).annotation || showAll());
}

/** @param {any} node @param {Box} box */
function drawNode(node, box) {
  const left = box.x - BOX.width / 2, top = box.y - box.height / 2;
  const label = (/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y, /** @type {string} */ kind) =>
    drawn("text", { class: kind, x, y }, [text]);
  const socket = (/** @type {string} */ name, /** @type {boolean} */ isOutput, /** @type {string} */ type) => {
    const y = socketHeight(box, name, isOutput), x = isOutput ? left + BOX.width : left;
    const given = { "data-owner": node.name, "data-side": isOutput ? "out" : "in", "data-name": name, "data-type": type };
    const free = !isOutput && !node.edges.some((/** @type {any} */ edge) => edge.plug === name);
    return [drawn("circle", { class: free ? "socket free" : "socket", cx: x, cy: y, r: 4.5, fill: typeColour(type), stroke: typeColour(type), ...given }, [drawn("title", {}, [`${name || "output"}: ${type}`])]),
      ...(box.folded ? [] : [label(name || type, isOutput ? x - 9 : x + 9, y + 4, isOutput ? "out" : "in")])];
  };
  const group = drawn("g", { class: "node", tabindex: 0, "data-node": node.name }, [
    drawn("rect", { class: "box", x: left, y: top, width: BOX.width, height: box.height, rx: 5 }),
    drawn("rect", { class: "head", x: left, y: top, width: BOX.width, height: BOX.head, rx: 5 }),
    iconAt(categoryOf(node.type), left + 7, top + 6),
    label(node.name, left + 24, top + 16, "name"),
    ...(box.folded ? [] : [drawn("text", { class: "seconds", x: left + 9, y: top + BOX.head + BOX.line * 0.5 + 6 })]), // next to the first output
    ...box.outputs.flatMap((name) => socket(name, true, node.type.outputs[name])),
    ...box.inputs.flatMap((name) => socket(name, false, typeOfPlug(node, name))),
    drawn("title", {}, [`${node.type.name}: ${node.fault ?? node.type.summary}`]),
  ]);
  if (!app.live) group.addEventListener("click", () => selectNode(node.name));
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
  if (!node) return;
  const outputs = Object.keys(node.type.outputs);
  const kept = outputs.find((output) => Object.values(app.cell(name)?.pictures ?? {}).length || node.kinds[output][0] !== "value");
  app.set({ node: name, output: kept ?? outputs[0] });
}

/** Colour the nodes by their state, without another layout. */
function paintGraph() {
  for (const one of document.querySelectorAll("#graph .annotation")) one.classList.toggle("chosen", app.chosen.has(one.getAttribute("data-annotation") ?? ""));
  for (const group of document.querySelectorAll("#graph .node")) {
    const name = /** @type {HTMLElement} */ (/** @type {unknown} */ (group)).dataset.node ?? "", state = worstState(name);
    const cells = app.state.nodes[name]?.cells ?? [];
    group.classList.toggle("chosen", app.chosen.has(name));
    group.classList.toggle("muted", state === "muted");
    const seconds = cells.reduce((/** @type {number} */ all, /** @type {Cell} */ cell) => all + (cell.seconds ?? 0), 0);
    group.classList.toggle("selected", name === app.node);
    group.querySelector(".head")?.setAttribute("fill", stateColour(state));
    group.querySelector(".name")?.setAttribute("fill", inkOn(stateColour(state)));
    group.querySelector(".icon")?.setAttribute("style", `color:${inkOn(stateColour(state))}`);
    drawInto(group.querySelector(".seconds"), seconds ? timeText(seconds) : WORDS[state]);
  }
}

app.on(["graph"], () => drawGraph());
app.on(["state", "node"], () => app.graph && paintGraph());
