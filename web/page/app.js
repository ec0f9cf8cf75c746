// The page's state and what follows from it: one thing after the other is asked of the engine, until
// what is shown is what is wanted. Nothing runs while nothing changes.

import { bandsShown, coloursOf, whiteOf } from './colours.js';
import { Died, Engine } from './engine.js';
import { matrixOf, poseFrom, pose as poseAt } from './pose.js';

const STILL_MS = 400; // after which the picked ommatidium's standard error is asked for
const MOVING_MS = 150; // after a frame, until which another one is expected
const isReceptors = (shown) => shown.startsWith('receptor');

export class App {
  /** show: what the page does with news: frame(app), scene(app, info), eye(app), said(text),
   * trouble(text). */
  constructor(state, picture, show) {
    Object.assign(this, { state, picture, show });
    this.kinds = []; // of engines, best first
    this.wanted = {}; // scene, eye: what is to be loaded; settings, picture, frame: true
    this.scene = null; // { thing, info }
    this.eye = null; // { thing, ommatidia, eyes, receptors, axes, acceptance }
    this.seen = null; // { responses, errors, labels, rays, milliseconds, pose }
    this.times = []; // of the last frames, for frames/s
    this.frames = 0;
    this.settled = {}; // of the state, what the engine is set to
  }

  async start(kinds) {
    this.kinds = kinds;
    this.engine = new Engine(kinds[0]);
    try {
      Object.assign(this, await this.engine.ask('start', { kind: kinds[0] }));
    } catch (error) {
      this.engine.end();
      if (kinds.length === 1) throw error;
      await this.start(kinds.slice(1)); // a slower one may run
    }
  }

  /** Asks for these: { scene: thing, eye: thing, settings, picture, frame }. */
  want(what) {
    Object.assign(this.wanted, what);
    this.working ??= this.#work();
    return this.working;
  }

  change(changes) {
    Object.assign(this.state, changes);
  }

  go(pose) {
    this.state.pose = pose;
    this.want({ frame: true });
  }

  /** Whether frames follow each other, as while the head moves. */
  isBusy() {
    return Boolean(this.working) || performance.now() - (this.times.at(-1) ?? 0) < MOVING_MS;
  }

  /** Shows the last frame again, in the colours that are wanted. */
  paint() {
    const { seen, state } = this;
    if (!seen || !this.picture.ids) return;
    const bands = bandsShown(state.shown, seen.labels, seen.responses);
    const white = whiteOf(seen.responses, seen.labels.length, bands, state.automatic);
    const gain = 2 ** state.exposure / white;
    this.picture.paint(coloursOf(seen.responses, seen.labels.length, bands, gain, state.palette));
  }

  pick(picked) {
    this.state.picked = picked;
    this.picture.pick(picked);
    this.paint();
    this.show.frame(this);
    this.#errorsSoon();
  }

  async #work() {
    await null; // so that `working` is set before it is cleared
    for (;;) {
      const { wanted } = this;
      this.wanted = {};
      if (!Object.keys(wanted).length) {
        this.working = null;
        return;
      }
      try {
        if (wanted.scene) await this.#loadScene(wanted.scene);
        const isNew = wanted.eye && await this.#loadEye(wanted.eye);
        if (!this.scene || !this.eye) continue;
        if (wanted.settings || isNew) await this.#settle();
        if (wanted.picture || isNew) await this.#project();
        await this.#render();
      } catch (error) {
        this.show.trouble(error.message);
        if (error instanceof Died) await this.#again();
        // What was there before is there still; nothing is tried a second time by itself.
      }
    }
  }

  // What is asked for along with a scene or an eye that fails is done all the same.
  async #loadScene(thing) {
    const info = await this.#load('scene', thing);
    if (!info) return;
    this.scene = { thing, info };
    this.state.scene = thing.name;
    this.state.pose = thing.pose ?? placeIn(info);
    this.#took(info.renderer);
    this.show.scene(this, info);
    delete info.drawn; // the engine and the graphics card have it
  }

  async #loadEye(thing) {
    const info = await this.#load('eye', thing, { metresPerUnit: 0.001 });
    if (!info) return false;
    this.eye = { thing, ...info };
    this.state.eye = thing.name;
    if (this.state.picked >= info.ommatidia) this.state.picked = -1;
    if (isReceptors(this.state.shown) && !this.#hasShown()) this.state.shown = 'colours';
    this.settled = { ...this.settled, widths: 1, shown: 'colours' };
    this.#took(info.renderer);
    this.show.eye(this);
    return true;
  }

  async #load(kind, thing, more = {}) {
    this.show.said(`Reading ${thing.name} …`);
    try {
      const data = await thing.bytes();
      return await this.engine.ask(kind, { name: thing.file ?? thing.name, data, ...more });
    } catch (error) {
      if (error instanceof Died) throw error;
      this.show.trouble(error.message);
      this.show.scene(this);
      this.show.eye(this);
      return null;
    } finally {
      this.show.said('');
    }
  }

  #hasShown() {
    const name = this.state.shown.replace(/^receptor /, '');
    return this.eye.receptors.length && (name.startsWith('receptors') || this.eye.receptors.includes(name));
  }

  async #settle() {
    const { rays, seed, widths, shown } = this.state;
    const wanted = { rays, seed, widths, receptors: isReceptors(shown) };
    try {
      const { renderer, axes, acceptance } = await this.engine.ask('settings', wanted);
      Object.assign(this.eye, { axes, acceptance });
      this.#took(renderer);
      this.settled = { rays, seed, widths, shown };
    } catch (error) {
      if (error instanceof Died) throw error;
      // Not all that can be chosen can be had of every eye.
      Object.assign(this.state, this.settled);
      this.show.trouble(error.message);
      this.show.eye(this);
    }
  }

  #took(renderer) {
    if (renderer) this.renderer = renderer;
  }

  async #project() {
    const [width, height] = this.picture.size(this.state.projection);
    const made = await this.engine.ask('picture', { kind: this.state.projection, width, height });
    this.picture.show(made, this.eye.ommatidia);
    this.picture.pick(this.state.picked);
  }

  async #render() {
    if (!this.picture.ids) await this.#project();
    // The next frame is rendered while this one is painted.
    for (let asked = this.#ask(); asked;) {
      const seen = await asked;
      const isFrameAll = this.wanted.frame && Object.keys(this.wanted).length === 1;
      if (isFrameAll) this.wanted = {};
      asked = isFrameAll ? this.#ask() : null;
      this.#see(seen);
    }
  }

  async #ask() {
    const { pose, rays } = this.state;
    const { labels } = this.renderer;
    const frame = await this.engine.ask('render', { pose: matrixOf(pose), frame: 0 });
    return { ...frame, errors: null, labels, rays, pose };
  }

  #see(seen) {
    this.seen = seen;
    this.frames += 1;
    const now = performance.now();
    this.times = [...this.times.filter((one) => one > now - 1000), now];
    this.paint();
    this.show.frame(this);
    this.#errorsSoon();
  }

  // While the head holds still and an ommatidium is picked, its standard error is rendered, once.
  #errorsSoon() {
    clearTimeout(this.soon);
    if (this.state.picked < 0 || !this.seen || this.seen.errors) return;
    this.soon = setTimeout(async () => {
      const { seen } = this;
      try {
        const found = await this.engine.ask('errors', { pose: matrixOf(seen.pose) });
        if (this.seen !== seen || this.working) return;
        this.seen = { ...seen, ...found };
        this.paint();
        this.show.frame(this);
      } catch (error) {
        this.show.trouble(error.message);
      }
    }, STILL_MS);
  }

  // An engine that has died is started anew, with the scene and the eye that it had.
  async #again() {
    const { scene, eye } = this;
    await this.start(this.kinds);
    this.renderer = null;
    if (scene) this.wanted.scene ??= { ...scene.thing, pose: this.state.pose };
    if (eye) this.wanted.eye ??= eye.thing;
  }
}

/** Where the head is at first: at the first camera, or else in the middle of the scene. */
export function placeIn({ cameras, bounds_m: bounds }) {
  if (cameras.length) return poseFrom(cameras[0].world_from_camera);
  return bounds ? poseAt(...[0, 1, 2].map((k) => (bounds[k] + bounds[3 + k]) / 2)) : poseAt(0, 0, 0);
}
