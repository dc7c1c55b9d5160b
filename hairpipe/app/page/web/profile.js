"use strict";
// Profile along hair as a curve: factors over fractions of the length from the root, linear between them.

const CURVE = { width: 200, height: 64, pad: 7 };
const RADIUS = 5;

/** A curve whose points are dragged; a double click adds one or takes one away. @param {number[][]} given @param {string} target @returns {HTMLElement} */
function profileField(given, target) {
  const points = given.map((point) => [...point]), top = roundedUp(Math.max(2, ...points.map(([, factor]) => 1.2 * factor)));
  const { width, height, pad } = CURVE;
  const placeOf = (/** @type {number[]} */ [x, y]) => [pad + x * (width - 2 * pad), height - pad - (y / top) * (height - 2 * pad)];
  const svg = /** @type {SVGSVGElement} */ (drawn("svg", { class: "profile", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": target, tabindex: 0 }));
  const holder = element("span", { class: "profile-field", title: `factor along the length, 0 ... ${top}\ndrag a point; double click adds one, or takes one away` }, svg);
  const draw = () => {
    const ends = points.length ? [[0, points[0][1]], ...points, [1, points[points.length - 1][1]]] : [[0, 1], [1, 1]];
    const one = placeOf([0, 1])[1];
    svg.replaceChildren(drawn("line", { class: "one", x1: pad, x2: width - pad, y1: one, y2: one }), drawn("polyline", { points: ends.map(placeOf).map((p) => p.join(",")).join(" ") }),
      ...points.map((point, i) => drawn("circle", { cx: placeOf(point)[0], cy: placeOf(point)[1], r: RADIUS, "data-point": i })));
  };
  const at = (/** @type {MouseEvent} */ event) => {
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM()?.inverse());
    const clamped = (/** @type {number} */ value, /** @type {number} */ most) => Math.max(0, Math.min(most, value));
    return [clamped((place.x - pad) / (width - 2 * pad), 1), clamped(((height - pad - place.y) / (height - 2 * pad)) * top, top)].map((v) => Number(v.toFixed(2)));
  };
  const save = () => commit(holder, target, points.length ? JSON.stringify(points).replaceAll(",", ", ") : "");
  let held = -1, moved = false;
  svg.addEventListener("pointerdown", (event) => {
    held = Number(/** @type {SVGElement} */ (event.target).dataset.point ?? -1);
    moved = false;
    if (held < 0) return;
    svg.setPointerCapture(event.pointerId);
    svg.classList.add("held");
  });
  svg.addEventListener("pointermove", (event) => {
    if (held < 0) return;
    const [x, y] = at(event), gap = 0.01;
    points[held] = [Number(Math.max((points[held - 1]?.[0] ?? -gap) + gap, Math.min((points[held + 1]?.[0] ?? 1 + gap) - gap, x)).toFixed(2)), y];
    moved = true;
    draw();
  });
  const end = () => {
    svg.classList.remove("held");
    if (held >= 0 && moved) void save();
    held = -1;
  };
  svg.addEventListener("pointerup", end);
  svg.addEventListener("pointercancel", end);
  svg.addEventListener("dblclick", (event) => {
    const point = Number(/** @type {SVGElement} */ (event.target).dataset.point ?? -1);
    if (point >= 0) points.splice(point, 1);
    else if (!points.length) points.push([0, 1], at(event), [1, 1]);
    else points.push(at(event));
    points.sort((a, b) => a[0] - b[0]);
    draw();
    void save();
  });
  draw();
  return holder;
}
