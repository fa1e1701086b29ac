// The track from above: what stays is drawn once, the car and its plan in each frame.

import { state, X, Y, at, pose, reached } from './state.js';

const box = document.getElementById('map');
const [base, top] = box.querySelectorAll('canvas');
let view = null, drawn = '', following = false;

export function follow(on) { following = on; drawn = ''; }

function size(canvas) {
  const scale = Math.min(2, window.devicePixelRatio || 1);
  const [width, height] = [box.clientWidth, box.clientHeight];
  const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const g = canvas.getContext('2d');
  g.setTransform(scale, 0, 0, scale, 0, 0);
  return { g, width, height };
}

// From metres to pixels: the whole track, turned if it then is larger, or the surroundings of the car.
function fit(width, height, car) {
  const world = state.world;
  if (following && car) {
    const radius = Math.max(7 * (world.car.front + world.car.rear), 0.8 * Math.abs(state.car?.v ?? 0));
    const scale = Math.min(width, height) / (2 * radius), turn = Math.PI / 2 - car.yaw;
    return place(scale, turn, car.x, car.y, width / 2, height * 0.66);
  }
  const { x0, x1, y0, y1, turn } = bounds(world);
  const scale = Math.min((width - 36) / (x1 - x0), (height - 36) / (y1 - y0));
  // The middle of the box, back in the world's frame.
  const [c, s, u, v] = [Math.cos(turn), Math.sin(turn), (x0 + x1) / 2, (y0 + y1) / 2];
  return place(scale, turn, c * u + s * v, -s * u + c * v, width / 2, height / 2);
}

// Where the track lies: a tall one is turned to its side.
function bounds(world) {
  for (const turn of [0, -Math.PI / 2]) {
    const [c, s] = [Math.cos(turn), Math.sin(turn)], all = [...world.left, ...world.right];
    const [us, vs] = [all.map(([x, y]) => c * x - s * y), all.map(([x, y]) => s * x + c * y)];
    const found = { turn, x0: Math.min(...us), x1: Math.max(...us), y0: Math.min(...vs), y1: Math.max(...vs) };
    if (turn || found.y1 - found.y0 <= 1.25 * (found.x1 - found.x0)) return found;
  }
}

// The box takes the shape of the track, within limits.
export function shape() {
  const { x0, x1, y0, y1 } = bounds(state.world);
  box.style.aspectRatio = String(Math.min(2, Math.max(1.05, (x1 - x0) / (y1 - y0))));
}

function place(scale, turn, x0, y0, px, py) {
  const [c, s] = [Math.cos(turn) * scale, Math.sin(turn) * scale];
  return { scale, turn, to: (x, y) => [px + c * (x - x0) - s * (y - y0), py - s * (x - x0) - c * (y - y0)] };
}

function path(g, points, x = 0, y = 1, close = false) {
  g.beginPath();
  for (const point of points) g.lineTo(...view.to(point[x], point[y]));
  if (close) g.closePath();
}

function line(g, points, style, x, y) {
  path(g, points, x, y);
  Object.assign(g, { strokeStyle: style.color, lineWidth: style.width, lineJoin: 'round', lineCap: 'round' });
  g.setLineDash(style.dash ?? []);
  g.stroke();
  g.setLineDash([]);
}

// Track, other laps, and what is driven of this one.
function ground(g, width, height, look) {
  const world = state.world;
  g.clearRect(0, 0, width, height);
  g.beginPath();
  for (const points of [world.left, [...world.right].reverse()]) {
    points.forEach(([x, y], i) => (i ? g.lineTo(...view.to(x, y)) : g.moveTo(...view.to(x, y))));
    if (world.closed) g.closePath();
  }
  g.fillStyle = look.road;
  g.fill('evenodd');
  for (const edge of [world.left, world.right]) {
    path(g, edge, 0, 1, world.closed);
    Object.assign(g, { strokeStyle: look.edge, lineWidth: 2 });
    g.stroke();
  }
  start(g, world, look);
  const { last, best } = state.laps;
  if (look.shown.last && last) line(g, last.samples, look.last, X, Y);
  if (look.shown.optimum && world.optimum) line(g, world.optimum.samples, look.optimum, 2, 3);
  if (look.shown.best && best) line(g, best.samples, look.best, X, Y);
}

// The line, in two rows of squares, and an arrow for the sense of driving.
function start(g, world, look) {
  const [l, r, c] = [world.left[0], world.right[0], world.centre];
  if (!l || !r || c.length < 2) return;
  const [a, b] = [view.to(...l), view.to(...r)];
  const steps = 8, [dx, dy] = [(b[0] - a[0]) / steps, (b[1] - a[1]) / steps];
  const length = Math.hypot(dx, dy) || 1, cell = Math.min(5, length);
  const [nx, ny] = [-dy / length * cell, dx / length * cell];
  for (let i = 0; i < steps; i++) for (let j = 0; j < 2; j++) {
    g.fillStyle = (i + j) % 2 ? look.paper : look.ink;
    g.beginPath();
    const [x, y] = [a[0] + i * dx + (j - 1) * nx, a[1] + i * dy + (j - 1) * ny];
    g.moveTo(x, y); g.lineTo(x + dx, y + dy); g.lineTo(x + dx + nx, y + dy + ny); g.lineTo(x + nx, y + ny);
    g.fill();
  }
}

export function draw(now, look) {
  const car = pose(now), world = state.world;
  const { width, height } = size(base);
  if (!world || !width) { base.getContext('2d').clearRect(0, 0, width, height); size(top).g.clearRect(0, 0, width, height); drawn = ''; return; }
  const key = [state.versions.world, state.versions.laps, width, height, look.name, Object.values(look.shown)].join();
  if (following || key !== drawn) {
    view = fit(width, height, car);
    ground(size(base).g, width, height, look);
    drawn = following ? '' : key;
  }
  const { g } = size(top);
  g.clearRect(0, 0, width, height);
  if (look.shown.current && state.lap.samples.length) {
    const trail = state.lap.samples.slice(0, reached(state.lap.samples, car));
    if (car) trail.push({ [X]: car.x, [Y]: car.y });
    line(g, trail, look.current, X, Y);
  }
  plan(g, look);
  if (car) body(g, car, world.car, look);
  if (state.hover !== null) pointed(g, look);
}

function plan(g, look) {
  const plan = state.plan;
  if (!plan) return;
  line(g, plan.x, { color: look.road, width: 6 }, 0, 1);
  for (const [x, y, weight] of plan.set ?? []) {
    const [px, py] = view.to(x, y), r = 3.5 + 4 * Math.sqrt(weight || 0);
    g.beginPath();
    g.moveTo(px, py - r); g.lineTo(px + r, py); g.lineTo(px, py + r); g.lineTo(px - r, py); g.closePath();
    g.fillStyle = weight > 0.01 ? look.set : look.paper;
    g.fill();
    Object.assign(g, { strokeStyle: look.set, lineWidth: 1.4 });
    g.stroke();
  }
  line(g, plan.x, { color: look.plan, width: 3 }, 0, 1);
  for (const [x, y] of plan.x) {
    g.beginPath(); g.arc(...view.to(x, y), 3.2, 0, 7);
    g.fillStyle = look.plan; g.fill();
  }
}

function body(g, car, shape, look) {
  const [px, py] = view.to(car.x, car.y);
  // A small car on a large track stays visible.
  const grow = Math.max(1, 15 / ((shape.front + shape.rear) * view.scale)), k = view.scale * grow;
  g.save();
  g.translate(px, py);
  g.rotate(-(car.yaw + view.turn));
  const [front, rear, half] = [shape.front * k, shape.rear * k, shape.half_width * k];
  if (front > 24) wheels(g, front, rear, half, look);
  g.beginPath();
  g.roundRect(-rear, -half, front + rear, 2 * half, 0.35 * half);
  Object.assign(g, { strokeStyle: look.halo, lineWidth: 5, fillStyle: look.car });
  g.stroke(); g.fill();
  Object.assign(g, { strokeStyle: look.ink, lineWidth: 1.5 });
  g.stroke();
  g.beginPath();
  g.moveTo(front * 0.85, 0); g.lineTo(front * 0.2, -half * 0.75); g.lineTo(front * 0.2, half * 0.75); g.closePath();
  g.fillStyle = look.paper; g.fill();
  g.restore();
}

// Where there is room for them: the front ones turned as they are.
function wheels(g, front, rear, half, look) {
  const [long, wide] = [0.24 * (front + rear), 0.34 * half];
  for (const [x, turned] of [[0.62 * front, true], [-0.62 * rear, false]]) for (const side of [-1, 1]) {
    g.save();
    g.translate(x, side * half);
    if (turned) g.rotate(-(state.car?.delta ?? 0));
    g.fillStyle = look.ink;
    g.fillRect(-long / 2, -wide / 2, long, wide);
    g.restore();
  }
}

// The place that is pointed at in a curve.
function pointed(g, look) {
  const s = state.hover, samples = [state.lap.samples, state.laps.last?.samples ?? [], state.laps.best?.samples ?? []];
  const own = samples.find((list) => !Number.isNaN(at(list, s, X)));
  if (!own) return;
  g.beginPath(); g.arc(...view.to(at(own, s, X), at(own, s, Y)), 7, 0, 7);
  Object.assign(g, { strokeStyle: look.ink, lineWidth: 2.5 });
  g.stroke();
}
