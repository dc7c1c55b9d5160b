"use strict";
// Plays: hair that is simulated while one looks on, with the settings as they are now.

/** @type {{node: string, output: string, stop: AbortController | null, times: number[]}} */
const player = { node: "", output: "", stop: null, times: [] };

/** Begin or end to play the selected node. */
function togglePlaying() {
  if (player.stop) return player.stop.abort();
  const stop = new AbortController();
  Object.assign(player, { node: app.node, output: app.output, stop, times: [] });
  drawChoices();
  sayPlaying("begins; the first time kernels are compiled, which takes up to a minute");
  play(stop).catch((reason) => reason?.name !== "AbortError" && sayPlaying(String(reason))).finally(() => {
    player.stop = null;
    void showStage();
  });
}

/** @param {string} text */
function sayPlaying(text) {
  if (viewer) viewer.note.textContent = text;
}

/** Show frames as they come. @param {AbortController} stop */
async function play(stop) {
  const answer = await fetch(`play/${player.node}?output=${player.output}&strands=${app.strands}`, { signal: stop.signal });
  const reader = /** @type {ReadableStream<Uint8Array>} */ (answer.body).getReader();
  let held = new Uint8Array(0);
  const need = async (/** @type {number} */ count) => {
    while (held.length < count) {
      const { done, value } = await reader.read();
      if (done || !value) throw new Error("it ended");
      const longer = new Uint8Array(held.length + value.length);
      longer.set(held);
      longer.set(value, held.length);
      held = longer;
    }
    const taken = held.slice(0, count);
    held = held.slice(count);
    return taken;
  };
  while (!stop.signal.aborted) {
    const [headBytes, bodyBytes] = new Uint32Array((await need(8)).buffer);
    const head = JSON.parse(new TextDecoder().decode(await need(headBytes)));
    const body = await need(bodyBytes);
    if (head.fault) sayPlaying(head.fault);
    else if (app.node === player.node) await showPlayed(head, body);
  }
}

/** @param {any} head @param {Uint8Array} bytes places of points, two bytes a coordinate, and their widths if these vary */
async function showPlayed(head, bytes) {
  const count = head.lengths.reduce((/** @type {number} */ sum, /** @type {number} */ one) => sum + one, 0);
  const codes = new Uint16Array(bytes.buffer, 0, 3 * count), widths = bytes.length > 6 * count && { widths: bytes.subarray(6 * count) };
  const arrays = { lengths: Uint16Array.from(head.lengths), ...(head.strands && { strands: Uint32Array.from(head.strands) }), ...widths };
  const body = upstream(player.node, "mesh", undefined, head.frame);
  await viewer?.showPlayed({ meta: head, arrays, codes }, body);
  const now = performance.now(), each = Object.entries(head.seconds).map(([node, s]) => `${node} ${(1000 * Number(s)).toFixed(1)} ms`);
  player.times = [...player.times.slice(-24), now];
  const rate = (1000 * (player.times.length - 1)) / (now - player.times[0] || 1);
  const total = Object.values(head.seconds).reduce((/** @type {number} */ all, s) => all + Number(s), 0);
  sayPlaying(`frame ${head.frame}, ${each.join(", ")}: ${Math.floor(1 / total)} frames a second could be made, ${rate.toFixed(0)} are shown`);
  document.body.dataset.played = String(Number(document.body.dataset.played ?? 0) + 1);
}
