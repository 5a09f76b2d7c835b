// A camera that turns about a point.
"use strict";

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => { const l = Math.hypot(...a) || 1; return a.map((c) => c / l); };
const plus = (a, b, f) => a.map((c, i) => c + f * b[i]);

// Half of the angle of view.
const HALF_ANGLE = (15 * Math.PI) / 180;

// Looks along the shortest side of a box, a little from above.
report.camera = function (box) {
  const size = [0, 1, 2].map((k) => box.high[k] - box.low[k]);
  const is_flat = size[2] < 0.2 * Math.min(size[0], size[1]);
  const start = is_flat ? { yaw: 0, pitch: Math.PI / 2 - 1e-3 } : { yaw: size[0] <= size[1] ? Math.PI / 2 : 0, pitch: 0.18 };
  if (!is_flat && Math.max(size[0], size[1]) < 1.5 * Math.min(size[0], size[1])) Object.assign(start, { yaw: 0.6, pitch: 0.3 });
  const home = () => ({ ...start, target: [0, 1, 2].map((k) => 0.5 * (box.low[k] + box.high[k])), zoom: 1, radius: 0.5 * Math.hypot(...size) || 1 });
  let now = home();
  const axes = () => {
    const [cp, sp] = [Math.cos(now.pitch), Math.sin(now.pitch)];
    const back = [Math.sin(now.yaw) * cp, -Math.cos(now.yaw) * cp, sp];
    const right = unit([Math.cos(now.yaw), Math.sin(now.yaw), 0]);
    return { back, right, up: cross(back, right) };
  };
  const distance = () => (0.88 * now.radius) / Math.sin(HALF_ANGLE) / now.zoom;
  return {
    home: () => { now = home(); },
    turn: (dx, dy) => {
      now.yaw -= dx * 0.008;
      now.pitch = Math.max(-1.57, Math.min(1.57, now.pitch + dy * 0.008));
    },
    shift: (dx, dy, height) => {
      const { right, up } = axes();
      const step = (2 * distance() * Math.tan(HALF_ANGLE)) / height;
      now.target = plus(plus(now.target, right, -dx * step), up, dy * step);
    },
    zoom: (factor) => { now.zoom = Math.max(0.05, Math.min(5000, now.zoom * factor)); },
    look_at: (target, zoom) => { now.target = target; now.zoom = zoom; },
    // Matrix by columns from places to the screen, the eye and the light.
    state: (aspect) => {
      const { back, right, up } = axes();
      const d = distance();
      const eye = plus(now.target, back, d);
      const [near, far] = [Math.max(d - 4 * now.radius, d * 0.01), d + 4 * now.radius];
      const f = 1 / Math.tan(HALF_ANGLE) * Math.min(1, aspect);
      const rows = [
        [...right.map((c) => (f / aspect) * c), (-f / aspect) * dot(right, eye)],
        [...up.map((c) => f * c), -f * dot(up, eye)],
      ];
      const depth = [...back.map((c) => -c), dot(back, eye)];
      const a = (far + near) / (far - near);
      const b = (-2 * far * near) / (far - near);
      rows.push(depth.map((c, i) => a * c + (i === 3 ? b : 0)), depth);
      const matrix = new Float32Array(16);
      rows.forEach((row, i) => row.forEach((c, j) => { matrix[4 * j + i] = c; }));
      return { matrix, eye, lamp: unit(plus(plus(back, up, 0.7), right, -0.5)) };
    },
  };
};
