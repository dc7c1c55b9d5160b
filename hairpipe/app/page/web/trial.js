"use strict";
// A value that is dragged, but not set yet: the selected result with it is computed and shown; the graph stays as it is.

/** Time after which a value that is being computed is superseded by the next one; earlier the next one waits [ms]. */
const TRIAL_PATIENCE = 800;

/** @typedef {{target: string, text: string}} Value */
/** The value that is dragged, the last one that was answered, and the one that a release ended with; whether an answer is awaited, and whether one is being computed, since when.
 * @type {{wanted: Value | null, answered: Value | null, ended: Value | null, asking: boolean, computing: boolean, begun: number}} */
const trying = { wanted: null, answered: null, ended: null, asking: false, computing: false, begun: 0 };

/** Show the selected result with another value of a setting, as soon as it is computed. @param {string} target @param {string} text */
function tryValue(target, text) {
  trying.wanted = { target, text };
  askTrial();
}

/** Ask for the results with the value that is dragged, unless there is nothing new, or those of an earlier value are about to come. */
function askTrial() {
  const { wanted, answered, asking, computing, begun } = trying;
  if (wanted && wanted !== answered && !asking && !app.wedge && (!computing || performance.now() - begun > TRIAL_PATIENCE)) void fetchTrial(wanted);
}

/** @param {Value} wanted */
async function fetchTrial(wanted) {
  const { node, frame } = app;
  trying.asking = true;
  const answer = await fetch("try", { method: "POST", body: JSON.stringify({ ...wanted, node, frame }), headers: { "Content-Type": "application/json" } }).then((found) => found.json()).catch(() => ({}));
  trying.asking = false;
  trying.computing = Boolean(answer.begun);
  if (answer.begun) trying.begun = performance.now();
  else trying.answered = wanted;
  if (answer.nodes && trying.wanted && trying.ended !== trying.wanted && app.node === node && app.frame === frame) takeTrial(answer.nodes);
  askTrial();
}

/** Show results with the value that is dragged, or null for those of the graph. @param {Trial} nodes */
function takeTrial(nodes) {
  app.trial = nodes;
  app.set({ state: stateOf(app.variant) });
}

/** End a drag with an edit: the results stay in view until those of the graph come. @param {Promise<string>} done @returns {Promise<string>} */
async function endTrial(done) {
  const { wanted } = trying;
  trying.ended = trying.answered = wanted;
  const refused = await done;
  if (trying.wanted !== wanted) return refused; // another drag has begun
  trying.wanted = null;
  if (app.trial && app.graph.revision >= app.answered) takeTrial(null);
  return refused;
}

/** End a drag without an edit, once the events of its release have passed: it came back to where it began. */
function dropTrial() {
  setTimeout(() => trying.wanted && trying.ended !== trying.wanted && void endTrial(Promise.resolve("")));
}

/** Cells of all nodes, with those of the value that is dragged. @param {Record<string, {cells: Cell[]}>} nodes */
function withTrial(nodes) {
  const tried = app.trial ?? {};
  return Object.fromEntries(Object.entries(nodes).map(([name, { cells }]) => [name, { cells: cells.map((cell) => tried[name]?.cells.find((other) => other.frame === cell.frame) ?? cell) }]));
}

app.on(["state"], () => {
  trying.computing &&= (app.wedge ?? app.base).verdict.running;
  askTrial();
});
