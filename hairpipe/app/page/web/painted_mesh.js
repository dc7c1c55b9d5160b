"use strict";
// A mesh with the image that is painted on it, from dark blue for 0 to yellow for 1, and pale where no hair grows.

const PAINT_VERTEX = `#version 300 es
layout(location=0) in vec3 place; layout(location=1) in vec3 normal; layout(location=2) in vec2 uv; layout(location=3) in float scalp;
uniform mat4 view; uniform vec3 lamp; out vec2 at; out float lit; out float grows;
void main() { grows = scalp; gl_Position = view * vec4(place, 1.0); at = vec2(uv.x, 1.0 - uv.y); lit = 0.55 + 0.45 * abs(dot(normalize(normal), lamp)); }`;
const PAINT_FRAGMENT = `#version 300 es
precision mediump float; in vec2 at; in float lit; in float grows; uniform sampler2D paint, density; out vec4 pixel;
void main() {
  float hair = min(grows, 10.0 * texture(density, at).r); // none below a density of a twentieth
  float value = texture(paint, at).r;
  vec3 colour = value < 0.5 ? mix(vec3(0.16, 0.17, 0.36), vec3(0.13, 0.57, 0.55), 2.0 * value) : mix(vec3(0.13, 0.57, 0.55), vec3(0.99, 0.91, 0.20), 2.0 * value - 1.0);
  float line = 1.0 - smoothstep(0.0, 1.5, abs(hair - 0.5) / max(fwidth(hair), 1e-5));
  colour = mix(mix(vec3(0.72, 0.64, 0.60), colour, 0.35 + 0.65 * smoothstep(0.3, 0.7, hair)), vec3(1.0), 0.8 * line);
  pixel = vec4(colour * lit, 1.0);
}`;

/** A painted mesh: `update` takes a changed image, and the painted density of hair where that is another one. @typedef {Item & {update: (density?: Uint8Array | null) => void}} PaintedItem */

/** Put a mesh and its image on the graphics card.
 * @param {Scene} scene @param {Texels} texels @param {Float32Array} uv @param {Numbers | undefined} scalp density of hair at each vertex, 0 to 255; hair grows everywhere without @returns {PaintedItem} */
function paintedMesh(scene, texels, uv, scalp) {
  const { gl } = scene, { places, triangles, size } = texels, corners = triangles.length, before = scene.work.bytes;
  const smooth = normalsOf(places, triangles), spread = (/** @type {Float32Array} */ values) => Float32Array.from({ length: 3 * corners }, (_, i) => values[3 * triangles[Math.floor(i / 3)] + (i % 3)]);
  const program = programOf(gl, PAINT_VERTEX, PAINT_FRAGMENT), array = gl.createVertexArray(), textures = [gl.createTexture(), gl.createTexture()];
  gl.bindVertexArray(array);
  const held = [spread(places), spread(smooth), Float32Array.from({ length: 2 * corners }, (_, i) => uv[(i % 2) * corners + (i >> 1)]),
    Float32Array.from({ length: corners }, (_, i) => (scalp ? scalp[triangles[i]] / 255 : 1))].map((data, k) => {
    const buffer = scene.buffer(data);
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, data.length / corners, gl.FLOAT, false, 0, 0);
    return buffer;
  });
  let own = true; // the image is the density
  gl.useProgram(program);
  gl.uniform1i(gl.getUniformLocation(program, "density"), 1);
  const upload = (/** @type {number} */ unit, /** @type {Uint8Array} */ values) => {
    gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, size, size, 0, gl.RED, gl.UNSIGNED_BYTE, values);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
  };
  const update = (/** @type {[(Uint8Array | null)?]} */ ...[density]) => {
    upload(0, texels.values);
    if (density) upload(1, density);
    if (density !== undefined) own = density === null;
  };
  const draw = (/** @type {Matrix} */ view) => {
    scene.use(program, { view, lamp: LIT });
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, textures[own ? 0 : 1]);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, textures[0]);
    gl.bindVertexArray(array);
    gl.drawArrays(gl.TRIANGLES, 0, corners);
    scene.count(corners);
  };
  const free = () => (scene.free(array, held), textures.forEach((texture) => gl.deleteTexture(texture)), gl.deleteProgram(program));
  update();
  return { draw, free, update, ...boxOf(places), bytes: scene.work.bytes - before, places, triangles };
}
