"use strict";
{
// -------- the data

/** @type {(id: string) => any} */
const $ = (id) => document.getElementById(id);
/** @type {PageData} */
const data = JSON.parse($("data").textContent);
const bytes = Uint8Array.from(atob($("arrays").textContent), (c) => c.charCodeAt(0)).buffer;
const KINDS = { f4: Float32Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };
const MISSING = 65535; // of 16 bit: no value
const CONCAVE = "concave edges", CONFORMAL = "conformal factor"; // quantities

/** @type {(entry: Packed) => PackedArray} */
const stored = (entry) => new /** @type {any} */ (KINDS[entry.type])(bytes, entry.at, entry.count);

/** @param {PackedNumbers} entry */
function numbers(entry) {
  const from = stored(entry), to = new Float64Array(entry.count);
  for (let i = 0; i < to.length; i++) {
    to[i] = entry.type === "u2" && from[i] === MISSING ? NaN : entry.low + entry.step * from[i];
  }
  return to;
}

const frames = data.frames, last = frames.length - 1;
const space = data.space ?? null; // where points of a curved one are, their models put about the origin

const meshes = data.meshes.map((entry) => {
  const corners = Uint32Array.from(stored(entry.faces)), ends = [];
  let solidEnds = 0; // of the triangles that nothing is seen through
  for (let h = 0; h < corners.length; h++) { // each edge inside is in two triangles, once in either direction
    const to = corners[h % 3 === 2 ? h - 2 : h + 1];
    if (corners[h] < to) ends.push(corners[h], to);
    if (h < 3 * entry.solid) solidEnds = ends.length;
  }
  return {
    faces: corners, edges: Uint32Array.from(ends), solid: 3 * entry.solid, solidEnds,
    owners: entry.polygons && stored(entry.polygons), // the face that each triangle is part of
    pieces: 2 ** (entry.cuts ?? 0), // of each edge
    own: entry.own ? stored(entry.own) : null, // the surface's own vertex next to each
    outlines: entry.outlines && stored(entry.outlines), // edges between faces, a bit each
    rim: entry.boundary ? Uint32Array.from(stored(entry.boundary)) : new Uint32Array(0), // ends of edges
  };
});

// -------- the state

const foldable = frames.some(({ concave: bits }) => bits); // whether frames mark concave edges
const still = data.camera; // the first view: rows right, up, toward the viewer
const view = { turn: still.slice(), zoom: 1, x: 0, y: 0 };
const shown = { frame: data.first, quantity: data.quantities[0], mesh: true, seams: true, creases: false, smooth: false };
let model = space ? space.models[0].model : "ambient";
let span = 1; // half the size of what is drawn
let walled = false; // whether that is the sphere at infinity
let seams = new Float64Array(0); // ends of lines on the answer
let { faces, edges, owners, outlines, rim, solid, solidEnds, pieces, own } = meshes[frames[last].mesh]; // of the frame, like all below
let n = frames[last].positions.count / 3;
/** @type {Float64Array} */
let positions;
/** @type {Float64Array} */
let values;
/** @type {Float64Array | null} */
let flat; // values of the faces, where each has one color
/** @type {PackedArray} */
let concave; // edges, a bit each
let low = 0, high = 1; // where the colors begin and end
let dirty = true, hovered = -1, pointed = -1; // a vertex, a triangle

// -------- words

/** @type {Record<string, string>} */
const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** @param {number | null} x */
function written(x, digits = 4) {
  if (x === null || Number.isNaN(x)) return "no value";
  if (x === 0) return "0";
  const far = Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5;
  const [mantissa, power] = (far ? x.toExponential(digits - 1) : String(Number(x.toPrecision(digits)))).split("e");
  const short = String(Number(mantissa)).replace("-", "−");
  return power === undefined ? short : `${short}\u00a0×\u00a010${[...power.replace("+", "")].map((c) => RAISED[c]).join("")}`;
}

const meant = (s) => (shown.quantity.scale === "log" ? 10 ** s : s); // a stored value

// -------- WebGL

/** @type {HTMLCanvasElement} */
const canvas = $("canvas");
const FAR = 6; // the viewer's distance, in half diameters
const VEIL = 0.4; // opacity of what is seen through
const gl = /** @type {WebGL2RenderingContext} */ (canvas.getContext("webgl2", { antialias: true, alpha: true, stencil: true }));
/** @type {Parts} */
let parts;

const PROJECTION = `
uniform mat3 turn; uniform vec4 frame; uniform float reach;
vec4 projected(vec3 p) { // right, up, toward
  float w = 1.0 - p.z / ${FAR.toFixed(1)};
  return vec4((p.xy * frame.x + frame.yz * w) * vec2(frame.w, 1.0), (-p.z / reach + reach / ${FAR.toFixed(1)}) , w);
}`;

const SURFACE = [`#version 300 es
layout(location = 0) in vec3 position; layout(location = 1) in vec3 normal; layout(location = 2) in vec2 value;
${PROJECTION}
out vec3 place; out vec3 direction; out vec2 shade;
void main() { place = turn * position; direction = turn * normal; shade = value; gl_Position = projected(place); }
`, `#version 300 es
precision highp float;
in vec3 place; in vec3 direction; in vec2 shade;
uniform sampler2D ramp; uniform bool smoothly; uniform float opacity;
out vec4 color;
vec3 linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 screen(vec3 c) { return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
void main() {
  vec3 n = cross(dFdx(place), dFdy(place));
  n = smoothly && dot(direction, direction) > 0.0 ? (gl_FrontFacing ? direction : -direction) : n;
  n = normalize(n);
  vec3 eye = normalize(vec3(0.0, 0.0, ${FAR.toFixed(1)}) - place);
  vec3 base = linear(shade.y > 0.001 ? vec3(0.60) : texture(ramp, vec2(clamp(shade.x, 0.0, 1.0) * 64.0 / 65.0 + 0.5 / 65.0, 0.5)).rgb);
  if (!gl_FrontFacing) base = mix(base, vec3(0.16, 0.15, 0.16), 0.75); // the inside
  vec3 key = normalize(vec3(-0.5, 0.8, 0.8)), fill = normalize(vec3(0.9, -0.1, 0.5));
  float light = 0.55 + 0.13 * n.y + 0.48 * max(dot(n, key), 0.0) + 0.12 * max(dot(n, fill), 0.0);
  float gloss = pow(max(dot(n, normalize(key + eye)), 0.0), 38.0);
  float edge = pow(1.0 - max(dot(n, eye), 0.0), 3.0);
  color = vec4(screen(clamp(base * light * (1.0 - 0.25 * edge) + 0.10 * gloss + 0.035 * edge, 0.0, 1.0)), 1.0) * opacity;
}`];

const LINES = [`#version 300 es
precision highp float; precision highp sampler2D;
layout(location = 0) in uvec2 ends;
${PROJECTION}
uniform sampler2D points; uniform vec2 size; uniform float width; uniform float lift;
out float across;
vec4 end(uint i) {
  vec3 p = turn * texelFetch(points, ivec2(int(i) & 1023, int(i) >> 10), 0).xyz;
  return projected(p + lift * normalize(vec3(0.0, 0.0, ${FAR.toFixed(1)}) - p));
}
void main() {
  vec4 a = end(ends.x), b = end(ends.y);
  vec2 along = (b.xy / b.w - a.xy / a.w) * size;
  along = dot(along, along) > 1e-12 ? normalize(along) : vec2(1.0, 0.0);
  float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
  bool first = gl_VertexID < 2;
  vec4 p = first ? a : b;
  across = side * (width / 2.0 + 1.0);
  vec2 shift = across * vec2(-along.y, along.x) + (first ? -0.3 : 0.3) * width * along;
  gl_Position = vec4(p.xy + shift / size * p.w, p.zw);
}`, `#version 300 es
precision highp float;
in float across;
uniform vec4 core; uniform vec4 casing; uniform float width; uniform float coreWidth;
out vec4 color;
void main() {
  float outer = clamp(width / 2.0 + 0.5 - abs(across), 0.0, 1.0), inner = clamp(coreWidth / 2.0 + 0.5 - abs(across), 0.0, 1.0);
  vec4 c = mix(casing, core, inner);
  color = vec4(c.rgb, 1.0) * c.a * outer;
}`];

/** @param {string[]} sources */
function program([vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error((gl.getAttachedShaders(made) ?? []).map((s) => gl.getShaderInfoLog(s)).join("\n"));
  }
  const count = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
  /** @type {Program["at"]} */
  const at = {};
  for (let k = 0; k < count; k++) {
    const { name } = /** @type {WebGLActiveInfo} */ (gl.getActiveUniform(made, k));
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}

function build() {
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.POLYGON_OFFSET_FILL);
  gl.enable(gl.STENCIL_TEST);
  gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  parts = /** @type {Parts} */ ({ surface: program(SURFACE), lines: program(LINES) });
  const buffer = (location, size, layOut) => {
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.enableVertexAttribArray(location);
    layOut(location, size);
    return made;
  };
  const floats = (location, size) => gl.vertexAttribPointer(location, size, gl.FLOAT, false, 0, 0);
  const ends = (location, size) => {
    gl.vertexAttribIPointer(location, size, gl.UNSIGNED_INT, 0, 0);
    gl.vertexAttribDivisor(location, 1);
  };
  const array = (fill) => {
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    return { made, ...fill() };
  };
  parts.mantle = array(() => ({
    positions: buffer(0, 3, floats), normals: buffer(1, 3, floats), shades: buffer(2, 2, floats), faces: gl.createBuffer(),
  }));
  for (const name of ["mesh", "rim", "seams", "creases"]) parts[name] = array(() => ({ ends: buffer(0, 2, ends), count: 0 }));
  gl.bindVertexArray(null);
  const texture = (unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, unit ? gl.NEAREST : gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  };
  texture(0);
  texture(1);
}

function paint() { // the colors of the quantity, for the surface
  const ramp = shown.quantity.ramp || data.ramp;
  const colors = Uint8Array.from(ramp.flatMap((c) => [1, 3, 5].map((k) => parseInt(c.slice(k, k + 2), 16)).concat(255)));
  gl.activeTexture(gl.TEXTURE0);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, ramp.length, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
}

/** @param {PackedArray} bits */
function marked(bits) { // the edges of these bits
  const found = [];
  for (let e = 0; e < edges.length / 2; e++) {
    if (bits[e >> 3] & (1 << (e & 7))) found.push(edges[2 * e], edges[2 * e + 1]);
  }
  return Uint32Array.from(found);
}

function normals() {
  const sums = new Float32Array(3 * n), p = positions;
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const v of [a, b, c]) {
      sums[v] += x;
      sums[v + 1] += y;
      sums[v + 2] += z;
    }
  }
  for (let v = 0; v < sums.length; v += 3) {
    const norm = Math.hypot(sums[v], sums[v + 1], sums[v + 2]);
    for (let k = v; k < v + 3 && norm > 0; k++) sums[k] /= norm;
  }
  return sums;
}

function upload() { // the frame and its colors
  const fill = (buffer, array) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.DYNAMIC_DRAW);
  };
  const draws = (lines, array) => {
    fill(lines.ends, array);
    lines.count = array.length / 2;
  };
  if (parts.faces !== faces) { // another mesh than before
    parts.faces = faces;
    gl.bindVertexArray(parts.mantle.made);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, parts.mantle.faces);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    draws(parts.mesh, outlines ? marked(outlines) : edges.subarray(0, solidEnds));
    draws(parts.rim, rim);
    draws(parts.seams, Uint32Array.from(Array(seams.length / 3).keys(), (k) => n + k));
  }
  const rows = Math.ceil((n + seams.length / 3) / 1024), texels = new Float32Array(4096 * rows);
  for (let k = 0; k < 3 * n; k++) texels[4 * Math.floor(k / 3) + k % 3] = positions[k];
  for (let k = 0; k < seams.length; k++) texels[4 * (n + Math.floor(k / 3)) + k % 3] = seams[k];
  const count = flat ? faces.length : n, sums = normals(); // corners of triangles, or vertices
  const places = new Float32Array(3 * count), directions = new Float32Array(3 * count), shades = new Float32Array(2 * count);
  for (let c = 0; c < count; c++) {
    const v = flat ? faces[c] : c, value = flat && owners ? flat[owners[Math.floor(c / 3)]] : values[v];
    const there = Number.isFinite(value);
    shades[2 * c] = there ? Math.min(Math.max((value - low) / (high - low), -9), 9) : 0.5;
    shades[2 * c + 1] = there ? 0 : 1;
    for (let k = 0; k < 3; k++) {
      places[3 * c + k] = positions[3 * v + k];
      directions[3 * c + k] = sums[3 * v + k];
    }
  }
  fill(parts.mantle.positions, places);
  fill(parts.mantle.normals, directions);
  fill(parts.mantle.shades, shades);
  draws(parts.creases, marked(concave));
  gl.activeTexture(gl.TEXTURE1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 1024, rows, 0, gl.RGBA, gl.FLOAT, texels);
}

// -------- the picture

function fit() { // the size of the canvas, and of the half diameter in it, in pixels
  const { clientWidth: w, clientHeight: h } = canvas, [halfWidth, halfHeight] = seen;
  const round = 0.9 * Math.min(w, h) / 2; // whichever way it is turned
  return { w, h, unit: Math.min(0.9 * w / 2 / halfWidth, 0.86 * h / 2 / halfHeight, 1.3 * round) };
}

const seen = [0, 0]; // half of the width and height of the first view, in units
let reach = 1; // beyond which nothing is, from the center

/** @param {PackedNumbers} entry */
function modeled(entry) { // points in the model that is shown
  const p = numbers(entry);
  if (!space) return p;
  for (let v = 0; v < p.length; v += 3) {
    const w = Math.sqrt(Math.max(1 - space.curvature * (p[v] ** 2 + p[v + 1] ** 2 + p[v + 2] ** 2), 0));
    const factor = (model === "conformal" ? 2 / (1 + w) : model === "projective" ? 1 / w : 1) / span;
    for (let k = v; k < v + 3; k++) p[k] *= factor;
  }
  return p;
}

function measure() { // the extent of all frames in the model
  [span, walled] = [1, false];
  if (space) {
    const p = modeled(frames[last].positions);
    span = 0;
    for (let v = 0; v < p.length; v += 3) span = Math.max(span, Math.hypot(p[v], p[v + 1], p[v + 2]));
    const end = (model === "conformal" ? 2 : 1) / Math.sqrt(Math.max(-space.curvature, 0)); // of space
    walled = model !== "ambient" && end <= space.farthest * span;
    if (walled) span = end;
  }
  let outermost = 1;
  seen.fill(walled ? 1 : 0);
  for (const frame of frames) {
    const p = modeled(frame.positions), rows = [still.slice(0, 3), still.slice(3, 6)];
    for (let v = 0; v < p.length; v += 3) {
      outermost = Math.max(outermost, Math.hypot(p[v], p[v + 1], p[v + 2]));
      rows.forEach(([a, b, c], k) => (seen[k] = Math.max(seen[k], Math.abs(a * p[v] + b * p[v + 1] + c * p[v + 2]))));
    }
  }
  reach = 1.02 * Math.min(outermost, 0.8 * FAR);
  const shrink = Math.min(1, 1.4 / Math.max(...seen)); // wild frames may leave the picture
  seen.forEach((half, k) => (seen[k] = Math.max(shrink * half, 0.2)));
  seams = data.seams ? modeled(data.seams) : seams;
}

function surround(size) { // the sphere at infinity is behind all
  const radius = size / Math.sqrt(1 - 1 / FAR ** 2), ball = $("infinity");
  ball.hidden = !walled;
  if (!walled) return;
  Object.assign(ball.style, {
    width: `${2 * radius}px`, height: `${2 * radius}px`,
    left: `calc(50% + ${view.x - radius}px)`, top: `calc(50% - ${view.y + radius}px)`,
  });
}

function draw() {
  const ratio = Math.min(window.devicePixelRatio || 1, 3), { w, h, unit } = fit();
  const width = Math.max(1, Math.round(ratio * w)), height = Math.max(1, Math.round(ratio * h));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
  const t = view.turn, columns = [t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]];
  const grown = view.zoom * unit;
  surround(grown);
  const common = ({ made, at }) => {
    gl.useProgram(made);
    gl.uniformMatrix3fv(at.turn, false, columns);
    gl.uniform4f(at.frame, grown / (h / 2), view.x / (h / 2), view.y / (h / 2), h / w);
    gl.uniform1f(at.reach, reach);
    return at;
  };
  const surface = common(parts.surface);
  gl.uniform1i(surface.ramp, 0);
  gl.uniform1i(surface.smoothly, shown.smooth ? 1 : 0);
  gl.uniform1f(surface.opacity, 1);
  gl.bindVertexArray(parts.mantle.made);
  gl.depthMask(true);
  gl.disable(gl.BLEND);
  gl.enable(gl.CULL_FACE);
  gl.stencilFunc(gl.ALWAYS, 1, 1);
  for (const [hidden, offset] of [[gl.FRONT, 4], [gl.BACK, 1]]) { // where a body is flat its front wins
    gl.cullFace(hidden);
    gl.polygonOffset(offset, offset);
    if (flat) gl.drawArrays(gl.TRIANGLES, 0, solid);
    else gl.drawElements(gl.TRIANGLES, solid, gl.UNSIGNED_INT, 0);
  }
  gl.depthMask(false);
  gl.enable(gl.BLEND);
  if (solid < faces.length) { // what is around others is seen through
    gl.uniform1f(surface.opacity, VEIL);
    gl.drawElements(gl.TRIANGLES, faces.length - solid, gl.UNSIGNED_INT, 4 * solid);
  }
  gl.disable(gl.CULL_FACE);

  const at = common(parts.lines);
  gl.uniform1i(at.points, 1);
  gl.uniform2f(at.size, width / 2, height / 2);
  const lines = ({ made, count }, widths, core, casing, lift) => {
    gl.uniform1f(at.width, ratio * widths[1]);
    gl.uniform1f(at.coreWidth, ratio * widths[0]);
    gl.uniform4fv(at.core, core);
    gl.uniform4fv(at.casing, casing);
    gl.uniform1f(at.lift, lift);
    gl.bindVertexArray(made);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  };
  const length = grown * pieces * Math.sqrt(5.8 / (faces.length / 3) * 4); // of an edge, about, in pixels
  const strength = Math.min(Math.max((length - 3.5) / 9, 0), 1);
  if (shown.mesh && strength > 0) {
    const black = [0.03, 0.04, 0.06, owners ? 0.6 * strength : 0.08 + 0.2 * strength]; // diagonals are no edges
    const fine = owners ? 1.1 : 0.7;
    lines(parts.mesh, [fine, fine], black, black, 0.001);
  }
  if (parts.rim.count) lines(parts.rim, [1.6, 1.6], [0.06, 0.05, 0.08, 1], [0.06, 0.05, 0.08, 1], 0.002);
  if (shown.seams && shown.frame === last && parts.seams.count) {
    gl.stencilFunc(gl.EQUAL, 1, 1);
    lines(parts.seams, [1.6, 2.4], [0.88, 0.28, 0.12, 1], [1, 1, 1, 0.5], 0.003);
  }
  if ((shown.creases || shown.quantity.name === CONCAVE) && parts.creases.count) {
    const core = Math.min(Math.max(length / 7, 1.1), 2.4);
    gl.stencilFunc(gl.EQUAL, 1, 1); // nothing of them beside the surface
    lines(parts.creases, [core, core + 1.6], [0.06, 0.05, 0.08, 1], [1, 1, 1, 0.75], 0.005);
  }
  gl.bindVertexArray(null);
  gl.depthMask(true);
}

function tick() {
  if (dirty) {
    dirty = false;
    if (!gl.isContextLost()) draw();
    point();
  }
  requestAnimationFrame(tick);
}

// -------- what the colors say

function select() { // take the frame and the quantity
  const frame = frames[shown.frame], { name, scale: kind, at } = shown.quantity;
  ({ faces, edges, owners, outlines, rim, solid, solidEnds, pieces, own } = meshes[frame.mesh]);
  positions = modeled(frame.positions);
  n = positions.length / 3;
  concave = frame.concave ? stored(frame.concave) : new Uint8Array(0);
  const of = frame.values[name] || (name === CONFORMAL && frames[last].values[name]); // the same for all
  values = of ? numbers(of) : new Float64Array(n).fill(NaN);
  [low, high] = (kind === "log" && of ? of : frames[last].values[name]).bounds;
  const faceted = of && (at === "faces" || !shown.smooth);
  flat = faceted && of.faces ? numbers(of.faces) : null;
  if (!gl.isContextLost()) {
    paint();
    upload();
  }
  legend();
  moment();
  dirty = true;
}

function legend() {
  const { label, unit, scale: kind, at } = shown.quantity;
  let least = Infinity, most = -Infinity, missing = 0;
  const there = own && at !== "faces" ? 1 + Math.max(...own) : values.length; // others draw arcs
  for (const value of values.subarray(0, there)) {
    if (Number.isFinite(value)) [least, most] = [Math.min(least, value), Math.max(most, value)];
    else missing++;
  }
  $("label").textContent = label + (unit && ` (${unit})`);
  const ramp = shown.quantity.ramp || data.ramp;
  $("colors").style.backgroundImage = `linear-gradient(to right, ${ramp.join(", ")})`;
  $("below").style.backgroundColor = ramp[0];
  $("above").style.backgroundColor = ramp[ramp.length - 1];
  const slack = 1e-6 * (high - low);
  $("below").style.visibility = least < low - slack ? "visible" : "hidden";
  $("above").style.visibility = most > high + slack ? "visible" : "hidden";
  const words = least <= most ? [least === most ? `all are ${written(meant(least))}` : `from ${written(meant(least))} to ${written(meant(most))}`] : [];
  const places = at === "faces" ? ["face", "faces"] : ["vertex", "vertices"];
  if (missing) words.push(`gray: no value at ${missing} ${places[missing === 1 ? 0 : 1]}`);
  $("span").textContent = words.join("; ");
  $("ticks").replaceChildren(...marks(kind).map((value) => {
    const mark = document.createElement("span");
    mark.textContent = kind === "log" ? written(10 ** value).replace(/^1\s×\s/, "") : written(value);
    mark.style.left = `${100 * (value - low) / (high - low)}%`;
    return mark;
  }));
}

function marks(kind) { // where the numbers stand beside the colors
  if (kind === "log" && high - low < 2) { // 1, 2 and 5 times powers of ten
    const powers = [0, 1, 2, 3, 4].map((k) => Math.floor(low) + k);
    return powers.flatMap((k) => [1, 2, 5].map((m) => k + Math.log10(m))).filter((value) => low <= value && value <= high);
  }
  const rough = (high - low) / 4, power = 10 ** Math.floor(Math.log10(rough));
  const whole = kind === "log" || shown.quantity.at === "faces";
  const step = whole ? Math.max(1, Math.round(rough)) : power * ([1, 2, 2.5, 5, 10].find((k) => k * power >= rough * 0.95) ?? 10);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

function moment() {
  const { stage, t, residual, remarks } = frames[shown.frame];
  let count = 0;
  for (const eight of concave) for (let b = eight; b; b &= b - 1) count++;
  const words = [`frame ${shown.frame + 1} of ${frames.length}`];
  if (t !== null) words.push(`t = ${written(t, 3)}`);
  if (residual !== null) words.push(`length errors up to ${written(residual, 2)}${shown.frame < last ? " at this t" : ""}`);
  count /= pieces;
  if (foldable) words.push(`${count.toLocaleString("en-US")} concave ${count === 1 ? "edge" : "edges"}`);
  const name = document.createElement("b");
  name.textContent = stage;
  $("moment").replaceChildren(name, ...words.flatMap((word) => {
    const whole = document.createElement("span"); // is not broken
    whole.textContent = word;
    return [" · ", whole];
  }), ...remarks.map((line) => {
    const whole = document.createElement("span");
    whole.className = "remarks";
    whole.textContent = line;
    return whole;
  }));
  $("frame").value = shown.frame;
  $("frame").setAttribute("aria-valuetext", [stage, ...words, ...remarks].join(", "));
}

// -------- turning and zooming

function turn(across, level, twist) { // by angles about the upright axis, the level one and the line of sight
  const angle = Math.hypot(across, level, twist);
  if (angle === 0) return;
  const [x, y, z] = [level / angle, across / angle, twist / angle], s = Math.sin(angle), c = 1 - Math.cos(angle);
  const r = [
    1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y,
    c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x,
    c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y),
  ];
  const m = view.turn, product = [];
  for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) product.push(r[3 * i] * m[j] + r[3 * i + 1] * m[3 + j] + r[3 * i + 2] * m[6 + j]);
  view.turn = orthonormal(product);
  changed();
}

/** @param {number[]} rows */
function orthonormal([a, b, c, d, e, f]) { // the rows do not drift
  const first = Math.hypot(a, b, c);
  [a, b, c] = [a / first, b / first, c / first];
  const along = a * d + b * e + c * f;
  [d, e, f] = [d - along * a, e - along * b, f - along * c];
  const second = Math.hypot(d, e, f);
  [d, e, f] = [d / second, e / second, f / second];
  return [a, b, c, d, e, f, b * f - c * e, c * d - a * f, a * e - b * d];
}

function zoom(factor, x = 0, y = 0) { // about a point, in pixels from the center, y up
  const to = Math.min(Math.max(view.zoom * factor, 0.4), 60), by = to / view.zoom;
  Object.assign(view, { zoom: to, x: x + (view.x - x) * by, y: y + (view.y - y) * by });
  changed();
}

function reset() {
  Object.assign(view, { turn: still.slice(), zoom: 1, x: 0, y: 0 });
  changed();
}

function changed() {
  dirty = true;
  placed = null;
}

/** @type {Map<number, [number, number]>} */
const pointers = new Map();
/** @type {(event: MouseEvent) => [number, number]} */
const where = (event) => {
  const box = canvas.getBoundingClientRect();
  return [event.clientX - box.left - box.width / 2, box.top + box.height / 2 - event.clientY];
};
let moved = 0;

function down(event) {
  if (event.button) return;
  if (!pointers.size) moved = 0;
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, where(event));
}

function move(event) {
  const here = where(event), before = pointers.get(event.pointerId);
  if (!before) {
    if (event.pointerType !== "touch") hover(here);
    return;
  }
  const [dx, dy] = [here[0] - before[0], here[1] - before[1]];
  moved += Math.hypot(dx, dy);
  if (pointers.size === 1) {
    const { unit } = fit();
    turn(dx / unit, -dy / unit, 0);
  } else {
    const [other] = [...pointers].flatMap(([id, there]) => (id === event.pointerId ? [] : [there]));
    const arm = [before[0] - other[0], before[1] - other[1]], now = [here[0] - other[0], here[1] - other[1]];
    zoom(Math.hypot(...now) / Math.max(Math.hypot(...arm), 1), ...other);
    turn(0, 0, Math.atan2(arm[0] * now[1] - arm[1] * now[0], arm[0] * now[0] + arm[1] * now[1]));
  }
  pointers.set(event.pointerId, here);
}

function up(event) {
  if (pointers.delete(event.pointerId) && moved < 6 && event.type === "pointerup") hover(where(event));
}

const KEYS = {
  ArrowLeft: () => turn(-0.1, 0, 0), ArrowRight: () => turn(0.1, 0, 0),
  ArrowUp: () => turn(0, -0.1, 0), ArrowDown: () => turn(0, 0.1, 0),
  "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), 0: reset,
  Enter: () => hover([0, 0]),
};

// -------- the vertex pointed at

/** @type {Float32Array | null} */
let placed = null; // the vertices on the screen: pixels from the center, and nearness

function place() {
  const { unit } = fit(), grown = view.zoom * unit, t = view.turn;
  const at = new Float32Array(3 * n);
  for (let v = 0; v < 3 * n; v += 3) {
    const [x, y, z] = [positions[v], positions[v + 1], positions[v + 2]];
    const near = t[6] * x + t[7] * y + t[8] * z, w = 1 - near / FAR;
    at[v] = (t[0] * x + t[1] * y + t[2] * z) * grown / w + view.x;
    at[v + 1] = (t[3] * x + t[4] * y + t[5] * z) * grown / w + view.y;
    at[v + 2] = near;
  }
  placed = at;
  return at;
}

/** @param {number[]} here */
function hover([x, y]) { // the front triangle there, and its nearest corner
  const at = placed ?? place();
  let best = -Infinity, found = -1;
  pointed = -1;
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const u = (at[b] - x) * (at[c + 1] - y) - (at[c] - x) * (at[b + 1] - y);
    const v = (at[c] - x) * (at[a + 1] - y) - (at[a] - x) * (at[c + 1] - y);
    const w = (at[a] - x) * (at[b + 1] - y) - (at[b] - x) * (at[a + 1] - y);
    if ((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) {
      const nearness = (u * at[a + 2] + v * at[b + 2] + w * at[c + 2]) / (u + v + w);
      if (nearness > best) {
        best = nearness;
        pointed = f / 3;
        const apart = [a, b, c].map((p) => Math.hypot(at[p] - x, at[p + 1] - y));
        found = [a, b, c][apart.indexOf(Math.min(...apart))] / 3;
        if (own) found = own[found];
      }
    }
  }
  hovered = found;
  point();
}

function point() { // mark the vertex, and say what it is
  const face = shown.quantity.at === "faces" && owners && pointed >= 0 ? owners[pointed] : -1;
  $("tip").hidden = hovered < 0;
  $("mark").hidden = hovered < 0 || face >= 0;
  if (hovered < 0) return;
  const at = placed ?? place();
  const { w, h } = fit();
  const [x, y] = [w / 2 + at[3 * hovered], h / 2 - at[3 * hovered + 1]];
  const name = document.createElement("b");
  name.textContent = face >= 0 ? `face ${face}` : `vertex ${hovered}`;
  $("tip").replaceChildren(name, `  ${shown.quantity.name} ${written(meant(values[face >= 0 ? face : hovered]))}`);
  Object.assign($("mark").style, { left: `${x}px`, top: `${y}px` });
  const { offsetWidth, offsetHeight } = $("tip");
  const left = Math.min(Math.max(x + 14, 4), w - offsetWidth - 4), top = y - offsetHeight - 12;
  Object.assign($("tip").style, { left: `${left}px`, top: `${top > 4 ? top : y + 14}px` });
}

// -------- the film

let playing = 0; // the time of the next frame

function play(now) {
  if (!playing) return;
  if (now >= playing) {
    if (shown.frame === last) {
      pause();
      return;
    }
    show(shown.frame + 1);
    playing = now + frames[shown.frame].pause;
  }
  requestAnimationFrame(play);
}

function pause() {
  playing = 0;
  $("play").textContent = "▶";
  $("play").setAttribute("aria-label", "Play");
}

function start() {
  if (shown.frame === last) show(0);
  playing = performance.now() + frames[shown.frame].pause;
  $("play").textContent = "❚❚";
  $("play").setAttribute("aria-label", "Pause");
  requestAnimationFrame(play);
}

function show(frame) {
  shown.frame = frame;
  placed = null;
  select();
}

// -------- beginning

function dark() {
  return getComputedStyle(document.documentElement).colorScheme === "dark" ||
    (!document.documentElement.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
}

$("theme").addEventListener("click", () => {
  document.documentElement.dataset.theme = dark() ? "light" : "dark";
});

if (gl) {
  build();
  $("controls").hidden = false;
  $("film").hidden = last === 0;
  $("alone").hidden = !data.alone;
  $("alone").textContent = data.alone;
  $("frame").max = last;
  for (const { name } of data.quantities) $("color").append(new Option(name));
  $("color").addEventListener("change", () => {
    shown.quantity = data.quantities[$("color").selectedIndex];
    $("creases").disabled = shown.quantity.name === CONCAVE; // they are drawn with their share
    $("creases").checked = shown.creases || $("creases").disabled;
    select();
  });
  $("kind").textContent = owners ? "Edges" : "Triangles";
  $("paper").hidden = !data.seams;
  $("folds").hidden = !foldable;
  $("models").hidden = !space;
  for (const { name } of space ? space.models : []) $("model").append(new Option(name));
  $("model").addEventListener("change", () => {
    model = /** @type {PageSpace} */ (space).models[$("model").selectedIndex].model;
    measure();
    placed = null;
    select();
  });
  $("moment").style.setProperty("--remarks", `${1.5 * Math.max(...frames.map(({ remarks }) => remarks.length))}em`); // the surface stays
  for (const name of ["mesh", "seams", "creases", "smooth"]) {
    $(name).addEventListener("change", () => {
      shown[name] = $(name).checked;
      if (name === "smooth" && owners) select(); // faces are of one color, or shaded
      dirty = true;
    });
  }
  $("frame").addEventListener("input", () => {
    pause();
    show(Number($("frame").value));
  });
  $("play").addEventListener("click", () => (playing ? pause() : start()));
  $("closer").addEventListener("click", () => zoom(1.3));
  $("farther").addEventListener("click", () => zoom(1 / 1.3));
  $("reset").addEventListener("click", reset);
  canvas.addEventListener("dblclick", reset);
  canvas.addEventListener("pointerdown", down);
  canvas.addEventListener("pointermove", move);
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, up);
  canvas.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") hover([Infinity, Infinity]);
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...where(event));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in KEYS)) return;
    event.preventDefault();
    KEYS[event.key]();
  });
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => {
    build();
    select();
  });
  new ResizeObserver(changed).observe(canvas);
  measure();
  select();
  requestAnimationFrame(tick);
} else {
  canvas.hidden = $("buttons").hidden = true;
  $("sorry").hidden = false;
  $("sorry").textContent = "The surface is drawn with WebGL 2, which this browser does not have or has turned off. The report does without.";
}
}
