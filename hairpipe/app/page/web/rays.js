"use strict";
// What lies below a place of the picture: the ray through it, the first triangle on the ray, the nearest strand.

/** @typedef {{from: number[], way: number[]}} Ray */
/** @typedef {{distance: number, triangle: number, place: number[], normal: number[]}} Hit */

/** Largest distance from a strand that counts as a click on it, and depth that a pixel of it is worth, over the depth. */
const REACH = 6, PIXEL_DEPTH = 0.004;
/** How far hair may lie below the skin and is still seen, over the depth: places are rounded. */
const SKIN_DEPTH = 0.003;

/** Ray from the eye through a place. @param {Camera} camera @param {number} x @param {number} y @param {number} width @param {number} height @returns {Ray} */
function rayAt(camera, x, y, width, height) {
  const { right, up, back } = camera.axes(), slope = Math.tan(camera.fov / 2);
  const across = ((2 * x) / width - 1) * slope * (width / height), above = (1 - (2 * y) / height) * slope;
  const way = back.map((v, k) => across * right[k] + above * up[k] - v), length = Math.hypot(...way);
  return { from: camera.eye(), way: way.map((v) => v / length) };
}

/** The first triangle on a ray, from either side, by Möller and Trumbore 1997.
 * @param {Ray} ray @param {Float32Array} places @param {Numbers} triangles @returns {Hit | null} */
function hitOf({ from, way }, places, triangles) {
  const [ox, oy, oz] = from, [wx, wy, wz] = way;
  let nearest = Infinity, found = -1;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const ax = places[a], ay = places[a + 1], az = places[a + 2];
    const ux = places[b] - ax, uy = places[b + 1] - ay, uz = places[b + 2] - az;
    const vx = places[c] - ax, vy = places[c + 1] - ay, vz = places[c + 2] - az;
    const px = wy * vz - wz * vy, py = wz * vx - wx * vz, pz = wx * vy - wy * vx;
    const scale = ux * px + uy * py + uz * pz;
    if (scale === 0) continue;
    const sx = ox - ax, sy = oy - ay, sz = oz - az, first = (sx * px + sy * py + sz * pz) / scale;
    if (first < 0 || first > 1) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const second = (wx * qx + wy * qy + wz * qz) / scale;
    if (second < 0 || first + second > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / scale;
    if (distance > 0 && distance < nearest) [nearest, found] = [distance, t / 3];
  }
  if (found < 0) return null;
  return { distance: nearest, triangle: found, place: from.map((v, k) => v + nearest * way[k]), normal: normalOf(found, places, triangles) };
}

/** Unit normal of a triangle. @param {number} triangle @param {Float32Array} places @param {Numbers} triangles */
function normalOf(triangle, places, triangles) {
  const [a, b, c] = [0, 1, 2].map((k) => 3 * triangles[3 * triangle + k]);
  const u = [0, 1, 2].map((k) => places[b + k] - places[a + k]), v = [0, 1, 2].map((k) => places[c + k] - places[a + k]);
  const normal = [0, 1, 2].map((k) => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
  const length = Math.hypot(...normal) || 1;
  return normal.map((value) => value / length);
}

/** The strand whose nearest segment is the foremost below a place, -1 for none: one pass over the points in memory, which
 * takes less than a pass of the graphics card and its answer.
 * @param {{places: Float32Array, lengths: ArrayLike<number>}} hair @param {Float32Array} m of the camera
 * @param {number} x @param {number} y @param {number} width @param {number} height @param {number} deepest depth beyond which nothing is seen */
function nearestStrand({ places, lengths }, m, x, y, width, height, deepest) {
  const far = deepest * (1 + SKIN_DEPTH);
  let best = Infinity, chosen = -1, at = 0;
  for (let s = 0; s < lengths.length; s++) {
    let x0 = 0, y0 = 0, w0 = -1;
    for (let i = 0; i < lengths[s]; i++, at += 3) {
      const px = places[at], py = places[at + 1], pz = places[at + 2], w1 = m[3] * px + m[7] * py + m[11] * pz + m[15];
      const x1 = ((m[0] * px + m[4] * py + m[8] * pz + m[12]) / w1 + 1) * 0.5 * width - x;
      const y1 = (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w1) * 0.5 * height - y;
      if (w0 > 0 && w1 > 0) {
        const dx = x1 - x0, dy = y1 - y0, along = Math.max(0, Math.min(1, -(x0 * dx + y0 * dy) / (dx * dx + dy * dy || 1)));
        const aside = Math.sqrt((x0 + along * dx) ** 2 + (y0 + along * dy) ** 2), depth = w0 + along * (w1 - w0);
        const score = aside < REACH && depth < far ? depth * (1 + PIXEL_DEPTH * aside) : Infinity;
        if (score < best) best = score, chosen = s;
      }
      x0 = x1, y0 = y1, w0 = w1;
    }
  }
  return chosen;
}
