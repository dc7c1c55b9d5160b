"use strict";
// A camera that orbits a target, and the matrices that it needs. Matrices are column by column, as WebGL has them.

/** @typedef {Float32Array} Matrix */

/** Vertical angle of view. */
const VIEW_ANGLE = (30 * Math.PI) / 180;

class Camera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance = 1;
    this.yaw = 0.7;
    this.pitch = 0.25;
    this.fov = VIEW_ANGLE;
  }

  /** Look at a box so that all of it is seen. @param {number[]} low @param {number[]} high */
  frame(low, high) {
    this.target = low.map((value, axis) => (value + high[axis]) / 2);
    this.distance = (0.62 * Math.hypot(...low.map((value, axis) => high[axis] - value))) / Math.tan(this.fov / 2);
  }

  /** Axes of the camera: to the right, up, and backwards from what it sees. */
  axes() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    return { right: [cy, 0, -sy], up: [-sy * sp, cp, -cy * sp], back: [sy * cp, sp, cy * cp] };
  }

  /** Position of the eye. */
  eye() {
    return this.axes().back.map((value, axis) => this.target[axis] + this.distance * value);
  }

  /** From the world to clip space. @param {number} aspect width over height @returns {Matrix} */
  matrix(aspect) {
    const { right, up, back } = this.axes(), eye = this.eye();
    const across = (/** @type {number[]} */ axis) => -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]);
    const scale = 1 / Math.tan(this.fov / 2), near = this.distance * 0.02, far = this.distance * 20;
    const sx = scale / Math.max(aspect, 1e-6), sy = scale, a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    const rows = [[...right.map((v) => v * sx), across(right) * sx], [...up.map((v) => v * sy), across(up) * sy],
      [...back.map((v) => v * a), across(back) * a + b], [...back.map((v) => -v), -across(back)]];
    return new Float32Array(16).map((_, i) => rows[i % 4][i >> 2]);
  }

  /** Move with the pointer. @param {HTMLElement} canvas @param {() => void} redraw @param {(x: number, y: number) => void} pick */
  listen(canvas, redraw, pick) {
    /** @type {{x: number, y: number, pan: boolean, moved: boolean} | null} */
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = { x: event.clientX, y: event.clientY, pan: event.shiftKey || event.button === 2, moved: false };
      if (event.button === 1) event.preventDefault(); // no scrolling
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      const dx = event.clientX - held.x, dy = event.clientY - held.y;
      if (!held.moved && Math.hypot(dx, dy) < 3) return;
      Object.assign(held, { x: event.clientX, y: event.clientY, moved: true });
      if (held.pan) {
        const { right, up } = this.axes(), step = (2 * this.distance * Math.tan(this.fov / 2)) / canvas.clientHeight;
        this.target = this.target.map((value, axis) => value + step * (dy * up[axis] - dx * right[axis]));
      } else {
        this.yaw -= dx * 0.008;
        this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + dy * 0.008));
      }
      redraw();
    });
    canvas.addEventListener("pointerup", (event) => {
      if (held && !held.moved) pick(event.offsetX, event.offsetY);
      held = null;
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.distance *= Math.exp(event.deltaY * 0.0012);
      redraw();
    }, { passive: false });
  }
}
