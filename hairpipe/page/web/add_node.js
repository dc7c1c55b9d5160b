"use strict";
// Nodes are added: a search over names, titles, and what the other end of a wire takes or gives.

/** @typedef {{text: string, node: string, type: string}} Source */
/** @typedef {{node: string, socket: string, type: string}} Feed */

/** Open the search at a place of the page, for a wire that begins or ends nowhere yet.
 * @param {{x: number, y: number}} place @param {{source?: Source, feeds?: Feed}} [wire] */
async function openAdd(place, wire = {}) {
  const { types } = await hairpipe.plain("catalogue"), at = graphPlace(place.x, place.y);
  const fits = types.filter((/** @type {any} */ type) => socketFor(type, wire) !== null);
  openPopup({
    ...place, text: "", hint: wire.source ? `node that takes ${wire.source.type}` : wire.feeds ? `node that gives ${wire.feeds.type}` : "node type",
    find: (text) => ranked(fits, text).slice(0, 200).map((type) => ({ value: type.name, note: type.summary, colour: typeColour(String(Object.values(type.outputs)[0])) })),
    done: (name) => addNode(types.find((/** @type {any} */ type) => type.name === name), at, wire),
  });
}

/** Types whose name comes first, then those that a text occurs in, or whose sockets have it. @param {any[]} types @param {string} text @returns {any[]} */
function ranked(types, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const score = (/** @type {any} */ type) => {
    const all = `${type.name} ${type.summary} ${type.sockets.map((/** @type {any} */ s) => s.type).join(" ")} ${Object.values(type.outputs).join(" ")}`.toLowerCase();
    if (!words.every((word) => all.includes(word))) return -1;
    return words.every((word) => type.name.includes(word)) ? 2 : 1;
  };
  return types.map((type) => ({ type, rank: score(type) })).filter(({ rank }) => rank > 0)
    .sort((a, b) => b.rank - a.rank || a.type.name.localeCompare(b.type.name)).map(({ type }) => type);
}

/** Socket or output at which a wire fits a type: empty without a wire, null where none does.
 * @param {any} type @param {{source?: Source, feeds?: Feed}} wire @returns {string | null} */
function socketFor(type, { source, feeds }) {
  if (source) return type.sockets.find((/** @type {any} */ s) => s.type === source.type)?.name ?? null;
  if (feeds) return Object.values(type.outputs).includes(feeds.type) ? "" : null;
  return "";
}

/** Add a node; required inputs that one node alone can feed are connected.
 * @param {any} type @param {number[]} at @param {{source?: Source, feeds?: Feed}} wire */
async function addNode(type, at, { source, feeds }) {
  /** @type {Record<string, string>} */
  const edges = {};
  for (const socket of type.sockets.filter((/** @type {any} */ s) => !s.optional)) {
    const givers = app.graph.nodes.filter((/** @type {any} */ node) => Object.values(node.type.outputs).includes(socket.type));
    if (givers.length === 1 && type.mode !== "once") edges[socket.name] = sourceText(givers[0], socket.type);
  }
  if (source) edges[/** @type {string} */ (socketFor(type, { source }))] = source.text;
  const given = { type: type.name, at, edges, ...(feeds && { feeds: { node: feeds.node, socket: feeds.socket } }) };
  const before = new Set(app.graph.nodes.map((/** @type {any} */ node) => node.name));
  app.awaited = () => app.graph.nodes.find((/** @type {any} */ node) => !before.has(node.name))?.name;
  if (await edit("add", given)) await edit("add", { ...given, edges: {} });
}

/** Text of an edge from an output: the node alone if one output has the type. @param {any} node @param {string} type @param {string} [output] */
function sourceText(node, type, output) {
  const names = Object.keys(node.type.outputs).filter((name) => node.type.outputs[name] === type);
  return names.length === 1 ? node.name : `${node.name}.${output ?? names[0]}`;
}
