// The state of the page, and the link that restores it: all of it is after the '#' of the address,
// which browsers tell no server.

/** What a page is at that was opened without a link. pose: null is the scene's first camera. */
export const FIRST = {
  scene: 'meadow', eye: 'honeybee_worker', projection: 'facets', shown: 'colours', palette: 'grey',
  widths: 1, rays: 4, seed: 0, exposure: 0, automatic: false, picked: -1, pose: null,
};
export const LIMITS = { widths: [0.25, 4], rays: [1, 64], exposure: [-6, 6] };
const POSE = ['x', 'y', 'z', 'yaw', 'pitch', 'roll'];

/** The part of a link after '#'. What is as at first is left out. */
export function linkOf(state) {
  const said = new URLSearchParams();
  for (const [name, first] of Object.entries(FIRST)) {
    if (name !== 'pose' && state[name] !== first) said.set(name, state[name]);
  }
  if (state.pose) said.set('pose', POSE.map((name) => state.pose[name]).join());
  return said.toString().replaceAll('%2C', ',');
}

/** The state that a link says; what it says wrongly is left as at first, and told in `wrong`. */
export function stateOf(hash) {
  const state = { ...FIRST };
  const wrong = [];
  for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ''))) {
    if (!(name in FIRST)) continue; // 'embed', and what later versions say
    const read = name === 'pose' ? poseOf(text) : valueOf(name, text);
    if (read === undefined) wrong.push(`${name}=${text}`);
    else state[name] = read;
  }
  return { state, wrong };
}

function poseOf(text) {
  const numbers = text.split(',').map(Number);
  const good = numbers.length === POSE.length && numbers.every((one) => Math.abs(one) < 1e6);
  return good ? Object.fromEntries(POSE.map((name, k) => [name, numbers[k]])) : undefined;
}

function valueOf(name, text) {
  if (typeof FIRST[name] === 'boolean') return text === 'true';
  if (typeof FIRST[name] !== 'number') return text.slice(0, 200);
  const [least, most] = LIMITS[name] ?? [-1, 2 ** 31 - 1];
  const value = Number(text);
  const whole = name === 'widths' || name === 'exposure' || Number.isInteger(value);
  return text.trim() && value >= least && value <= most && whole ? value : undefined;
}
