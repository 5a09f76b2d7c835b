// Bodies of the report at an instant: pose * (x + factor * sum of coordinates times shapes), with normals and values at the vertices.
"use strict";

// Decodes a body and prepares its buffers. A section is revolved into `around` copies of its vertices.
report.body = async function (json) {
  const x = await report.values(json.x);
  const shapes = [];
  for (const shape of json.shapes) {
    const [displacement, stress] = [await report.values(shape.displacement), shape.stress && (await report.values(shape.stress))];
    shapes.push({ displacement, stress });
  }
  const series = (arrays) => Promise.all((arrays || []).map((array) => report.values(array)));
  const stills = new Map();
  for (const still of json.stills) {
    stills.set(still.frame, { largest: still.largest, values: await report.values(still.von_mises) });
  }
  const n = json.vertices;
  const copies = Math.max(1, json.around);
  return {
    name: json.name, json, x, shapes, stills, n, copies,
    coordinates: await series(json.coordinates), rates: await series(json.rates),
    pose: await report.values(json.pose), velocity: await report.values(json.velocity),
    triangles: triangles(await report.values(json.parts), json, n),
    u: new Float64Array(3 * n), v: new Float64Array(3 * n), s: new Float64Array(6 * n),
    positions: new Float32Array(3 * n * copies), normals: new Float32Array(3 * n * copies), values: new Float32Array(n * copies),
    has_stress: shapes.length > 0 && shapes.every((shape) => shape.stress),
  };
};

function triangles(parts, json, n) {
  if (json.corners === 3) return Uint32Array.from(parts);
  const out = [];
  for (let k = 0; k < json.around; k++) {
    const next = (k + 1) % json.around;
    for (let i = 0; i < parts.length; i += 2) {
      const [a, b, c, d] = [parts[i] + k * n, parts[i + 1] + k * n, parts[i + 1] + next * n, parts[i] + next * n];
      out.push(a, b, c, a, c, d);
    }
  }
  return Uint32Array.from(out);
}

function combine(out, shapes, field, coordinates, frame) {
  out.fill(0);
  for (let k = 0; k < shapes.length; k++) {
    const [q, shape] = [coordinates[k][frame], shapes[k][field]];
    if (q === 0) continue;
    for (let i = 0; i < out.length; i++) out[i] += q * shape[i];
  }
}

// Rows of the rotation of a quaternion w, x, y, z.
function rotation(pose, at) {
  const [w, x, y, z] = [pose[at + 3], pose[at + 4], pose[at + 5], pose[at + 6]];
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
  ];
}

function von_mises(s, i) {
  const [x, y, z, xy, yz, zx] = [s[i], s[i + 1], s[i + 2], s[i + 3], s[i + 4], s[i + 5]];
  const normal = (x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2;
  return Math.sqrt(0.5 * normal + 3 * (xy * xy + yz * yz + zx * zx));
}

// The quantity at the vertices of a body; NaN where there is none.
function values_at(body, frame, quantity, turn) {
  const { n, u, v, s, x, velocity } = body;
  const out = new Float64Array(n).fill(NaN);
  if (quantity === "von_mises") {
    const still = body.stills.get(frame);
    if (still) return still.values;
    if (!body.has_stress) return out;
    combine(s, body.shapes, "stress", body.coordinates, frame);
    for (let i = 0; i < n; i++) out[i] = von_mises(s, 6 * i);
  } else if (quantity === "displacement") {
    for (let i = 0; i < n; i++) out[i] = Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]);
  } else if (quantity === "speed") {
    combine(v, body.shapes, "displacement", body.rates, frame);
    const [a, b, c, p, q, r] = velocity.subarray(6 * frame, 6 * frame + 6);
    for (let i = 0; i < n; i++) {
      const m = [0, 1, 2].map((k) => x[3 * i + k] + u[3 * i + k]);
      const arm = turned(turn, m[0], m[1], m[2]);
      const rate = turned(turn, v[3 * i], v[3 * i + 1], v[3 * i + 2]);
      out[i] = Math.hypot(
        a + q * arm[2] - r * arm[1] + rate[0], b + r * arm[0] - p * arm[2] + rate[1], c + p * arm[1] - q * arm[0] + rate[2]);
    }
  }
  return out;
}

function turned(m, x, y, z) {
  return [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];
}

// Moves a body to a frame; returns the largest value at its vertices, NaN if it has none.
report.move = function (body, frame, factor, quantity, centre) {
  const { n, copies, x, u, positions, values } = body;
  const turn = rotation(body.pose, 7 * frame);
  const origin = [0, 1, 2].map((k) => body.pose[7 * frame + k] - centre[k]);
  combine(u, body.shapes, "displacement", body.coordinates, frame);
  const at_vertices = values_at(body, frame, quantity, turn);
  for (let copy = 0; copy < copies; copy++) {
    const angle = (2 * Math.PI * copy) / copies;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    for (let i = 0; i < n; i++) {
      const [a, b, c] = [x[3 * i] + factor * u[3 * i], x[3 * i + 1] + factor * u[3 * i + 1], x[3 * i + 2] + factor * u[3 * i + 2]];
      const p = turned(turn, cos * a - sin * b, sin * a + cos * b, c);
      const at = 3 * (copy * n + i);
      for (let k = 0; k < 3; k++) positions[at + k] = origin[k] + p[k];
    }
    values.set(at_vertices, copy * n);
  }
  smooth(body);
  let largest = NaN;
  for (const value of at_vertices) if (!(value <= largest) && !Number.isNaN(value)) largest = value;
  return largest;
};

// Normals at the vertices, means over the triangles by their areas.
function smooth({ positions: p, normals, triangles: t }) {
  normals.fill(0);
  for (let i = 0; i < t.length; i += 3) {
    const [a, b, c] = [3 * t[i], 3 * t[i + 1], 3 * t[i + 2]];
    const [ux, uy, uz] = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
    const [vx, vy, vz] = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const at of [a, b, c]) {
      normals[at] += x;
      normals[at + 1] += y;
      normals[at + 2] += z;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let k = 0; k < 3; k++) normals[i + k] /= length;
  }
}
