"use strict";
// The selected node in words: what it is, its settings with unit, range and default, its inputs, its state.

function drawPanel() {
  const panel = /** @type {HTMLElement} */ (document.getElementById("panel")), node = app.nodeNamed(app.node);
  if (!node || (document.activeElement instanceof HTMLInputElement && panel.contains(document.activeElement))) return;
  const cell = app.cell(node.name);
  const parts = [
    element("h2", {}, node.name, element("small", {}, node.type.name)),
    element("p", { class: "doc" }, node.doc),
    element("p", { class: "state" }, element("i", { style: `background:${stateColour(cell?.state ?? "")}` }), cellText(node.name, app.frame)),
    ...(app.live ? [explanation(node.name, cell, panel.querySelector(`.explain[data-node="${node.name}"]`))] : []),
    ...inputRows(node, cell),
    element("h3", {}, "settings"),
    ...node.type.settings.flatMap((/** @type {any} */ field) => settingRows(field, node.settings, node.given, [])),
  ];
  if (node.publish) parts.push(element("p", {}, `published as ${node.publish}`));
  panel.replaceChildren(...parts);
}

/** All that a result was made of, and every difference to the latest one: fetched when it is opened. As the box before
 * it, it is open or not, and has its text until there is another.
 * @param {string} node @param {Cell | undefined} cell @param {HTMLDetailsElement | null} before */
function explanation(node, cell, before) {
  const text = element("pre", {}, before?.querySelector("pre")?.textContent ?? "");
  const box = /** @type {HTMLDetailsElement} */ ( element("details", { class: "explain", "data-node": node }, element("summary", {}, "explain"), text));
  box.addEventListener("toggle", async () => {
    if (box.open) text.textContent = await (await fetch(`explain?node=${node}&frame=${cell?.frame ?? ""}`)).text();
  });
  box.open = before?.open ?? false;
  return box;
}

/** @param {any} node @param {Cell | undefined} cell @returns {HTMLElement[]} */
function inputRows(node, cell) {
  if (!node.edges.length) return [];
  return [element("h3", {}, "inputs"), ...node.edges.map((/** @type {any} */ edge) =>
    element("div", { class: "row" }, element("b", {}, edge.plug),
      element("a", { href: "#", onclick: (/** @type {Event} */ event) => (event.preventDefault(), selectNode(edge.node)) }, edge.node + (edge.output ? `.${edge.output}` : "")),
      element("code", { title: "name of the object" }, cell?.inputs?.[edge.plug] ?? "")))];
}

/** @param {any} field @param {any} values @param {any} given @param {string[]} above @returns {HTMLElement[]} */
function settingRows(field, values, given, above) {
  const value = values?.[field.name], names = [...above, field.name], isSet = given !== undefined && given !== null && typeof given === "object" && field.name in given;
  const limits = [field.unit && field.unit !== "1" ? field.unit : "", field.range, field.default === null || field.required ? "" : `default ${spoken(field.default)}`].filter(Boolean).join(", ");
  const title = `${field.help}\n${field.kind}${limits ? `, ${limits}` : ""}`;
  if (field.group.length && (value === null || value === undefined)) {
    return [element("div", { class: "row absent", title }, element("b", {}, names.join(".")), element("span", {}, "absent"))];
  }
  if (field.group.length) {
    return [element("div", { class: "row group", title }, element("b", {}, names.join("."))),
      ...field.group.flatMap((/** @type {any} */ inner) => settingRows(inner, value, isSet ? given[field.name] : undefined, names))];
  }
  return [element("div", { class: isSet ? "row given" : "row", title, "data-setting": names.join(".") }, element("b", {}, names.join(".")), valueOf(field, value, names), element("small", {}, limits.split(", default")[0]))];
}

/** The value of a setting; live it can be changed. @param {any} field @param {any} value @param {string[]} names @returns {HTMLElement} */
function valueOf(field, value, names) {
  return app.live ? editorOf(field, value, names) : element("span", {}, spoken(value));
}

/** @param {any} value @returns {string} */
function spoken(value) {
  if (value === null || value === undefined) return "absent";
  return typeof value === "number" ? numberText(value) : Array.isArray(value) ? `[${value.map(spoken).join(", ")}]` : String(value);
}

app.on(["node", "frame", "state", "graph"], () => app.graph && app.state && drawPanel());
