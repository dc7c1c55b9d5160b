"use strict";
// Live: settings are edited, the plan says what would run, runs begin and end, files are saved.

/** Ask for a deed; what is wrong with it is returned, empty where all is well. @param {string} deed @param {any} given @returns {Promise<string>} */
async function act(deed, given = {}) {
  const answer = await fetch(deed, { method: "POST", body: JSON.stringify(given), headers: { "Content-Type": "application/json" } });
  const { fault = "", revision = 0 } = await answer.json();
  app.answered = Math.max(app.answered, revision);
  return fault;
}

/** Take every change in, for as long as the page is open. */
async function follow() {
  drawControls();
  app.on(["state", "graph"], () => app.graph && app.state && drawControls());
  app.on(["state", "graph", "node", "frame"], () => app.graph && app.state && cookSoon());
  cookSoon();
  let lost = false;
  document.addEventListener("pointerdown", () => lost || sayControls(""), true);
  for (let seen = 0; ; ) {
    try {
      const { revision, graph } = await (await fetch(`wait?seen=${seen}`)).json();
      if (revision > seen || lost) await renew(lost || graph !== app.graph.revision);
      if (lost) sayControls("");
      [seen, lost] = [revision, false];
    } catch {
      if (!lost) sayControls("the server has ended; start `hairpipe view` again");
      lost = true;
      await new Promise((resolve) => setTimeout(resolve, 2000));
    }
  }
}

/** Fetch the state again, and the graph where it has changed. @param {boolean} graph */
function renew(graph) {
  for (const name of graph ? ["graph", "state", "wedge"] : ["state", "wedge"]) hairpipe.raw.delete(name);
  return refresh();
}

/** Pause after a change, before the selected node is computed [ms]. */
const COOK_PAUSE = 250;
let cooking = 0;

/** Ask, soon after the last change, what the selected node lacks, and compute it at this frame where that is cheap. */
function cookSoon() {
  clearTimeout(cooking);
  const { node, frame } = app, isComplete = (app.state.nodes[node]?.cells ?? []).every((/** @type {Cell} */ cell) => cell.outputs);
  if (app.wedge || app.trial || trying.wanted || app.graph.conflict || !node || isComplete) return void (app.ahead && app.set({ ahead: null }));
  cooking = window.setTimeout(async () => {
    const work = await (await fetch(`work?node=${node}&frame=${frame}`)).json().catch(() => ({ fault: "none" }));
    if (app.node !== node || app.frame !== frame) return;
    app.set({ ahead: work.fault ? null : { node, ...work } });
    if (!work.fault && work.now && !work.reason) await act("cook", { node, frame });
  }, COOK_PAUSE);
}

/** @param {string} text */
function sayControls(text) {
  const said = document.querySelector("#controls .said");
  if (said) said.textContent = text;
}

function drawControls() {
  const { asked: running, missing } = (app.wedge ?? app.base).verdict, { edits, undo, redo, conflict, saved } = app.graph;
  const button = (/** @type {string} */ text, /** @type {boolean} */ can, /** @type {string} */ deed, /** @type {any} */ given = {}) => {
    const made = /** @type {HTMLButtonElement} */ (element("button", { id: `do-${text.split(" ")[0]}`, onclick: () => edit(deed, given) }, text));
    made.disabled = !can;
    return made;
  };
  const controls = document.getElementById("controls"), shown = JSON.stringify([running || missing, edits, undo, redo, conflict, saved]);
  if (!controls || controls.dataset.shown === shown) return;
  controls.dataset.shown = shown;
  const stop = button("stop", running, "stop");
  stop.hidden = !running;
  drawInto(controls,
    stop, " ", button(running ? "run next" : `run ${missing ? `${missing} results` : ""}`, missing > 0, "run"),
    " ", button(`save ${edits.length || ""}`, edits.length > 0 && saved, "save"),
    " ", button("revert", edits.length > 0, "revert"),
    " ", button("undo", undo !== null, "undo"), " ", button("redo", redo !== null, "redo"),
    " ", element("button", { id: "do-save-as", title: "Ctrl-Shift-S", onclick: () => saveGraph(true) }, "save as"),
    controls.querySelector(".said") ?? element("span", { class: "said" }),
    ...(edits.length ? [element("details", { class: "edits" }, element("summary", {}, edits[edits.length - 1]), element("div", { class: "list" }, ...edits.map((/** @type {string} */ one) => element("p", {}, one))))] : []),
    ...(conflict ? [conflictBox(conflict)] : []),
  );
}

/** The lines in which the page and the file differ, and what to do. @param {string[]} lines */
function conflictBox(lines) {
  const choice = (/** @type {string} */ keep, /** @type {string} */ text) => element("button", { "data-keep": keep, onclick: () => edit("resolve", { keep }) }, text);
  const marked = lines.slice(2).map((line) => element("span", { class: line[0] === "-" ? "mine" : line[0] === "+" ? "theirs" : "" }, `${line}\n`));
  return element("div", { id: "conflict" }, element("b", {}, "Another program has changed the file (+) since these edits (-)."), element("pre", {}, ...marked),
    choice("page", "keep mine"), " ", choice("file", "take the file"), " ", choice("both", "repeat my edits in the file"));
}
