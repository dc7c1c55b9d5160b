"use strict";
// Tables that sort by a click, and their columns as curves; the one-row tables of a shot as curves over its frames.

/** @param {HTMLElement} stage @param {string} name */
async function showTable(stage, name) {
  const here = await hairpipe.plain(name);
  const rowsOfFrames = here.rows.length === 1 && app.nodeNamed(app.node).per_frame ? await overFrames() : null;
  const table = rowsOfFrames ?? here;
  const holder = element("div", { class: "table" });
  stage.append(holder);
  if (table.rows.length > 2) plotTable(holder, table);
  holder.append(sortable(table));
}

/** Rows of all frames of the selected node, the frame in front. */
async function overFrames() {
  const names = framesOf(app.node).map((frame) => [frame, app.document(app.node, app.output, "table", frame)]);
  const known = names.filter(([, name]) => name);
  const found = await Promise.all(known.map(([, name]) => hairpipe.plain(/** @type {string} */ (name))));
  return found.length ? { names: ["frame", ...found[0].names], rows: found.map((table, i) => [known[i][0], ...table.rows[0]]) } : null; // of a stale result
}

/** @param {any} table @returns {HTMLElement} */
function sortable(table) {
  let [sorted, sign] = [-1, 1];
  const body = element("tbody");
  const fill = () => {
    const rows = [...table.rows];
    if (sorted >= 0) rows.sort((a, b) => sign * (typeof a[sorted] === "number" && typeof b[sorted] === "number" ? a[sorted] - b[sorted] : String(a[sorted]).localeCompare(String(b[sorted]))));
    body.replaceChildren(...rows.map((row) => element("tr", {}, ...row.map((/** @type {any} */ cell) =>
      element("td", { class: typeof cell === "number" ? "number" : "" }, typeof cell === "number" ? numberText(cell) : cell)))));
  };
  fill();
  const heads = table.names.map((/** @type {string} */ name, /** @type {number} */ place) => element("th", {
    onclick: () => {
      sign = sorted === place ? -sign : 1;
      sorted = place;
      fill();
    },
  }, name));
  return element("table", {}, element("thead", {}, element("tr", {}, ...heads)), body);
}

/** Colour of a curve by its number. @param {number} i */
const inkOf = (i) => `hsl(${(i * 67 + 30) % 360} 70% 65%)`;

/** @param {HTMLElement} holder @param {any} table */
function plotTable(holder, table) {
  const numeric = table.names.map((/** @type {string} */ _, /** @type {number} */ k) => table.rows.every((/** @type {any[]} */ row) => typeof row[k] === "number"));
  const over = numeric.indexOf(true), drawnColumns = table.names.map((/** @type {any} */ _, /** @type {number} */ k) => k).filter((/** @type {number} */ k) => numeric[k] && k !== over);
  if (over < 0 || !drawnColumns.length) return;
  const rows = [...table.rows].sort((a, b) => a[over] - b[over]);
  const axis = { stroke: "#9aa3ad", grid: { stroke: "#2b3036" }, ticks: { stroke: "#2b3036" } };
  const chart = element("div", { class: "chart" });
  holder.append(chart);
  new uPlot({
    width: Math.max(320, holder.clientWidth - 20), height: 240, scales: { x: { time: false } }, axes: [axis, axis],
    series: [{ label: table.names[over] }, ...drawnColumns.map((/** @type {number} */ k, /** @type {number} */ i) => ({ label: table.names[k], stroke: inkOf(i), width: 1.5, show: i === 0 }))],
  }, [over, ...drawnColumns].map((k) => rows.map((row) => row[k])), chart);
}
