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
  if (!app.graph.nodes.length) return offerTemplates(stage);
  document.getElementById("templates")?.remove();
  if (!app.nodeNamed(app.node)) return;
  if (player.stop && player.node === app.node) return;
  if (brush.texels && brush.node === app.node) return showPainting();
  endPainting();
  const now = layersOf(app.node, app.output), past = now.length ? comparison() : { layers: pastLayers(app.node, app.output), label: "" }, three = now.length ? now : past.layers;
  [...stage.children].forEach((child) => LASTING.includes(child.id) || child.remove());
  stage.classList.toggle("solid", three.length > 0);
  try {
    if (three.length) {
      viewer ??= new Viewer(stage, () => stage.append(element("p", { class: "none" }, "no WebGL2 in this browser: strands and meshes cannot be drawn, pictures can")));
      await viewer.show(now, past.layers, past.label);
      const slices = app.document(app.node, app.output, "slices");
      if (slices) await showSlices(stage, slices);
    } else if (!showPictures(stage)) {
      const kinds = app.nodeNamed(app.node).kinds[app.output] ?? [];
      const name = kinds.map((/** @type {string} */ kind) => app.document(app.node, app.output, kind)).find(Boolean);
      if (!name) stage.append(element("p", { class: "none" }, nothingText()));
      else if (name.endsWith(".table")) await showTable(stage, name);
      else if (name.endsWith(".slices")) await showSlices(stage, name);
      else stage.append(element("div", { class: "table" }, sortable({ names: ["value", "kind", "from ... to"], rows: (await hairpipe.plain(name)).lines })));
    }
  } catch (fault) {
    stage.append(element("p", { class: "none" }, fault instanceof Error ? fault.message : String(fault)));
  }
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
  document.getElementById("choices")?.replaceChildren(
    ...(outputs.length > 1 ? outputs.map(([name, type]) => button(name || String(type), name === app.output, { output: name })) : []),
    ...(strands && app.graph.playable?.includes(app.node)
      ? [element("button", { id: "live", class: player.stop ? "on" : "", title: "simulate it now, with the settings as they are", onclick: togglePlaying }, player.stop ? "stop playing" : "play live")] : []),
    ...(canPaint() ? [element("button", { id: "paint", class: brush.texels ? "on" : "", title: "paint maps of the body that settings of this node read", onclick: () => (brush.texels ? leavePainting() : void beginPainting(paintTargets(node)[0])) }, "paint")] : []),
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

/** What is drawn for an output of another graph, with other results, or at another frame.
 * @param {{graph: any, state: any, frame: number}} given @param {string} node @param {string} output @returns {Layer[]} */
function layersAt({ graph, state, frame }, node, output) {
  const own = { graph: app.graph, state: app.state, frame: app.frame };
  Object.assign(app, { graph, state, frame });
  try {
    return layersOf(node, output);
  } finally {
    Object.assign(app, own);
  }
}

/** What was drawn for an output before the last edit that changed it. @param {string} node @param {string} output @returns {Layer[]} */
function pastLayers(node, output) {
  const own = app.past.get(`${node}@${app.frame}`) ?? app.past.get(`${node}@`);
  if (!own) return [];
  const state = app.state, nodes = { ...state.nodes };
  for (const [key, cell] of app.past) {
    const [name, frame] = key.split("@");
    if (nodes[name] && (frame === "" || Number(frame) === app.frame)) nodes[name] = { cells: [cell] };
  }
  return layersAt({ graph: app.graph, state: { ...state, nodes }, frame: app.frame }, node, output);
}

app.on(["strands", "node", "output", "frame", "channel", "pinned", "state", "compare", "apart"], () => app.graph && (app.showing = showStage()));
