// What the page knows: kept up to date by the server's events, drawn by the other files.

// Columns of a sample, as the server writes them.
export const T = 0, S = 1, X = 2, Y = 3, V = 4, A = 5, DELTA = 6, USE_F = 7, USE_R = 8, SUPPORT = 9, LIMITED = 10;
// Steps kept, as many as the server keeps.
const STEPS = 1200;

export const state = {
  hello: null, world: null, laps: { rows: [], last: null, best: null }, status: null, ended: null,
  lap: { lap: 0, whole: false, samples: [] }, car: null, plan: null, steps: [],
  states: 0, connected: false, heard: 0,
  // Grow with each change of what is drawn once: track, curves of other laps, this lap, steps.
  versions: { world: 0, laps: 0, lap: 0, steps: 0, status: 0, frame: 0 },
  // Place along the track that a finger or mouse points at.
  hover: null,
};

// A car that moves between the states that arrive, one interval late.
export const motion = { from: null, to: null, since: 0, interval: 100 };

const listeners = [];
export const onChange = (listener) => listeners.push(listener);
const changed = (what) => { state.versions[what] += 1; for (const listener of listeners) listener(what); };

function onFrame(frame) {
  state.heard = performance.now();
  if (frame.car) {
    if (!state.car || frame.car.at !== state.car.at) moved(frame.car);
    state.car = frame.car;
  }
  state.states = frame.states;
  if (frame.lap) {
    const { lap, whole, fresh, add } = frame.lap;
    if (fresh) { state.lap = { lap, whole, samples: [] }; state.versions.lap += 1; }
    for (const sample of add) state.lap.samples.push(sample);
  }
  if (frame.steps) {
    state.steps.push(...frame.steps);
    if (state.steps.length > STEPS) state.steps.splice(0, state.steps.length - STEPS);
    state.versions.steps += 1;
  }
  if (frame.plan) state.plan = frame.plan;
  changed('frame');
}

// Where the car is drawn now, until the next state.
export function pose(now) {
  const { from, to, since, interval } = motion;
  if (!to) return null;
  if (!from) return to;
  const part = Math.min(1, (now - since) / interval);
  const turn = Math.atan2(Math.sin(to.yaw - from.yaw), Math.cos(to.yaw - from.yaw));
  return { x: from.x + part * (to.x - from.x), y: from.y + part * (to.y - from.y), yaw: from.yaw + part * turn,
    s: Math.abs(to.s - from.s) > 0.4 * (state.world?.length ?? Infinity) ? to.s : from.s + part * (to.s - from.s),
    v: from.v + part * (to.v - from.v), moving: part < 1 };
}

function moved(car) {
  const now = performance.now(), shown = pose(now);
  const far = shown && Math.hypot(car.x - shown.x, car.y - shown.y) > 2 + Math.abs(car.v);
  const gap = now - motion.since;
  if (motion.to && gap < 1000) motion.interval += 0.15 * (Math.min(gap, 250) - motion.interval);
  motion.from = shown && !far ? shown : null;
  motion.to = car;
  motion.since = now;
}

// A number as it is written.
export const number = (value, digits = 2) => (Number.isFinite(value) ? value.toFixed(digits) : '–');

// Value of a column of a trace at a place, between the samples around it.
export function at(samples, s, column, key = S) {
  let low = 0, high = samples.length - 1;
  if (high < 1 || s < samples[0][key] || s > samples[high][key]) return NaN;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (samples[middle][key] <= s) low = middle; else high = middle;
  }
  const [a, b] = [samples[low], samples[high]], span = b[key] - a[key];
  if (a[column] === null || b[column] === null) return NaN;
  return span > 0 ? a[column] + (s - a[key]) / span * (b[column] - a[column]) : a[column];
}

// Samples of this lap up to the car as it is drawn.
export function reached(samples, car) {
  let count = samples.length;
  if (Number.isFinite(car?.s)) while (count > 0 && samples[count - 1][S] > car.s) count -= 1;
  return count;
}

// Time lost so far against a lap at a place of this one; of laps that were seen from the line on.
export function behind(sample, other) {
  return sample[T] - at(other, sample[S], T);
}

// Begins to listen; the browser comes back by itself after a break.
export function listen() {
  const source = new EventSource('/stream');
  const on = (name, take) => source.addEventListener(name, (event) => take(JSON.parse(event.data)));
  on('hello', (hello) => {
    // All of a drive comes again after it: nothing old may stay beside it.
    Object.assign(state, { hello, world: null, car: null, plan: null, steps: [], status: null, ended: null,
      laps: { rows: [], last: null, best: null }, lap: { lap: 0, whole: false, samples: [] }, connected: true });
    motion.from = motion.to = null;
    for (const what of ['world', 'laps', 'lap']) state.versions[what] += 1;
    changed('hello');
  });
  on('world', (world) => { state.world = world; changed('world'); });
  on('laps', (laps) => { state.laps = laps; changed('laps'); });
  on('status', ({ seen, ended }) => { state.status = seen; state.ended = ended; changed('status'); });
  on('frame', onFrame);
  source.onerror = () => { state.connected = false; changed('hello'); };
}
