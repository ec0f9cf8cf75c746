// The panel: lists and sliders that show the state and change it.

import { poseFrom } from './pose.js';

const $ = (id) => document.getElementById(id);

export const COLOURS = 'colours';
export const FALSE_COLOURS = 'receptors, false colours';
const RGB = ['red', 'green', 'blue'];
// Pictures that need a pixel for each ommatidium or show single rays are for programs.
const NOT_SHOWN = ['single_dimension_fast', 'raw_ommatidial_samples'];

const placed = (pose) => Object.values(pose).join();
export const words = (name) => name.replaceAll('_', ' ');

function fill(select, entries, chosen) {
  const options = entries.map(([value, text]) => new Option(text, value, false, value === chosen));
  select.replaceChildren(...options);
}

/** What can be shown of an eye: colours, red, green and blue, its receptors. */
export function channelsOf(receptors) {
  const more = receptors.length ? [FALSE_COLOURS, ...receptors.map((one) => `receptor ${one}`)] : [];
  return [COLOURS, ...RGB, ...more];
}

export class Panel {
  /** data: of data.json; changed(name, value): what the user chose. */
  constructor(data, projections, changed) {
    this.data = data;
    const shown = Object.entries(data.projections).filter(([, name]) => projections.includes(name));
    const known = shown.map(([, name]) => name);
    const others = projections.filter((one) => !known.includes(one) && !NOT_SHOWN.includes(one));
    this.projections = [...shown.map(([text, name]) => [name, text]), ...others.map((one) => [one, words(one)])];
    this.cameras = [];
    const listen = (id, event, value) => {
      $(id).addEventListener(event, () => changed(id, value($(id))));
    };
    for (const id of ['scene-name', 'eye-name', 'camera', 'projection', 'shown', 'palette']) {
      listen(id, 'change', (one) => one.value);
    }
    listen('rays', 'input', (one) => 2 ** Number(one.value));
    listen('widths', 'input', (one) => 2 ** Number(one.value));
    listen('exposure', 'input', (one) => Number(one.value));
    listen('automatic', 'change', (one) => one.checked);
  }

  /** Shows the state of the page. */
  show({ state, scene, eye }) {
    const own = (thing, listed) => (thing?.own && !listed.some(({ name }) => name === thing.name)
      ? [[thing.name, thing.name]] : []);
    const scenes = this.data.scenes.map(({ name, triangles }) => (
      [name, `${name} (${triangles.toLocaleString('en')} triangles)`]));
    const eyes = this.data.species.map(({ name, ommatidia }) => (
      [name, `${words(name)} (${ommatidia.toLocaleString('en')})`]));
    fill($('scene-name'), [...scenes, ...own(scene?.thing, this.data.scenes)], state.scene);
    fill($('eye-name'), [...eyes, ...own(eye?.thing, this.data.species)], state.eye);
    this.cameras = scene?.info.cameras ?? [];
    this.places = this.cameras.map((one) => placed(poseFrom(one.world_from_camera)));
    const cameras = this.cameras.map(({ name }, k) => [String(k), name || `camera ${k}`]);
    fill($('camera'), [['', 'a place of its own'], ...cameras], '');
    fill($('projection'), this.projections, state.projection);
    fill($('shown'), channelsOf(eye?.receptors ?? []).map((one) => [one, one]), state.shown);
    this.sliders(state);
  }

  sliders(state) {
    for (const id of ['rays', 'widths']) $(id).value = Math.log2(state[id]);
    $('exposure').value = state.exposure;
    $('automatic').checked = state.automatic;
    $('palette').value = state.palette;
    const here = state.pose ? this.places?.indexOf(placed(state.pose)) ?? -1 : -1;
    $('camera').value = here < 0 ? '' : here;
    const output = (id, text) => { document.querySelector(`output[for=${id}]`).value = text; };
    output('rays', state.rays);
    output('widths', `× ${Number(state.widths.toPrecision(3))}`);
    output('exposure', `${state.exposure > 0 ? '+' : ''}${state.exposure}`);
    const isOne = state.shown !== COLOURS && state.shown !== FALSE_COLOURS;
    for (const each of document.querySelectorAll('[data-one]')) each.hidden = !isOne;
  }
}
