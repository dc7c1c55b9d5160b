"use strict";
// Graphs to begin with, offered on the viewport of a graph without nodes: a shipped one, or a text that is pasted. Each is one edit.

const TEMPLATE_VIEW = `
[body]
type = "pose_body"
in = { rest = "head", pose = "motion" }

[surface]
type = "bake_levelset"
in.body = "body"

[groom]
type = "grow_groom"
in.scalp = "head"
length = { value = 0.2, variation = 0.08 }

[hair]
type = "simulate_hair"
in = { groom = "groom", body = "body", surface = "surface" }

[picture]
type = "preview"
in = { hair = "hair", body = "body", framed = "groom" }
`;
/** Title, explanation and text of each. @type {[string, string, string][]} */
const TEMPLATES = [
  ["bust with fringe", "a groom on our bust, to paint and comb", `[head]\ntype = "make_bust"\n\n[groom]\ntype = "grow_groom"\nin.scalp = "head"\nlength = { value = 0.12, map = "length" }\n`],
  ["bust in motion", "our bust with motion from a BVH file of yours, simulated hair, a picture", `[head]\ntype = "make_bust"\n\n[motion]\ntype = "load_motion"\nin.rest = "head"\n${TEMPLATE_VIEW}`],
  ["my character", "a body and its motion from files of yours, simulated hair, a picture", `[head]\ntype = "load_body"\n\n[motion]\ntype = "load_motion"\nin.rest = "head"\n${TEMPLATE_VIEW}`],
];

/** Buttons for the templates where there are no nodes. @param {HTMLElement} stage */
function offerTemplates(stage) {
  stage.classList.remove("solid");
  if (!app.live || document.getElementById("templates")) return;
  stage.append(element("div", { id: "templates", class: "none" }, element("p", {}, "An empty graph. Begin with"),
    element("button", { "data-template": "demo", onclick: () => edit("begin", { name: "demo" }) }, element("b", {}, "demo"), element("small", {}, "our bust in a head shake, with all settings of the graph demo; its motion is copied next to the graph")),
    ...TEMPLATES.map(([title, note, text]) => element("button", { "data-template": title, onclick: () => edit("paste", { text }) }, element("b", {}, title), element("small", {}, note))),
    element("p", {}, "or add a node: Shift-A over the graph")));
}
