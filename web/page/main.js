// The page: brings its parts together, as the address and the browser allow.

import { App } from './app.js';
import { Bundled, kindOf, ownFile } from './files.js';
import { Hands } from './hands.js';
import { linkOf, LIMITS, stateOf } from './link.js';
import { csvOf, numbersHtml } from './numbers.js';
import { Panel, words } from './panel.js';
import { poseFrom, moved, turned, pose as poseAt } from './pose.js';
import { EyePicture } from './eye_picture.js';
import { SceneView, sizeOf } from './scene_view.js';
import { enginesHere, slower, webgl } from './support.js';
import { explain, note, say, download, trouble } from './telling.js';

const $ = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search);
const isEmbedded = asked.has('embed');
document.body.classList.toggle('embed', isEmbedded);

const MORE_KEYS = [
  ['W A S D, Q E', 'ahead, left, back, right, down, up'],
  ['arrows', 'look round'],
  ['flying: mouse, wheel', 'look round; faster, slower'],
  ['click on the picture', 'pick the ommatidium'],
  ['drag the picture', 'turn the head'],
  ['drag the yellow head', 'move it; elsewhere: the camera of the scene'],
];
const LAYOUTS = ['beside', 'page', 'panel'];

const bundled = new Bundled(new URL('./data/', location.href));
const data = await (await fetch(new URL('./data/data.json', location.href))).json();
const { state, wrong } = stateOf(location.hash);
const picture = new EyePicture($('eye'));
const notes = new Map(); // what the page says of itself, by what it is about
let speed = 1; // m/s
let camera = 0;
let view = null; // of the scene
let awaited = null; // a link's own scene, which only its user has: { scene, pose }

const shown = {
  frame(app) {
    panel?.sliders(app.state);
    view?.place(app.state.pose, hands.flying || hands.held.size > 0 || hands.holding !== 0);
    status(app);
    const { picked } = app.state;
    $('numbers').hidden = picked < 0;
    if (picked >= 0 && app.seen) $('numbers').innerHTML = numbersHtml(app.eye, picked, app.seen);
    linkSoon(app);
  },
  scene(app, info) {
    panel?.show(app);
    if (!info) return;
    speed = Math.min(Math.max(0.2 * sizeOf(info.bounds_m), 1e-4), 1);
    remark('scene', info.warnings.join(' '));
    remark('drawn', view ? view.show(info) : '');
    view?.lookAt(app.state.pose);
  },
  eye(app) { panel?.show(app); },
  said(text) { say(text); },
  trouble,
};
const app = new App(state, picture, shown);
let panel = null;

function remark(about, text) {
  notes.set(about, text);
  $('said').textContent = [...notes.values()].filter(Boolean).join(' ');
}

function status({ seen, times, renderer, eye }) {
  if (!seen || !times.length) return;
  const frames = times.length > 2 ? ((times.length - 1) * 1000) / (times.at(-1) - times[0]) : 0;
  const rays = renderer.rays_per_frame / seen.milliseconds / 1000;
  say([
    `${eye.ommatidia.toLocaleString('en')} ommatidia`, `${seen.rays} rays`,
    `${seen.milliseconds.toFixed(seen.milliseconds < 10 ? 1 : 0)} ms`,
    ...(frames ? [`${frames.toFixed(0)} frames/s`] : []), `${rays.toFixed(2)} million rays/s`,
  ].join(' · '));
}

let linking = 0;
function linkSoon({ state: now }) {
  clearTimeout(linking);
  if (isEmbedded) return;
  // Browsers take few changes of the address in a row.
  linking = setTimeout(() => history.replaceState(null, '', `#${linkOf(now)}`), 300);
}

const thingOf = (listed, name) => {
  const found = listed.find((one) => one.name === name);
  return found ? bundled.thing(found.name, found.file) : null;
};
const scaled = (name, factor) => {
  const [least, most] = LIMITS[name];
  app.change({ [name]: Math.min(Math.max(app.state[name] * factor, least), most) });
  app.want({ settings: true });
};

function choose(id, value) {
  if (id === 'scene-name' || id === 'eye-name') {
    const kind = id === 'eye-name' ? 'eye' : 'scene';
    const thing = thingOf(kind === 'eye' ? data.species : data.scenes, value);
    if (thing) app.want({ [kind]: thing });
  } else if (id === 'camera') {
    if (value !== '') toCamera(Number(value));
  } else {
    app.change({ [id]: value });
    if (id === 'projection') app.want({ picture: true });
    else if (['rays', 'widths', 'shown'].includes(id)) {
      app.want({ settings: true, picture: id === 'widths' });
    } else app.paint();
    shown.frame(app);
  }
}

function toCamera(index) {
  const { cameras } = app.scene.info;
  if (!cameras.length) return note('The scene has no cameras');
  camera = (index + cameras.length) % cameras.length;
  app.go(poseFrom(cameras[camera].world_from_camera));
  view?.lookAt(app.state.pose);
  return note(cameras[camera].name || `camera ${camera}`);
}

async function take(files) {
  try {
    // A scene and an eye that are dropped together are taken together.
    const wanted = {};
    for (const file of files) {
      const kind = kindOf(file);
      wanted[kind] = ownFile(file);
      if (kind === 'scene' && file.name === awaited?.scene) wanted.scene.pose = awaited.pose;
    }
    await app.want(wanted);
  } catch (error) {
    trouble(error.message);
  }
}

const step = (ahead, right, up) => () => app.go(moved(app.state.pose, ahead * speed / 8, right * speed / 8, up * speed / 8));
const acts = {
  note,
  go({ ahead, right, up, yaw, pitch }) {
    if (!app.state.pose) return;
    app.go(moved(turned(app.state.pose, yaw, pitch), ahead * speed, right * speed, up * speed));
  },
  pick(x, y) { app.pick(picture.at(x, y)); },
  speed(factor) {
    speed = Math.min(Math.max(speed * factor, 1e-4), 100);
    note(`${Number(speed.toPrecision(3))} m/s`);
  },
  layout() {
    const { dataset } = document.body;
    dataset.layout = LAYOUTS[(LAYOUTS.indexOf(dataset.layout) + 1) % LAYOUTS.length];
  },
  fly: () => hands.fly(),
  faster: () => acts.speed(1.25),
  slower: () => acts.speed(0.8),
  next_camera: () => toCamera(camera + 1),
  previous_camera: () => toCamera(camera - 1),
  more_rays: () => scaled('rays', 2),
  fewer_rays: () => scaled('rays', 0.5),
  save: () => $('eye').toBlob((blob) => download(blob, `${nameOf()}.png`)),
  step_ahead: step(1, 0, 0), step_back: step(-1, 0, 0), step_left: step(0, -1, 0),
  step_right: step(0, 1, 0), step_up: step(0, 0, 1), step_down: step(0, 0, -1),
  turn_left: () => app.go(turned(app.state.pose, -3, 0)),
  turn_right: () => app.go(turned(app.state.pose, 3, 0)),
  help: () => ($('help').open ? $('help').close() : $('help').show()),
  leave() {
    if ($('help').open) $('help').close();
    else if (!$('trouble').hidden) $('trouble').hidden = true;
    else if (hands.flying) hands.fly(false);
    else document.body.dataset.layout = 'beside';
  },
  open: () => $('files').click(),
  csv: () => app.seen && download(new Blob([csvOf(app.eye, app.seen)], { type: 'text/csv' }), `${nameOf()}.csv`),
  async link() {
    history.replaceState(null, '', `#${linkOf(app.state)}`);
    const own = [app.scene, app.eye].filter((one) => one?.thing.own).map(({ thing }) => thing.name);
    const more = own.length ? ` It does not hold ${own.join(' and ')}: whoever opens it drops that again.` : '';
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    note(`${copied ? 'The link is copied.' : 'The link is this page’s address.'}${more}`);
  },
};
const nameOf = () => [app.state.scene, app.state.eye].map((one) => one.replace(/\.\w+$/, '')).join('_');
const hands = new Hands(data.keys, acts);

function listen() {
  hands.watchPicture($('eye'));
  for (const button of document.querySelectorAll('[data-hold]')) hands.watchButton(button, Number(button.dataset.hold));
  document.addEventListener('click', ({ target }) => {
    const button = target.closest('[data-do]');
    if (!button) return;
    acts[button.dataset.do]();
    button.blur();
  });
  $('files').addEventListener('change', ({ target }) => take([...target.files]).finally(() => { target.value = ''; }));
  addEventListener('dragover', (event) => {
    event.preventDefault();
    $('drop').hidden = false;
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) $('drop').hidden = true; });
  addEventListener('drop', (event) => {
    event.preventDefault();
    $('drop').hidden = true;
    take([...event.dataTransfer.files]);
  });
  let resizing = 0;
  new ResizeObserver(() => {
    clearTimeout(resizing);
    resizing = setTimeout(() => app.eye && app.want({ picture: true }), 150);
  }).observe($('eye').parentElement);
  addEventListener('hashchange', () => open(stateOf(location.hash)));
  $('whole').addEventListener('pointerdown', () => { $('whole').href = `./index.html#${linkOf(app.state)}`; });
  const rows = [...data.keys.map((one) => [one.shown, one.says]), ...MORE_KEYS];
  const cells = rows.flatMap((row) => row.map((text, k) => {
    const cell = document.createElement(k ? 'dd' : 'dt');
    cell.textContent = text;
    return cell;
  }));
  $('help').querySelector('dl').replaceChildren(...cells);
}

async function viewOfScene() {
  const context = webgl($('scene'));
  if (!context) {
    explain('This browser has no WebGL: the scene’s own view is not drawn, the eye sees as ever.');
    return null;
  }
  const [three, { OrbitControls }] = await Promise.all([
    import('./three/build/three.module.js'),
    import('./three/examples/jsm/controls/OrbitControls.js'),
  ]);
  const drag = (x, y, z) => {
    const { yaw, pitch, roll } = app.state.pose;
    app.go(poseAt(x, y, z, yaw, pitch, roll));
  };
  const isBusy = () => app.isBusy();
  return new SceneView(three, OrbitControls, $('scene'), context, { drag, isBusy });
}

/** Takes what a link says; what it says wrongly is told. */
async function open({ state: wanted, wrong: not }) {
  const told = [];
  const thing = (listed, name) => {
    const found = thingOf(listed, name);
    if (!found) told.push(`The link was made with the file ${name}: drop it here again.`);
    return found ?? thingOf(listed, listed[0].name);
  };
  const scene = thing(data.scenes, wanted.scene);
  const eye = thing(data.species, wanted.eye);
  awaited = scene.name === wanted.scene ? null : { scene: wanted.scene, pose: wanted.pose };
  if (!awaited) scene.pose = wanted.pose ?? undefined;
  if (!app.projections.includes(wanted.projection)) {
    not.push(`projection=${wanted.projection}`);
    wanted.projection = 'facets';
  }
  if (not.length) told.push(`The link says what is not known here: ${not.join(', ')}.`);
  app.change({ ...wanted, pose: app.state.pose });
  await app.want({ scene, eye, settings: true, picture: true });
  if (told.length) trouble(told.join('\n'));
}

async function begin() {
  listen();
  const kinds = enginesHere(data.engines, asked.get('engine'));
  if (!kinds.length) {
    say('');
    trouble('This browser has no WebAssembly, by which the engine runs: none of its pictures can be made.');
    return;
  }
  [view] = await Promise.all([viewOfScene(), app.start(kinds)]);
  panel = new Panel(data, app.projections, choose);
  remark('engine', slower(app.engine.kind, data.engines, asked.get('engine')));
  await open({ state, wrong });
  document.body.dataset.ready = app.engine.kind;
  if (isEmbedded) return;
  // The rest of what the page brings along: from here on the network may be gone.
  const rest = [...data.scenes, ...data.species].map(({ file }) => file);
  await bundled.fetchAll(rest).then(
    () => { document.body.dataset.whole = 'yes'; },
    (error) => remark('network', error.message),
  );
}

// What tests and measurements ask the page for.
globalThis.omma = { app, words, link: () => linkOf(app.state) };
await begin().catch((error) => {
  say('');
  trouble(`The engine did not start: ${error.message}`);
});
