"use strict";
// Draws strands on a head from turning eyes, and writes what it took into the page. Numbers are given before: strands, points, redraws.

const canvas = document.querySelector("canvas"), gl = canvas.getContext("webgl2", { antialias: true });
const scene = new Scene(gl), camera = new Camera(), places = new Float32Array(3 * strands * points);
for (let s = 0, at = 0; s < strands; s++) {
  const height = 1 - 1.4 * (s + 0.5) / strands, ring = Math.sqrt(1 - height * height), turn = 2.399963 * s;
  for (let i = 0; i < points; i++, at += 3) {
    const out = 0.1 + 0.15 * i / points, fall = 0.12 * (i / points) ** 2;
    places.set([out * ring * Math.cos(turn + 0.02 * i), out * height - fall, out * ring * Math.sin(turn + 0.02 * i)], at);
  }
}
const time = (work) => { const begun = performance.now(); work(); return performance.now() - begun; };
const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
const meta = { total: strands, diameter: 7e-5, low: [0, 0, 0], step: 0 };
const found = { meta, arrays: { points: new Uint16Array(0), lengths: new Uint16Array(strands).fill(points) }, places };
let item;
const upload = time(() => { item = scene.strands(found, "shaded", null); finish(); }), uploaded = scene.work.bytes;
camera.frame(item.low, item.high);
scene.draw([item], camera);
finish();
const before = { ...scene.work };
const times = Array.from({ length: redraws }, () => time(() => { camera.yaw += 0.05; scene.draw([item], camera); finish(); }));
const each = (name) => (scene.work[name] - before[name]) / redraws, median = [...times].sort((a, b) => a - b)[redraws >> 1];
const matrix = camera.matrix(1280 / 720);
const picks = [1, 2, 3].map((k) => time(() => nearestStrand({ places, lengths: found.arrays.lengths }, matrix, 400 + 90 * k, 300, 1280, 720, Infinity)));
const info = gl.getExtension("WEBGL_debug_renderer_info");
document.body.dataset.found = JSON.stringify({
  "renderer": gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER), "strands": strands, "points": points,
  "first upload [bytes]": uploaded, "first upload [ms]": upload, "redraw [ms]": median, "frames a second": 1000 / median,
  "uploads a redraw [bytes]": each("bytes"), "draw calls": each("calls"), "vertices": each("vertices"), "pick [ms]": Math.min(...picks),
});
