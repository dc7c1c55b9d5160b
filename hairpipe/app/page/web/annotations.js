"use strict";
// Frames around nodes, and notes: titled boxes below the graph, and lines of text on it, kept in `[layout]`.

const FRAME = { pad: 14, head: 20 }, NOTE = { width: 170, line: 14 };

/** @typedef {{name: string, title?: string, nodes?: string[], text?: string, at?: number[]}} Annotation */

/** Frames and notes of the file. @returns {Annotation[]} */
const annotations = () => Object.entries(app.graph.layout ?? {}).filter(([, value]) => !Array.isArray(value)).map(([name, value]) => ({ name, ...value }));
/** @param {string | null | undefined} name */
const annotationNamed = (name) => annotations().find((one) => one.name === name);

/** Place and size of a frame or note; null for a frame without nodes. @param {Annotation} one @param {Map<string, Box>} boxes */
function annotationBox(one, boxes) {
  if (one.at) return { x: one.at[0], y: one.at[1], width: NOTE.width, height: NOTE.line * linesOf(one.text ?? "").length + 10 };
  const around = (one.nodes ?? []).flatMap((name) => boxes.get(name) ?? []), half = BOX.width / 2;
  if (!around.length) return null;
  const x = Math.min(...around.map((box) => box.x)) - half - FRAME.pad, y = Math.min(...around.map((box) => box.y - box.height / 2)) - FRAME.pad - FRAME.head;
  return { x, y, width: Math.max(...around.map((box) => box.x)) + half + FRAME.pad - x, height: Math.max(...around.map((box) => box.y + box.height / 2)) + FRAME.pad - y };
}

/** Lines of a note, broken between words. @param {string} text @returns {string[]} */
function linesOf(text) {
  return text.split("\n").flatMap((line) => line.match(/.{1,28}(\s|$)|\S+/g) ?? [""]);
}

/** @param {Map<string, Box>} boxes @param {Map<string, number[]>} [moved] @returns {SVGElement[]} frames first, for they lie below the others */
function drawAnnotations(boxes, moved) {
  return annotations().sort((a, b) => Number(Boolean(a.at)) - Number(Boolean(b.at))).flatMap((one) => {
    const box = annotationBox(one, boxes), by = (one.at && moved?.get(one.name)) || [0, 0];
    if (!box) return [];
    const [x, y] = [box.x + by[0], box.y + by[1]], kind = `annotation ${one.at ? "note" : "frame"} ${app.chosen.has(one.name) ? "chosen" : ""}`;
    const texts = one.at ? linesOf(one.text ?? "").map((line, i) => drawn("text", { x: x + 8, y: y + 16 + NOTE.line * i }, [line])) : [drawn("text", { x: x + 8, y: y + 15 }, [one.title ?? ""])];
    const head = one.at ? [] : [drawn("rect", { class: "title", x, y, width: box.width, height: FRAME.head, rx: 6 })];
    return [drawn("g", { class: kind, "data-annotation": one.name }, [drawn("rect", { class: "back", x, y, width: box.width, height: box.height, rx: 6 }), ...head, ...texts])];
  });
}

/** Ask for the title of a frame around the chosen nodes. @param {string[]} nodes */
function askFrame(nodes) {
  openPopup({ ...pointer, text: "", hint: "title of the frame", done: async (title) => {
    if (!title) return;
    const shown = document.getElementById("graph")?.getAttribute("viewBox")?.split(" ").map(Number) ?? [], places = nodes.map((name) => boxOfNode(name));
    app.fresh ||= Math.min(...places.map((box) => box.y - box.height / 2)) - FRAME.pad - FRAME.head < shown[1]; // else its title would not be seen
    await edit("annotate", { value: { title, nodes } });
  } });
}

/** Ask for a note at the pointer. */
function askNote() {
  const at = graphPlace(pointer.x, pointer.y);
  openPopup({ ...pointer, text: "", hint: "note", done: (text) => text && edit("annotate", { value: { text, at } }) });
}

/** Ask for another text of a frame or note; without one it is removed. @param {Annotation} one @param {number} x @param {number} y */
function askAnnotation({ name, ...value }, x, y) {
  const key = value.at ? "text" : "title";
  openPopup({ x, y, text: value[key] ?? "", hint: key, done: (text) => edit("annotate", { name, value: text ? { ...value, [key]: text } : null }) });
}

/** Nodes that are dragged with a frame. @param {Annotation} one @returns {string[]} */
const draggedWith = (one) => (one.at ? [one.name] : (one.nodes ?? []).filter((name) => app.nodeNamed(name)));
