"use strict";
// Draws strands on a head from turning eyes, and writes what it took into the page. `redraws` is given, and the document of the hair.

const canvas = document.querySelector("canvas"), gl = canvas.getContext("webgl2", { antialias: true });
const scene = new Scene(gl), camera = new Camera();
const time = async (work) => { const begun = performance.now(); await work(); return performance.now() - begun; };
const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));

async function measure() {
  let found, item;
  const unpacked = await time(async () => { found = await hairpipe.get("hair"); }), decoded = await time(() => placesIn(found));
  const made = await time(() => { item = scene.strands(found, "shaded", null); finish(); }), sent = { ...scene.work };
  camera.frame(item.low, item.high);
  scene.draw([item], camera);
  finish();
  const before = { ...scene.work }, times = [];
  for (let k = 0; k < redraws; k++) times.push(await time(() => { camera.yaw += 0.05; scene.draw([item], camera); finish(); }));
  const each = (name) => (scene.work[name] - before[name]) / redraws, median = [...times].sort((a, b) => a - b)[redraws >> 1];
  const matrix = camera.matrix(1280 / 720), { places } = item, { lengths } = found.arrays;
  const picks = [];
  for (const k of [1, 2, 3]) picks.push(await time(() => nearestStrand({ places, lengths }, matrix, 400 + 90 * k, 300, 1280, 720, Infinity)));
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return {
    "renderer": gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER), "strands": lengths.length, "points": places.length / 3 / lengths.length,
    "frame sent [bytes]": hairpipe.raw.get("hair").packed.length, "frame unpacked [ms]": unpacked, "frame decoded [ms]": decoded,
    "frame uploaded [bytes]": sent.bytes, "uploads": sent.uploads, "frame uploaded [ms]": made,
    "redraw [ms]": median, "frames a second": 1000 / median,
    "redraw uploads [bytes]": each("bytes"), "draw calls": each("calls"), "vertices": each("vertices"), "pick [ms]": Math.min(...picks),
  };
}

measure().then((found) => {
  document.body.dataset.found = JSON.stringify(found);
  document.body.dataset.state = "ready";
});
