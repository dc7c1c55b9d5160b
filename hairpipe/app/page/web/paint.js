"use strict";
// A brush on a body: it paints the image that a setting reads, such as density or length. A stroke is an edit.

/** Texels of a side of a painted image. */
const PAINT_SIZE = 512;
/** Distance between two dabs, over the radius. */
const DAB_SPACING = 0.3;
/** Setting that scales the density of hair. */
const DENSITY = "density";

/** The brush; radius [m]. While one paints: the setting, the image on its body, and the stroke that is drawn.
 * @type {{radius: number, falloff: number, strength: number, value: number, mirror: boolean, node: string, target: string, source: string, texels: Texels | null,
 *   item: PaintedItem | null, stroke: {before: Uint8Array, cover: Float32Array, last: number[], value: number} | null, sending: number, sent: Promise<unknown>}} */
const brush = { radius: 0.025, falloff: 0.7, strength: 1, value: 0, mirror: false, node: "", target: "", source: "", texels: null, item: null, stroke: null, sending: 0, sent: Promise.resolve() };

/** Settings of a node that read a map or an image, by dotted name. @param {any} node @returns {string[]} */
function paintTargets(node) {
  return paintedWithin(node.type.settings, "");
}

/** @param {any[]} fields @param {string} above @returns {string[]} */
function paintedWithin(fields, above) {
  return fields.flatMap((field) => {
    const name = `${above}${field.name}`, inner = field.group.map((/** @type {any} */ one) => one.name);
    return inner.includes("map") && inner.includes("image") ? [name] : paintedWithin(field.group, `${name}.`);
  });
}

/** Whether maps of the selected node can be painted: it depends on a body at rest. */
const canPaint = () => app.live && paintTargets(app.nodeNamed(app.node)).length > 0 && Boolean(upstream(app.node, "mesh", "Body"));

/** What a setting reads now: its map or image. @param {string} target @returns {{map?: string, image?: string}} */
function paintSource(target) {
  const value = target.split(".").reduce((/** @type {any} */ table, name) => table?.[name], app.nodeNamed(brush.node)?.settings);
  return { map: value?.map ?? undefined, image: value?.image ?? undefined };
}

/** Begin to paint a setting of the selected node. @param {string} target */
async function beginPainting(target) {
  const body = upstream(app.node, "mesh", "Body");
  if (!body) return;
  const found = await hairpipe.get(body), faces = await hairpipe.get(`${found.meta.faces}.faces`), uv = floatsOf(faces.arrays.uv);
  if (!uv) return void sayControls(document.body.dataset.refused = "the body has no texture coordinates to paint an image in; vertex maps are painted in the program that made its file");
  endPainting();
  viewer ??= new Viewer(/** @type {HTMLElement} */ (document.getElementById("stage")), () => {});
  const scene = /** @type {Scene} */ (viewer.scene), texels = new Texels(placesOf(found, [found.arrays.points.length / 3]), scene.facesOf(found.meta.faces, faces).rows, uv, PAINT_SIZE);
  const scalp = (await hairpipe.get(body.replace(/mesh$/, "maps"))).arrays.scalp;
  Object.assign(brush, { node: app.node, target, texels, item: paintedMesh(scene, texels, uv, scalp), source: "" });
  await takeSource(body);
  showPainting();
}

/** Take the image or map that the setting reads, unless it is the one that is shown. @param {string} body document of its mesh */
async function takeSource(body) {
  const { texels, item } = brush, source = paintSource(brush.target), density = paintSource(DENSITY), text = JSON.stringify([source, density]);
  if (!texels || text === brush.source) return;
  brush.source = text;
  const pixels = await sourceTexels(texels, body, source).catch(() => null), grown = brush.target === DENSITY ? null : await sourceTexels(texels, body, density).catch(() => new Uint8Array(PAINT_SIZE ** 2).fill(255));
  if (brush.source !== text || brush.texels !== texels || brush.stroke) return; // another one, meanwhile
  if (!pixels) return leavePainting(), void sayControls(document.body.dataset.refused = `${source.image} cannot be shown: browsers read PNG, JPEG and WebP`);
  texels.values = pixels;
  item?.update(grown);
  viewer?.redraw();
}

/** Values of a map or image, as large as painted ones; white for none. @param {Texels} texels @param {string} body document of its mesh @param {{map?: string, image?: string}} source */
async function sourceTexels(texels, body, { map, image }) {
  if (image) return pixelsOf(image);
  const values = new Uint8Array(PAINT_SIZE ** 2).fill(255), vertices = map && (await hairpipe.get(body.replace(/mesh$/, "maps"))).arrays[map];
  if (vertices) texels.takeMap(vertices, values);
  return values;
}

/** Values of an image from 0 to 255, as large as painted ones; rejects for one that no browser reads. @param {string} path @returns {Promise<Uint8Array<ArrayBuffer>>} */
async function pixelsOf(path) {
  const image = new Image();
  image.src = `files?path=${encodeURIComponent(path)}`;
  await image.decode();
  const canvas = new OffscreenCanvas(PAINT_SIZE, PAINT_SIZE), ink = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d"));
  ink.drawImage(image, 0, 0, PAINT_SIZE, PAINT_SIZE);
  const { data } = ink.getImageData(0, 0, PAINT_SIZE, PAINT_SIZE);
  return Uint8Array.from({ length: PAINT_SIZE ** 2 }, (_, i) => Math.round(0.299 * data[4 * i] + 0.587 * data[4 * i + 1] + 0.114 * data[4 * i + 2]));
}

/** Show the painted body in place of what the node made. */
function showPainting() {
  const { item } = brush, stage = /** @type {HTMLElement} */ (document.getElementById("stage"));
  if (!viewer || !item) return;
  stage.classList.add("solid");
  viewer.turn++;
  viewer.take([item], []);
  viewer.mark(null);
  document.getElementById("picked")?.remove();
  viewer.legend.replaceChildren();
  if (viewer.framed !== `paint ${brush.node}`) viewer.camera.frame(item.low, item.high);
  viewer.framed = `paint ${brush.node}`;
  const shared = Math.round(100 * (brush.texels?.overlap ?? 0)), overlap = shared ? `; ${shared} % of its texture coordinates overlap, where paint shows in several places` : "";
  viewer.note.textContent = `drag on the body to paint, with Ctrl to paint the opposite; drag beside it to turn, right drag to move; [ and ] change the radius; hair grows within the white line${overlap}`;
  if (!document.getElementById("brush")) stage.append(brushTools());
  viewer.redraw();
}

function endPainting() {
  if (!brush.texels) return;
  viewer?.take(viewer.items.filter((item) => item !== brush.item), []);
  document.getElementById("brush")?.remove();
  document.getElementById("ring")?.remove();
  Object.assign(brush, { node: "", target: "", texels: null, item: null, stroke: null });
  if (viewer) viewer.framed = "";
}

/** Setting, value, radius, falloff, strength and mirror. @returns {HTMLElement} */
function brushTools() {
  const slider = (/** @type {"value" | "radius" | "falloff" | "strength"} */ name, /** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ scale, /** @type {string} */ unit, /** @type {string} */ title) => {
    const shown = element("output", {}, `${Number((scale * brush[name]).toPrecision(2))}${unit}`);
    const input = /** @type {HTMLInputElement} */ (element("input", { type: "range", id: `brush-${name}`, min: low, max: high, step: (high - low) / 100, value: brush[name] }));
    input.addEventListener("input", () => (brush[name] = Number(input.value), shown.textContent = `${Number((scale * brush[name]).toPrecision(2))}${unit}`));
    return element("label", { title }, name, input, shown);
  };
  const choice = element("select", { "aria-label": "painted setting", onchange: (/** @type {Event} */ event) => void beginPainting(/** @type {HTMLSelectElement} */ (event.target).value) },
    ...paintTargets(app.nodeNamed(brush.node)).map((name) => element("option", { value: name, ...(name === brush.target && { selected: "" }) }, name)));
  const mirror = element("input", { type: "checkbox", ...(brush.mirror && { checked: "" }), onchange: (/** @type {Event} */ event) => (brush.mirror = /** @type {HTMLInputElement} */ (event.target).checked) });
  return element("div", { id: "brush" }, choice, slider("value", 0, 1, 1, "", "0: the value `low` of the setting, 1: its value"), slider("radius", 0.002, 0.1, 1000, " mm", "radius on the skin"),
    slider("falloff", 0, 1, 1, "", "share of the radius over which a dab fades"), slider("strength", 0.02, 1, 1, "", "share of the value that one stroke paints"),
    element("label", { title: "paint the other side as well: x is mirrored" }, mirror, "mirror"), element("button", { title: "Escape", onclick: leavePainting }, "done"));
}

function togglePainting() {
  if (brush.texels) leavePainting();
  else void beginPainting(paintTargets(app.nodeNamed(app.node))[0]);
}

function leavePainting() {
  endPainting();
  void showStage();
}

/** Place of a pointer on the painted body, or null. @param {PointerEvent} event @param {number} [x] @param {number} [y] of the page */
function brushHit(event, x = event.clientX, y = event.clientY) {
  const { canvas, camera } = /** @type {Viewer} */ (viewer), frame = canvas.getBoundingClientRect(), texels = /** @type {Texels} */ (brush.texels);
  return hitOf(rayAt(camera, x - frame.left, y - frame.top, frame.width, frame.height), texels.places, texels.triangles);
}

/** Radius of the brush in the picture [px]. @param {Hit} hit */
function ringRadius(hit) {
  const { canvas, camera } = /** @type {Viewer} */ (viewer);
  return (brush.radius * canvas.clientHeight) / (2 * Math.tan(camera.fov / 2) * hit.distance);
}

/** Dabs from the last place of a stroke to the pointer. @param {PointerEvent} event */
function dabTo(event) {
  const { stroke, texels, item } = brush;
  if (!stroke || !texels) return;
  const [fx, fy] = stroke.last, here = brushHit(event), step = here ? Math.max(2, DAB_SPACING * ringRadius(here)) : 4;
  const count = Math.max(1, Math.min(64, Math.ceil(Math.hypot(event.clientX - fx, event.clientY - fy) / step)));
  for (let k = 1; k <= count; k++) {
    const hit = brushHit(event, fx + ((event.clientX - fx) * k) / count, fy + ((event.clientY - fy) * k) / count);
    if (!hit) continue;
    texels.dab(stroke.cover, hit.place, hit.normal, brush);
    const flipped = (/** @type {number[]} */ [x, y, z]) => [-x, y, z];
    if (brush.mirror) texels.dab(stroke.cover, flipped(hit.place), flipped(hit.normal), brush);
  }
  stroke.last = [event.clientX, event.clientY];
  texels.paint(stroke.before, stroke.cover, Math.round(255 * stroke.value));
  item?.update();
  viewer?.redraw();
}

/** Send the image: the server writes it next to the graph, and the setting reads it. */
function endStroke() {
  const { texels, node, target } = brush;
  if (!texels) return;
  let text = "";
  for (let at = 0; at < texels.values.length; at += 8192) text += String.fromCharCode(...texels.values.subarray(at, at + 8192));
  Object.assign(brush, { stroke: null, source: "" });
  brush.sending++;
  brush.sent = brush.sent.then(async () => {
    await edit("stroke", { target: `${node}.${target}`, height: PAINT_SIZE, values: btoa(text) }).catch((lost) => fault(String(lost)));
    brush.sending--;
    void followPainting(); // its graph may have come before its answer
  });
}

/** Take the image that the graph names, unless a stroke is drawn or sent, or the graph is older than the last answer. */
async function followPainting() {
  const ahead = brush.stroke || brush.sending || app.graph.revision < app.answered;
  const body = brush.texels && !ahead && upstream(brush.node, "mesh", "Body");
  if (body) await takeSource(body);
}

/** A circle where the brush would paint. @param {PointerEvent} event */
function drawRing(event) {
  const stage = /** @type {HTMLElement} */ (document.getElementById("stage")), frame = stage.getBoundingClientRect(), hit = brushHit(event);
  const ring = document.getElementById("ring") ?? stage.appendChild(element("div", { id: "ring" })), radius = hit ? ringRadius(hit) : 0;
  ring.style.cssText = `left:${event.clientX - frame.left - radius}px;top:${event.clientY - frame.top - radius}px;width:${2 * radius}px;height:${2 * radius}px;${hit ? "" : "display:none"}`;
}

/** Strokes begin on the body; what begins beside it is for the camera. */
function listenToBrush() {
  const stage = /** @type {HTMLElement} */ (document.getElementById("stage"));
  const isOurs = (/** @type {PointerEvent} */ event) => Boolean(brush.texels) && event.target === viewer?.canvas;
  stage.addEventListener("pointerdown", (event) => {
    if (!isOurs(event) || event.button !== 0 || event.shiftKey || !brushHit(event)) return;
    event.stopPropagation();
    viewer?.canvas.setPointerCapture(event.pointerId);
    const { values, covered } = /** @type {Texels} */ (brush.texels);
    brush.stroke = { before: values.slice(), cover: new Float32Array(covered.length), last: [event.clientX, event.clientY], value: event.ctrlKey ? 1 - brush.value : brush.value };
    dabTo(event);
  }, true);
  stage.addEventListener("pointermove", (event) => {
    if (!isOurs(event)) return;
    drawRing(event);
    if (!brush.stroke) return;
    event.stopPropagation();
    dabTo(event);
  }, true);
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) => {
    if (!brush.stroke) return;
    event.stopPropagation();
    endStroke();
  }, true);
  document.addEventListener("keydown", (event) => {
    if (!brush.texels || (event.target instanceof HTMLElement && event.target.matches("input:not([type=range]), textarea"))) return;
    if (event.key === "Escape") leavePainting();
    const factor = event.key === "[" ? 0.8 : event.key === "]" ? 1.25 : 1, slider = /** @type {HTMLInputElement | null} */ (document.getElementById("brush-radius"));
    if (factor === 1 || !slider) return;
    slider.value = String(brush.radius * factor);
    slider.dispatchEvent(new Event("input"));
  });
}

app.on(["graph"], () => void followPainting());
