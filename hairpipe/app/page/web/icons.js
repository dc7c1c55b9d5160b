"use strict";
// Icons of nodes by category: lines of our own in a square of 12.

/** Path of each category; others have that of `other`. @type {Record<string, string>} */
const ICONS = {
  import: "M6 1v7M3 5l3 3 3-3M1.5 8v3h9V8",
  export: "M6 8V1M3 4l3-3 3 3M1.5 8v3h9V8",
  measure: "M1 8.5l7.5-7.5 2.5 2.5L3.5 11zM4 5.5l1.5 1.5M6.5 3L8 4.5",
  simulate: "M1 3.5h6.5a1.6 1.6 0 1 0-1.6-1.6M1 6h8.6a1.6 1.6 0 1 1-1.6 1.6M1 8.5h4a1.4 1.4 0 1 1-1.4 1.4",
  groom: "M1 10.5h10M2.5 10.5C2 7 2.5 4 4 1.5M6 10.5c-.5-3.5 0-6 1.5-8.5M9.5 10.5c-.5-3 0-5 1-7",
  strands: "M2 1c3 3-2 7 1 10M5.5 1c3 3-2 7 1 10M9 1c3 3-2 7 1 10",
  mesh: "M6 1l5 3v4.5L6 11 1 8.5V4zM1 4l5 2.5L11 4M6 6.5V11",
  body: "M6 1a2.2 2.2 0 1 1 0 4.4A2.2 2.2 0 1 1 6 1M1.5 11c0-6 9-6 9 0",
  pose: "M6 1a1.2 1.2 0 1 1 0 2.4A1.2 1.2 0 1 1 6 1M2 4.5l4 .5 4-.5M6 5v3M3.5 11L6 8l2.5 3",
  levelset: "M6 2.5c4 0 4.5 7 0 7s-4-7 0-7M6 .8c6.5 0 6.5 10.4 0 10.4S-.5.8 6 .8",
  bodyparts: "M1.5 1.5h4v4h-4zM6.5 6.5h4v4h-4zM7 1.5h3.5V5M5 10.5H1.5V7",
  density: "M2 2h.1M6 2h.1M10 2h.1M2 6h.1M6 6h.1M10 6h.1M2 10h.1M6 10h.1M10 10h.1",
  particles: "M3 2.5a1 1 0 1 1 0 2 1 1 0 1 1 0-2M9 1.5a1 1 0 1 1 0 2 1 1 0 1 1 0-2M6 6a1 1 0 1 1 0 2 1 1 0 1 1 0-2M10 8.5a1 1 0 1 1 0 2 1 1 0 1 1 0-2",
  picture: "M1 2h10v8H1zM1 8.5l3-3 3 3 1.5-1.5L11 9M8.5 4h.1",
  file: "M2.5 1h5l2.5 2.5V11H2.5zM7.5 1v2.5H10",
  table: "M1 2h10v8H1zM1 4.5h10M1 7.25h10M5 2v8",
  ends: "M2 11C2 6 4 3 8 3M9.5 1.5a1.5 1.5 0 1 1 0 3 1.5 1.5 0 1 1 0-3",
  other: "M2 2h8v8H2z",
};

/** Icon of a category at a place of a drawing. @param {string} category @param {number} x @param {number} y */
const iconAt = (category, x, y) => drawn("path", { class: "icon", d: ICONS[category] ?? ICONS.other, transform: `translate(${x} ${y})`, "data-category": category });

/** Icon of a category in a line of text. @param {string} category */
const iconOf = (category) => drawn("svg", { class: "icon", viewBox: "0 0 12 12", "aria-hidden": "true" }, [iconAt(category, 0, 0)]);
