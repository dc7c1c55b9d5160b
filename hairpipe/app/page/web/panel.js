"use strict";
// The selected node in words: what it is, its settings with unit, range and default, its inputs, its state.

function drawPanel() {
  const panel = /** @type {HTMLElement} */ (document.getElementById("panel")), node = app.nodeNamed(app.node);
  if (isInUse(panel)) return;
  const cell = node && app.cell(node.name), { frames, fps, preroll, edits } = app.graph;
  const shown = JSON.stringify([node, edits, frames, fps, preroll, [...openTables], app.variant, cell?.frame, node && upstream(node.name, "maps")]);
  if (panel.dataset.shown === shown) return drawState(node); // what one points at stays where it is
  panel.dataset.shown = shown;
  const shot = app.live ? [shotFields()] : [];
  if (!node) return void panel.replaceChildren(element("p", {}, app.live ? "Shift-A over the graph adds a node." : ""), ...shot);
  const settings = node.type.settings, absent = settings.filter((/** @type {any} */ field) => isAbsent(field, node.settings));
  const folded = panel.querySelector("details.absent"), open = folded instanceof HTMLDetailsElement && folded.open;
  const parts = [
    element("h2", {}, iconOf(categoryOf(node.type)), node.name, element("small", {}, node.type.name)),
    ...docParts(node, panel.querySelector(`.doc details[data-node="${node.name}"]`)),
    element("p", { class: "state" }), element("p", { class: "ahead" }),
    ...(app.live ? [explanation(node.name, cell, panel.querySelector(`.explain[data-node="${node.name}"]`))] : []),
    ...inputRows(node),
    element("h3", {}, "settings"),
    ...settings.filter((/** @type {any} */ field) => !absent.includes(field)).flatMap((/** @type {any} */ field) => settingRows(field, node.settings, node.given, [])),
    ...(absent.length ? [element("details", { class: "absent", ...(open && { open: "" }) }, element("summary", {}, `${absent.length} groups are off`), ...absent.flatMap((/** @type {any} */ field) => settingRows(field, node.settings, node.given, [])))] : []),
  ];
  if (node.publish) parts.push(element("p", {}, `published as ${node.publish}`));
  parts.push(...shot);
  panel.replaceChildren(...parts);
  drawState(node);
}

/** State of the selected result, what a run to its node computes, and the button for it. @param {any} node */
function drawState(node) {
  if (!node) return;
  const state = /** @type {HTMLElement} */ (document.querySelector("#panel .state")), line = /** @type {HTMLElement} */ (document.querySelector("#panel .ahead"));
  drawInto(state, element("i", { style: `background:${stateColour(app.cell(node.name)?.state ?? "")}` }), cellText(node.name, app.frame));
  const { ahead } = app, counts = Object.entries(ahead?.counts ?? {});
  if (!ahead || ahead.node !== node.name || !counts.length) return line.replaceChildren();
  const words = [counts.map(([name, count]) => `${name} ${count}`).join(", "), ...(ahead.seconds === null ? [] : [timeText(ahead.seconds)]), ...(ahead.reason && ahead.now ? [`this frame waits for a run: ${ahead.reason}`] : [])];
  drawInto(line, element("button", { id: "run-to", onclick: () => edit("run", { to: [app.node] }) }, "run to this node"),
    element("small", { title: "missing results of each node, and their expected time" }, words.join(" · ")));
}

/** What a node does, with all but the first paragraph folded. @param {any} node @param {HTMLDetailsElement | null} before @returns {HTMLElement[]} */
function docParts(node, before) {
  const [first, ...more] = node.doc.split("\n\n").map((/** @type {string} */ text) => element("p", {}, text.replaceAll("\n", " ")));
  const rest = element("details", { "data-node": node.name, ...(before?.open && { open: "" }) }, element("summary", {}, "more"), ...more);
  return [element("div", { class: "doc" }, first, ...(more.length ? [rest] : []))];
}

/** Whether a person types, chooses or drags in the panel: drawn anew it would lose that. @param {HTMLElement} panel */
function isInUse(panel) {
  const focus = document.activeElement;
  return panel.contains(focus) && focus?.matches("input:not([type=checkbox]), select") || panel.querySelector(".held") !== null;
}

/** Whether a group of settings is left out. @param {any} field @param {any} values */
const isAbsent = (field, values) => field.group.length && (values?.[field.name] === null || values?.[field.name] === undefined);

/** Switch of an optional group, and the name of it. @param {any} field @param {string[]} names @param {boolean} on @returns {HTMLElement} */
function groupName(field, names, on) {
  const label = element("b", { style: `padding-left:${10 * (names.length - 1)}px` }, names[names.length - 1]);
  if (!app.live || !field.optional) return label;
  const box = element("input", { type: "checkbox", ...(on && { checked: "" }), onchange: () => edit("switch", { target: `${app.node}.${names.join(".")}`, on: !on }) });
  return element("label", {}, box, label);
}

/** Button that takes a given value away. @param {string[]} names @returns {HTMLElement} */
function unsetButton(names) {
  return element("button", { class: "unset", title: "back to the default", onclick: () => edit("unset", { target: `${app.node}.${names.join(".")}` }) }, "×");
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

/** @param {any} node @returns {HTMLElement[]} */
function inputRows(node) {
  if (!node.edges.length) return [];
  return [element("h3", {}, "inputs"), ...node.edges.map((/** @type {any} */ edge) =>
    element("div", { class: "row input" }, element("b", {}, edge.plug),
      element("a", { href: "#", onclick: (/** @type {Event} */ event) => (event.preventDefault(), selectNode(edge.node)) }, edge.node + (edge.output ? `.${edge.output}` : ""))))];
}

/** @param {any} field @param {any} values @param {any} given @param {string[]} above @returns {HTMLElement[]} */
function settingRows(field, values, given, above) {
  const value = values?.[field.name], names = [...above, field.name], isSet = given !== undefined && given !== null && typeof given === "object" && field.name in given;
  const title = titleOf(field), inner = isSet ? given[field.name] : undefined;
  if (isAbsent(field, values)) {
    return [element("div", { class: "row absent", title, "data-group": names.join(".") }, groupName(field, names, false), element("span", {}, field.help || "absent"))];
  }
  if (field.group.length && field.kind !== "a group" && !field.optional && app.live) return tableRows(field, value, inner, names);
  if (field.group.length) {
    return [element("div", { class: "row group", title, "data-group": names.join(".") }, groupName(field, names, true)),
      ...field.group.flatMap((/** @type {any} */ one) => settingRows(one, value, inner, names))];
  }
  const varied = variedValue(`${app.node}.${names.join(".")}`);
  if (varied !== undefined) return [variedRow(field, names, varied)];
  return [rowOf(field, names, isSet, app.live ? editorOf(field, value, `${app.node}.${names.join(".")}`) : element("span", {}, spoken(value)))];
}

/** Value of a setting in the selected variant of the wedge; undefined for one that the wedge does not vary. @param {string} target */
function variedValue(target) {
  const place = (app.wedge?.targets ?? []).findIndex((/** @type {string} */ one) => one === target || one === `${target}.value`), variant = app.wedge?.variants[app.variant];
  return place < 0 || !variant ? undefined : variant.settings[app.wedge.names[place]];
}

/** A setting that the wedge varies, with its value in the selected variant. @param {any} field @param {string[]} names @param {any} value @returns {HTMLElement} */
function variedRow(field, names, value) {
  const row = rowOf(field, names, false, element("span", { title: "value of this variant" }, spoken(value)));
  row.classList.add("varied");
  return row;
}

/** What a setting is, with unit, range and default. @param {any} field */
function titleOf(field) {
  const unit = field.unit && field.unit !== "1" ? field.unit : "", standard = field.default === null || field.required ? "" : `default ${spoken(field.default)}`;
  return [field.help, [field.kind, unit, field.range, standard].filter(Boolean).join(", ")].filter(Boolean).join("\n");
}

/** A setting with its field and unit. @param {any} field @param {string[]} names @param {boolean} isSet @param {HTMLElement} editor @returns {HTMLElement} */
function rowOf(field, names, isSet, editor) {
  const target = `${app.node}.${names.join(".")}`, edited = app.live && app.graph.edits.some((/** @type {string} */ one) => one.startsWith(`${target} = `) || one.startsWith(`${target}.value = `));
  const unit = (field.unit ?? field.kind.match(/ in (\S+)/)?.[1] ?? "").replace(/^1$/, "");
  return element("div", { class: `row${isSet ? " given" : ""}${edited ? " edited" : ""}`, title: titleOf(field), "data-setting": names.join(".") },
    element("b", { style: `padding-left:${10 * (names.length - 1)}px` }, names[names.length - 1]), editor, element("small", {}, app.live ? unit : [unit, field.range].filter(Boolean).join(", ")), ...(isSet && app.live && !field.required ? [unsetButton(names)] : []));
}

/** @param {any} value @returns {string} */
function spoken(value) {
  if (value === null || value === undefined) return "absent";
  return typeof value === "number" ? numberText(value) : Array.isArray(value) ? `[${value.map(spoken).join(", ")}]` : String(value);
}

app.on(["node", "frame", "state", "graph", "ahead", "variant"], () => app.graph && app.state && drawPanel());
