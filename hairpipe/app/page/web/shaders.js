"use strict";
// Hair as ribbons that face the eye, lit after Kajiya and Kay 1989; meshes; particles.

/** Most pieces of a segment, and the length of one [px]: a shorter one looks as straight as it is. */
const HAIR_PIECES = 3, PIECE = 5;
const HAIR_VERTEX = `#version 300 es
layout(location=0) in vec3 codeBefore; layout(location=1) in vec3 codeHere; layout(location=2) in vec3 codeThere; layout(location=3) in vec3 codeAfter;
layout(location=4) in vec4 markHere; layout(location=5) in vec4 markThere;
uniform vec3 low; uniform float grid; uniform float mode;
uniform mat4 view; uniform vec3 eye; uniform vec3 lamp; uniform vec2 size; uniform float width; uniform float least; uniform float pieces; uniform float shaded; uniform float shown;
out vec4 tint;
const vec3 RAMP[5] = vec3[5](RAMP_VALUES);
vec3 colourOf(float tone) {
  if (mode < 0.5) return vec3(0.588, 0.404, 0.259) * (0.8 + 0.45 * tone);
  if (mode < 1.5) return 0.549 + 0.392 * cos(6.2832 * tone + vec3(0.0, 2.0944, 4.1888));
  if (mode > 2.5) return vec3(0.275, 0.804, 1.0);
  float at = min(tone, 0.9999) * 4.0;
  return mix(RAMP[int(at)], RAMP[int(at) + 1], fract(at));
}
void main() {
  uint endHere = uint(markHere.z * 255.0 + 0.5), endThere = uint(markThere.z * 255.0 + 0.5);
  if ((endHere & 2u) != 0u) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  vec3 before = low + grid * codeBefore, here = low + grid * codeHere, there = low + grid * codeThere, after = low + grid * codeAfter;
  vec3 p0 = (endHere & 1u) != 0u ? 2.0 * here - there : before, p3 = (endThere & 2u) != 0u ? 2.0 * there - here : after;
  float t = float(gl_VertexID >> 1) / pieces, side = float(gl_VertexID & 1) * 2.0 - 1.0;
  vec3 m0 = 0.5 * (there - p0), m1 = 0.5 * (p3 - here), c = 3.0 * (there - here) - 2.0 * m0 - m1, d = 2.0 * (here - there) + m0 + m1;
  vec3 place = here + t * (m0 + t * (c + t * d)), along = normalize(m0 + t * (2.0 * c + 3.0 * t * d));
  vec4 at = view * vec4(place, 1.0), next = view * vec4(place + 0.001 * along, 1.0);
  vec2 way = normalize((next.xy / next.w - at.xy / at.w) * size + vec2(1e-9, 0.0));
  float wide = width * mix(float(endHere >> 2), float(endThere >> 2), t) / 63.0 * size.y / at.w, drawn = max(wide, least);
  at.xy += side * 0.5 * drawn * vec2(-way.y, way.x) / size * 2.0 * at.w;
  gl_Position = at;
  vec4 colour = vec4(colourOf(mix(markHere.x, markThere.x, t)), mix(markHere.y, markThere.y, t));
  vec3 back = normalize(eye - place);
  float tl = dot(along, lamp), te = dot(along, back), sl = sqrt(1.0 - tl * tl), se = sqrt(max(0.0, 1.0 - te * te));
  float lit = colour.a, highlight = pow(max(0.0, sl * se - tl * te), 40.0);
  vec3 hair = colour.rgb * (0.16 + 0.95 * lit * sl) + 0.28 * lit * highlight * (0.4 + colour.rgb);
  tint = vec4(mix(colour.rgb * (0.7 + 0.3 * lit), hair, shaded), shown * min(1.0, wide / drawn + 0.25));
}`.replace("RAMP_VALUES", RAMP.map((colour) => `vec3(${colour.map((v) => (v / 255).toFixed(4))})`).join());
const HAIR_FRAGMENT = `#version 300 es
precision mediump float; in vec4 tint; out vec4 pixel; void main() { pixel = tint; }`;

const MESH_VERTEX = `#version 300 es
layout(location=0) in vec3 place; layout(location=1) in vec3 normal;
uniform mat4 view; uniform vec3 eye; uniform vec3 lamp; uniform vec3 colour; out vec3 tint;
void main() {
  gl_Position = view * vec4(place, 1.0);
  vec3 n = normalize(normal), back = normalize(eye - place);
  float facing = abs(dot(n, back));
  tint = colour * (0.25 + 0.6 * max(0.0, dot(n, lamp)) + 0.2 * max(0.0, -dot(n, lamp)) * 0.3) + 0.12 * pow(1.0 - facing, 3.0);
}`;
const MESH_FRAGMENT = `#version 300 es
precision mediump float; in vec3 tint; out vec4 pixel; void main() { pixel = vec4(tint, 1.0); }`;

const POINT_VERTEX = `#version 300 es
layout(location=0) in vec3 place; layout(location=1) in vec3 colour;
uniform mat4 view; uniform vec2 size; uniform float width; out vec3 tint;
void main() { gl_Position = view * vec4(place, 1.0); gl_PointSize = max(2.0, width * size.y / gl_Position.w); tint = colour; }`;
const POINT_FRAGMENT = `#version 300 es
precision mediump float; in vec3 tint; out vec4 pixel;
void main() { vec2 at = 2.0 * gl_PointCoord - 1.0; if (dot(at, at) > 1.0) discard; pixel = vec4(tint * (1.0 - 0.4 * dot(at, at)), 1.0); }`;

/** @param {WebGL2RenderingContext} gl @param {string} vertex @param {string} fragment */
function programOf(gl, vertex, fragment) {
  const program = /** @type {WebGLProgram} */ (gl.createProgram());
  for (const [kind, text] of /** @type {Array<[number, string]>} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "a shader does not compile");
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "shaders do not link");
  return program;
}
