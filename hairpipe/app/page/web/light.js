"use strict";
// How much hair lies between each point and a lamp: the optical depth, summed along the light on a coarse grid.
// What is shown of a groom stands for all of it.

const CELLS = 56;
const LAMP = [0.45, 0.75, 0.48];

/** Share of the light that reaches each point, 0 to 255. @param {Float32Array} places x y z of each
 * @param {ArrayLike<number> & Iterable<number>} lengths points of each strand @param {number} width of a strand, over how many of all are shown [m] */
function lightAt(places, lengths, width) {
  const length = Math.hypot(...LAMP), along = LAMP.map((v) => -v / length);
  const aside = [along[2], 0, -along[0]].map((v) => v / Math.hypot(along[0], along[2]));
  const up = [0, 1, 2].map((i) => aside[(i + 1) % 3] * along[(i + 2) % 3] - aside[(i + 2) % 3] * along[(i + 1) % 3]);
  const grid = turned(places, [aside, up, along]), { low, high } = boxOf(grid);
  const cell = Math.max(...high.map((v, k) => v - low[k])) / (CELLS - 2) || 1, cells = cellsOf(grid, low, cell);
  const depth = new Float32Array(CELLS ** 3);
  let point = 0;
  for (const points of lengths) {
    for (let i = 0; i < points - 1; i++, point++) {
      const run = Math.hypot(grid[3 * point + 3] - grid[3 * point], grid[3 * point + 4] - grid[3 * point + 1]);
      depth[cells[point]] += (width * run) / (cell * cell);
    }
    point++;
  }
  for (let i = 0; i < depth.length; i++) if (i % CELLS) depth[i] += depth[i - 1];
  const light = new Uint8Array(cells.length);
  for (let i = 0; i < light.length; i++) light[i] = 255 * Math.exp(-Math.max(0, depth[cells[i]] - 0.5));
  return light;
}

/** Places along three axes. @param {Float32Array} places @param {number[][]} axes */
function turned(places, axes) {
  const found = new Float32Array(places.length);
  axes.forEach(([x, y, z], k) => {
    for (let i = 0; i < places.length; i += 3) found[i + k] = x * places[i] + y * places[i + 1] + z * places[i + 2];
  });
  return found;
}

/** Cell of the grid that holds each point. @param {Float32Array} grid @param {number[]} low @param {number} cell */
function cellsOf(grid, low, cell) {
  const cells = new Uint32Array(grid.length / 3), [x, y, z] = low;
  for (let i = 0; i < cells.length; i++) {
    const [a, b, c] = [Math.floor((grid[3 * i] - x) / cell + 0.5), Math.floor((grid[3 * i + 1] - y) / cell + 0.5), Math.floor((grid[3 * i + 2] - z) / cell + 0.5)];
    cells[i] = (a * CELLS + b) * CELLS + c;
  }
  return cells;
}
