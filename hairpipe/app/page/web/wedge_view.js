"use strict";
// Variants of a wedge: their pictures, a table of what differs, and two of its columns against each other. One selection.

const SHEET = { width: 150 };

/** Take a variant's results in place of those of the graph file; -1 is the graph file. @param {number} variant */
function selectVariant(variant) {
  app.set({ variant, state: stateOf(variant) });
}

/** State of the results of a variant; the verdict is on all variants, which are run together. @param {number} variant */
function stateOf(variant) {
  if (!app.wedge) return app.trial ? { ...app.base, nodes: withTrial(app.base.nodes) } : app.base;
  return variant < 0 ? app.base : { ...app.base, nodes: app.wedge.states[variant], verdict: app.wedge.verdict };
}

function drawWedge() {
  const section = /** @type {HTMLElement} */ (document.getElementById("wedge"));
  section.hidden = !app.wedge;
  if (!app.wedge) return;
  const { name, names, variants } = app.wedge;
  const metrics = [...new Set(variants.flatMap((/** @type {any} */ v) => Object.keys(v.metrics)))];
  const rows = variants.map((/** @type {any} */ v) => [...names.map((/** @type {string} */ n) => v.settings[n]), ...metrics.map((m) => v.metrics[/** @type {string} */ (m)] ?? ""), v.seconds, v.state]);
  const table = sortable({ names: [...names, ...metrics, "seconds", "state"], rows });
  const whole = element("button", { class: app.variant < 0 ? "on" : "", onclick: () => selectVariant(-1) }, "the graph file");
  section.replaceChildren(element("h3", {}, `wedge ${name} `, whole), drawSheet(), element("div", { class: "beside" }, table, drawPareto([...metrics, "seconds"])));
  table.querySelectorAll("tbody tr").forEach((row, place) => row.addEventListener("click", () => selectVariant(place)));
  paintWedge();
}

/** Pictures of the variants at the selected frame, their values burnt in below. */
function drawSheet() {
  const { variants, show } = app.wedge, sheet = element("div", { class: "sheet" });
  variants.forEach((/** @type {any} */ variant, /** @type {number} */ place) => {
    const cell = cellOf(app.wedge.states[place], show[0], app.frame);
    const output = Object.keys(cell?.pictures ?? {})[0], object = output === undefined ? "" : cell?.outputs?.[output];
    const source = object && hairpipe.picture(object, cell?.pictures?.[/** @type {string} */ (output)] ?? "");
    sheet.append(element("figure", { "data-variant": place, onclick: () => selectVariant(place) },
      source ? element("img", { src: source, width: SHEET.width }) : element("p", { class: "none" }, variant.state || "no picture"),
      element("figcaption", {}, Object.entries(variant.settings).map(([name, value]) => `${name} ${spoken(value)}`).join(", "))));
  });
  return sheet;
}

/** Two columns against each other: a point a variant, a curve through those that differ along one axis. @param {Array<any>} columns */
function drawPareto(columns) {
  const { variants } = app.wedge, known = columns.filter((column) => variants.every((/** @type {any} */ v) => typeof numberOf(v, column) === "number"));
  const holder = element("div", { class: "pareto" });
  if (known.length < 2) return holder;
  const choice = (/** @type {string} */ part, /** @type {string} */ value) => element("select", { "aria-label": part, onchange: (/** @type {Event} */ event) => {
    app.pareto[part] = /** @type {HTMLSelectElement} */ (event.target).value;
    drawWedge();
  } }, ...known.map((column) => element("option", column === value ? { selected: "" } : {}, column)));
  const across = app.pareto.x ?? "seconds", up = app.pareto.y ?? known[0];
  const xs = variants.map((/** @type {any} */ v) => numberOf(v, across)), ys = variants.map((/** @type {any} */ v) => numberOf(v, up));
  const place = (/** @type {number[]} */ values, /** @type {number} */ k) => (values[k] - Math.min(...values)) / (Math.max(...values) - Math.min(...values) || 1);
  const best = (/** @type {number} */ k) => !xs.some((/** @type {number} */ x, /** @type {number} */ j) => x <= xs[k] && ys[j] <= ys[k] && (x < xs[k] || ys[j] < ys[k]));
  const spot = (/** @type {number} */ k) => [14 + 252 * place(xs, k), 166 - 152 * place(ys, k)];
  const axes = axesOf(app.wedge);
  const curves = axes.flatMap(({ lines }, i) => lines.map((line) => drawn("polyline", { points: line.map(spot).join(" "), style: `stroke:${inkOf(i)}` })));
  const points = variants.map((/** @type {any} */ variant, /** @type {number} */ k) => {
    const [cx, cy] = spot(k);
    const point = drawn("circle", { cx, cy, r: 6, class: best(k) ? "front" : "behind", "data-variant": k },
      [drawn("title", {}, [`${variant.name}: ${across} ${spoken(xs[k])}, ${up} ${spoken(ys[k])}`])]);
    point.addEventListener("click", () => selectVariant(k));
    return point;
  });
  holder.append(choice("y", up), drawn("svg", { width: 280, height: 180, viewBox: "0 0 280 180" }, [...curves, ...points]), choice("x", across),
    element("small", {}, ...axes.map(({ name }, i) => element("span", { style: `color:${inkOf(i)}` }, `along ${name} `))));
  return holder;
}

/** Axes of a wedge, and the variants along each, in its order, where the settings of the others are the same; joint settings are one axis.
 * @param {any} wedge @returns {Array<{name: string, lines: number[][]}>} */
function axesOf({ names, joint, variants }) {
  return (joint ? [names] : names.map((/** @type {string} */ name) => [name])).map((/** @type {string[]} */ axis) => {
    /** @type {Map<string, number[]>} */
    const lines = new Map();
    variants.forEach((/** @type {any} */ { settings }, /** @type {number} */ k) => {
      const others = JSON.stringify(names.map((/** @type {string} */ name) => (axis.includes(name) ? null : settings[name])));
      lines.set(others, [...(lines.get(others) ?? []), k]);
    });
    return { name: axis.join(", "), lines: [...lines.values()] };
  });
}

/** @param {any} variant @param {string} column */
const numberOf = (variant, column) => (column === "seconds" ? variant.seconds : variant.metrics[column]);

/** Mark the selected variant everywhere. */
function paintWedge() {
  document.querySelectorAll("#wedge [data-variant]").forEach((one) => one.classList.toggle("selected", one.getAttribute("data-variant") === String(app.variant)));
}

app.on(["wedge", "frame"], () => app.graph && drawWedge());
app.on(["variant"], () => app.wedge && drawWedge());
