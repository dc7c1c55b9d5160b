"use strict";
// What the selected node made: chosen among its outputs, shown in the way that its type has.

/** @type {Viewer | null} */
let viewer = null;
/** Numbers of strands to choose among, the last for all, and the name by which the browser keeps the choice. */
const STRANDS_SHOWN = [4000, 20000, 100000, 10000000], STRANDS_KEPT = "hairpipe strands";
/** Elements of the viewport, which stay. */
const LASTING = ["view", "note", "legend", "knife", "picked", "brush", "ring", "backdrop"];
/** Backgrounds of the viewport, in either theme, and the name by which the browser keeps the choice. */
const BACKDROPS = ["dark", "grey", "light"], BACKDROP_KEPT = "hairpipe backdrop";

/** Give the viewport a background, and a button for the next one. @param {string} name */
function takeBackdrop(name) {
  const stage = /** @type {HTMLElement} */ (document.getElementById("stage")), at = Math.max(0, BACKDROPS.indexOf(name));
  stage.dataset.backdrop = BACKDROPS[at];
  document.getElementById("backdrop")?.remove();
  stage.append(element("button", { id: "backdrop", title: `background of the viewport: ${BACKDROPS.join(", ")}`, onclick: () => takeBackdrop(BACKDROPS[(at + 1) % BACKDROPS.length]) }, "◐"));
  keepItem(BACKDROP_KEPT, BACKDROPS[at]);
  viewer?.redraw();
}

async function showStage() {
  const stage = /** @type {HTMLElement} */ (document.getElementById("stage"));
  drawChoices();
  document.getElementById("stale")?.remove();
  stage.classList.remove("stale");
  if (!app.graph.nodes.length) return offerTemplates(stage);
  document.getElementById("templates")?.remove();
  if (!app.nodeNamed(app.node)) return;
  if (player.stop && player.node === app.node) return;
  if (brush.texels && brush.node === app.node) return showPainting();
  endPainting();
  const fresh = isShown(), stale = fresh ? null : staleResult(), now = fresh ? layersOf(app.node, app.output) : [];
  const past = stale ? { layers: layersAt(stale, app.node, app.output), label: "" } : comparison(), three = now.length ? now : stale ? past.layers : [];
  if (fresh) app.last.set(lastName(), { graph: app.graph, state: app.state, frame: app.frame });
  [...stage.children].forEach((child) => LASTING.includes(child.id) || child.remove());
  stage.classList.toggle("solid", three.length > 0);
  stage.classList.toggle("stale", stale !== null);
  if (stale) stage.append(element("div", { id: "stale", title: "the result that was shown last stays until there is a new one" }, staleText(stale)));
  try {
    if (three.length) {
      viewer ??= new Viewer(stage, () => stage.append(element("p", { class: "none" }, "no WebGL2 in this browser: strands and meshes cannot be drawn, pictures can")));
      await viewer.show(now, past.layers, past.label);
      const slices = withResult(stale ?? app, () => app.document(app.node, app.output, "slices"));
      if (slices) await showSlices(stage, slices);
    } else if (!withResult(stale ?? app, () => showPictures(stage))) {
      const name = withResult(stale ?? app, documentShown);
      if (!name) stage.append(element("p", { class: "none" }, nothingText()));
      else if (name.endsWith(".table")) await showTable(stage, name);
      else if (name.endsWith(".slices")) await showSlices(stage, name);
      else stage.append(element("div", { class: "table" }, sortable({ names: ["value", "kind", "from ... to"], rows: (await hairpipe.plain(name)).lines })));
    }
  } catch (fault) {
    stage.append(element("p", { class: "none" }, fault instanceof Error ? fault.message : String(fault)));
  }
}

/** Name of the first document of the selected output that there is. @returns {string | undefined} */
function documentShown() {
  const kinds = app.nodeNamed(app.node)?.kinds[app.output] ?? [];
  return kinds.map((/** @type {string} */ kind) => app.document(app.node, app.output, kind)).find(Boolean);
}

/** Whether there is something to show of the selected output. */
const isShown = () => Boolean(pictureOf(app.node, app.output) ?? documentShown());

/** What stays in view of an output without a result at this frame: that of before the edit, else what was shown last, else the nearest frame.
 * @returns {Result | null} */
function staleResult() {
  const { graph, state, frame } = app, computed = (state.nodes[app.node]?.cells ?? []).filter((/** @type {Cell} */ cell) => cell.outputs);
  const away = (/** @type {Cell} */ cell) => Math.abs(Number(cell.frame) - frame), nearest = computed.sort((/** @type {Cell} */ a, /** @type {Cell} */ b) => away(a) - away(b))[0];
  const choices = [pastResult(app.node), app.last.get(lastName()), nearest && { graph, state, frame: Number(nearest.frame) }];
  return choices.find((one) => one && withResult(one, isShown)) ?? null;
}

/** Name of the selected output of the selected variant. */
const lastName = () => `${variantName()} ${app.node}.${app.output}`;

/** Why a result is stale. @param {Result} stale */
function staleText({ state, frame }) {
  const outputs = (/** @type {any} */ { nodes }) => JSON.stringify(cellOf(nodes, app.node, frame)?.outputs);
  return `stale: ${[frame !== app.frame && `frame ${frame}`, outputs(state) !== outputs(app.state) && "before the edit"].filter(Boolean).join(", ")}`;
}

/** Why nothing is shown. */
function nothingText() {
  const cell = app.cell(app.node);
  if (!cell?.outputs) return cellText(app.node, app.frame);
  const type = app.nodeNamed(app.node).type.outputs[app.output];
  if (type === "File") return `a file of ${sizeText(cell.bytes ?? 0)}, which a browser cannot show`;
  return app.live ? "this output was not kept" : "this output is not part of the report at this frame; `hairpipe view` shows it";
}

/** Buttons for the outputs of the node, and for the colour of strands. */
function drawChoices() {
  const node = app.nodeNamed(app.node);
  if (!node) return void document.getElementById("choices")?.replaceChildren();
  const outputs = Object.entries(node.type.outputs);
  const button = (/** @type {string} */ text, /** @type {boolean} */ on, /** @type {Record<string, any>} */ changes) =>
    element("button", { class: on ? "on" : "", onclick: () => app.set(changes) }, text);
  const strands = node.kinds[app.output]?.includes("strands"), other = strands && otherStrands();
  drawInto(document.getElementById("choices"),
    ...(outputs.length > 1 ? outputs.map(([name, type]) => button(name || String(type), name === app.output, { output: name })) : []),
    ...(strands && app.graph.playable?.includes(app.node)
      ? [element("button", { id: "live", class: player.stop ? "on" : "", title: "simulate it now, with the settings as they are", onclick: togglePlaying }, player.stop ? "stop playing" : "play live")] : []),
    ...(canPaint() ? [element("button", { id: "paint", class: brush.texels ? "on" : "", title: "paint maps of the body that settings of this node read", onclick: togglePainting }, "paint")] : []),
    ...(strands && app.live ? [strandsChoice()] : []),
    ...(strands ? [pinButton()] : []),
    ...(other ? [button("side by side", app.apart, { apart: !app.apart })] : []),
    ...(strands ? [element("small", {}, "colour"), ...[...CHANNELS, ...(other ? [DIFFERENCE] : []), ...measuredOf(valueDocuments(app.node, app.output)).keys()].map((channel) => button(channel, channel === app.channel, { channel }))] : []),
  );
}

/** A list of how many strands are shown, which the browser keeps. @returns {HTMLElement} */
function strandsChoice() {
  const menu = /** @type {HTMLSelectElement} */ (element("select", { id: "strands", "aria-label": "strands shown", title: "largest number of strands that are shown" },
    ...STRANDS_SHOWN.map((count) => element("option", { value: count, ...(count === app.strands && { selected: "" }) }, count === STRANDS_SHOWN.at(-1) ? "all strands" : `up to ${count.toLocaleString("en")}`))));
  menu.addEventListener("change", () => {
    keepItem(STRANDS_KEPT, menu.value);
    menu.blur();
    app.set({ strands: Number(menu.value) });
  });
  return menu;
}

/** What the selected output is compared with: what is kept, if it can be drawn, else, if that is asked for, what was before an edit.
 * @returns {{layers: Layer[], label: string}} */
function comparison() {
  const pinned = pinnedResult(), kept = pinned ? layersAt(pinned, pinned.node, pinned.output) : [];
  if (kept.length) return { layers: kept, label: comparisonLabel(pinned) };
  return { layers: app.compare ? pastLayers(app.node, app.output) : [], label: comparisonLabel(null) };
}

/** Document of the strands that the selected ones are compared with, or null. @returns {string | null} */
function otherStrands() {
  return comparison().layers.find((layer) => layer.kind === "strands")?.name ?? null;
}

/** Call a function with other results in place of those that are selected. @template T @param {Result} given @param {() => T} look @returns {T} */
function withResult({ graph, state, frame }, look) {
  const own = { graph: app.graph, state: app.state, frame: app.frame };
  Object.assign(app, { graph, state, frame });
  try {
    return look();
  } finally {
    Object.assign(app, own);
  }
}

/** What is drawn for an output with other results. @param {Result} given @param {string} node @param {string} output @returns {Layer[]} */
const layersAt = (given, node, output) => withResult(given, () => layersOf(node, output));

/** Results before the last edit that changed those of a node; null without any. @param {string} node @returns {Result | null} */
function pastResult(node) {
  if (!app.past.has(`${node}@${app.frame}`) && !app.past.has(`${node}@`)) return null;
  const state = app.state, nodes = { ...state.nodes };
  for (const [key, cell] of app.past) {
    const [name, frame] = key.split("@");
    if (nodes[name] && (frame === "" || Number(frame) === app.frame)) nodes[name] = { cells: [cell] };
  }
  return { graph: app.graph, state: { ...state, nodes }, frame: app.frame };
}

/** What was drawn for an output before the last edit that changed it. @param {string} node @param {string} output @returns {Layer[]} */
function pastLayers(node, output) {
  const past = pastResult(node);
  return past ? layersAt(past, node, output) : [];
}

app.on(["strands", "node", "output", "frame", "channel", "pinned", "state", "compare", "apart"], () => app.graph && (app.showing = showStage()));
