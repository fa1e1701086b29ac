// Curves along the lap: other laps and what is driven are drawn as they come, the cursor in each frame.

import { state, T, S, V, A, DELTA, USE_F, USE_R, SUPPORT, LIMITED, at, behind, number, pose, reached } from './state.js';

const LEFT = 44, RIGHT = 8, TOP = 6, BOTTOM = 18, GAP = 0.05;
const signed = (value, digits = 2) => (Number.isFinite(value) ? (value < 0 ? '−' : '+') + Math.abs(value).toFixed(digits) : '–');

// Each chart: its name, unit, the series of a lap, limits, the least range, and how a value is written.
const CHARTS = [
  { id: 'speed', title: 'Speed', unit: 'm/s', tall: true, fit: true, value: (p) => p[V], optimum: (p) => p[4], least: [0, 1],
    limits: (car) => [car.v_max], plan: (plan) => plan.x.map((p) => [p[2], p[3]]), show: (v) => number(v) },
  { id: 'gain', title: 'Time to best lap', unit: 's', value: (p) => behind(p, state.laps.best?.samples ?? []), laps: ['current', 'last'],
    least: [-0.1, 0.1], zero: true, words: ['slower', 'faster'], show: (v) => signed(v, 3) },
  { id: 'a', title: 'Acceleration', unit: 'm/s²', value: (p) => p[A], limits: (car) => [car.a_min, car.a_max], zero: true, marks: 12 | 16,
    least: [-1, 1], plan: (plan) => plan.u.map((u, i) => [plan.x[i]?.[2], u[0]]), show: (v) => signed(v) },
  { id: 'delta', title: 'Steering', unit: 'rad', value: (p) => p[DELTA], limits: (car) => [-car.delta_max, car.delta_max], zero: true, marks: 3,
    least: [-0.1, 0.1], words: ['left', 'right'], plan: (plan) => plan.u.map((u, i) => [plan.x[i]?.[2], u[1]]), show: (v) => signed(v, 3) },
  { id: 'tyres', title: 'Tyre use', unit: '%', value: (p) => percent(p[USE_F]), second: (p) => percent(p[USE_R]), names: ['front', 'rear'],
    laps: ['current'], limits: () => [100], range: [0, 112, 50], show: (v) => number(v, 0) },
  { id: 'support', title: 'Data support', unit: 'kernel weights', value: (p) => p[SUPPORT], laps: ['current', 'last'], least: [0, 1], show: (v) => number(v, 1) },
];
const percent = (share) => (share === null ? NaN : 100 * share);

class Chart {
  constructor(about, parent) {
    this.about = about;
    this.box = document.createElement('div');
    this.box.className = `chart${about.tall ? ' tall' : ''}`;
    this.box.innerHTML = '<div class="head"><h3></h3><span class="values num"></span></div><div class="canvas"><canvas></canvas><canvas></canvas></div>';
    this.box.querySelector('h3').textContent = about.title;
    const unit = document.createElement('small');
    unit.textContent = about.unit;
    this.box.querySelector('h3').append(' ', unit);
    about.names?.forEach((name, i) => {
      const key = document.createElement('small');
      key.className = ['k-front', 'k-rear'][i];
      key.textContent = `${['━', '─'][i]} ${name}`;
      this.box.querySelector('h3').append(' ', key);
    });
    this.values = this.box.querySelector('.values');
    this.area = this.box.querySelector('.canvas');
    [this.base, this.top] = this.area.querySelectorAll('canvas');
    this.key = ''; this.done = 0;
    parent.append(this.box);
    const point = (event) => {
      const s = this.place(event.offsetX);
      state.hover = s >= 0 && s <= (state.world?.length ?? 0) ? s : null;
      state.versions.frame += 1;
    };
    this.area.addEventListener('pointermove', point);
    this.area.addEventListener('pointerdown', point);
    this.area.addEventListener('pointerleave', () => { state.hover = null; state.versions.frame += 1; });
  }

  size(canvas) {
    const scale = Math.min(2, window.devicePixelRatio || 1), [width, height] = [this.area.clientWidth, this.area.clientHeight];
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const g = canvas.getContext('2d');
    g.setTransform(scale, 0, 0, scale, 0, 0);
    return { g, width, height };
  }

  place(px) { return (px - LEFT) / (this.width - LEFT - RIGHT) * (state.world?.length ?? 1); }
  px(s) { return LEFT + s / (state.world?.length ?? 1) * (this.width - LEFT - RIGHT); }
  py(y) { return TOP + (this.range[1] - y) / (this.range[1] - this.range[0]) * (this.height - TOP - BOTTOM); }

  // Laps other than this one, as lists of [s, value].
  others(look) {
    const { about } = this, { last, best } = state.laps, shown = look.shown, found = [];
    const allowed = (name) => (about.laps ?? ['current', 'last', 'best']).includes(name) && shown[name];
    if (last && allowed('last')) found.push([last.samples, S, about.value, look.last]);
    if (about.optimum && state.world?.optimum && shown.optimum) found.push([state.world.optimum.samples, 1, about.optimum, look.optimum]);
    if (best && allowed('best')) found.push([best.samples, S, about.value, look.best]);
    return found;
  }

  // Lowest and highest value, in round numbers; it grows at once and shrinks with a new lap.
  reach(look) {
    if (this.about.range) return this.about.range;
    let [low, high] = this.about.fit ? [Infinity, -Infinity] : this.about.least;
    const take = (value) => { if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); } };
    for (const [samples, , value] of this.others(look)) for (const sample of samples) take(value(sample));
    for (const sample of state.lap.samples) { take(this.about.value(sample)); if (this.about.second) take(this.about.second(sample)); }
    if (this.about.fit) { if (!(high > low)) [low, high] = this.about.least; else if (low >= 0) low = Math.max(0, low - 0.04 * (high - low)); }
    for (const limit of this.limits()) if (limit <= 1.6 * high && limit >= 1.6 * low) take(limit);
    const step = round((high - low) / 3);
    return [low < 0 || this.about.fit ? Math.max(Math.floor(low / step - GAP), low < 0 ? -Infinity : 0) * step : 0, Math.ceil(high / step + GAP) * step, step];
  }

  limits() { return state.world ? (this.about.limits?.(state.world.car) ?? []).filter((value) => value !== null) : []; }

  redraw(look) {
    const { g, width, height } = this.size(this.base);
    Object.assign(this, { width, height, range: this.reach(look), done: 0 });
    g.clearRect(0, 0, width, height);
    this.grid(g, look);
    for (const limit of this.limits()) this.limit(g, limit, look);
    for (const [samples, key, value, style] of this.others(look)) this.line(g, samples.map((p) => [p[key], value(p)]), style);
  }

  grid(g, look) {
    const [low, high, step] = this.range;
    Object.assign(g, { strokeStyle: look.grid, lineWidth: 1, fillStyle: look.soft, font: look.font, textBaseline: 'middle', textAlign: 'right' });
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let y = low; y <= high + 1e-6 * step; y += step) {
      const py = Math.round(this.py(y)) + 0.5;
      g.beginPath(); g.moveTo(LEFT, py); g.lineTo(this.width - RIGHT, py); g.stroke();
      g.fillText((Math.abs(y) < 1e-9 ? 0 : y).toFixed(digits).replace('-', '−'), LEFT - 6, py);
    }
    if (this.about.zero) {
      g.strokeStyle = look.soft;
      g.beginPath(); g.moveTo(LEFT, this.py(0)); g.lineTo(this.width - RIGHT, this.py(0)); g.stroke();
    }
    const length = state.world?.length ?? 1, mark = round(length / Math.max(3, this.width / 90));
    Object.assign(g, { textAlign: 'center', textBaseline: 'alphabetic' });
    for (let s = 0; s <= length - 0.4 * mark; s += mark) g.fillText(s ? `${+s.toFixed(3)}` : '0', this.px(s), this.height - 4);
    g.textAlign = 'right';
    g.fillText('m', this.width - RIGHT, this.height - 4);
    if (this.about.words) {
      Object.assign(g, { textAlign: 'left', textBaseline: 'top' });
      g.fillText(`↑ ${this.about.words[0]}`, LEFT + 4, TOP + 1);
      g.textBaseline = 'bottom';
      g.fillText(`↓ ${this.about.words[1]}`, LEFT + 4, this.height - BOTTOM - 2);
    }
  }

  // A line with hatching on the side that may not be entered.
  limit(g, value, look) {
    if (value < this.range[0] || value > this.range[1]) return;
    const y = Math.round(this.py(value)) + 0.5, side = value < 0 ? 1 : -1;
    Object.assign(g, { strokeStyle: look.limit, lineWidth: 1.5 });
    g.beginPath(); g.moveTo(LEFT, y); g.lineTo(this.width - RIGHT, y);
    for (let x = LEFT; x < this.width - RIGHT - 5; x += 8) { g.moveTo(x, y); g.lineTo(x + 5, y + 5 * side); }
    g.stroke();
  }

  line(g, points, style) {
    g.beginPath();
    let drawing = false;
    for (const [s, value] of points) {
      if (!Number.isFinite(value) || !Number.isFinite(s)) { drawing = false; continue; }
      if (drawing) g.lineTo(this.px(s), this.py(value)); else g.moveTo(this.px(s), this.py(value));
      drawing = true;
    }
    Object.assign(g, { strokeStyle: style.color, lineWidth: style.width, lineJoin: 'round', lineCap: 'round' });
    g.setLineDash(style.dash ?? []);
    g.stroke();
    g.setLineDash([]);
  }

  // What came since the last frame is added to what stands there.
  current(look, car) {
    const samples = state.lap.samples, count = reached(samples, car), { about } = this;
    if (count <= this.done || !look.shown.current) return;
    const { g } = this.size(this.base), added = samples.slice(Math.max(0, this.done - 1), count);
    this.line(g, added.map((p) => [p[S], about.value(p)]), look.current);
    if (about.second) this.line(g, added.map((p) => [p[S], about.second(p)]), look.second);
    if (about.marks) {
      g.fillStyle = look.alert;
      for (const p of added) if (p[LIMITED] & about.marks) g.fillRect(this.px(p[S]) - 1, this.height - BOTTOM - 5, 2.5, 5);
    }
    this.done = count;
  }

  outgrown() {
    for (const sample of state.lap.samples.slice(this.done)) for (const value of [this.about.value(sample), this.about.second?.(sample)]) {
      if (Number.isFinite(value) && (value < this.range[0] || value > this.range[1])) return true;
    }
    return false;
  }

  draw(now, look) {
    if (!state.world || !this.area.clientWidth) return;
    const versions = state.versions;
    const key = [versions.world, versions.laps, versions.lap, this.area.clientWidth, this.area.clientHeight, look.name, Object.values(look.shown)].join();
    if (key !== this.key || this.outgrown()) { this.redraw(look); this.key = key; }
    const car = pose(now);
    this.current(look, car);
    const { g, width, height } = this.size(this.top);
    g.clearRect(0, 0, width, height);
    if (this.about.plan && state.plan?.x && look.shown.current) this.ahead(g, look);
    const live = state.lap.samples.at(-1);
    const s = state.hover ?? car?.s;
    if (Number.isFinite(s)) this.cursor(g, s, look);
    this.read(state.hover === null ? live : null, s);
  }

  ahead(g, look) {
    const length = state.world.length, points = this.about.plan(state.plan).filter(([s]) => Number.isFinite(s));
    let turn = 0;
    const wrapped = [];
    for (const [s, value] of points) {
      const over = Math.floor(s / length);
      if (over !== turn) { wrapped.push([NaN, NaN]); turn = over; }
      wrapped.push([s - over * length, value]);
    }
    g.globalAlpha = 0.6;
    this.line(g, wrapped, { color: look.halo, width: 4 });
    g.globalAlpha = 1;
    this.line(g, wrapped, { color: look.plan, width: 2, dash: [2, 4] });
  }

  cursor(g, s, look) {
    const x = Math.round(this.px(s)) + 0.5;
    Object.assign(g, { strokeStyle: look.ink, lineWidth: state.hover === null ? 1 : 1.6 });
    g.beginPath(); g.moveTo(x, TOP); g.lineTo(x, this.height - BOTTOM); g.stroke();
  }

  // Values beside the name: at the pointer of each lap, else of the car now.
  read(live, s) {
    const { about } = this, show = (value) => about.show(value);
    const of = (samples, value, key = S) => {
      const near = samples?.findLast?.((sample) => sample[key] <= s);
      return near && s - near[key] < 0.03 * state.world.length ? value(near) : NaN;
    };
    let text;
    if (live) text = about.second ? `${about.names[0]} ${show(about.value(live))}  ${about.names[1]} ${show(about.second(live))}` : show(about.value(live));
    else if (state.hover === null) text = '';
    else {
      const { last, best } = state.laps, parts = [`${s.toFixed(1)} m`];
      if (about.second) parts.push(`${about.names[0]} ${show(of(state.lap.samples, about.value))}  ${about.names[1]} ${show(of(state.lap.samples, about.second))}`);
      else {
        parts.push(`this ${show(of(state.lap.samples, about.value))}`);
        if (last) parts.push(`last ${show(of(last.samples, about.value))}`);
        if (best && about.id !== 'gain') parts.push(`best ${show(of(best.samples, about.value))}`);
        if (about.optimum && state.world.optimum) parts.push(`opt ${show(of(state.world.optimum.samples, about.optimum, 1))}`);
      }
      text = parts.join('   ');
    }
    if (this.values.textContent !== text) this.values.textContent = text;
  }
}

// The next of 1, 2, 5 times a power of ten.
function round(value) {
  const power = 10 ** Math.floor(Math.log10(value || 1)), lead = value / power;
  return power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
}

export function charts(parent) {
  const all = CHARTS.map((about) => new Chart(about, parent));
  return (now, look) => { for (const chart of all) chart.draw(now, look); };
}
