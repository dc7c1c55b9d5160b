"use strict";
// What is drawn in three dimensions: buffers on the graphics card made of documents, and the drawing of them.

/** What is drawn, with bytes on the graphics card; of strands and meshes also what a ray is compared with, and of strands the documents.
 * @typedef {{draw: (view: Matrix, eye: number[], size: number[]) => void, free: () => void, low: number[], high: number[], bytes: number,
 *   places?: Float32Array, codes?: Uint16Array, grid?: {low: number[], step: number}, lengths?: ArrayLike<number>, strands?: ArrayLike<number>, triangles?: Numbers, note?: string,
 *   document?: string, rest?: string | null, total?: number, step?: number}} Item */

/** Vertices of a drawing of strands, beyond which segments have fewer pieces. */
const MOST_VERTICES = 12e6;
const LIT = LAMP.map((v) => v / Math.hypot(...LAMP));
/** @type {Record<string, number[]>} */
const MESH_COLOURS = { mesh: [0.78, 0.68, 0.62], surface: [0.42, 0.72, 0.66] };

class Scene {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.programs = { hair: programOf(gl, HAIR_VERTEX, HAIR_FRAGMENT), mesh: programOf(gl, MESH_VERTEX, MESH_FRAGMENT),
      points: programOf(gl, POINT_VERTEX, POINT_FRAGMENT) };
    this.faint = false;
    /** Triangles by document, which the frames of a mesh share. @type {Map<string, {rows: Numbers, buffer: WebGLBuffer}>} */
    this.faces = new Map();
    /** @type {Map<WebGLProgram, Map<string, WebGLUniformLocation | null>>} */ this.uniforms = new Map();
    /** Work of the graphics card so far, for measurements. */
    this.work = { bytes: 0, uploads: 0, calls: 0, vertices: 0 };
    gl.enable(gl.DEPTH_TEST);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
  }

  /** Draw items, and left of a place those of before an edit, which are faint where there are no others.
   * @param {Item[]} items @param {Camera} camera @param {Item[]} [past] @param {number} [cut] share of the width @param {Item | null} [mark] drawn over all @param {boolean} [apart] whether either side has all of the picture, with one camera */
  draw(items, camera, past = [], cut = 0, mark = null, apart = false) {
    const { gl } = this, { width, height } = gl.canvas, left = past.length ? Math.round(cut * width) : 0;
    const [red = 28, green = 31, blue = 34] = getComputedStyle(/** @type {HTMLElement} */ (/** @type {HTMLCanvasElement} */ (gl.canvas).parentElement)).backgroundColor.match(/\d+/g)?.map(Number) ?? [];
    gl.clearColor(red / 255, green / 255, blue / 255, 1);
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const eye = camera.eye();
    let view = camera.matrix(width / height), size = [width, height];
    gl.enable(gl.SCISSOR_TEST);
    for (const [some, from, to] of /** @type {Array<[Item[], number, number]>} */ ([[past, 0, left], [items, left, width]])) {
      gl.scissor(from, 0, to - from, height);
      this.faint = some === past && !items.length;
      if (apart && past.length && items.length) {
        [view, size] = [camera.matrix((to - from) / height), [to - from, height]];
        gl.viewport(from, 0, to - from, height);
      }
      for (const item of some) item.draw(view, eye, size);
    }
    gl.disable(gl.SCISSOR_TEST);
    this.faint = false;
    gl.disable(gl.DEPTH_TEST);
    mark?.draw(view, eye, size);
    gl.enable(gl.DEPTH_TEST);
  }

  /** @param {WebGLProgram} program @param {Record<string, any>} values */
  use(program, values) {
    const { gl } = this;
    gl.useProgram(program);
    const known = this.uniforms.get(program) ?? new Map();
    this.uniforms.set(program, known);
    for (const [name, value] of Object.entries(values)) {
      if (!known.has(name)) known.set(name, gl.getUniformLocation(program, name));
      const place = known.get(name);
      if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else if (value.length === 3) gl.uniform3fv(place, value);
      else if (value.length === 2) gl.uniform2fv(place, value);
      else gl.uniform1f(place, value);
    }
  }

  /** @param {ArrayBufferView} data @param {number} [target] */
  buffer(data, target = this.gl.ARRAY_BUFFER) {
    const made = this.gl.createBuffer();
    this.gl.bindBuffer(target, made);
    this.gl.bufferData(target, /** @type {ArrayBufferView<ArrayBuffer>} */ (data), this.gl.STATIC_DRAW);
    this.work.bytes += data.byteLength;
    this.work.uploads++;
    return made;
  }

  /** Strands: each segment is an instance that sees its neighbours in the same buffer, one point on. Six bytes a point
   * are its place, as it was sent; four its tone, light, width and whether a strand begins or ends there.
   * @param {Unpacked} found @param {string} channel @param {any} rest places at rest, or null
   * @param {Float32Array | null} measured values of the points in 0..1 to colour by, or null @param {number} [least] width [px] @returns {Item} */
  strands(found, channel, rest, measured = null, least = 0.8) {
    const { gl } = this, { lengths, widths } = found.arrays, { low, step } = found.meta, places = placesIn(found), count = places.length / 3, before = this.work.bytes;
    const shown = lengths.length, many = found.meta.total / Math.max(shown, 1), codes = /** @type {Uint16Array} */ (found.codes);
    const padded = new Uint16Array(3 * (count + 3)), marks = new Uint8Array(4 * (count + 2));
    padded.set(codes, 3);
    const tones = tonesOf(found, channel, places, rest, measured), light = lightAt(places, lengths, 8e-5 * many * 8);
    for (let i = 0; i < count; i++) marks[4 * i] = tones[i], marks[4 * i + 1] = light[i], marks[4 * i + 2] = 4 * (widths ? widths[i] : 63); // above the two marks
    let point = 0;
    for (const length of lengths) {
      marks[4 * point + 2] |= 1;
      marks[4 * (point + length - 1) + 2] |= 2;
      point += length;
    }
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const held = [this.buffer(padded)];
    for (let k = 0; k < 4; k++) this.attribute(k, 3, gl.UNSIGNED_SHORT, 6, 6 * k, 1);
    held.push(this.buffer(marks));
    for (let k = 0; k < 2; k++) this.attribute(4 + k, 4, gl.UNSIGNED_BYTE, 4, 4 * k, 1, true);
    const width = Math.max(found.meta.diameter, 8e-5) * Math.min(12, Math.sqrt(250000 / Math.max(shown, 1)));
    const box = boxOf(places), span = meanSpan(places, lengths), bytes = this.work.bytes - before;
    const draw = (/** @type {Matrix} */ view, /** @type {number[]} */ eye, /** @type {number[]} */ size) => {
      const pieces = Math.min(piecesOf(span, box, eye, size[1]), Math.max(1, Math.floor(MOST_VERTICES / (2 * count)) - 1));
      this.use(this.programs.hair, { view, eye, lamp: LIT, low, grid: step, mode: modeOf(channel, measured !== null), size, width, least, pieces, shaded: channel === "shaded" ? 1 : 0, shown: this.faint ? 0.35 : 1 });
      gl.enable(this.faint ? gl.BLEND : gl.SAMPLE_ALPHA_TO_COVERAGE); // samples are too few for what is both thin and faint
      gl.depthMask(!this.faint);
      gl.bindVertexArray(array);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 2 * (pieces + 1), Math.max(0, count - 1));
      this.count(2 * (pieces + 1) * Math.max(0, count - 1));
      gl.disable(this.faint ? gl.BLEND : gl.SAMPLE_ALPHA_TO_COVERAGE);
      gl.depthMask(true);
    };
    const note = shown < found.meta.total ? `${shown.toLocaleString("en")} of ${found.meta.total.toLocaleString("en")} strands shown` : "";
    return { draw, ...box, bytes, places, codes, grid: { low, step }, lengths, strands: found.arrays.strands, note, total: found.meta.total, step, free: () => this.free(array, held) };
  }

  /** @param {Unpacked} found @param {Unpacked} faces @param {string} kind @returns {Item} */
  mesh(found, faces, kind) {
    const { gl } = this, before = this.work.bytes, places = placesOf(found, [found.arrays.points.length / 3]);
    const { rows: triangles, buffer } = kind === "mesh" ? this.facesOf(found.meta.faces, faces) : this.ownFaces(faces);
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const held = [this.buffer(places)];
    this.attribute(0, 3, gl.FLOAT, 12, 0, 0);
    held.push(this.buffer(normalsOf(places, triangles)), ...(kind === "mesh" ? [] : [buffer]));
    this.attribute(1, 3, gl.FLOAT, 12, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    const draw = (/** @type {Matrix} */ view, /** @type {number[]} */ eye) => {
      this.use(this.programs.mesh, { view, eye, lamp: LIT, colour: MESH_COLOURS[kind] });
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 4);
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
      this.count(triangles.length);
      gl.disable(gl.POLYGON_OFFSET_FILL);
    };
    return { draw, ...boxOf(places), bytes: this.work.bytes - before, places, triangles, free: () => this.free(array, held) };
  }

  /** Triangles that meshes of all frames share. @param {string} name @param {Unpacked} faces */
  facesOf(name, faces) {
    const known = this.faces.get(name) ?? this.ownFaces(faces);
    this.faces.set(name, known);
    return known;
  }

  /** Triangles as rows, and on the graphics card. @param {Unpacked} faces */
  ownFaces(faces) {
    this.gl.bindVertexArray(null); // else the buffer would be that of another mesh
    const rows = rowsOf(faces.arrays.triangles, 3);
    return { rows, buffer: this.buffer(rows, this.gl.ELEMENT_ARRAY_BUFFER) };
  }

  /** Count a draw call. @param {number} vertices */
  count(vertices) {
    this.work.calls++;
    this.work.vertices += vertices;
  }

  /** @param {Unpacked} found @returns {Item} */
  points(found) {
    const { gl } = this, count = found.arrays.points.length / 3, before = this.work.bytes;
    const places = placesOf(found, new Uint8Array(count).fill(1)), box = boxOf(places);
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const held = [this.buffer(places)];
    this.attribute(0, 3, gl.FLOAT, 12, 0, 0);
    held.push(this.buffer(rowsOf(found.arrays.directions, 3)));
    this.attribute(1, 3, gl.UNSIGNED_BYTE, 3, 0, 0, true);
    const width = 0.25 * Math.hypot(...box.high.map((v, k) => v - box.low[k])) / Math.cbrt(Math.max(count, 1));
    const draw = (/** @type {Matrix} */ view, /** @type {number[]} */ _, /** @type {number[]} */ size) => {
      this.use(this.programs.points, { view, size, width });
      gl.bindVertexArray(array);
      gl.drawArrays(gl.POINTS, 0, count);
      this.count(count);
    };
    return { draw, ...box, bytes: this.work.bytes - before, free: () => this.free(array, held) };
  }

  /** @param {number} place @param {number} parts @param {number} type @param {number} stride @param {number} offset @param {number} divisor @param {boolean} [normalised] */
  attribute(place, parts, type, stride, offset, divisor, normalised = false) {
    const { gl } = this;
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, parts, type, normalised, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
  }

  /** @param {WebGLVertexArrayObject | null} array @param {Array<WebGLBuffer>} buffers */
  free(array, buffers) {
    this.gl.deleteVertexArray(array);
    for (const buffer of buffers) this.gl.deleteBuffer(buffer);
  }
}

/** Columns one after another as rows. @template {Numbers} T @param {T} columns @param {number} parts @returns {T} */
function rowsOf(columns, parts) {
  const rows = /** @type {T} */ (columns.slice()), count = columns.length / parts;
  for (let i = 0; i < count; i++) for (let k = 0; k < parts; k++) rows[parts * i + k] = columns[k * count + i];
  return rows;
}

/** @param {Float32Array} places */
function boxOf(places) {
  const low = [0, 0, 0], high = [0, 0, 0];
  for (let axis = 0; axis < 3 && places.length; axis++) {
    let least = Infinity, most = -Infinity;
    for (let i = axis; i < places.length; i += 3) {
      if (places[i] < least) least = places[i];
      if (places[i] > most) most = places[i];
    }
    [low[axis], high[axis]] = [least, most];
  }
  return { low, high };
}

/** Mean length of the segments of strands [m]. @param {Float32Array} places @param {ArrayLike<number> & Iterable<number>} lengths */
function meanSpan(places, lengths) {
  let whole = 0, at = 0;
  for (const length of lengths) {
    for (let i = at + 3; i < at + 3 * length; i += 3) whole += Math.hypot(places[i] - places[i - 3], places[i + 1] - places[i - 2], places[i + 2] - places[i - 1]);
    at += 3 * length;
  }
  return whole / Math.max(1, places.length / 3 - lengths.length);
}

/** Into how many straight pieces a segment is divided, so that each is a few pixels long.
 * @param {number} span of a segment [m] @param {{low: number[], high: number[]}} box @param {number[]} eye @param {number} height of the picture [px] */
function piecesOf(span, { low, high }, eye, height) {
  const away = Math.hypot(...eye.map((v, k) => Math.max(low[k] - v, 0, v - high[k])));
  const pixels = (span * height) / (2 * Math.tan(VIEW_ANGLE / 2) * Math.max(away, 1e-6));
  return Math.max(1, Math.min(HAIR_PIECES, Math.round(pixels / PIECE)));
}

/** @param {Float32Array} places @param {Numbers} triangles */
function normalsOf(places, triangles) {
  const normals = new Float32Array(places.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((k) => places[b + k] - places[a + k]), v = [0, 1, 2].map((k) => places[c + k] - places[a + k]);
    for (let k = 0; k < 3; k++) {
      const n = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
      normals[a + k] += n;
      normals[b + k] += n;
      normals[c + k] += n;
    }
  }
  return normals;
}
