"use strict";
// One timeline for everything.

function listenToTimeline() {
  const slider = /** @type {HTMLInputElement} */ (document.getElementById("frame")), play = /** @type {HTMLElement} */ (document.getElementById("play"));
  const step = (/** @type {number} */ by) => {
    const [first, last] = app.graph.frames, count = last - first + 1;
    app.set({ frame: first + ((app.frame - first + by + count) % count) });
  };
  let playing = false, turn = 0;
  const run = async (/** @type {number} */ own) => {
    while (playing && own === turn) {
      step(1);
      await Promise.all([app.showing, new Promise((done) => setTimeout(done, 1000 / app.graph.fps))]); // else no frame is shown where loading is slow
    }
  };
  const toggle = () => {
    playing = !playing;
    play.textContent = playing ? "❚❚" : "▶";
    void run(++turn);
  };
  slider.addEventListener("input", () => app.set({ frame: Number(slider.value) }));
  play.addEventListener("click", toggle);
  document.addEventListener("keydown", (event) => {
    if (event.target instanceof HTMLInputElement && event.target.type !== "range") return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "ArrowRight") step(1);
    else if (event.key === "ArrowLeft") step(-1);
    else if (event.key === " ") toggle();
    else return;
    event.preventDefault();
  });
}

function drawTimeline() {
  const slider = /** @type {HTMLInputElement} */ (document.getElementById("frame"));
  [slider.min, slider.max] = app.graph.frames.map(String);
  slider.value = String(app.frame);
  /** @type {HTMLElement} */ (document.querySelector("#timeline output")).textContent = String(app.frame);
}

app.on(["graph", "frame"], () => app.graph && drawTimeline());
