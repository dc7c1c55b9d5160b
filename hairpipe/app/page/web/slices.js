"use strict";
// Sections of a field through its middle: blue outside, orange inside, the surface a white line.

/** @param {HTMLElement} stage @param {string} name */
async function showSlices(stage, name) {
  const found = await hairpipe.get(name), holder = element("div", { class: "slices" });
  const { bottom, top, signed, cell } = found.meta;
  found.meta.arrays.forEach((/** @type {any} */ array, /** @type {number} */ axis) => {
    const [rows, columns] = array.shape, values = found.arrays[array.name];
    const canvas = /** @type {HTMLCanvasElement} */ (element("canvas", {}));
    [canvas.width, canvas.height] = axis === 0 ? [columns, rows] : [rows, columns];
    const ink = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const image = ink.createImageData(canvas.width, canvas.height);
    // Columns come first, and Y is up: of the sections across X and Z that axis is vertical, of that across Y it is Z.
    for (let r = 0; r < rows; r++) {
      for (let c = 0; c < columns; c++) {
        const value = bottom + (values[c * rows + r] / 255) * (top - bottom), [x, y] = axis === 0 ? [c, rows - 1 - r] : [r, columns - 1 - c];
        image.data.set(fieldColour(value, top, signed, 0.7 * cell), 4 * (y * canvas.width + x));
      }
    }
    ink.putImageData(image, 0, 0);
    holder.append(element("figure", {}, canvas, element("figcaption", {}, `across ${"XYZ"[axis]}`)));
  });
  stage.append(holder);
}

/** @param {number} value @param {number} top @param {boolean} signed @param {number} line @returns {number[]} */
function fieldColour(value, top, signed, line) {
  if (!signed) return [...rampColour(value / top), 255];
  if (Math.abs(value) < line) return [255, 255, 255, 255];
  const bands = 0.75 + 0.25 * Math.cos((20 * Math.PI * value) / top), share = 1 - 0.6 * Math.abs(value / top);
  return [...(value < 0 ? [235, 150, 70] : [70, 130, 200]).map((v) => v * bands * share), 255];
}
