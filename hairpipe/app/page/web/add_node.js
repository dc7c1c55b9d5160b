"use strict";
// Nodes are added: a search over names, summaries, settings, words of other programs, and what the other end of a wire takes or gives.

/** @typedef {{text: string, node: string, type: string}} Source */
/** @typedef {{node: string, socket: string, type: string}} Feed */

/** Open the search at a place of the page, for a wire that begins or ends nowhere yet.
 * @param {{x: number, y: number}} place @param {{source?: Source, feeds?: Feed}} [wire] */
async function openAdd(place, wire = {}) {
  const { types } = await hairpipe.plain("catalogue"), at = graphPlace(place.x, place.y);
  const fits = types.filter((/** @type {any} */ type) => socketFor(type, wire) !== null);
  openPopup({
    ...place, text: "", hint: wire.source ? `node that takes ${wire.source.type}` : wire.feeds ? `node that gives ${wire.feeds.type}` : "node type",
    find: (text) => ranked(fits, text).slice(0, 200).map(({ type, setting }) => ({ value: type.name, note: setting ? `setting ${setting}` : type.summary, category: categoryOf(type), icon: iconOf(categoryOf(type)) })),
    done: (name) => addNode(types.find((/** @type {any} */ type) => type.name === name), at, wire),
  });
}

/** Words of other programs, and those of ours that mean the same. @type {Record<string, string[]>} */
const SYNONYMS = {
  wind: ["air", "gust"], collision: ["contact", "collisions", "levelset"], collider: ["levelset", "contact"], curl: ["curl", "curls"], import: ["load"], open: ["load"], read: ["load"],
  export: ["export", "write"], save: ["export"], alembic: ["alembic", "mesh_cache"], abc: ["alembic"], render: ["preview", "cycles"], sim: ["simulate"], dynamics: ["simulate"], physics: ["simulate"], clump: ["lock", "clump"],
  guide: ["guide", "lock"], comb: ["comb", "groom"], brush: ["groom", "density"], trim: ["cut", "length"], haircut: ["cut"], frizz: ["stray", "curl"], sdf: ["levelset"], rig: ["body", "pose"], animation: ["motion", "pose"], mocap: ["motion"],
  texture: ["image", "map"], fur: ["groom"], character: ["body"], video: ["flipbook"], film: ["flipbook"], movie: ["flipbook"],
};
/** Categories of nodes, by what their names begin with; others belong to what they give. @type {[RegExp, string][]} */
const CATEGORIES = [[/^load_/, "import"], [/^(export|write)_/, "export"], [/^(measure|count|validate|compare|watch)_/, "measure"], [/^simulate_/, "simulate"], [/^(preview|render|flipbook|contact_sheet|join_pictures)/, "picture"]];

/** Category of a type of nodes. @param {any} type @returns {string} */
const categoryOf = (type) => CATEGORIES.find(([begin]) => begin.test(type.name))?.[1] ?? String(Object.values(type.outputs)[0]).toLowerCase();

/** Settings of a type, with those of groups, as dotted name and help. @param {any[]} fields @param {string} [above] @returns {[string, string][]} */
const settingsWithin = (fields, above = "") => fields.flatMap((field) => [[`${above}${field.name}`, field.help ?? ""], ...settingsWithin(field.group, `${above}${field.name}.`)]);

/** Types that a text finds, the best first: by name, by summary, sockets and category, or by a setting, which is named then. A word also finds its synonyms.
 * @param {any[]} types @param {string} text @returns {{type: any, setting: string}[]} */
function ranked(types, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean).map((word) => [word, ...Object.entries(SYNONYMS).flatMap(([other, ours]) => (word.length > 2 && other.startsWith(word) ? ours : []))]);
  const fits = (/** @type {string} */ place) => words.every((all) => all.some((word) => ` ${place.toLowerCase().replace(/[^a-z0-9]+/g, " ")}`.includes(` ${word.replaceAll("_", " ")}`)));
  const found = types.map((type) => {
    const about = `${type.name} ${categoryOf(type)} ${type.summary} ${type.sockets.map((/** @type {any} */ s) => s.type).join(" ")} ${Object.values(type.outputs).join(" ")}`;
    if (words.every(([word]) => type.name.includes(word))) return { type, rank: 5, setting: "" };
    if (fits(type.name)) return { type, rank: 4, setting: "" };
    const settings = settingsWithin(type.settings), named = settings.find(([name]) => fits(name)), told = settings.find(([, help]) => fits(help));
    if (named || fits(about)) return { type, rank: named ? 3 : 2, setting: named?.[0] ?? "" };
    return { type, rank: told ? 1 : 0, setting: told?.[0] ?? "" };
  });
  const order = (/** @type {any} */ type) => (words.length ? type.name : `${categoryOf(type)} ${type.name}`);
  return found.filter(({ rank }) => rank).sort((a, b) => b.rank - a.rank || order(a.type).localeCompare(order(b.type)));
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
