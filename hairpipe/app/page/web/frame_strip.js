"use strict";
// A row a node, a cell a frame: coloured by what became of it, shaded by its seconds.

const STRIP = { label: 150, row: 13, top: 14 };

/** Place of the first pixel of a frame, and the width of one. */
function stripScale() {
  const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector("#strip canvas"));
  const first = Math.min(app.graph.frames[0], ...app.graph.nodes.flatMap((/** @type {any} */ node) => framesOf(node.name)));
  const last = app.graph.frames[1], width = canvas.clientWidth - STRIP.label - 8;
  return { canvas, first, last, cell: width / (last - first + 1) };
}

/** Nodes that have a row: in the preset `look` the selected one. @returns {any[]} */
const stripNodes = () => app.graph.nodes.filter((/** @type {any} */ node) => panes.preset !== "look" || !app.node || node.name === app.node);

/** @param {string} node @returns {number[]} */
function framesOf(node) {
  return (app.state.nodes[node]?.cells ?? []).map((/** @type {Cell} */ cell) => cell.frame).filter((/** @type {any} */ f) => f !== null);
}

/** A colour of the theme. @param {string} name */
const themed = (name) => getComputedStyle(document.body).getPropertyValue(name);

function drawStrip() {
  const { canvas, first, last, cell } = stripScale();
  const rows = stripNodes(), ratio = window.devicePixelRatio || 1;
  canvas.style.height = `${STRIP.top + STRIP.row * rows.length + 4}px`;
  canvas.width = canvas.clientWidth * ratio;
  canvas.height = (STRIP.top + STRIP.row * rows.length + 4) * ratio;
  const ink = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  ink.scale(ratio, ratio);
  ink.font = "11px system-ui, sans-serif";
  const every = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((n) => n * cell >= 42) ?? 2000;
  ink.fillStyle = themed("--soft");
  for (let frame = Math.ceil(first / every) * every; frame <= last; frame += every) {
    const text = String(frame), end = canvas.clientWidth - ink.measureText(text).width;
    ink.fillText(text, Math.min(STRIP.label + (frame - first) * cell, end), 10);
  }
  rows.forEach((/** @type {any} */ node, /** @type {number} */ row) => {
    const y = STRIP.top + row * STRIP.row, cells = app.state.nodes[node.name]?.cells ?? [];
    const slowest = Math.max(...cells.map((/** @type {Cell} */ c) => c.seconds ?? 0), 1e-9);
    ink.fillStyle = themed(node.name === app.node ? "--strong" : "--text");
    ink.fillText(node.name, 4, y + 9, STRIP.label - 10);
    for (const one of cells) {
      const x = STRIP.label + (one.frame === null ? 0 : (one.frame - first) * cell);
      const wide = one.frame === null ? (last - first + 1) * cell : cell;
      ink.globalAlpha = one.seconds === undefined ? 1 : 0.45 + 0.55 * Math.sqrt(one.seconds / slowest);
      ink.fillStyle = stateColour(one.state);
      ink.fillRect(x, y, Math.max(wide - (wide > 4 ? 1 : 0), 0.7), STRIP.row - 3);
    }
    ink.globalAlpha = 1;
  });
  ink.fillStyle = themed("--strong");
  ink.fillRect(STRIP.label + (app.frame - first + 0.5) * cell - 0.75, STRIP.top - 2, 1.5, STRIP.row * rows.length + 2);
}

/** Scroll to the row of the selected node, unless variants are above the rows. */
function showRow() {
  const pane = document.getElementById("time"), row = stripNodes().findIndex((node) => node.name === app.node);
  if (!pane || row < 0 || app.wedge) return;
  const { canvas } = stripScale(), at = pane.getBoundingClientRect(), above = document.getElementById("timeline")?.offsetHeight ?? 0;
  const top = canvas.getBoundingClientRect().top - at.top + STRIP.top + row * STRIP.row;
  pane.scrollTop += Math.min(0, top - STRIP.top - above) + Math.max(0, top + STRIP.row + 4 - pane.clientHeight);
}

/** Node and frame below the pointer, or null. @param {MouseEvent} event */
function cellAt(event) {
  const { canvas, first, last, cell } = stripScale(), at = canvas.getBoundingClientRect();
  const row = Math.floor((event.clientY - at.top - STRIP.top) / STRIP.row);
  const frame = Math.floor((event.clientX - at.left - STRIP.label) / cell) + first;
  const node = stripNodes()[row]?.name;
  return node ? { node, frame: Math.max(first, Math.min(last, frame)) } : null;
}

/** @param {string} node @param {number} frame */
function cellText(node, frame) {
  const cell = app.cell(node, frame);
  const fault = app.nodeNamed(node)?.fault;
  if (fault) return `${node}: incomplete, ${fault}`;
  if (!cell) return `${node}@${frame}: ${app.nodeNamed(node)?.muted ? "muted" : "not asked for"}`;
  const name = cell.frame === null ? node : `${node}@${frame}`;
  const took = cell.seconds === undefined ? "" : `\n${timeText(cell.seconds)}, of the processor ${timeText(cell.processor ?? 0)}, ${sizeText(cell.bytes ?? 0)}`;
  return `${name}: ${WORDS[cell.state]}${cell.reason ? ` ${cell.state === "run" ? "because: " : ""}${cell.reason}` : ""}${took}${(cell.warnings ?? []).map((/** @type {string} */ w) => `\nwarning: ${w}`).join("")}`;
}

function listenToStrip() {
  const tip = /** @type {HTMLElement} */ (document.getElementById("tip"));
  const { canvas } = stripScale();
  canvas.addEventListener("click", (event) => {
    const found = cellAt(event);
    if (found && event.offsetX < STRIP.label) selectNode(found.node);
    else if (found) app.set({ frame: Math.max(app.graph.frames[0], found.frame) }), selectNode(found.node);
  });
  canvas.addEventListener("mousemove", (event) => {
    const found = cellAt(event);
    tip.textContent = found ? cellText(found.node, found.frame) : "";
    tip.style.cssText = found ? `display:block;left:${Math.min(event.pageX + 12, innerWidth - 320)}px;top:${event.pageY + 14}px` : "display:none";
  });
  canvas.addEventListener("mouseleave", () => (tip.style.display = "none"));
  new ResizeObserver(() => app.graph && drawStrip()).observe(canvas);
  matchMedia("(prefers-color-scheme: light)").addEventListener("change", drawStrip);
}

app.on(["graph", "state", "frame", "node"], () => app.graph && app.state && drawStrip());
app.on(["node"], () => app.graph && app.state && showRow());
