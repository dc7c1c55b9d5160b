"use strict";
// Soft range of a number: what a slider spans, from the bounds, the default and the unit of a setting.

/** @typedef {{low: number, high: number, log: boolean, whole: boolean, open: boolean}} SoftRange */

/** Usual sizes by unit, for a default of 0 or none. @type {Record<string, number>} */
const SIZES = { m: 0.25, deg: 45, s: 1, px: 500, Hz: 5, "1": 0.25 };
/** Bounds whose ratio is larger are spanned logarithmically, and those that are this much larger than a default are cut. */
const DECADES = 200, FAR = 20;

/** The declared bounds: those that are absent are infinite. @param {string} range such as `> 0, <= 1` */
function boundsOf(range) {
  const bound = (/** @type {string} */ sign) => range.match(new RegExp(`${sign}(=?) (-?[\\d.e+-]+)`));
  const low = bound(">"), high = bound("<");
  return { low: low ? Number(low[2]) : -Infinity, high: high ? Number(high[2]) : Infinity, open: low ? !low[1] : false };
}

/** A round number that is not smaller. @param {number} value */
function roundedUp(value) {
  const step = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((n) => n * step).find((n) => n >= value * (1 - 1e-9)) ?? value;
}

/** @param {any} field @param {any} value @returns {SoftRange} */
function softRange(field, value) {
  const { low, high, open } = boundsOf(field.range), whole = field.kind.includes("whole");
  const base = [field.default, value].find((one) => typeof one === "number" && one !== 0);
  const size = base === undefined ? (whole ? 5 : SIZES[field.unit] ?? 1) : Math.abs(base), log = low > 0 && high / low >= DECADES && high < Infinity;
  const near = roundedUp(4 * size);
  let [from, to] = [low, high];
  if (log) [from, to] = [Math.max(low, size / 1000), Math.min(high, size * 1000)];
  else if (!(high - low <= FAR * size * (1 + 1e-9))) [from, to] = [low > -Infinity ? low : -near, Math.min(high, near)];
  if (typeof value === "number" && (!log || value > 0)) [from, to] = [Math.min(from, value), Math.max(to, value)];
  return { low: from, high: to, log, whole, open: open && from === low };
}

const STEPS = 1000;

/** Place of a value on the slider, 0 to STEPS. @param {SoftRange} range @param {number} value */
function slideOf({ low, high, log }, value) {
  const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(STEPS * Math.max(0, Math.min(1, share)));
}

/** Value at a place of the slider, rounded to what a person would type. @param {SoftRange} range @param {number} place */
function valueAt({ low, high, log, whole, open }, place) {
  if (log) {
    const near = low * (high / low) ** (place / STEPS), first = open ? Number((1.1 * low).toPrecision(2)) : low;
    return Math.max(first, Math.min(high, whole ? Math.round(near) : Number(near.toPrecision(2))));
  }
  const step = whole ? Math.max(1, roundedUp((high - low) / STEPS)) : roundedUp((high - low) / 400), at = low + ((high - low) * (open && !place ? 1 : place)) / STEPS;
  const near = Number((Math.round(at / step) * step).toPrecision(10));
  return Math.max(open && near <= low ? low + step : low, Math.min(high, near));
}
