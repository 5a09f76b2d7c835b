// Draws moving surfaces with WebGL2.
"use strict";

const VERTEX = `#version 300 es
in vec3 position; in vec3 normal; in float value;
uniform mat4 view;
out vec3 place; out vec3 smooth_normal; out float shade;
void main() { place = position; smooth_normal = normal; shade = value; gl_Position = view * vec4(position, 1.0); }`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place; in vec3 smooth_normal; in float shade;
uniform vec3 eye; uniform vec3 lamp; uniform float largest; uniform vec4 plain; uniform sampler2D colours;
out vec4 colour;
void main() {
  vec3 flat_normal = normalize(cross(dFdx(place), dFdy(place)));
  vec3 towards = normalize(eye - place);
  // At edges of the body the normals of its vertices lie between both sides.
  bool is_round = abs(dot(flat_normal, normalize(smooth_normal))) > 0.8;
  vec3 n = is_round ? normalize(smooth_normal) : flat_normal;
  n *= sign(dot(n, towards));
  float light = 0.42 + 0.5 * max(dot(n, lamp), 0.0) + 0.12 * max(dot(n, towards), 0.0);
  bool has_value = shade >= 0.0 && largest > 0.0 && plain.a >= 1.0;
  vec3 base = has_value ? texture(colours, vec2(clamp(shade / largest, 0.0, 1.0) * 0.996 + 0.002, 0.5)).rgb : plain.rgb;
  colour = vec4(base * min(light, 1.08), plain.a);
}`;

// Viridis, which rises in lightness and is told apart by people with any kind of colour vision.
const STOPS = ["440154", "482878", "3e4a89", "31688e", "26828e", "1f9e89", "35b779", "6dcd59", "b4de2c", "fde725"];
report.gradient = "linear-gradient(90deg," + STOPS.map((s) => "#" + s).join(",") + ")";

function colour_table() {
  const rgb = STOPS.map((s) => [0, 2, 4].map((i) => parseInt(s.slice(i, i + 2), 16)));
  const out = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (rgb.length - 1);
    const k = Math.min(Math.floor(at), rgb.length - 2);
    for (let c = 0; c < 3; c++) out[4 * i + c] = Math.round(rgb[k][c] + (at - k) * (rgb[k + 1][c] - rgb[k][c]));
    out[4 * i + 3] = 255;
  }
  return out;
}

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) || "no shader");
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) || "no program");
  return made;
}

// Buffers of a body, which change with every frame, and of its triangles.
function mesh(gl, made, { positions, normals, values, triangles }) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const buffers = [["position", positions, 3], ["normal", normals, 3], ["value", values, 1]].map(([name, data, size]) => {
    const buffer = gl.createBuffer();
    const place = gl.getAttribLocation(made, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    return [buffer, data];
  });
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  return { array, buffers, count: triangles.length };
}

// A painter of `bodies` and `sheets` (plain surfaces) on a canvas; throws where there is no WebGL2.
report.painter = function (canvas, bodies, sheets) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
  if (!gl) throw new Error("there is no WebGL2");
  let state = null;
  const prepare = () => {
    const made = program(gl);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colour_table());
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    const place = (name) => gl.getUniformLocation(made, name);
    const places = Object.fromEntries(["view", "eye", "lamp", "largest", "plain", "colours"].map((name) => [name, place(name)]));
    state = { made, places, bodies: bodies.map((b) => mesh(gl, made, b)), sheets: sheets.map((b) => mesh(gl, made, b)) };
  };
  prepare();
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  const draw_all = (meshes, colour) => {
    gl.uniform4fv(state.places.plain, colour);
    for (const { array, count } of meshes) {
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    }
  };
  return {
    gl, prepare,
    upload: () => state.bodies.forEach(({ buffers }) => buffers.forEach(([buffer, data]) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
    })),
    draw: (camera, largest) => {
      const paper = report.dark() ? [0.11, 0.125, 0.14] : [0.975, 0.98, 0.985];
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...paper, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.useProgram(state.made);
      gl.uniformMatrix4fv(state.places.view, false, camera.matrix);
      gl.uniform3fv(state.places.eye, camera.eye);
      gl.uniform3fv(state.places.lamp, camera.lamp);
      gl.uniform1f(state.places.largest, largest);
      gl.uniform1i(state.places.colours, 0);
      draw_all(state.bodies, [0.62, 0.65, 0.68, 1]);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      draw_all(state.sheets, [0.5, 0.52, 0.55, 0.3]);
      gl.disable(gl.BLEND);
    },
  };
};
