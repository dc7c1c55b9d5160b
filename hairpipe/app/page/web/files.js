"use strict";
// Files of the project: a field with a browser of its folders, and a small picture of an image.

const IMAGES = /\.(png|jpe?g|webp)$/i;

/** @param {any} field @param {any} value @param {string} target @returns {HTMLElement} */
function fileField(field, value, target) {
  const done = (/** @type {string} */ path) => commit(holder, target, path && JSON.stringify(path));
  const button = element("button", { title: "files of the project", onclick: (/** @type {MouseEvent} */ event) => void browse(folderOf(value ?? ""), event, suffixesOf(field), done) }, "…");
  const holder = element("span", { class: "file" }, lineOf(value ?? "", "absent", done), button);
  if (IMAGES.test(value ?? "")) holder.append(element("img", { src: `files?path=${encodeURIComponent(value)}`, alt: "", onerror: (/** @type {Event} */ event) => /** @type {HTMLElement} */ (event.target).remove() }));
  return holder;
}

/** Folder of a path, empty for that of the graph. @param {string} path */
const folderOf = (path) => path.split("/").slice(0, -1).join("/");

/** Suffixes that a file may have; none where all may. @param {any} field @returns {string[]} */
function suffixesOf(field) {
  const found = field.range.match(/\.\w+/g) ?? [];
  return field.name === "image" ? [".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr"] : found;
}

/** Choose a file in a folder, or in another one from there. @param {string} folder @param {MouseEvent | {clientX: number, clientY: number}} event @param {string[]} suffixes @param {(path: string) => unknown} done */
async function browse(folder, event, suffixes, done) {
  const answer = await fetch(`files?path=${encodeURIComponent(folder || ".")}`), found = await answer.json();
  if (found.fault) return void (folder ? browse("", event, suffixes, done) : sayControls(found.fault));
  const shown = found.entries.filter((/** @type {any} */ one) => one.folder || !suffixes.length || suffixes.some((suffix) => one.name.toLowerCase().endsWith(suffix)));
  openPopup({
    x: event.clientX, y: event.clientY, text: "", hint: `file in ${found.folder}`,
    find: (text) => shown.filter((/** @type {any} */ one) => one.name.toLowerCase().includes(text.toLowerCase()))
      .map((/** @type {any} */ one) => ({ value: one.name, note: one.folder ? "folder" : sizeText(one.bytes), colour: one.folder ? typeColour("Body") : typeColour("File") })),
    done: (name) => {
      const one = shown.find((/** @type {any} */ entry) => entry.name === name);
      return one.folder ? browse(one.path, event, suffixes, done) : done(one.path);
    },
  });
}
