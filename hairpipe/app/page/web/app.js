"use strict";
// What is selected, and who has to know. Views are functions of it; they are called when a part of it changes.

/** @typedef {{frame: number | null, state: string, reason: string, seconds?: number, processor?: number, bytes?: number,
 *   warnings?: string[], outputs?: Record<string, string>, pictures?: Record<string, string>, inputs?: Record<string, string>}} Cell */

/** Results of a graph at a frame: they are named by their content, so edits and runs leave them as they were. @typedef {{graph: any, state: any, frame: number}} Result */
/** Results at a frame with a value of a setting that is dragged. @typedef {Record<string, {cells: Cell[]}> | null} Trial */

/** @typedef {{graph: any, state: any, live: boolean, compare: boolean, apart: boolean, chosen: Set<string>, folded: Set<string>, places: Record<string, number[]>, past: Map<string, Cell>, last: Map<string, Result>, trial: Trial, fresh: boolean, answered: number, awaited: (() => string | undefined) | null, strands: number, showing: Promise<void>, node: string, output: string, frame: number, channel: string, picked: {node: string, strand: number} | null, pinned: Pinned | null, base: any, wedge: any, variant: number, pareto: Record<string, string>,
 *   ahead: {node: string, counts: Record<string, number>, seconds: number | null, now: number, reason: string} | null,
 *   views: Array<[string[], () => void]>, on: (parts: string[], view: () => void) => void, set: (changes: Record<string, any>) => void,
 *   nodeNamed: (name: string) => any, cell: (node: string, frame?: number) => Cell | undefined,
 *   document: (node: string, output: string, kind: string, frame?: number) => string | null}} App */

/** @type {App} */
const app = {
  graph: null, state: null, live: false, compare: false,
  /** Whether what is compared is side by side, not behind a slider. */
  apart: false,
  /** Nodes that are chosen, and those of which the head alone is drawn; places of all nodes in this page; results before an edit, by node@frame. */
  chosen: new Set(), folded: new Set(), places: {}, past: new Map(), fresh: true, awaited: null,
  /** Revision of the server's last answer to an edit; a graph with a lower one is older. */
  answered: 0,
  /** What was shown last of each output of a variant; it stays in view until there is a new result. */
  last: new Map(),
  /** Results with the value of a slider that is dragged. */
  trial: null,
  /** Number of the strand that was clicked on, of what a node made. */
  picked: null,
  /** Largest number of strands that are shown. */
  strands: 4000,
  /** Ends when the viewport shows what is selected. */
  showing: Promise.resolve(),
  node: "", output: "", frame: 0, channel: "shaded",
  /** What is kept for comparison. */
  pinned: null,
  base: null, wedge: null, variant: -1, pareto: {},
  /** What a run to the selected node computes. */
  ahead: null,
  views: [],

  /** Call a view when one of these parts changes. @param {string[]} parts @param {() => void} view */
  on(parts, view) {
    app.views.push([parts, view]);
  },

  /** Change parts of what is selected. @param {Record<string, any>} changes */
  set(changes) {
    const changed = Object.keys(changes).filter((part) => /** @type {any} */ (app)[part] !== changes[part]);
    Object.assign(app, changes);
    for (const [parts, view] of app.views) if (parts.some((part) => changed.includes(part))) view();
  },

  /** @param {string} name @returns {any} */
  nodeNamed(name) {
    return app.graph.nodes.find((/** @type {any} */ node) => node.name === name);
  },

  /** The result of a node at a frame; of a value for the shot at any. @param {string} node @param {number} frame @returns {Cell | undefined} */
  cell(node, frame = app.frame) {
    return cellOf(app.state.nodes, node, frame);
  },

  /** Name of a document of an output, or null where there is none. @param {string} node @param {string} output @param {string} kind */
  document(node, output, kind, frame = app.frame) {
    const object = app.cell(node, frame)?.outputs?.[output];
    const name = `${object}.${kind}${app.live && THINNED.includes(kind) ? `@${app.strands}` : ""}`;
    return object && app.nodeNamed(node).kinds[output]?.includes(kind) && hairpipe.has(name) ? name : null;
  },
};

/** The result of a node at a frame among those of all nodes. @param {any} nodes @param {string} node @param {number} frame @returns {Cell | undefined} */
function cellOf(nodes, node, frame) {
  return (nodes[node]?.cells ?? []).find((/** @type {Cell} */ cell) => cell.frame === null || cell.frame === frame);
}

/** Kinds of documents with as many strands as are shown. */
const THINNED = ["strands", "values"];
/** Colours of types: each has a contrast of 3 to boxes of nodes in either theme. */
const COLOURS = {
  Strands: "#db7a1f", Groom: "#ba6d31", Mesh: "#4192ff", Body: "#5f8fd0", Pose: "#a27aff", LevelSet: "#2ea485",
  BodyParts: "#369079", Density: "#309dca", File: "#8a8a8a", Table: "#a79227", Cloud: "#ff5090", Particles: "#df4a89",
};
const STATES = {
  cached: "#3f7d4f", computed: "#63c07a", resumed: "#6fa8d0", running: "#f0c860", run: "#9a7a3a", depends: "#5f5640",
  failed: "#d65a4a", blocked: "#7a4a44", queued: "#5a6a8a", incomplete: "#a05a8a", muted: "#6a6f75",
};
/** @type {Record<string, string>} */
const WORDS = {
  cached: "cached", computed: "computed", resumed: "computed again for its state", running: "running", run: "will run",
  depends: "depends on", failed: "failed", blocked: "blocked", incomplete: "incomplete", muted: "muted",
};
const WORST = ["failed", "running", "run", "depends", "blocked", "resumed", "computed", "cached"];

/** @param {string} type */
const typeColour = (type) => /** @type {any} */ (COLOURS)[type] ?? "#758392";
/** @param {string} state */
const stateColour = (state) => /** @type {any} */ (STATES)[state] ?? "#555555";

/** Black or white, whichever has more contrast to a colour: the luminance at which both have the same is 0.179. @param {string} colour such as #3f7d4f */
function inkOn(colour) {
  const parts = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255).map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2] > 0.179 ? "#000000" : "#ffffff";
}

/** The state that tells most about a node. @param {string} node */
function worstState(node) {
  const { muted, fault } = app.nodeNamed(node) ?? {};
  if (muted || fault) return muted ? "muted" : "incomplete";
  const states = new Set((app.state.nodes[node]?.cells ?? []).map((/** @type {Cell} */ cell) => cell.state));
  return WORST.find((state) => states.has(state)) ?? "run";
}
