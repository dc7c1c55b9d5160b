"use strict";
// Colours of strands: as hair, by number, or by a value at each point.

const CHANNELS = ["shaded", "strand", "speed", "stretch"], DIFFERENCE = "difference [mm]";
const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/** Colour of a value in 0..1, as viridis has it. @param {number} value */
function rampColour(value) {
  const at = Math.max(0, Math.min(0.9999, value)) * (RAMP.length - 1), low = RAMP[Math.floor(at)], high = RAMP[Math.floor(at) + 1];
  return low.map((v, k) => v + (at % 1) * (high[k] - v));
}

/** A number in 0..1 that looks random, the same for the same strand. @param {number} strand */
const noiseOf = (strand) => ((Math.imul(strand + 1, 2654435761) >>> 0) % 10007) / 10007;

/** Values at the points of strands that other nodes have measured: by name, the document and the place in it.
 * @param {string[]} documents those that have come are looked at @returns {Map<string, {name: string, place: number}>} */
function measuredOf(documents) {
  const found = new Map();
  for (const name of documents) hairpipe.raw.get(name)?.meta.names.forEach((/** @type {string} */ label, /** @type {number} */ place) => found.set(label, { name, place }));
  return found;
}

/** Values by which strands are coloured: bytes as differences, and the range that they span; null where the colour is no such value.
 * @param {Layer} layer @param {string} channel @returns {Promise<{steps: Numbers, range: number[]} | null>} */
async function valuesOf(layer, channel) {
  const [found] = await Promise.all([layer.name, ...layer.values].map((one) => hairpipe.get(one)));
  const source = measuredOf(layer.values).get(channel), values = source && await hairpipe.get(source.name);
  if (values) return { steps: values.arrays[`values${source.place}`], range: values.meta.ranges[source.place] };
  return channel === "speed" && found.arrays.speeds ? { steps: found.arrays.speeds, range: [0, found.meta.fastest] } : null;
}

/** Range of the values of all strands that are drawn, by which all are coloured; null without values. @param {Layer[]} layers @param {string} channel */
async function rangeOf(layers, channel) {
  const found = await Promise.all(layers.filter((layer) => layer.kind === "strands").map((layer) => valuesOf(layer, channel)));
  const ends = found.flatMap((one) => one?.range ?? []);
  return ends.length ? [Math.min(...ends), Math.max(...ends)] : null;
}

/** Values in 0..1 of a range that holds theirs. @param {{steps: Numbers, range: number[]}} values @param {number[]} range */
function valuesWithin({ steps, range: [low, high] }, range) {
  return runningSums(steps).map((value) => (low + value * (high - low) - range[0]) / (range[1] - range[0] || 1));
}

/** Names of the documents of values that are measured of an output. @param {string} node @param {string} output @returns {string[]} */
function valueDocuments(node, output) {
  const nodes = app.graph.nodes.filter((/** @type {any} */ other) => other.edges.some((/** @type {any} */ edge) => edge.node === node && edge.output === output));
  return nodes.flatMap((/** @type {any} */ other) => Object.keys(other.kinds).map((out) => app.document(other.name, out, "values"))).filter(Boolean);
}

/** Modes in which the shader colours a tone: as hair, as a hue, by the ramp, as what is picked. @param {string} channel @param {boolean} measured */
function modeOf(channel, measured) {
  if (channel === "marked") return 3;
  return measured || channel === "speed" || channel === "stretch" ? 2 : channel === "strand" ? 1 : 0;
}

/** Tone of each point, 0 to 255: a number of its strand that looks random, or a value.
 * @param {Unpacked} found @param {string} channel @param {Float32Array} places @param {any} rest @param {Float32Array | null} measured */
function tonesOf(found, channel, places, rest, measured) {
  const { lengths, strands } = found.arrays, tones = new Uint8ClampedArray(places.length / 3);
  const speeds = measured ?? (channel === "speed" ? runningSums(found.arrays.speeds ?? new Uint8Array(tones.length)) : null);
  const values = speeds ?? (channel === "stretch" ? stretchOf(places, lengths, rest).map((value) => 0.5 + value / (2 * STRETCH)) : null);
  if (values) return tones.map((_, point) => 255 * values[point]);
  for (let s = 0, point = 0; s < lengths.length; point += lengths[s++]) tones.fill(255 * noiseOf(strands ? strands[s] : s), point, point + lengths[s]);
  return tones;
}

const STRETCH = 0.05;

/** Bytes whose differences these are, over 255. @param {Numbers} steps */
function runningSums(steps) {
  const values = new Float32Array(steps.length);
  for (let i = 0, value = 0; i < steps.length; i++) values[i] = (value = (value + steps[i]) & 255) / 255;
  return values;
}

/** Change of length of the segment at each point, over its length at rest; 0 where the rest is not known.
 * @param {Float32Array} places @param {ArrayLike<number>} lengths @param {Float32Array | null} rest */
function stretchOf(places, lengths, rest) {
  const values = new Float32Array(places.length / 3);
  if (!rest || rest.length !== places.length) return values;
  /** @param {Float32Array} p @param {number} i */
  const span = (p, i) => Math.hypot(p[3 * i + 3] - p[3 * i], p[3 * i + 4] - p[3 * i + 1], p[3 * i + 5] - p[3 * i + 2]);
  let point = 0;
  for (let s = 0; s < lengths.length; s++) {
    for (let i = 0; i < lengths[s] - 1; i++, point++) values[point] = span(places, point) / span(rest, point) - 1;
    if (lengths[s] > 1) values[point] = values[point - 1];
    point++;
  }
  return values;
}

/** Distance of each point to the same one of other strands, over the largest, and that one [m]; null for strands with other points.
 * @param {Unpacked} found @param {Unpacked} other @returns {{values: Float32Array, most: number} | null} */
function differencesOf(found, other) {
  const [places, others] = [placesIn(found), placesIn(other)], values = new Float32Array(places.length / 3);
  if (others.length !== places.length || found.meta.total !== other.meta.total) return null;
  let most = 0;
  for (let i = 0; i < values.length; i++) {
    values[i] = Math.hypot(places[3 * i] - others[3 * i], places[3 * i + 1] - others[3 * i + 1], places[3 * i + 2] - others[3 * i + 2]);
    most = Math.max(most, values[i]);
  }
  return { values: values.map((value) => value / (most || 1)), most };
}

/** What a colour means. @param {string} channel @param {number[] | null} range */
function legendOf(channel, range) {
  if (channel === "speed") return range && ["0", `${range[1].toPrecision(3)} m/s`];
  if (range) return [range[0].toPrecision(3), `${range[1].toPrecision(3)} ${channel.match(/\[(.*)\]/)?.[1] ?? ""}`];
  return channel === "stretch" ? [`-${100 * STRETCH} %`, `+${100 * STRETCH} %`] : null;
}
