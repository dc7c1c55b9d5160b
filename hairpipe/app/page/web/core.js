"use strict";
// Documents: what Python packed, by name. In a file no page may fetch, but it may load scripts, so each is one.

/** @typedef {Uint8Array | Uint16Array | Uint32Array} Numbers */
/** @typedef {{meta: any, arrays: Record<string, Numbers>, codes?: Uint16Array, places?: Float32Array}} Unpacked */
/** @typedef {{meta: any, packed: string}} Raw */

/** Largest number and size [bytes] of arrays that are kept. */
const MOST_UNPACKED = 96, MOST_UNPACKED_BYTES = 400e6;

const hairpipe = {
  /** @type {Map<string, Raw>} */ raw: new Map(),
  /** @type {Map<string, Promise<Unpacked>>} */ unpacked: new Map(),
  /** Bytes of arrays, and of what is made of them. @type {Map<string, number>} */ sizes: new Map(),
  /** @type {Map<string, Array<(found: Raw | Error) => void>>} */ waiting: new Map(),

  /** Take a document in; every data script calls this.
   * @param {string} name @param {any} meta @param {string} packed */
  load(name, meta, packed) {
    hairpipe.unpacked.delete(name);
    hairpipe.raw.set(name, { meta, packed });
    hairpipe.answer(name, { meta, packed });
  },

  /** Say that a document cannot be had; a data script of the server calls this.
   * @param {string} name @param {string} message */
  fail(name, message) {
    hairpipe.answer(name, new Error(message));
  },

  /** @param {string} name @param {Raw | Error} found */
  answer(name, found) {
    for (const hear of hairpipe.waiting.get(name) ?? []) hear(found);
    hairpipe.waiting.delete(name);
  },

  /** Get a document that is plain data.
   * @param {string} name @returns {Promise<any>} */
  async plain(name) {
    return (await hairpipe.fetch(name)).meta;
  },

  /** Get a document with its arrays.
   * @param {string} name @returns {Promise<Unpacked>} */
  get(name) {
    const known = hairpipe.unpacked.get(name);
    const found = known ?? hairpipe.fetch(name).then(unpack);
    hairpipe.unpacked.delete(name);
    hairpipe.unpacked.set(name, found);
    found.then(({ arrays }) => hairpipe.sizes.set(name, 4 * Object.values(arrays).reduce((all, one) => all + one.byteLength, 0)), () => hairpipe.unpacked.delete(name));
    let bytes = 0;
    for (const other of hairpipe.unpacked.keys()) bytes += hairpipe.sizes.get(other) ?? 0;
    for (const oldest of hairpipe.unpacked.keys()) {
      if ((hairpipe.unpacked.size <= MOST_UNPACKED && bytes <= MOST_UNPACKED_BYTES) || oldest === name) break;
      bytes -= hairpipe.sizes.get(oldest) ?? 0;
      hairpipe.unpacked.delete(oldest);
      hairpipe.sizes.delete(oldest);
      if (app.live) hairpipe.raw.delete(oldest); // the server has it still
    }
    return found;
  },

  /** @param {string} name @returns {Promise<Raw>} */
  fetch(name) {
    const known = hairpipe.raw.get(name);
    if (known) return Promise.resolve(known);
    return new Promise((resolve, reject) => {
      const hear = (/** @type {Raw | Error} */ found) => (found instanceof Error ? reject(found) : resolve(found));
      const others = hairpipe.waiting.get(name);
      if (others) return void others.push(hear);
      hairpipe.waiting.set(name, [hear]);
      const script = document.createElement("script");
      script.src = `data/${hairpipe.fileOf(name)}.js`;
      script.onload = () => (script.remove(), hairpipe.waiting.has(name) && hairpipe.fail(name, `${name} is not in its file`));
      script.onerror = () => (script.remove(), hairpipe.fail(name, `${script.src} cannot be read`));
      document.head.append(script);
    });
  },

  /** Name of the file that holds a document: in a report several share one. @param {string} name */
  fileOf(name) {
    return hairpipe.raw.get("index")?.meta.files[name] ?? name;
  },

  /** Address of a picture. @param {string} object @param {string} suffix */
  picture(object, suffix) {
    return hairpipe.raw.get("index")?.meta.pictures[object] ?? `pictures/${object}${suffix}`;
  },

  /** Whether there is a document of a name: a frozen page has only some. @param {string} name */
  has(name) {
    const index = hairpipe.raw.get("index")?.meta;
    return !index || hairpipe.raw.has(name) || name in index.files;
  },
};

/** Undo deflate, byte planes and columns. @param {Raw} raw @returns {Promise<Unpacked>} */
async function unpack(raw) {
  const letters = atob(raw.packed), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  /** @type {Record<string, Numbers>} */
  const arrays = {};
  let at = 0;
  for (const { name, bytes: size, shape } of raw.meta.arrays) {
    const count = shape.reduce((/** @type {number} */ all, /** @type {number} */ n) => all * n, 1);
    const values = size === 1 ? new Uint8Array(count) : size === 2 ? new Uint16Array(count) : new Uint32Array(count);
    for (let plane = 0; plane < size; plane++) {
      const factor = 256 ** plane;
      for (let i = 0; i < count; i++) values[i] += planes[at++] * factor;
    }
    arrays[name] = values;
  }
  return { meta: raw.meta, arrays };
}

/** Undo second differences along strands: places in steps of their box, x y z of each point.
 * @param {Unpacked} found @param {ArrayLike<number>} lengths points of each strand @returns {Uint16Array} */
function codesOf(found, lengths) {
  const packed = found.arrays.points, count = packed.length / 3, codes = new Uint16Array(3 * count);
  for (let axis = 0; axis < 3; axis++) {
    let point = 0;
    for (let strand = 0; strand < lengths.length; strand++) {
      let value = 0, change = 0;
      for (let i = 0; i < lengths[strand]; i++, point++) {
        const code = packed[axis * count + point];
        const difference = code & 1 ? -((code + 1) >> 1) : code >> 1;
        change = i < 2 ? difference : change + difference;
        value = i === 0 ? difference : value + change;
        codes[3 * point + axis] = value;
      }
    }
  }
  return codes;
}

/** Places [m], x y z of each point. @param {Unpacked} found @param {ArrayLike<number>} lengths points of each strand @returns {Float32Array} */
function placesOf(found, lengths) {
  const codes = (found.codes ??= codesOf(found, lengths)), { low, step } = found.meta, places = new Float32Array(codes.length);
  for (let i = 0; i < places.length; i += 3) for (let axis = 0; axis < 3; axis++) places[i + axis] = low[axis] + step * codes[i + axis];
  return places;
}

/** Places of the points of strands, made once. @param {Unpacked} found @returns {Float32Array} */
const placesIn = (found) => (found.places ??= placesOf(found, found.arrays.lengths));

/** Numbers in single precision whose bits these are, or null for none. @param {Numbers | undefined} bits */
const floatsOf = (bits) => (bits ? new Float32Array(bits.buffer, bits.byteOffset, bits.length) : null);

/** @param {number} value */
function numberText(value) {
  const large = Math.abs(value) >= 1e7 || (value !== 0 && Math.abs(value) < 1e-4);
  return large ? Number(value.toPrecision(6)).toExponential().replace("e+", "e") : String(Number(value.toPrecision(6)));
}

/** @param {number} bytes */
function sizeText(bytes) {
  const step = bytes < 1000 ? 0 : Math.min(4, Math.floor(Math.log10(bytes) / 3));
  return `${(bytes / 1000 ** step).toPrecision(3)} ${["B", "kB", "MB", "GB", "TB"][step]}`;
}

/** @param {number} seconds */
function timeText(seconds) {
  if (seconds < 60) return `${seconds.toPrecision(seconds < 0.1 ? 1 : 3)} s`;
  const minutes = Math.round(seconds / 60);
  return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")} h`;
}

/** Fill an element; what is the same as before stays, as a click on what is made anew meanwhile is lost. So does a button of the same id,
 * with its listeners, which therefore ask for what is selected when they are called. @param {Element | null} holder @param {...(Node | string)} parts */
function drawInto(holder, ...parts) {
  if (!holder) return;
  parts.forEach((part, k) => {
    const made = typeof part === "string" ? document.createTextNode(part) : part, before = holder.childNodes[k];
    if (!before) holder.append(made);
    else if (before === made || before.isEqualNode(made)) return;
    else if (before instanceof HTMLButtonElement && made instanceof HTMLButtonElement && made.id && before.id === made.id) {
      before.textContent = made.textContent;
      [before.disabled, before.hidden] = [made.disabled, made.hidden];
    } else before.replaceWith(made);
  });
  while (holder.childNodes.length > parts.length) holder.lastChild?.remove();
}

/** Make an element. @param {string} tag @param {Record<string, any>} given @param {...(Node | string)} inner @returns {HTMLElement} */
function element(tag, given = {}, ...inner) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "class") made.className = value;
    else made.setAttribute(name, value);
  }
  made.append(...inner);
  return made;
}
