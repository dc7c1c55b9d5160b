"use strict";
// Strands, meshes and particles of the selected output, on the body that they follow.

/** Largest size of what is kept on the graphics card to be shown again [bytes]. */
const MOST_KEPT = 512e6;

class Viewer {
  /** @param {HTMLElement} stage @param {() => void} failed */
  constructor(stage, failed) {
    this.canvas = /** @type {HTMLCanvasElement} */ (element("canvas", { id: "view" }));
    this.note = element("div", { id: "note" });
    this.legend = element("div", { id: "legend" });
    this.camera = new Camera();
    /** @type {Item[]} */ this.items = [];
    /** What was drawn, the latest last: frames that are shown again are not uploaded again. @type {Map<string, Item>} */ this.kept = new Map();
    /** The picked strand. @type {Item | null} */ this.marked = null;
    this.framed = "";
    this.turn = 0;
    const gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    this.scene = gl && new Scene(gl);
    this.knife = /** @type {HTMLInputElement} */ (element("input", { id: "knife", type: "range", min: 0, max: 1000, value: 500, hidden: "", title: "what is compared | what is selected", oninput: () => this.redraw() }));
    /** Items of what is compared, or of before the last edit. @type {Item[]} */ this.ghost = [];
    stage.append(this.canvas, this.note, this.legend, this.knife);
    this.camera.listen(this.canvas, () => this.redraw(), (x, y) => app.set({ picked: this.pick(x, y) }));
    this.canvas.addEventListener("dblclick", () => this.frameAll());
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
    if (!gl) failed();
  }

  /** Show the documents of an output at the selected frame, and others: alone as what was before an edit, or behind a slider with a label.
   * @param {Layer[]} layers @param {Layer[]} past @param {string} label */
  async show(layers, past, label) {
    const turn = ++this.turn, scene = this.scene;
    if (!scene) return;
    const range = await rangeOf([...layers, ...past], app.channel);
    const loaded = await Promise.all([layers, past].map((some) => Promise.all(some.map((layer) => this.load(layer, range, some === past)))));
    if (turn !== this.turn) return;
    this.take(loaded[0], loaded[1]);
    const made = layers.length ? this.items : this.ghost;
    const first = made[made.length - 1];
    if (first && this.framed !== app.node) {
      const box = made.find((item) => item.lengths) ?? first;
      this.camera.frame(box.low, box.high);
      this.framed = app.node;
    }
    this.note.textContent = [layers.length && past.length ? label : "", ...made.map((item) => item.note)].filter(Boolean).join(", ");
    document.body.dataset.ghost = String(past.length && !layers.length ? 1 : past.length ? 2 : 0);
    void drawPicked();
    this.redraw();
  }

  /** Look at all that is drawn. */
  frameAll() {
    const shown = this.items.length ? this.items : this.ghost;
    if (!shown.length) return;
    const ends = (/** @type {"low" | "high"} */ end, /** @type {(...values: number[]) => number} */ most) => [0, 1, 2].map((k) => most(...shown.map((item) => item[end][k])));
    this.camera.frame(ends("low", Math.min), ends("high", Math.max));
    this.redraw();
  }

  /** Draw items in place of others, and free what was not drawn for long. @param {Item[]} items @param {Item[]} ghost */
  take(items, ghost) {
    const kept = new Set(this.kept.values()), drawn = new Set([...items, ...ghost]);
    [...this.items, ...this.ghost].forEach((item) => kept.has(item) || drawn.has(item) || item.free());
    [this.items, this.ghost] = [items, ghost];
    const both = items.length > 0 && ghost.length > 0;
    this.knife.hidden = !both || app.apart;
    this.canvas.parentElement?.classList.toggle("apart", both && app.apart);
    let bytes = [...kept].reduce((all, item) => all + item.bytes, 0);
    for (const [key, item] of this.kept) {
      if (bytes <= MOST_KEPT) break;
      if (drawn.has(item)) continue;
      this.kept.delete(key);
      bytes -= item.bytes;
      item.free();
    }
  }

  /** Highlight a strand, or none. @param {Picked | null} picked */
  mark(picked) {
    this.marked?.free();
    const codes = picked?.item.codes?.slice(3 * picked.start, 3 * (picked.start + picked.count)), meta = { total: 1, diameter: 0, ...picked?.item.grid };
    this.marked = codes && this.scene ? this.scene.strands({ meta, arrays: { lengths: Uint16Array.of(codes.length / 3) }, codes }, "marked", null, null, 3) : null;
    this.redraw();
  }

  /** Show strands that were just made, on a body. @param {Unpacked} found @param {string | null} body */
  async showPlayed(found, body) {
    const turn = ++this.turn, made = body ? [await this.load({ name: body, kind: "mesh", rest: null, values: [] })] : [];
    if (turn !== this.turn) return;
    this.take([...made, /** @type {Scene} */ (this.scene).strands(found, app.channel, null)], []);
    void drawPicked();
    this.redraw();
  }

  /** Get what a layer shows, as it was kept, or made. @param {Layer} layer @param {number[] | null} [range] of all values by which it is coloured
   * @param {boolean} [past] whether others are compared with it @returns {Promise<Item>} */
  async load(layer, range = null, past = false) {
    const { name, kind } = layer, scene = /** @type {Scene} */ (this.scene), found = await hairpipe.get(name);
    if (kind === "strands") return this.loadStrands(layer, found, range, past);
    const faces = kind === "points" ? null : await hairpipe.get(`${found.meta.faces}.faces`);
    return this.keep([name, kind].join(), () => (faces ? scene.mesh(found, faces, kind) : scene.points(found)));
  }

  /** @param {string} key @param {() => Item} make @returns {Item} */
  keep(key, make) {
    const found = this.kept.get(key) ?? make();
    this.kept.delete(key);
    this.kept.set(key, found);
    return found;
  }

  /** @param {Layer} layer @param {Unpacked} found @param {number[] | null} range @param {boolean} past @returns {Promise<Item>} */
  async loadStrands(layer, found, range, past) {
    const { name, rest } = layer, base = rest && app.channel === "stretch" ? await hairpipe.get(rest) : null;
    const values = await valuesOf(layer, app.channel), source = measuredOf(layer.values).get(app.channel);
    const differs = app.channel === DIFFERENCE, other = differs && !past ? otherStrands() : null, difference = other ? differencesOf(found, await hairpipe.get(other)) : null;
    const legend = legendOf(app.channel, difference ? [0, 1e3 * difference.most] : range);
    drawChoices();
    if (!past) this.legend.replaceChildren(...(legend ? [legend[0], element("i", {}), legend[1]] : other ? ["the compared strands have other points"] : []));
    const measured = difference?.values ?? (values && range ? valuesWithin(values, range) : null);
    const channel = differs && !measured ? CHANNELS[0] : app.channel, key = [name, channel, other, base && rest, source?.name, source?.place, range].join();
    return this.keep(key, () => ({ .../** @type {Scene} */ (this.scene).strands(found, channel, base && placesIn(base), measured), document: name, rest }));
  }

  redraw() {
    if (this.pending || !this.scene) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      const ratio = Math.min(2, window.devicePixelRatio || 1), { canvas } = this;
      const [wide, high] = [canvas.clientWidth, canvas.clientHeight].map((v) => Math.max(1, Math.floor(v * ratio)));
      if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high]; // makes the picture anew
      const { items, ghost } = this;
      this.scene?.draw(items, this.camera, ghost, ghost.length && items.length ? (app.apart ? 0.5 : Number(this.knife.value) / 1000) : 1, this.marked, app.apart);
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    });
  }

  /** Find the strand that is seen at a place, in front of meshes; null for none. @param {number} x @param {number} y */
  pick(x, y) {
    const hair = this.items.find((one) => one.lengths), { camera } = this;
    if (!hair?.places || !hair.lengths) return null;
    const { clientWidth, clientHeight: height } = this.canvas, half = app.apart && this.ghost.length ? clientWidth / 2 : 0, width = clientWidth - half;
    if (x < half) return null;
    x -= half;
    const ray = rayAt(camera, x, y, width, height), { back } = camera.axes();
    const hits = this.items.map((one) => (one.triangles && one.places ? hitOf(ray, one.places, one.triangles)?.distance ?? Infinity : Infinity));
    const deepest = Math.min(...hits) * -(ray.way[0] * back[0] + ray.way[1] * back[1] + ray.way[2] * back[2]);
    const chosen = nearestStrand({ places: hair.places, lengths: hair.lengths }, camera.matrix(width / height), x, y, width, height, deepest);
    return chosen < 0 ? null : { node: app.node, strand: hair.strands ? hair.strands[chosen] : chosen };
  }
}

/** @typedef {{name: string, kind: string, rest: string | null, values: string[]}} Layer */

/** What is drawn for an output, the body first. @param {string} node @param {string} output @returns {Layer[]} */
function layersOf(node, output) {
  /** @type {Layer[]} */
  const layers = [];
  const own = ["strands", "mesh", "points", "surface"].find((kind) => app.document(node, output, kind));
  if (!own) return layers;
  if (own === "strands" || own === "points") {
    const body = upstream(node, "mesh");
    if (body) layers.push({ name: body, kind: "mesh", rest: null, values: [] });
  }
  const rest = own === "strands" ? upstream(node, "strands", "Groom") : null;
  layers.push({ name: /** @type {string} */ (app.document(node, output, own)), kind: own, rest, values: own === "strands" ? valueDocuments(node, output) : [] });
  return layers;
}

/** The nearest document of a kind, and of a type, that a node depends on at a frame.
 * @param {string} node @param {string} kind @param {string} [type] @returns {string | null} */
function upstream(node, kind, type, frame = app.frame) {
  const queue = [node], seen = new Set(queue);
  while (queue.length) {
    for (const edge of app.nodeNamed(/** @type {string} */ (queue.shift())).edges) {
      const fits = !type || app.nodeNamed(edge.node).type.outputs[edge.output] === type;
      const found = fits && app.document(edge.node, edge.output, kind, frame);
      if (found) return found;
      if (!seen.has(edge.node)) seen.add(edge.node), queue.push(edge.node);
    }
  }
  return null;
}
