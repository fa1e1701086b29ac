// Orders, where the program was started with --operator and the page was opened with its token.

import { state } from './state.js';

const $ = (id) => document.getElementById(id);
// An order that lets the car move is held, so that a slip of the finger does nothing. [ms]
const HOLD = 800;
let token = null;

function remember() {
  const found = /operator=([0-9a-f]+)/.exec(location.hash);
  if (found) {
    sessionStorage.setItem('operator', found[1]);
    // Not in the address any more: it would be in pictures of the screen and in the history.
    history.replaceState(null, '', '/');
  }
  token = sessionStorage.getItem('operator');
}

async function give(order, value = 0) {
  $('answer').textContent = `${order} …`;
  try {
    const reply = await fetch('/order', { method: 'POST', headers: { 'X-Lmpc-Token': token ?? '', 'Content-Type': 'application/json' },
      body: JSON.stringify({ order, value }) });
    const text = await reply.text();
    $('answer').textContent = reply.status === 403 ? 'this page may not order: open the address that lmpc view printed' : `${reply.ok ? '✓' : '✕'} ${order}: ${text}`;
    $('answer').className = reply.ok ? '' : 'refused';
  } catch {
    $('answer').textContent = `✕ ${order}: lmpc view does not answer`;
    $('answer').className = 'refused';
  }
}

export function operator() {
  remember();
  $('estop').addEventListener('pointerdown', () => give('estop'));
  $('estop').addEventListener('keydown', (event) => { if (event.key === 'Enter' || event.key === ' ') give('estop'); });
  for (const button of document.querySelectorAll('#operator [data-order]')) {
    const order = button.dataset.order;
    if (!('hold' in button.dataset)) { button.addEventListener('click', () => give(order)); continue; }
    let timer = null;
    const begin = () => { timer ??= setTimeout(() => { end(); give(order); }, HOLD); button.classList.add('held'); };
    const end = () => { clearTimeout(timer); timer = null; button.classList.remove('held'); };
    // Captured, so that a finger on a page that moves still holds it.
    button.addEventListener('pointerdown', (event) => { button.setPointerCapture(event.pointerId); begin(); });
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture', 'blur']) button.addEventListener(name, end);
    button.addEventListener('keydown', (event) => { if (!event.repeat && (event.key === 'Enter' || event.key === ' ')) begin(); });
    button.addEventListener('keyup', end);
    button.addEventListener('contextmenu', (event) => event.preventDefault());
  }
  $('cap').addEventListener('submit', (event) => { event.preventDefault(); give('speed-cap', Number($('cap-value').value)); });
}

export function shown() {
  $('operator').hidden = !state.hello?.operator;
  document.body.classList.toggle('ordering', Boolean(state.hello?.operator));
}
