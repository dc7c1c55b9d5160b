"use strict";
// The first line of the page: whether all is well.

function drawVerdict() {
  const { verdict } = app.state, { graph } = app;
  const [first, last] = graph.frames;
  const good = !verdict.failures.length && !verdict.missing;
  const all = first === last ? `${first}` : `${first}-${last}`, part = verdict.frames && verdict.frames !== all;
  const done = part ? "complete at these frames" : "complete";
  const word = verdict.failures.length ? `${verdict.failures.length} failed` : verdict.missing ? `${verdict.missing.toLocaleString("en")} to compute` : done;
  const counted = verdict.computed === undefined ? `${verdict.cached.toLocaleString("en")} results in the cache`
    : `${verdict.computed.toLocaleString("en")} computed, ${verdict.reused.toLocaleString("en")} cached, in ${timeText(verdict.took)}`;
  const hosts = Object.entries(verdict.hosts).map(([host, count]) => `${host} ${count}`);
  const parts = [`frames ${part ? `${verdict.frames} of ${all}` : all} at ${graph.fps} fps`, counted, ...(hosts.length ? [`computing: ${hosts.join(", ")}`] : []), `${timeText(verdict.seconds)} of work, ${timeText(verdict.processor)} of processor`,
    sizeText(verdict.bytes), ...Object.entries(verdict.versions).map(([name, version]) => `${name} ${version}`)];
  drawInto(document.getElementById("verdict"),
    element("h1", {}, graph.name), presetButtons(), element("strong", { class: good ? "good" : "bad" }, word), document.getElementById("controls") ?? element("span", { id: "controls" }), element("span", { class: "facts", title: parts.join("\n") }, parts.join(" · ")), ...warningLog(),
    ...(verdict.note ? [element("span", { class: "said" }, verdict.note)] : []),
    element("code", { title: `repeats it: ${verdict.command}` }, verdict.command),
    ...verdict.failures.map(failureLine),
  );
}

app.on(["state", "graph"], () => app.graph && app.state && drawVerdict());
