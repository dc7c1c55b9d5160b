"use strict";
// Strands, meshes and particles of the selected output, on the body that they follow.

class Viewer {
  /** @param {HTMLElement} stage @param {() => void} failed */
  constructor(stage, failed) {
    this.canvas = /** @type {HTMLCanvasElement} */ (element("canvas", { id: "view" }));
    this.note = element("div", { id: "note" });
    this.legend = element("div", { id: "legend" });
    this.camera = new Camera();
    /** @type {Item[]} */ this.items = [];
    this.framed = "";
    this.turn = 0;
    const gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    this.scene = gl && new Scene(gl);
    this.knife = /** @type {HTMLInputElement} */ (element("input", { id: "knife", type: "range", min: 0, max: 1000, value: 500, hidden: "", title: "before the edit | after it", oninput: () => this.redraw() }));
    /** Items of before the last edit. @type {Item[]} */ this.ghost = [];
    stage.append(this.canvas, this.note, this.legend, this.knife);
    this.camera.listen(this.canvas, () => this.redraw(), (x, y) => this.pick(x, y));
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
    if (!gl) failed();
  }

  /** Show the documents of an output at the selected frame, and those of before an edit: alone as a ghost, or behind a slider.
   * @param {Layer[]} layers @param {Layer[]} past */
  async show(layers, past) {
    const turn = ++this.turn, scene = this.scene;
    if (!scene) return;
    const loaded = await Promise.all([layers, past].map((some) => Promise.all(some.map((layer) => this.load(layer)))));
    if (turn !== this.turn) return void loaded.flat().forEach((item) => item.free());
    [...this.items, ...this.ghost].forEach((item) => item.free());
    [this.items, this.ghost] = loaded;
    const made = layers.length ? this.items : this.ghost;
    this.knife.hidden = !(layers.length && past.length);
    const first = made[made.length - 1];
    if (first && this.framed !== app.node) {
      const box = made.find((item) => item.places) ?? first;
      this.camera.frame(box.low, box.high);
      this.framed = app.node;
    }
    const before = layers.length ? (past.length ? "left: before the edit" : "") : "before the edit; a run shows the new result";
    this.note.textContent = [before, ...made.map((item) => item.note)].filter(Boolean).join(", ");
    document.body.dataset.ghost = String(past.length && !layers.length ? 1 : past.length ? 2 : 0);
    this.redraw();
  }

  /** Show strands that were just made, on a body. @param {Unpacked} found @param {string | null} body */
  async showPlayed(found, body) {
    const turn = ++this.turn, made = body ? [await this.load({ name: body, kind: "mesh", rest: null })] : [];
    made.push(/** @type {Scene} */ (this.scene).strands(found, app.channel, null));
    if (turn !== this.turn) return void made.forEach((item) => item.free());
    [...this.items, ...this.ghost].forEach((item) => item.free());
    [this.items, this.ghost] = [made, []];
    this.redraw();
  }

  /** @param {Layer} layer @returns {Promise<Item>} */
  async load({ name, kind, rest }) {
    const scene = /** @type {Scene} */ (this.scene), found = await hairpipe.get(name);
    if (kind === "points") return scene.points(found);
    if (kind !== "strands") return scene.mesh(found, await hairpipe.get(`${found.meta.faces}.faces`), kind);
    const base = rest && app.channel === "stretch" ? await hairpipe.get(rest) : null;
    await Promise.all(valueDocuments(app.node, app.output).map((/** @type {string} */ one) => hairpipe.get(one)));
    const source = measuredOf(app.node, app.output).get(app.channel), values = source && await hairpipe.get(source.name);
    const legend = legendOf(app.channel, found, values ? values.meta.ranges[source.place] : null);
    drawChoices();
    this.legend.replaceChildren(...(legend ? [legend[0], element("i", {}), legend[1]] : []));
    const measured = values ? runningSums(values.arrays[`values${source.place}`]) : null;
    return scene.strands(found, app.channel, base && placesOf(base, base.arrays.lengths), measured);
  }

  redraw() {
    if (this.pending || !this.scene) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      const ratio = Math.min(2, window.devicePixelRatio || 1), { canvas } = this;
      [canvas.width, canvas.height] = [Math.max(1, canvas.clientWidth * ratio), Math.max(1, canvas.clientHeight * ratio)];
      const { items, ghost } = this;
      this.scene?.draw(items, this.camera, ghost, ghost.length && items.length ? Number(this.knife.value) / 1000 : 1);
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
    });
  }

  /** Say which strand is nearest to a place in the picture. @param {number} x @param {number} y */
  pick(x, y) {
    const item = this.items.find((one) => one.lengths);
    if (!item?.places || !item.lengths) return;
    const { clientWidth: width, clientHeight: height } = this.canvas, m = this.camera.matrix(width / height);
    let [best, chosen, point] = [Infinity, -1, 0];
    for (let s = 0; s < item.lengths.length; s++) {
      for (let i = 0; i < item.lengths[s]; i++, point++) {
        const [px, py, pz] = item.places.subarray(3 * point, 3 * point + 3);
        const w = m[3] * px + m[7] * py + m[11] * pz + m[15];
        const dx = ((m[0] * px + m[4] * py + m[8] * pz + m[12]) / w + 1) * 0.5 * width - x;
        const dy = (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w) * 0.5 * height - y;
        const score = Math.hypot(dx, dy) < 6 ? w + 0.02 * Math.hypot(dx, dy) * w : Infinity;
        if (score < best) [best, chosen] = [score, s];
      }
    }
    const strand = item.strands ? item.strands[chosen] : chosen;
    this.note.textContent = chosen < 0 ? "no strand there" : `strand ${strand}, ${item.lengths[chosen]} points`;
  }
}

/** @typedef {{name: string, kind: string, rest: string | null}} Layer */

/** What is drawn for an output, the body first. @param {string} node @param {string} output @returns {Layer[]} */
function layersOf(node, output) {
  /** @type {Layer[]} */
  const layers = [];
  const own = ["strands", "mesh", "points", "surface"].find((kind) => app.document(node, output, kind));
  if (!own) return layers;
  if (own === "strands" || own === "points") {
    const body = upstream(node, "mesh");
    if (body) layers.push({ name: body, kind: "mesh", rest: null });
  }
  const rest = own === "strands" ? upstream(node, "strands", "Groom") : null;
  layers.push({ name: /** @type {string} */ (app.document(node, output, own)), kind: own, rest });
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
