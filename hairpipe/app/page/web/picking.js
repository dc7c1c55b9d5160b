"use strict";
// The strand that was clicked on: what it is, how it is strained, and what made it. It stays picked at other frames.

/** @typedef {{item: Item, index: number, strand: number, start: number, count: number}} Picked */

/** The picked strand in what is drawn now, or null. @returns {Picked | null} */
function pickedStrand() {
  const item = viewer?.items.find((one) => one.lengths), { picked } = app;
  if (!item?.lengths || !picked || picked.node !== app.node) return null;
  const index = item.strands ? Array.from(item.strands).indexOf(picked.strand) : picked.strand;
  if (index < 0 || index >= item.lengths.length) return null;
  let start = 0;
  for (let s = 0; s < index; s++) start += item.lengths[s];
  return { item, index, strand: picked.strand, start, count: item.lengths[index] };
}

/** Places of some points of a document, as a copy. @param {Float32Array} places @param {Picked} picked */
const placesOfPicked = (places, { start, count }) => places.slice(3 * start, 3 * (start + count));

/** Lengths of the segments of one strand [m]. @param {Float32Array} places */
function segmentsOf(places) {
  const spans = new Float64Array(Math.max(0, places.length / 3 - 1));
  for (let i = 0; i < spans.length; i++) spans[i] = Math.hypot(places[3 * i + 3] - places[3 * i], places[3 * i + 4] - places[3 * i + 1], places[3 * i + 5] - places[3 * i + 2]);
  return spans;
}

/** Number of the latest description: an earlier one that comes later is dropped. */
let pickedTurn = 0;

/** Highlight the picked strand, and describe it. */
async function drawPicked() {
  const stage = /** @type {HTMLElement} */ (document.getElementById("stage")), picked = pickedStrand(), turn = ++pickedTurn;
  viewer?.mark(picked);
  const rows = picked ? await rowsOfPicked(picked) : [];
  if (turn !== pickedTurn) return;
  document.getElementById("picked")?.remove();
  if (!picked || !stage.classList.contains("solid")) return;
  const close = element("button", { class: "unset", title: "Escape", onclick: () => app.set({ picked: null }) }, "×");
  stage.append(element("div", { id: "picked" }, close, element("dl", {}, ...rows.flatMap(([name, ...value]) => [element("dt", {}, name), element("dd", {}, ...value)]))));
}

/** @param {Picked} picked @returns {Promise<Array<[string, ...(Node | string)[]]>>} */
async function rowsOfPicked(picked) {
  const { item, strand, count } = picked, { node, output } = app;
  const rest = item.rest ? await hairpipe.get(item.rest) : null, same = rest && placesIn(rest).length === item.places?.length;
  const now = placesOfPicked(/** @type {Float32Array} */ (item.places), picked), spans = segmentsOf(now);
  const rows = /** @type {Array<[string, ...(Node | string)[]]>} */ ([["strand", `${strand.toLocaleString("en")} of ${(item.total ?? 0).toLocaleString("en")}, ${count} points`],
    ["root", `${[...now.slice(0, 3)].map((v) => v.toFixed(4)).join(" ")} m`]]);
  const own = (same ? rest : null) ?? (item.document && await hairpipe.get(item.document)), uv = own && floatsOf(own.arrays.uv);
  if (uv) rows.push(["uv", [uv[picked.index], uv[uv.length / 2 + picked.index]].map((v) => v.toFixed(4)).join(" ")]);
  const length = spans.reduce((all, v) => all + v, 0);
  if (same && item.rest) rows.push(...strainRows(spans, segmentsOf(placesOfPicked(placesIn(rest), picked)), length, (item.step ?? 0) + rest.meta.step));
  else rows.push(["length", `${numberText(1e3 * length)} mm`]);
  return [...rows, ...await measuredRows(picked), ...await contactRows(picked), ...makerRows(node, output)];
}

/** Length, and the largest strain with the error of rounded places. @param {Float64Array} spans @param {Float64Array} resting @param {number} length @param {number} step @returns {Array<[string, string]>} */
function strainRows(spans, resting, length, step) {
  const whole = resting.reduce((all, v) => all + v, 0), percent = (/** @type {number} */ v) => `${v < 0 ? "−" : "+"}${(100 * Math.abs(v)).toFixed(2)} %`;
  let most = 0;
  for (let i = 0; i < spans.length; i++) if (Math.abs(spans[i] / resting[i] - 1) > Math.abs(spans[most] / resting[most] - 1)) most = i;
  const before = resting.slice(0, most).reduce((all, v) => all + v, 0), error = (Math.sqrt(3) * step) / resting[most];
  return [["length", `${(1e3 * whole).toFixed(2)} mm at rest, ${(1e3 * length).toFixed(2)} mm now`],
    ["largest strain", spans.length ? `${percent(spans[most] / resting[most] - 1)} ± ${(100 * error).toFixed(2)}, ${(1e3 * (before + resting[most] / 2)).toFixed(0)} mm from the root` : "one point"]];
}

/** The largest of every value that nodes have measured along the strand. @param {Picked} picked @returns {Promise<Array<[string, string]>>} */
async function measuredRows({ start, count }) {
  const documents = valueDocuments(app.node, app.output);
  await Promise.all(documents.map((one) => hairpipe.get(one)));
  return Promise.all([...measuredOf(documents)].map(async ([name, { name: document, place }]) => {
    const found = await hairpipe.get(document), [low, high] = found.meta.ranges[place];
    const values = runningSums(found.arrays[`values${place}`]).subarray(start, start + count);
    return /** @type {[string, string]} */ ([`most ${name}`, numberText(Number((low + Math.max(...values) * (high - low)).toPrecision(3)))]);
  }));
}

/** Connections with other hair, where the simulation kept its state at this frame. @param {Picked} picked @returns {Promise<Array<[string, string]>>} */
async function contactRows({ item, start, count, index }) {
  const output = Object.entries(app.nodeNamed(app.node).kinds).find(([, kinds]) => kinds.includes("contacts"))?.[0];
  const name = output && app.document(app.node, output, "contacts");
  if (!name || item.strands) return []; // segments are numbered over all strands
  const pairs = await hairpipe.get(name).then((found) => found.arrays.segments, () => null); // not kept at this frame
  if (!pairs) return [];
  const first = start - index, last = first + count - 1, half = pairs.length / 2;
  let touching = 0;
  for (let k = 0; k < half; k++) if ((pairs[k] >= first && pairs[k] < last) || (pairs[half + k] >= first && pairs[half + k] < last)) touching++;
  return [["contacts", touching ? `${touching} connection${touching > 1 ? "s" : ""} with other hair` : "none with other hair"]];
}

/** The node that made the strand, its graph and result, and the nodes before it that make strands. @param {string} node @param {string} output @returns {Array<[string, ...(Node | string)[]]>} */
function makerRows(node, output) {
  const object = app.cell(node)?.outputs?.[output] ?? "";
  const link = (/** @type {string} */ name) => element("a", { href: "#", onclick: (/** @type {Event} */ event) => (event.preventDefault(), selectNode(name)) }, name);
  const sources = makersOf(node).map((name) => {
    const { type, settings } = app.nodeNamed(name), files = type.settings.filter((/** @type {any} */ field) => field.kind === "a file" && settings?.[field.name]);
    return element("span", {}, link(name), ` ${[type.name, ...files.map((/** @type {any} */ field) => settings[field.name])].join(" ")} `);
  });
  return [["made by", link(node), ` ${app.nodeNamed(node).type.name} in ${app.graph.file} `, element("code", { title: "object in the cache" }, object.slice(0, 14))], ...(sources.length ? /** @type {Array<[string, ...Node[]]>} */ ([["grown by", ...sources]]) : [])];
}

/** Nodes upstream that give a groom without taking one. @param {string} node @returns {string[]} */
function makersOf(node) {
  const queue = [node], seen = new Set(queue);
  for (const name of queue) {
    for (const edge of app.nodeNamed(name).edges) if (!seen.has(edge.node)) seen.add(edge.node), queue.push(edge.node);
  }
  const gives = (/** @type {string} */ name) => Object.values(app.nodeNamed(name).type.outputs).includes("Groom");
  return queue.slice(1).filter((name) => gives(name) && !app.nodeNamed(name).edges.some((/** @type {any} */ edge) => gives(edge.node)));
}

document.addEventListener("keydown", (event) => event.key === "Escape" && app.set({ picked: null }));
app.on(["picked"], () => void drawPicked());
