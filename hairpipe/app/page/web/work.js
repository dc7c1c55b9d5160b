"use strict";
// Long work: runs that are active and wait, the time that each node still takes, memory and disk, and word of the end.

/** Latest results of which a median is what one takes. */
const RECENT_RESULTS = 15;
/** Free space of the disk, and free memory, that are too little [bytes]. */
const LITTLE_DISK = 5e9, LITTLE_MEMORY = 1e9;

/** @typedef {{node: string, done: number, total: number, left: number | null, scan: boolean, bytes: number}} Work */

/** Number of the last run that was seen to end, -1 before the first look; a run that takes longer than `long` [s] is worth a notification. */
const runs = { ended: -1, timer: 0, asked: false, long: 20 };

/** @param {number[]} values */
const medianOf = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

/** What is missing, node by node: as its latest results took, else as recorded before the edit.
 * @param {Record<string, {cells: Cell[]}>} nodes @param {any[]} types of the nodes of the graph @param {Record<string, number>} costs @returns {Work[]} */
function workOf(nodes, types, costs) {
  return types.flatMap(({ name, type }) => {
    const cells = nodes[name]?.cells ?? [], made = cells.filter((cell) => cell.outputs), missing = cells.filter((cell) => !cell.outputs && cell.state !== "failed" && cell.state !== "blocked");
    if (!missing.length) return [];
    const known = made.map((cell) => cell.seconds ?? 0).slice(-RECENT_RESULTS), each = known.length > 1 ? medianOf(known) : costs[name] ?? known[0];
    const bytes = made.length ? medianOf(made.map((cell) => cell.bytes ?? 0)) : 0;
    const running = type.mode === "each" ? Math.max(1, missing.filter((cell) => cell.state === "running").length) : 1;
    return [{ node: name, done: cells.length - missing.length, total: cells.length, scan: type.mode === "scan", bytes: bytes * missing.length, left: each === undefined ? null : (each * missing.length) / running }];
  });
}

/** The runs, and what they still take. */
function drawWork() {
  const { queue = [], asked, costs = {}, machine } = (app.wedge ?? app.base).verdict, line = document.getElementById("work");
  if (!line || !app.live) return;
  const work = workOf(app.base.nodes, app.graph.nodes, costs), bytes = work.reduce((all, one) => all + one.bytes, 0);
  const parts = asked ? [...runParts(queue, work), ...askingParts()] : [];
  const little = machine && (machine.disk < LITTLE_DISK || machine.disk < bytes);
  const need = little && bytes ? `, ${sizeText(bytes)} needed` : "";
  drawInto(line, ...parts, element("span", { class: "room" },
    ...(machine?.memory ? [element("span", { class: machine.memory < LITTLE_MEMORY ? "bad" : "", title: "memory of this machine that is free" }, `memory ${sizeText(machine.memory)} free`)] : []),
    ...(machine ? [element("span", { class: little ? "bad" : "", title: "free space of the disk of the cache" }, `disk ${sizeText(machine.disk)} free${need}`)] : [])));
}

/** @param {{number: number, label: string}[]} queue @param {Work[]} work @returns {HTMLElement[]} */
function runParts(queue, work) {
  const left = work.map((one) => one.left), since = (app.wedge ?? app.base).verdict.since;
  const whole = left.every((one) => one !== null) ? `${timeText(left.reduce((/** @type {number} */ all, one) => all + Number(one), 0))} left` : "time left unknown";
  return [element("b", {}, `${queue[0].label}: ${whole}, ${timeText(since)} so far`),
    ...work.map(({ node, done, total, left: own }) => element("a", { href: "#", class: "task", "data-task": node, title: "results of all, time left", onclick: (/** @type {Event} */ event) => (event.preventDefault(), selectNode(node)) },
      element("progress", { max: total, value: done }), `${node} ${done}/${total}${own === null ? "" : ` ${timeText(own)}`}`)),
    ...queue.slice(1).map(({ number, label }) => element("span", { class: "waiting", title: "waits for the runs before it" }, label, element("button", { class: "unset", "data-run": number, title: "take it from the queue", onclick: () => edit("drop", { number }) }, "×")))];
}

/** A button to be told of the end, where the browser has not let the page ask by itself. @returns {HTMLElement[]} */
function askingParts() {
  if (!runs.asked || !("Notification" in window) || Notification.permission !== "default") return [];
  return [element("button", { id: "notify", onclick: () => Notification.requestPermission().then(drawWork) }, "tell me at the end")];
}

/** Follow the runs: ask once for notifications when one is long, and tell of the end of such a one. */
function followRuns() {
  const { asked, since = 0, last } = (app.wedge ?? app.base).verdict;
  clearTimeout(runs.timer);
  if (asked && !runs.asked) runs.timer = window.setTimeout(askToNotify, Math.max(0, 1000 * (runs.long - since)));
  if (last && runs.ended >= 0 && last.number > runs.ended && last.took > runs.long && !last.interrupted) notifyOf(last);
  runs.ended = last?.number ?? runs.ended;
}

function askToNotify() {
  runs.asked = true;
  if ("Notification" in window && Notification.permission === "default") void Notification.requestPermission().then(drawWork, drawWork);
  drawWork();
}

/** @param {{label: string, took: number, failures: string[], computed?: number}} last */
function notifyOf({ label, took, failures, computed = 0 }) {
  if (!("Notification" in window) || Notification.permission !== "granted") return;
  const title = failures.length ? `${app.graph.name} failed` : `${app.graph.name} is computed`;
  const made = new Notification(title, { body: failures[0] ?? `${label}: ${computed.toLocaleString("en")} results in ${timeText(took)}`, tag: document.title });
  made.onclick = () => window.focus();
}

app.on(["state"], () => app.live && app.state && (followRuns(), drawWork()));
