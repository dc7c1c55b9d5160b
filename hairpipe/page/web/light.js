"use strict";
// How much hair lies between each point and a lamp: the optical depth, summed along the light on a coarse grid.
// What is shown of a groom stands for all of it.

const CELLS = 56;
const LAMP = [0.45, 0.75, 0.48];

/** Share of the light that reaches each point, 0 to 255. @param {Float32Array} places x y z of each
 * @param {ArrayLike<number> & Iterable<number>} lengths points of each strand @param {number} width of a strand, over how many of all are shown [m] */
function lightAt(places, lengths, width) {
  const count = places.length / 3, length = Math.hypot(...LAMP), along = LAMP.map((v) => -v / length);
  const aside = [along[2], 0, -along[0]].map((v) => v / Math.hypot(along[0], along[2]));
  const up = [0, 1, 2].map((i) => aside[(i + 1) % 3] * along[(i + 2) % 3] - aside[(i + 2) % 3] * along[(i + 1) % 3]);
  const grid = new Float32Array(count * 3), low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < count; i++) {
    [aside, up, along].forEach((axis, k) => {
      const place = axis[0] * places[3 * i] + axis[1] * places[3 * i + 1] + axis[2] * places[3 * i + 2];
      grid[3 * i + k] = place;
      low[k] = Math.min(low[k], place);
      high[k] = Math.max(high[k], place);
    });
  }
  const cell = Math.max(...high.map((v, k) => v - low[k])) / (CELLS - 2) || 1;
  const depth = new Float32Array(CELLS ** 3);
  /** @param {number} i */
  const indexOf = (i) => [0, 1, 2].reduce((all, k) => all * CELLS + Math.floor((grid[3 * i + k] - low[k]) / cell + 0.5), 0);
  let point = 0;
  for (const points of lengths) {
    for (let i = 0; i < points - 1; i++, point++) {
      const run = Math.hypot(grid[3 * point + 3] - grid[3 * point], grid[3 * point + 4] - grid[3 * point + 1]);
      depth[indexOf(point)] += (width * run) / (cell * cell);
    }
    point++;
  }
  for (let i = 0; i < depth.length; i++) if (i % CELLS) depth[i] += depth[i - 1];
  const light = new Uint8Array(count);
  for (let i = 0; i < count; i++) light[i] = 255 * Math.exp(-Math.max(0, depth[indexOf(i)] - 0.5));
  return light;
}
