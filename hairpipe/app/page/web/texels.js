"use strict";
// An image over the texture coordinates of a mesh, painted by the places of its texels in space: no seam is seen.

/** Texels beyond the border of a triangle that are painted with it, since images are read between texels. */
const BORDER = 2;

class Texels {
  /** @param {Float32Array} places @param {Numbers} triangles @param {Float32Array} uv of all corners, u before v @param {number} size of a side */
  constructor(places, triangles, uv, size) {
    this.size = size;
    this.places = places;
    this.triangles = triangles;
    /** Coverings: a texel, the triangle it shows, and barycentric coordinates there. Where texture coordinates overlap, a texel has several.
     * @type {{texel: number, triangle: number, parts: number[]}[]} */
    const coverings = [], near = new Map(), away = new Float32Array(size * size).fill(Infinity), corners = uv.length / 2;
    for (let t = 0; t < triangles.length / 3; t++) this.cover(t, [0, 1, 2].map((k) => [uv[3 * t + k] * size - 0.5, (1 - uv[corners + 3 * t + k]) * size - 0.5]), away, coverings, near);
    for (const [texel, one] of near) if (away[texel] > 0) coverings.push(one);
    /** Texel, and triangle, of each covering. */
    this.covered = Uint32Array.from(coverings, (one) => one.texel);
    this.triangle = Uint32Array.from(coverings, (one) => one.triangle);
    this.weights = Float32Array.from({ length: 3 * coverings.length }, (_, i) => coverings[Math.floor(i / 3)].parts[i % 3]);
    /** Share of the coverings that share a texel with another one. */
    this.overlap = 1 - new Set(this.covered).size / Math.max(1, coverings.length);
    this.spots = this.spotsOf();
    this.normals = new Float32Array(triangles.length);
    for (let t = 0; t < triangles.length / 3; t++) this.normals.set(normalOf(t, places, triangles), 3 * t);
    this.values = new Uint8Array(size * size).fill(255);
  }

  /** Give a triangle the texels within it, and near its border those that no other is nearer to. @param {number} triangle @param {number[][]} corners [texels]
   * @param {Float32Array} away @param {{texel: number, triangle: number, parts: number[]}[]} coverings @param {Map<number, {texel: number, triangle: number, parts: number[]}>} near */
  cover(triangle, [a, b, c], away, coverings, near) {
    const { size } = this, area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!area) return;
    const from = [0, 1].map((k) => Math.max(0, Math.floor(Math.min(a[k], b[k], c[k])) - BORDER)), to = [0, 1].map((k) => Math.min(size - 1, Math.ceil(Math.max(a[k], b[k], c[k])) + BORDER));
    for (let y = from[1]; y <= to[1]; y++) {
      for (let x = from[0]; x <= to[0]; x++) {
        const second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area, third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        const raw = [1 - second - third, second, third], parts = raw.map((v) => Math.max(0, v)), sum = parts[0] + parts[1] + parts[2], texel = y * size + x;
        const at = [0, 1].map((k) => (parts[0] * a[k] + parts[1] * b[k] + parts[2] * c[k]) / sum), distance = raw.every((v) => v >= 0) ? 0 : Math.hypot(x - at[0], y - at[1]);
        if (distance > BORDER || (distance && distance >= away[texel])) continue;
        away[texel] = distance;
        const found = { texel, triangle, parts: parts.map((v) => v / sum) };
        if (distance) near.set(texel, found);
        else coverings.push(found);
      }
    }
  }

  spotsOf() {
    const { covered, triangle, places, triangles, weights } = this, spots = new Float32Array(3 * covered.length);
    for (let i = 0; i < covered.length; i++) {
      for (let corner = 0; corner < 3; corner++) {
        const at = 3 * triangles[3 * triangle[i] + corner], share = weights[3 * i + corner];
        for (let k = 0; k < 3; k++) spots[3 * i + k] += share * places[at + k];
      }
    }
    return spots;
  }

  /** Take the values of a vertex map into an image. @param {Numbers} map @param {Uint8Array} values */
  takeMap(map, values) {
    this.covered.forEach((texel, i) => {
      let value = 0;
      for (let corner = 0; corner < 3; corner++) value += this.weights[3 * i + corner] * map[this.triangles[3 * this.triangle[i] + corner]];
      values[texel] = Math.round(value);
    });
  }

  /** Add a dab to a stroke: the largest cover that any of its dabs has. @param {Float32Array} cover of the covered texels
   * @param {number[]} place @param {number[]} normal of the skin there: the other side of an ear is not painted
   * @param {{radius: number, falloff: number, strength: number}} brush radius [m] */
  dab(cover, place, normal, { radius, falloff, strength }) {
    const { spots, normals, triangle, covered } = this, [x, y, z] = place, [nx, ny, nz] = normal, hard = 1 - falloff;
    for (let i = 0; i < covered.length; i++) {
      const dx = spots[3 * i] - x, dy = spots[3 * i + 1] - y, dz = spots[3 * i + 2] - z, square = dx * dx + dy * dy + dz * dz;
      if (square >= radius * radius) continue;
      const t = 3 * triangle[i];
      if (nx * normals[t] + ny * normals[t + 1] + nz * normals[t + 2] <= 0) continue;
      const away = Math.sqrt(square) / radius, ramp = away <= hard ? 1 : (1 - away) / falloff;
      cover[i] = Math.max(cover[i], strength * ramp * ramp * (3 - 2 * ramp));
    }
  }

  /** Paint a stroke over what was there before it. @param {Uint8Array} before @param {Float32Array} cover @param {number} value 0 to 255 */
  paint(before, cover, value) {
    const { covered, values } = this, most = new Map();
    for (let i = 0; i < covered.length; i++) if (cover[i] > (most.get(covered[i]) ?? 0)) most.set(covered[i], cover[i]);
    for (const [texel, share] of most) values[texel] = Math.round(before[texel] + share * (value - before[texel]));
  }
}
