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
    /** Triangle of each texel, -1 for none, and its barycentric coordinates. */
    this.triangle = new Int32Array(size * size).fill(-1);
    this.weights = new Float32Array(3 * size * size);
    const away = new Float32Array(size * size).fill(Infinity), corners = uv.length / 2;
    for (let t = 0; t < triangles.length / 3; t++) this.cover(t, [0, 1, 2].map((k) => [uv[3 * t + k] * size - 0.5, (1 - uv[corners + 3 * t + k]) * size - 0.5]), away);
    /** Texels with a triangle, and their places [m]. */
    this.covered = Uint32Array.from(this.triangle.keys()).filter((texel) => this.triangle[texel] >= 0);
    this.spots = this.spotsOf();
    this.normals = new Float32Array(triangles.length);
    for (let t = 0; t < triangles.length / 3; t++) this.normals.set(normalOf(t, places, triangles), 3 * t);
    this.values = new Uint8Array(size * size).fill(255);
  }

  /** Give a triangle the texels within it, and near its border those that no other is nearer to. @param {number} triangle @param {number[][]} corners [texels] @param {Float32Array} away */
  cover(triangle, [a, b, c], away) {
    const { size } = this, area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if (!area) return;
    const from = [0, 1].map((k) => Math.max(0, Math.floor(Math.min(a[k], b[k], c[k])) - BORDER)), to = [0, 1].map((k) => Math.min(size - 1, Math.ceil(Math.max(a[k], b[k], c[k])) + BORDER));
    for (let y = from[1]; y <= to[1]; y++) {
      for (let x = from[0]; x <= to[0]; x++) {
        const second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area, third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        const parts = [1 - second - third, second, third].map((v) => Math.max(0, v)), sum = parts[0] + parts[1] + parts[2], texel = y * size + x;
        const near = [0, 1].map((k) => (parts[0] * a[k] + parts[1] * b[k] + parts[2] * c[k]) / sum), distance = Math.hypot(x - near[0], y - near[1]);
        if (distance > BORDER || distance >= away[texel]) continue;
        away[texel] = distance;
        this.triangle[texel] = triangle;
        this.weights.set(parts.map((v) => v / sum), 3 * texel);
      }
    }
  }

  spotsOf() {
    const { covered, places, triangles, weights } = this, spots = new Float32Array(3 * covered.length);
    covered.forEach((texel, i) => {
      for (let corner = 0; corner < 3; corner++) {
        const at = 3 * triangles[3 * this.triangle[texel] + corner], share = weights[3 * texel + corner];
        for (let k = 0; k < 3; k++) spots[3 * i + k] += share * places[at + k];
      }
    });
    return spots;
  }

  /** Take the values of a vertex map. @param {Numbers} map */
  takeMap(map) {
    for (const texel of this.covered) {
      let value = 0;
      for (let corner = 0; corner < 3; corner++) value += this.weights[3 * texel + corner] * map[this.triangles[3 * this.triangle[texel] + corner]];
      this.values[texel] = Math.round(value);
    }
  }

  /** Add a dab to a stroke: the largest cover that any of its dabs has. @param {Float32Array} cover of the covered texels
   * @param {number[]} place @param {number[]} normal of the skin there: the other side of an ear is not painted
   * @param {{radius: number, falloff: number, strength: number}} brush radius [m] */
  dab(cover, place, normal, { radius, falloff, strength }) {
    const { spots, normals, triangle, covered } = this, [x, y, z] = place, [nx, ny, nz] = normal, hard = 1 - falloff;
    for (let i = 0; i < covered.length; i++) {
      const dx = spots[3 * i] - x, dy = spots[3 * i + 1] - y, dz = spots[3 * i + 2] - z, square = dx * dx + dy * dy + dz * dz;
      if (square >= radius * radius) continue;
      const t = 3 * triangle[covered[i]];
      if (nx * normals[t] + ny * normals[t + 1] + nz * normals[t + 2] <= 0) continue;
      const away = Math.sqrt(square) / radius, ramp = away <= hard ? 1 : (1 - away) / falloff;
      cover[i] = Math.max(cover[i], strength * ramp * ramp * (3 - 2 * ramp));
    }
  }

  /** Paint a stroke over what was there before it. @param {Uint8Array} before @param {Float32Array} cover @param {number} value 0 to 255 */
  paint(before, cover, value) {
    const { covered, values } = this;
    for (let i = 0; i < covered.length; i++) if (cover[i] > 0) values[covered[i]] = Math.round(before[covered[i]] + cover[i] * (value - before[covered[i]]));
  }
}
