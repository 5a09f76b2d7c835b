// Bodies in motion with their controls. Drawn when something changes, never otherwise.
"use strict";

const QUANTITIES = {
  von_mises: { name: "von Mises stress", unit: "Pa" },
  displacement: { name: "elastic displacement", unit: "m" },
  speed: { name: "speed", unit: "m/s" },
  none: { name: "nothing", unit: "" },
};
// Displacements reach this part of a body at first.
const SEEN = 0.05;
// Milliseconds a state.
const PACE = 33;

function element(name, parent, properties = {}) {
  const made = Object.assign(document.createElement(name), properties);
  parent.append(made);
  return made;
}

// Box around all bodies at some of the states.
function box_of(bodies, n_frames) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const body of bodies) {
    let reach = 0;
    for (let i = 0; i < body.x.length; i += 3) reach = Math.max(reach, Math.hypot(body.x[i], body.x[i + 1], body.x[i + 2]));
    for (let frame = 0; frame < n_frames; frame += Math.max(1, Math.floor(n_frames / 40))) {
      const turn = rotation(body.pose, 7 * frame);
      const step = 3 * Math.max(1, Math.floor(body.n / 300));
      for (let copy = 0; copy < Math.min(body.copies, 1) + (body.copies > 1 ? 3 : 0); copy++) {
        const [cos, sin] = [Math.cos(copy * Math.PI / 2), Math.sin(copy * Math.PI / 2)];
        for (let i = 0; i < body.x.length; i += step) {
          const [a, b] = [body.x[i], body.x[i + 1]];
          const p = turned(turn, cos * a - sin * b, sin * a + cos * b, body.x[i + 2]);
          for (let k = 0; k < 3; k++) {
            const at = p[k] + body.pose[7 * frame + k];
            low[k] = Math.min(low[k], at);
            high[k] = Math.max(high[k], at);
          }
        }
      }
    }
    body.reach = reach;
  }
  return { low, high };
}

// A square of a plane at rest below the bodies.
function sheet(plane, centre, radius) {
  const normal = unit(plane.normal);
  const gap = dot(centre.map((c, k) => c - plane.point[k]), normal);
  const middle = normal.map((n) => -gap * n);
  const a = unit(cross(normal, Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const b = cross(normal, a);
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, t]) => plus(plus(middle, a, s * radius), b, t * radius));
  const positions = Float32Array.from(corners.flat());
  const normals = Float32Array.from(corners.flatMap(() => normal));
  return { positions, normals, values: new Float32Array(4).fill(-1), triangles: Uint32Array.from([0, 1, 2, 0, 2, 3]) };
}

report.view = async function (scene, place) {
  const bodies = [];
  for (const json of scene.bodies) bodies.push(await report.body(json));
  const box = box_of(bodies, scene.time.length);
  const centre = [0, 1, 2].map((k) => 0.5 * (box.low[k] + box.high[k]));
  const local = { low: box.low.map((c, k) => c - centre[k]), high: box.high.map((c, k) => c - centre[k]) };
  const radius = 0.5 * Math.hypot(...local.high.map((c, k) => c - local.low[k])) || 1;
  const sheets = scene.planes.map((plane) => sheet(plane, centre, 1.3 * radius));
  const frame_box = element("div", place, { className: "view" });
  const canvas = element("canvas", frame_box, { tabIndex: 0 });
  let painter;
  try {
    painter = report.painter(canvas, bodies, sheets);
  } catch (error) {
    frame_box.remove();
    throw error;
  }
  place.querySelector(".note").remove();
  const viewer = {
    scene, bodies, painter, canvas, centre, camera: report.camera(local),
    legend: element("div", frame_box, { className: "legend" }),
    readout: element("div", frame_box, { className: "readout" }),
    frame: 0, factor: 1, quantity: bodies.some((b) => b.has_stress) ? "von_mises" : "speed", span: "nearly", is_due: false, timer: 0,
  };
  controls(viewer, place);
  remarks(viewer, place);
  hands(viewer);
  const redraw = () => schedule(viewer);
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  canvas.addEventListener("webglcontextrestored", () => { painter.prepare(); redraw(); });
  viewer.go_to = (time) => viewer.show(nearest(scene.time, time));
  viewer.probe = () => probe(viewer);
  // The first thing to be seen is what a run is made for.
  viewer.show(scene.peaks.length > 0 ? scene.peaks[0] : Math.floor(scene.time.length / 2));
  draw(viewer);
  return viewer;
};

function nearest(times, time) {
  let best = 0;
  for (let i = 1; i < times.length; i++) if (Math.abs(times[i] - time) < Math.abs(times[best] - time)) best = i;
  return best;
}

// Largest displacement as it shows at first, of the body that shows most.
function first_factor(bodies) {
  const parts = bodies.filter((b) => b.shapes.length > 0 && b.json.largest.displacement > 0);
  const factors = parts.map((b) => (SEEN * b.reach) / b.json.largest.displacement);
  return factors.length > 0 ? Math.max(1, Math.min(...factors)) : 1;
}

function controls(viewer, place) {
  const { scene } = viewer;
  const bar = element("div", place, { className: "controls" });
  const time = element("div", bar, { className: "time" });
  const play = element("button", time, { type: "button", textContent: "Play" });
  const slider = element("input", time, { type: "range", min: 0, max: scene.time.length - 1, step: 1, value: 0, ariaLabel: "stored state" });
  const clock = element("output", time);
  viewer.show = (frame) => {
    viewer.frame = frame;
    slider.value = frame;
    schedule(viewer);
  };
  viewer.tell = () => {
    const digits = 9;
    clock.textContent = "t = " + report.text(scene.time[viewer.frame], digits) + " s" + (scene.in_impact[viewer.frame] ? ", impact" : "");
  };
  slider.addEventListener("input", () => viewer.show(Number(slider.value)));
  const stop = () => { clearInterval(viewer.timer); viewer.timer = 0; play.textContent = "Play"; };
  play.addEventListener("click", () => {
    if (viewer.timer) return stop();
    play.textContent = "Pause";
    if (viewer.frame === scene.time.length - 1) viewer.show(0);
    viewer.timer = setInterval(() => (viewer.frame + 1 < scene.time.length ? viewer.show(viewer.frame + 1) : stop()), PACE);
  });
  const peaks = scene.peaks.slice(0, 12);
  peaks.forEach((frame, i) => {
    const button = element("button", bar, { type: "button", textContent: "Impact " + (i + 1), title: "the largest force of this impact" });
    button.addEventListener("click", () => { stop(); viewer.show(frame); });
  });
  colours(viewer, bar);
  magnification(viewer, bar);
  const home = element("button", bar, { type: "button", textContent: "Whole view" });
  home.addEventListener("click", () => { viewer.camera.home(); schedule(viewer); });
  const save = element("button", bar, { type: "button", textContent: "Picture" });
  save.addEventListener("click", () => picture(viewer));
}

// What thinning and rounding cost.
function remarks({ scene, bodies }, place) {
  const shown = scene.time.length;
  const of = (key) => Math.max(0, ...bodies.map((b) => (b.json.errors && b.json.errors[key]) || 0));
  const parts = [["displacement", "displacement"], ["von_mises", "von Mises stress"], ["speed", "speed"]].map(([key, name]) => [name, of(key)]);
  const errors = parts.filter(([, error]) => error > 0).map(([name, error]) => name + " " + report.text(100 * error, 2) + " %");
  const states = shown < scene.stored ? shown + " of " + scene.stored + " stored states" : "all " + shown + " stored states";
  const within = errors.length > 0 ? "; right to these parts of the largest: " + errors.join(", ") : "";
  element("p", place, { className: "note", textContent: states + within + ". Drag turns, the wheel zooms, shift and drag moves, a double click brings a place near." });
}

function colours(viewer, bar) {
  const label = element("label", bar, { textContent: "colour" });
  const select = element("select", label);
  for (const [key, { name }] of Object.entries(QUANTITIES)) {
    if (key !== "von_mises" || viewer.bodies.some((b) => b.has_stress)) element("option", select, { value: key, textContent: name });
  }
  select.value = viewer.quantity;
  select.addEventListener("change", () => { viewer.quantity = select.value; schedule(viewer); });
  const span = element("select", element("label", bar, { textContent: "up to" }));
  element("option", span, { value: "nearly", textContent: "98 % of this state" });
  element("option", span, { value: "state", textContent: "the largest of this state" });
  element("option", span, { value: "run", textContent: "the largest of the run" });
  span.addEventListener("change", () => { viewer.span = span.value; schedule(viewer); });
}

function magnification(viewer, bar) {
  const first = first_factor(viewer.bodies);
  if (!viewer.bodies.some((b) => b.shapes.length > 0)) return;
  const label = element("label", bar, { textContent: "displacement ×" });
  const most = Math.log10(Math.max(10, first * 20));
  const slider = element("input", label, { type: "range", min: 0, max: 1000, step: 1, value: Math.round((1000 * Math.log10(first)) / most) });
  const shown = element("output", label);
  const apply = () => {
    viewer.factor = 10 ** ((most * Number(slider.value)) / 1000);
    shown.textContent = report.text(viewer.factor, 3);
    schedule(viewer);
  };
  slider.addEventListener("input", apply);
  apply();
}

function schedule(viewer) {
  if (viewer.is_due) return;
  viewer.is_due = true;
  requestAnimationFrame(() => { viewer.is_due = false; draw(viewer); });
}

// Largest value of the run, which colours go up to.
function largest_of_run({ bodies, quantity }) {
  const stills = quantity === "von_mises" ? bodies.flatMap((b) => [...b.stills.values()].map((still) => Math.max(...still.values))) : [];
  return Math.max(0, ...bodies.map((b) => b.json.largest[quantity] || 0), ...stills);
}

// The value that a fiftieth of the vertices go beyond: small spots of large values leave the rest its colours.
function nearly_largest(bodies) {
  const all = bodies.flatMap((b) => Array.from(b.values.subarray(0, b.n)).filter((x) => x >= 0)).sort((a, b) => a - b);
  return all.length > 0 ? all[Math.floor(0.98 * (all.length - 1))] : 0;
}

function draw(viewer) {
  const { bodies, painter, canvas, camera, frame, quantity, factor, centre } = viewer;
  const largest = bodies.map((b) => report.move(b, frame, factor, quantity, centre)).filter((x) => !Number.isNaN(x));
  const spans = { state: () => Math.max(0, ...largest), run: () => largest_of_run(viewer), nearly: () => nearly_largest(bodies) };
  viewer.largest = spans[viewer.span]();
  for (const { values } of bodies) for (let i = 0; i < values.length; i++) if (Number.isNaN(values[i])) values[i] = -1;
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const [width, height] = [Math.max(1, Math.round(canvas.clientWidth * ratio)), Math.max(1, Math.round(canvas.clientHeight * ratio))];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  viewer.view = camera.state(width / height);
  painter.upload();
  painter.draw(viewer.view, quantity === "none" ? 0 : viewer.largest);
  viewer.tell();
  tell_colours(viewer);
}

function tell_colours(viewer) {
  const { legend, quantity, bodies, frame, scene, largest } = viewer;
  const { name, unit: of } = QUANTITIES[quantity];
  legend.replaceChildren();
  legend.hidden = quantity === "none";
  element("div", legend, { textContent: name });
  element("div", legend, { className: "bar" }).style.background = report.gradient;
  const ends = element("div", legend, { className: "ends" });
  element("span", ends, { textContent: "0" });
  element("span", ends, { textContent: (viewer.span === "nearly" ? "≥ " : "") + report.with_unit(largest, of) });
  if (quantity !== "von_mises") return;
  const stills = bodies.map((b) => b.stills.get(frame)).filter(Boolean);
  if (stills.length > 0) {
    const most = Math.max(...stills.map((still) => still.largest));
    element("div", legend, { textContent: "with the contact zones, whose largest is " + report.with_unit(most, of) });
  } else if (scene.in_impact[frame]) {
    element("div", legend, { textContent: "without what contact zones add" });
  }
}

// Mouse, fingers and wheel; what lies under the pointer is told.
function hands(viewer) {
  const { canvas, camera } = viewer;
  const held = new Map();
  let spread = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
    spread = 0;
  });
  const release = (event) => held.delete(event.pointerId);
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) return point_at(viewer, event);
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    held.set(event.pointerId, [event.clientX, event.clientY]);
    if (held.size > 1) {
      const [a, b] = [...held.values()];
      const now = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (spread > 0) camera.zoom(now / spread);
      spread = now;
    } else if (event.shiftKey || event.buttons > 1) camera.shift(dx, dy, canvas.clientHeight);
    else camera.turn(dx, dy);
    schedule(viewer);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(-event.deltaY * 0.0015));
    schedule(viewer);
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => {
    const hit = nearest_vertex(viewer, event);
    if (hit) { camera.look_at(hit.place, 8); schedule(viewer); }
  });
}

// The vertex next to the pointer, the foremost of those within some pixels.
function nearest_vertex(viewer, event) {
  const { matrix: m } = viewer.view;
  const { left, top, width, height } = viewer.canvas.getBoundingClientRect();
  const [px, py] = [event.clientX - left, event.clientY - top];
  let best = null;
  for (const body of viewer.bodies) {
    const p = body.positions;
    for (let i = 0; i < p.length; i += 3) {
      const w = m[3] * p[i] + m[7] * p[i + 1] + m[11] * p[i + 2] + m[15];
      const x = (0.5 + (m[0] * p[i] + m[4] * p[i + 1] + m[8] * p[i + 2] + m[12]) / w / 2) * width;
      const y = (0.5 - (m[1] * p[i] + m[5] * p[i + 1] + m[9] * p[i + 2] + m[13]) / w / 2) * height;
      const distance = Math.hypot(x - px, y - py);
      if (distance > 14) continue;
      if (!best || w < best.depth || distance < best.distance - 6) best = { body, vertex: i / 3, depth: w, distance, place: [p[i], p[i + 1], p[i + 2]] };
    }
  }
  return best;
}

function point_at(viewer, event) {
  const hit = viewer.view && nearest_vertex(viewer, event);
  const { name, unit: of } = QUANTITIES[viewer.quantity];
  const value = hit ? hit.body.values[hit.vertex] : -1;
  viewer.readout.textContent = hit ? hit.body.name + (value >= 0 && of ? ": " + name + " " + report.with_unit(value, of) : "") : "";
}

// Saves what is drawn; a canvas keeps it until the task ends.
function picture(viewer) {
  draw(viewer);
  viewer.canvas.toBlob((blob) => {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: "bodies.png" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

// What is drawn, for tests: how much of the canvas is not paper, and values of the first, middle and last states.
function probe(viewer) {
  const { painter: { gl }, canvas, bodies, scene } = viewer;
  draw(viewer);
  const pixels = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let covered = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if ([0, 1, 2].some((c) => Math.abs(pixels[i + c] - pixels[c]) > 12)) covered++;
  }
  const last = scene.time.length - 1;
  const states = [...new Set([0, Math.floor(last / 2), last, ...scene.peaks])].map((frame) => {
    const of = (quantity) => bodies.map((b) => report.move(b, frame, 1, quantity, [0, 0, 0]));
    const [von_mises, displacement, speed] = ["von_mises", "displacement", "speed"].map(of);
    const places = bodies.map((b) => Array.from(b.positions.slice(0, 3)));
    return { frame, time: scene.time[frame], von_mises, displacement, speed, places };
  });
  return { error: gl.getError(), covered: (4 * covered) / pixels.length, states };
}
