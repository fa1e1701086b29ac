// Tables of laps, programs and channels, the numbers on top, and the times of the steps.

import { state, T, behind, number } from './state.js';

const $ = (id) => document.getElementById(id);
const set = (id, text) => {
  const node = $(id);
  if (node.textContent === text) return;
  node.textContent = text;
  // A lap of minutes has more digits than a tile of a phone has room for.
  node.closest('.numbers b')?.classList.toggle('long', text.length > 6);
};
const seconds = (value) => {
  if (!Number.isFinite(value)) return '–';
  const minutes = Math.floor(value / 60);
  return minutes ? `${minutes}:${(value - 60 * minutes).toFixed(3).padStart(6, '0')}` : value.toFixed(3);
};
const signed = (value) => (Number.isFinite(value) ? `${value < 0 ? '−' : '+'}${Math.abs(value).toFixed(3)}` : '–');
const age = (s) => (s < 0.9995 ? `${(1e3 * s).toFixed(0)} ms` : s < 100 ? `${s.toFixed(1)} s` : `${(s / 60).toFixed(0)} min`);

// A word with a mark whose shape, not its colour alone, says how it is.
const SHAPES = { RUNNING: ['good', '●'], ARMED: ['good', '◐'], IDLE: ['idle', '○'], BOOT: ['idle', '○'],
  SAFE_STOP: ['warn', '▲'], FAULT: ['bad', '■'], ESTOP: ['bad', '■'], silent: ['bad', '✕'] };
function chip(name, word, title = '') {
  const [kind, shape] = SHAPES[word] ?? ['idle', '○'], node = document.createElement('span');
  node.className = `chip ${kind}`;
  node.title = title;
  const mark = document.createElement('i');
  mark.textContent = shape;
  node.append(mark, `${name ? `${name} ` : ''}${word}`);
  return node;
}
const word = (program) => (state.ended ? 'ended' : program.alive ? program.state : 'silent');

export function numbers() {
  const { car, laps, world } = state, live = state.lap.samples.at(-1), best = laps.best;
  set('n-speed', car ? number(car.v, 2) : '–');
  set('n-lap', car ? `${state.lap.lap}` : '');
  set('n-time', live && state.lap.whole ? seconds(live[T]) : '–');
  const gain = live && best && state.lap.whole ? behind(live, best.samples) : NaN;
  set('n-delta', signed(gain));
  for (const [name, on] of [['ahead', gain <= 0], ['behind', gain > 0]]) $('n-delta').classList.toggle(name, on);
  set('n-last', seconds(laps.last?.time ?? NaN));
  set('n-best', seconds(best?.time ?? NaN));
  set('n-optimum', seconds(world?.optimum?.time ?? NaN));
  const share = best && world?.optimum ? best.time / world.optimum.time : NaN;
  const text = Number.isFinite(share) ? `× ${share.toFixed(3)}` : '';
  if ($('n-share').textContent !== text) $('n-share').textContent = text;
}

const SOURCES = ['nobody drives', 'command', 'plan', 'safe stop'];
export function chips() {
  const nodes = [], { status, car } = state;
  if (!state.connected) nodes.push(chip('', 'silent', 'lmpc view'));
  for (const program of status?.programs ?? []) nodes.push(chip(program.name, word(program), program.detail));
  if (car && !state.ended && Number.isInteger(car.source)) {
    const node = chip('', SOURCES[car.source] ?? 'unknown');
    node.className = `chip ${['idle', 'good', 'warn', 'bad'][car.source] ?? 'idle'}`;
    node.firstChild.textContent = ['○', '●', '▲', '■'][car.source] ?? '○';
    nodes.push(node);
  }
  if (car?.quality === 0) { const node = chip('', 'bad state'); node.className = 'chip bad'; node.firstChild.textContent = '■'; nodes.push(node); }
  $('chips').replaceChildren(...nodes);
}

function table(id, heads, rows) {
  const make = (tag, cells) => {
    const row = document.createElement('tr');
    for (const [text, kind] of cells) {
      const cell = document.createElement(tag);
      cell.textContent = text;
      if (kind) cell.className = kind;
      row.append(cell);
    }
    return row;
  };
  const head = document.createElement('thead'), body = document.createElement('tbody');
  head.append(make('th', heads));
  for (const { cells, kind } of rows) { const row = make('td', cells); row.className = kind ?? ''; body.append(row); }
  $(id).replaceChildren(head, body);
}

// Laps in the table, the newest and the best. [-]
const ROWS = 60;

export function laps() {
  const { best } = state.laps, all = state.laps.rows;
  const isBest = (row) => best && row.lap === best.lap && row.time === best.time;
  const rows = all.filter((row, i) => i >= all.length - ROWS || isBest(row));
  set('lap-count', all.length > rows.length ? `best and newest of ${all.length} laps` : all.length ? `${all.length} laps` : 'none finished yet');
  const shown = rows.map((row) => {
    const first = isBest(row);
    const known = (text) => (row.judged ? text : '');
    return { kind: first ? 'first' : row.valid ? '' : 'invalid', cells: [
      [`${first ? '★ ' : ''}${row.lap}`], [seconds(row.time)], [first ? 'best' : best ? signed(row.time - best.time) : ''],
      [row.valid ? '✓ yes' : '✕ no'], [known(number(row.min_margin, 3))], [number(row.v_max, 2), 'wide'],
      [known(`${row.fallbacks}`)], [known(`${row.late}`), 'wide'], [known(`${row.violations}`), 'wide']] };
  });
  table('laps', [['lap'], ['time'], ['to best'], ['valid'], ['margin [m]'], ['v max', 'wide'], ['fallback'], ['late', 'wide'], ['off track', 'wide']], shown.reverse());
}

export function programs() {
  const nodes = (state.status?.programs ?? []).map((program) => {
    const node = document.createElement('div');
    node.className = 'program';
    const head = document.createElement('div'), name = document.createElement('b'), facts = document.createElement('span');
    name.textContent = program.name;
    facts.className = 'soft num';
    facts.textContent = `${program.sender}  ${program.version}  up ${age(program.uptime_s)}  ${number(program.rss_mb, 0)} MB${program.granted ? '  granted' : ''}`;
    head.append(name, chip('', word(program)), facts);
    const counts = document.createElement('dl');
    for (const what of ['ok', 'bad', 'old', 'stale', 'lost']) {
      const item = document.createElement('div'), term = document.createElement('dt'), value = document.createElement('dd');
      term.textContent = what;
      value.textContent = `${program[what]}`;
      item.className = what !== 'ok' && program[what] > 0 ? 'some' : '';
      item.append(term, value);
      counts.append(item);
    }
    const detail = document.createElement('p');
    detail.textContent = program.detail;
    node.append(head, counts, detail);
    return node;
  });
  const { order, last_stop: stop } = state.status ?? {};
  const say = (text) => { const node = document.createElement('p'); node.className = 'note'; node.textContent = text; nodes.push(node); };
  if (stop) say(`last stop: ${stop}`);
  if (order) {
    const answers = order.answers.map((a) => `${a.who} ${a.accepted ? 'obeys' : `refuses: ${a.detail}`}`).join('; ');
    say(`order ${order.order} of ${order.sender}, ${age(order.age_s)} ago${answers ? `: ${answers}` : ''}`);
  }
  if (!nodes.length) say('no heartbeat yet');
  $('programs').replaceChildren(...nodes);
}

export function channels() {
  const rows = state.status?.channels ?? [];
  set('channel-count', rows.length ? `${rows.length} channels` : 'none yet');
  table('channels', [['channel'], ['rate [Hz]'], ['age'], ['lost'], ['unreadable'], ['senders', 'wide'], ['bytes', 'wide'], ['messages', 'wide']], rows.map((c) => ({
    kind: c.lost || c.unreadable ? 'some' : '', cells: [[c.name], [number(c.rate_hz, 1)], [age(c.age_s)], [`${c.lost}`], [`${c.unreadable}`],
      [`${c.senders}`, 'wide'], [`${c.bytes}`, 'wide'], [`${c.count}`, 'wide']] })));
}

// Times of the last steps on a logarithmic axis, with what a step may take.
export function steps(look) {
  const box = $('steps'), canvas = box.firstElementChild, scale = Math.min(2, window.devicePixelRatio || 1);
  const [width, height] = [box.clientWidth, box.clientHeight];
  if (canvas.width !== Math.round(width * scale)) { canvas.width = Math.round(width * scale); canvas.height = Math.round(height * scale); }
  const g = canvas.getContext('2d'), deadline = (state.plan?.deadline_us ?? 0) / 1e3;
  g.setTransform(scale, 0, 0, scale, 0, 0);
  g.clearRect(0, 0, width, height);
  const shown = state.steps.slice(-Math.max(60, Math.floor((width - 52) / 1.5))), left = 44, right = 8;
  const most = Math.max(deadline * 1.6, ...shown.map((step) => step[0] / 1e3), 1), least = 0.02;
  const py = (ms) => 6 + (height - 12) * Math.log(most / Math.max(least, ms)) / Math.log(most / least);
  const px = (i) => left + (i + 0.5) * (width - left - right) / Math.max(1, shown.length);
  Object.assign(g, { font: look.font, fillStyle: look.soft, strokeStyle: look.grid, lineWidth: 1, textAlign: 'right', textBaseline: 'middle' });
  for (const ms of [0.1, 1, 10, 100, 1000]) if (ms < most) {
    g.beginPath(); g.moveTo(left, py(ms)); g.lineTo(width - right, py(ms)); g.stroke();
    g.fillText(`${ms} ms`, left - 4, py(ms));
  }
  if (deadline) {
    Object.assign(g, { strokeStyle: look.limit, lineWidth: 1.5 });
    g.beginPath(); g.moveTo(left, py(deadline)); g.lineTo(width - right, py(deadline)); g.stroke();
    Object.assign(g, { fillStyle: look.limit, textBaseline: 'bottom', textAlign: 'left' });
    g.fillText('deadline', left + 4, py(deadline) - 1);
  }
  const bar = Math.max(1, 0.7 * (width - left - right) / Math.max(1, shown.length));
  shown.forEach(([total, , solve, status], i) => {
    g.fillStyle = status === 0 && (!deadline || total <= 1e3 * deadline) ? look.bar : look.alert;
    g.fillRect(px(i) - bar / 2, py(total / 1e3), bar, height - 6 - py(total / 1e3));
    if (solve > 0) { g.fillStyle = look.ink; g.fillRect(px(i) - bar / 2, py(solve / 1e3) - 1, bar, 2); }
  });
  const step = state.status?.step;
  set('step-text', step ? `${number(step.total_ms, 2)} of ${number(step.deadline_ms, 0)} ms · solver ${number(step.solve_ms, 2)} · longest ${number(step.worst_ms, 1)} · ${step.overruns} late · ${step.status}` : 'no step yet');
  set('estimates', step ? estimates(step.estimates) : '');
}

// What the controller does and what it has found out, in one line.
function estimates(e) {
  const ms = (s) => `${number(1e3 * s, 0)} ms`, milli = ([e_psi, e_y]) => `${number(1e3 * e_y, 0)} mm ${number(1e3 * e_psi, 0)} mrad`;
  const parts = [`${e.action}${e.reason ? ` (${e.reason})` : ''}`.replaceAll('_', ' '),
    `grip ${number(e.grip[0], 2)} ${number(e.grip[1], 2)} of nominal, road ${number(e.road_grip, 2)}`,
    `delay ${ms(e.delay_s)}, lag ${ms(e.lag_s)} ${e.response_found ? 'estimated' : 'configured'}`];
  if (e.delay_change_s) parts.push(`commands act ${ms(Math.abs(e.delay_change_s))} ${e.delay_change_s > 0 ? 'later' : 'sooner'} than that`);
  if (e.sigma && e.noise) parts.push(`filter ${milli(e.sigma)} of ${milli(e.noise)}`);
  return parts.join(' · ');
}
