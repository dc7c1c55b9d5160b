"use strict";
// A small window at a place of the page: a line to type in, with a list of what it finds, or alone.

/** Ask for a line. @param {{x: number, y: number, text: string, hint: string, find?: (text: string) => Array<{value: string, note: string, icon?: Element, category?: string}>, done: (value: string) => unknown}} asked */
function openPopup({ x, y, text, hint, find, done }) {
  closePopup();
  const line = /** @type {HTMLInputElement} */ (element("input", { placeholder: hint, spellcheck: "false", "aria-label": hint }));
  const list = element("ul"), box = element("div", { id: "popup" }, line, list);
  line.value = text;
  let [chosen, found] = [0, find ? find(text) : []];
  const end = (/** @type {string} */ value) => (closePopup(), done(value));
  const draw = () => {
    list.replaceChildren(...found.map(({ value, note, icon, category = "" }, place) => element("li", {
      class: place === chosen ? "on" : "", "data-value": value, onpointerdown: (/** @type {Event} */ event) => (event.preventDefault(), end(value)),
    }, ...(icon ? [icon] : []), element("b", {}, value), element("small", {}, note), element("span", { class: "category" }, category))));
    list.querySelector(".on")?.scrollIntoView({ block: "nearest" });
  };
  line.addEventListener("input", () => find && ([chosen, found] = [0, find(line.value)], draw()));
  line.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Escape") closePopup();
    else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      chosen = Math.max(0, Math.min(found.length - 1, chosen + (event.key === "ArrowDown" ? 1 : -1)));
      draw();
    } else if (event.key === "Enter" && (!find || found[chosen])) end(find ? found[chosen].value : line.value);
    else return;
    event.preventDefault();
  });
  line.addEventListener("blur", closePopup);
  draw();
  placePopup(box, x, y);
  line.focus();
  line.select();
}

/** Open a menu of actions, each with its key. @param {{x: number, y: number, items: {name: string, key: string, does: () => unknown}[]}} asked */
function openMenu({ x, y, items }) {
  closePopup();
  const rows = items.map(({ name, key, does }) => element("li", { role: "menuitem", tabindex: -1, "data-action": name, onclick: () => (closePopup(), does()), onpointerenter: (/** @type {Event} */ event) => /** @type {HTMLElement} */ (event.target).focus() }, element("b", {}, name), element("kbd", { class: "category" }, key)));
  const box = element("div", { id: "popup", class: "menu", role: "menu" }, element("ul", {}, ...rows));
  box.addEventListener("keydown", (event) => {
    event.stopPropagation();
    const at = rows.indexOf(/** @type {HTMLElement} */ (document.activeElement)), step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (event.key === "Escape") closePopup();
    else if (event.key === "Enter") rows[at]?.click();
    else if (step) rows[(at + step + rows.length) % rows.length].focus();
    else return;
    event.preventDefault();
  });
  box.addEventListener("focusout", (event) => box.contains(/** @type {Node | null} */ (event.relatedTarget)) || closePopup());
  placePopup(box, x, y);
  rows[0].focus();
}

/** Show a small window at a place, within the page. @param {HTMLElement} box @param {number} x @param {number} y */
function placePopup(box, x, y) {
  document.body.append(box);
  box.style.left = `${Math.max(4, Math.min(x, innerWidth - box.offsetWidth - 8))}px`;
  box.style.top = `${Math.max(4, Math.min(y, innerHeight - box.offsetHeight - 8))}px`;
}

function closePopup() {
  const box = document.getElementById("popup");
  box?.removeAttribute("id"); // its line loses the focus as it goes, which asks for this again
  box?.remove();
}
