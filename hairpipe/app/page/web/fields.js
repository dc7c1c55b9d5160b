"use strict";
// Fields of settings, by kind and unit. Each commits one edit, when it is left or released.

/** Settings whose tables are open, as `node.setting`. @type {Set<string>} */
const openTables = new Set();

/** Set a setting; why it is refused is shown below its row. @param {HTMLElement} editor @param {string} target @param {string} text */
async function commit(editor, target, text) {
  if (document.activeElement instanceof HTMLElement && editor.contains(document.activeElement)) document.activeElement.blur();
  const row = editor.closest(".row"), fault = await endTrial(act(text === "" ? "unset" : "edit", { target, text }));
  row?.querySelector(".wrong")?.remove();
  if (fault) row?.append(element("span", { class: "wrong" }, fault));
}

/** Editor of a setting by its kind. @param {any} field @param {any} value @param {string} target @returns {HTMLElement} */
function editorOf(field, value, target) {
  const { kind } = field, numbers = kind.match(/^a list, ([234]) of: a (whole )?number/);
  if (kind.startsWith("one of")) return choiceField(field, value, target);
  if (kind === "true or false") return switchField(value, target);
  if (kind.startsWith("a number") || kind.startsWith("a whole number")) return numberField(field, value, target);
  if (numbers) return vectorField(field, Number(numbers[1]), value, target);
  if (kind === "a file") return fileField(field, value, target);
  if (field.name === "profile") return profileField(value ?? [], target);
  if (kind.endsWith("any number of: a list: a text, a number")) return pairsField(value ?? [], target, mapsAbove());
  return textField(value, target, field.name === "map" ? mapsAbove() : []);
}

/** A line to type in. @param {string} shown @param {string} hint @param {(text: string) => unknown} done @returns {HTMLInputElement} */
function lineOf(shown, hint, done) {
  const line = /** @type {HTMLInputElement} */ (element("input", { value: shown, placeholder: hint, spellcheck: "false" }));
  line.addEventListener("change", () => done(line.value.trim()));
  line.addEventListener("keydown", (event) => event.key === "Enter" && line.blur());
  return line;
}

/** A number with a slider; beyond it one may type. @param {any} field @param {any} value @param {string} target @returns {HTMLElement} */
function numberField(field, value, target) {
  const range = softRange(field, value), known = typeof value === "number", base = known ? value : Number(field.default) || (range.log ? range.low : 0);
  const line = lineOf(known ? shortText(value) : "", "absent", (text) => commit(holder, target, text));
  const slider = /** @type {HTMLInputElement} */ (element("input", { type: "range", min: 0, max: STEPS, value: slideOf(range, base), class: known ? "" : "unknown", "aria-label": target, title: `${numberText(range.low)} ... ${numberText(range.high)}` }));
  slider.addEventListener("input", () => (line.value = String(valueAt(range, Number(slider.value))), tryValue(target, line.value)));
  slider.addEventListener("change", () => commit(holder, target, line.value));
  slider.addEventListener("pointerup", dropTrial);
  const holder = element("span", { class: "number" }, line, slider);
  return holder;
}

/** A number in full where it is short, else with four digits. @param {number} value */
const shortText = (value) => (String(value).length > 7 ? numberText(Number(value.toPrecision(4))) : String(value));

/** Numbers with the names of their axes; of a colour also a field of it. @param {any} field @param {number} count @param {any} value @param {string} target @returns {HTMLElement} */
function vectorField(field, count, value, target) {
  const isColour = field.name.includes("colour") && count === 3, names = isColour ? ["r", "g", "b"] : ["x", "y", "z", "w"];
  const given = Array.from({ length: count }, (_, i) => (Array.isArray(value) ? value[i] : "")), shown = given.map((one) => (one === "" ? "" : shortText(one)));
  const written = (/** @type {any[]} */ parts) => (parts.every((part) => part === "") ? "" : `[${parts.join(", ")}]`);
  /** @type {HTMLInputElement[]} */
  const lines = shown.map((text) => lineOf(text, "absent", () => commit(holder, target, written(lines.map((line, i) => (line.value === shown[i] ? given[i] : line.value))))));
  const holder = element("span", { class: "vector" }, ...lines.map((line, i) => element("label", {}, element("i", {}, names[i]), line)));
  if (isColour && Array.isArray(value)) {
    const hex = `#${value.map((part) => Math.round(255 * part).toString(16).padStart(2, "0")).join("")}`;
    const picker = /** @type {HTMLInputElement} */ (element("input", { type: "color", value: hex, "aria-label": target }));
    const picked = () => written([1, 3, 5].map((at) => Number((parseInt(picker.value.slice(at, at + 2), 16) / 255).toFixed(3))));
    picker.addEventListener("input", () => tryValue(target, picked()));
    picker.addEventListener("change", () => commit(holder, target, picked()));
    holder.append(picker);
  }
  return holder;
}

/** @param {any} field @param {any} value @param {string} target @returns {HTMLElement} */
function choiceField(field, value, target) {
  const choices = [...field.kind.matchAll(/'([^']*)'/g)].map((match) => match[1]), known = choices.includes(String(value));
  const menu = /** @type {HTMLSelectElement} */ (element("select", {}, ...(known ? [] : [element("option", { value: "", selected: "" }, "absent")]),
    ...choices.map((choice) => element("option", choice === String(value) ? { selected: "" } : {}, choice))));
  menu.addEventListener("change", () => (menu.blur(), commit(menu, target, menu.value)));
  return menu;
}

/** @param {any} value @param {string} target @returns {HTMLElement} */
function switchField(value, target) {
  const box = /** @type {HTMLInputElement} */ (element("input", { type: "checkbox", role: "switch", class: "switch", "aria-label": target, ...(value === true && { checked: "" }) }));
  box.addEventListener("change", () => commit(box, target, String(box.checked)));
  return box;
}

/** A text; one of the given words, or any other. @param {any} value @param {string} target @param {string[] | Promise<string[]>} words @returns {HTMLElement} */
function textField(value, target, words) {
  const list = element("datalist", { id: `words-${target.replaceAll(".", "-")}` }), plain = typeof value === "string";
  const shown = value === null || value === undefined ? "" : plain ? value : JSON.stringify(value);
  const line = lineOf(shown, "absent", (text) => commit(holder, target, plain && text ? JSON.stringify(text) : text));
  line.setAttribute("list", list.id);
  void Promise.resolve(words).then((found) => list.append(...found.map((word) => element("option", { value: word }))));
  const holder = element("span", { class: "text" }, line, list);
  return holder;
}

/** Names, each with its number, in any number: an empty line below them takes another one.
 * @param {[string, number][]} given @param {string} target @param {Promise<string[]>} words @returns {HTMLElement} */
function pairsField(given, target, words) {
  const list = element("datalist", { id: `words-${target.replaceAll(".", "-")}` });
  void words.then((found) => list.append(...found.map((word) => element("option", { value: word }))));
  const save = (/** @type {[string, string | number][]} */ pairs) => commit(holder, target, pairs.length ? `[${pairs.map(([name, factor]) => `[${JSON.stringify(name)}, ${factor}]`).join(", ")}]` : "");
  const lines = [...given, /** @type {[string, number]} */ (["", 1])].map(([name, factor], at) => {
    const others = (/** @type {[string, string | number][]} */ own) => [...given.slice(0, at), ...own, ...given.slice(at + 1)], known = at < given.length;
    const text = lineOf(name, "another group", (typed) => save(others(typed ? [[typed, number.value]] : [])));
    const number = lineOf(shortText(factor), "factor", (typed) => text.value && save(others([[text.value.trim(), typed]])));
    text.setAttribute("list", list.id);
    const gone = element("button", { class: "unset", title: `take ${name} away`, onclick: () => save(others([])) }, "×");
    return element("span", { class: "pair" }, text, number, ...(known ? [gone] : []));
  });
  const holder = element("span", { class: "pairs" }, ...lines, list);
  return holder;
}

/** Names of the maps and groups of the nearest body or groom. @returns {Promise<string[]>} */
async function mapsAbove() {
  const name = app.document(app.node, app.output, "maps") ?? upstream(app.node, "maps");
  return name ? (await hairpipe.plain(name)).names : [];
}

/** Rows of a setting that is a value, or a table with it: the value with a button that opens the rest.
 * @param {any} field @param {any} value @param {any} given @param {string[]} names @returns {HTMLElement[]} */
function tableRows(field, value, given, names) {
  const target = `${app.node}.${names.join(".")}`, plain = typeof given !== "object" || given === null, open = openTables.has(target);
  const inner = field.group.find((/** @type {any} */ one) => one.name === "value"), others = field.group.filter((/** @type {any} */ one) => one !== inner);
  const set = plain ? 0 : Object.keys(given).filter((name) => name !== "value").length;
  const opener = element("button", { class: "opener", "aria-expanded": String(open), title: others.map((/** @type {any} */ one) => one.name).join(", "), onclick: () => {
    open ? openTables.delete(target) : openTables.add(target);
    drawPanel();
  } }, open ? "▾" : set ? `▸ ${set}` : "▸");
  const editor = element("span", { class: "table-value" }, editorOf({ ...inner, default: inner.default }, value?.value, plain ? target : `${target}.value`), opener);
  const row = rowOf({ ...inner, help: field.help, optional: field.optional, required: false }, names, given !== undefined, editor);
  return [row, ...(open ? others.flatMap((/** @type {any} */ one) => settingRows(one, value, plain ? undefined : given, names)) : [])];
}
