// The page: colours, buttons, and one loop that draws what has changed.

import { state, onChange, listen, pose } from './state.js';
import { draw as map, follow, shape } from './map.js';
import { charts } from './charts.js';
import * as tables from './tables.js';
import { operator, shown as operatorShown } from './operator.js';

const $ = (id) => document.getElementById(id);
// The network is silent if no message came for so long. [ms]
const SILENCE = 2000;
const shown = { current: true, last: true, best: true, optimum: true };
const THEMES = { auto: '◐', light: '☀', dark: '☾' };
let look = null;

// Colours that people who cannot tell red from green tell apart; every line has a dash of its own, too.
function looks() {
  const style = getComputedStyle(document.documentElement), color = (name) => style.getPropertyValue(`--${name}`).trim();
  return {
    name: `${document.documentElement.dataset.theme} ${color('paper')}`, shown, font: '11px system-ui, sans-serif',
    ink: color('ink'), soft: color('soft'), paper: color('paper'), halo: color('card'), grid: color('grid'), edge: color('edge'), road: color('road'),
    limit: color('limit'), alert: color('alert'), plan: color('plan'), set: color('set'), car: color('car'), bar: color('bar'),
    current: { color: color('current'), width: 3 }, second: { color: color('second'), width: 1.6 },
    last: { color: color('last'), width: 1.5 }, best: { color: color('best'), width: 2.2, dash: [9, 5] }, optimum: { color: color('optimum'), width: 2, dash: [1.5, 4.5] },
  };
}

function theme(name) {
  document.documentElement.dataset.theme = name;
  $('theme').textContent = THEMES[name];
  localStorage.setItem('theme', name);
  look = looks();
  dirty = true;
}

let dirty = true, frames = 0;
const drawCharts = charts($('curves'));

function banner() {
  const text = !state.connected ? 'lmpc view is not reachable; trying again' : state.ended ? state.ended : '';
  $('banner').hidden = !text;
  $('banner').textContent = text;
  $('banner').className = state.connected ? 'over' : 'lost';
  let waiting = '';
  if (state.connected && !state.world) waiting = state.car ? 'Waiting for the track: it comes with lmpc serve.' : `Waiting for messages on ${state.hello?.source ?? ''}`;
  if ($('waiting').textContent !== waiting) $('waiting').textContent = waiting;
}

onChange((what) => {
  dirty = true;
  if (what === 'hello') { $('source').textContent = state.hello?.source ?? ''; operatorShown(); tables.laps(); tables.chips(); }
  if (what === 'world') shape();
  if (what === 'world') $('track').textContent = `${state.world.name}, ${state.world.length.toFixed(1)} m${state.world.car.known ? `, ${state.world.car.name}` : ', car not known: see --car'}`;
  if (what === 'laps') tables.laps();
  if (what === 'status') { tables.chips(); tables.programs(); tables.channels(); }
  if (what !== 'frame') banner();
});

let seconds = performance.now(), seen = { frames: 0, states: 0 };
function rates(now) {
  if (now - seconds < 1000) return;
  const per = 1000 / (now - seconds), states = Math.max(0, state.states - seen.states) * per;
  const fps = (frames - seen.frames) * per;
  $('rates').textContent = `${fps.toFixed(0)} frames/s · ${states.toFixed(0)} states/s`;
  document.body.dataset.fps = fps.toFixed(1);
  document.body.dataset.states = states.toFixed(1);
  seen = { frames, states: state.states };
  seconds = now;
}

function loop(now) {
  requestAnimationFrame(loop);
  rates(now);
  // Also while the car is on its way between two states.
  if (!dirty && !pose(performance.now())?.moving) return;
  dirty = false;
  frames += 1;
  map(performance.now(), look);
  drawCharts(performance.now(), look);
  tables.numbers();
  if (frames % 6 === 0) tables.steps(look);
}

$('theme').addEventListener('click', () => {
  const names = Object.keys(THEMES);
  theme(names[(names.indexOf(document.documentElement.dataset.theme) + 1) % names.length]);
});
for (const [name, on] of [['whole', false], ['follow', true]]) $(name).addEventListener('click', () => {
  follow(on);
  $('whole').setAttribute('aria-pressed', String(!on));
  $('follow').setAttribute('aria-pressed', String(on));
  dirty = true;
});
for (const button of document.querySelectorAll('#lines button')) button.addEventListener('click', () => {
  const on = (shown[button.dataset.line] = !shown[button.dataset.line]);
  button.setAttribute('aria-pressed', String(on));
  dirty = true;
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => theme(document.documentElement.dataset.theme));
new ResizeObserver(() => { dirty = true; }).observe(document.body);
setInterval(() => {
  const silent = state.connected && state.heard && !state.ended && performance.now() - state.heard > SILENCE;
  document.body.classList.toggle('silent', Boolean(silent));
}, 500);

theme(localStorage.getItem('theme') in THEMES ? localStorage.getItem('theme') : 'auto');
operator();
listen();
requestAnimationFrame(loop);
