// Keys, mouse and fingers: what they ask of the page. The table of keys is that of `omma view`.

const DEGREES_PER_PIXEL = 0.12;
const TURN_DEG_PER_S = 60;
const FARTHEST_CLICK = 4; // pixels; beyond, it is a drag
const LONGEST_S = 0.25; // of one step of a flight, however long the browser was away
const WAYS = {
  KeyW: ['ahead', 1], KeyS: ['ahead', -1], KeyA: ['right', -1], KeyD: ['right', 1],
  KeyE: ['up', 1], KeyQ: ['up', -1],
  ArrowLeft: ['yaw', -TURN_DEG_PER_S], ArrowRight: ['yaw', TURN_DEG_PER_S],
  ArrowUp: ['pitch', TURN_DEG_PER_S], ArrowDown: ['pitch', -TURN_DEG_PER_S],
};
const nothing = () => ({ ahead: 0, right: 0, up: 0, yaw: 0, pitch: 0 });

export class Hands {
  /** keys: the table; acts: what is done, by name: each action of the table, and go({ ahead, right,
   * up } in seconds of flight, { yaw, pitch } in degrees), pick(clientX, clientY), speed(factor). */
  constructor(keys, acts) {
    this.acts = acts;
    this.held = new Set();
    this.holding = 0;
    this.flying = false;
    this.moving = false;
    this.byKey = new Map(keys.flatMap((one) => one.keys.map((key) => [key, one])));
    this.#listen();
  }

  fly(wanted = !this.flying) {
    if (wanted === this.flying) return;
    this.flying = wanted;
    this.held.clear();
    document.body.classList.toggle('flying', wanted);
    this.acts.note(wanted ? 'Flying: W A S D, Q E, mouse; wheel: speed; F or Esc ends it' : '');
    if (wanted) {
      // The mouse is caught where the browser allows it; else arrows turn, and drags of the picture.
      document.body.requestPointerLock?.()?.catch?.(() => {});
    } else if (document.pointerLockElement) {
      document.exitPointerLock();
    }
  }

  /** The picture of the eye: a click picks, a drag turns the head. */
  watchPicture(canvas) {
    let drag = null;
    canvas.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || drag) return;
      event.preventDefault();
      canvas.setPointerCapture(event.pointerId);
      const from = [event.clientX, event.clientY];
      drag = { pointer: event.pointerId, from, at: from, far: false };
    });
    canvas.addEventListener('pointermove', (event) => {
      if (drag?.pointer !== event.pointerId || document.pointerLockElement) return;
      const { clientX: x, clientY: y } = event;
      drag.far ||= Math.hypot(x - drag.from[0], y - drag.from[1]) > FARTHEST_CLICK;
      // The view is taken along, as a map is.
      if (drag.far) this.#look(drag.at[0] - x, drag.at[1] - y);
      drag.at = [x, y];
    });
    for (const name of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(name, (event) => {
        if (drag?.pointer !== event.pointerId) return; // another finger's
        if (name === 'pointerup' && !drag.far) this.acts.pick(event.clientX, event.clientY);
        drag = null;
      });
    }
  }

  /** A button that goes ahead (1) or back (-1) while it is held. */
  watchButton(button, way) {
    button.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      this.holding = way;
      this.#move();
    });
    for (const name of ['pointerup', 'pointercancel', 'pointerleave']) {
      button.addEventListener(name, () => { this.holding = 0; });
    }
    button.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  #look(right, down) {
    const gone = nothing();
    gone.yaw = DEGREES_PER_PIXEL * right;
    gone.pitch = -DEGREES_PER_PIXEL * down;
    this.acts.go(gone);
  }

  // Frames of the browser are asked for only while something is held.
  #move() {
    if (this.moving) return;
    this.moving = true;
    let before = performance.now();
    const tick = () => {
      if (!this.held.size && !this.holding) {
        this.moving = false;
        return;
      }
      const now = performance.now();
      const seconds = Math.min((now - before) / 1000, LONGEST_S);
      before = now;
      const gone = nothing();
      for (const code of this.held) gone[WAYS[code][0]] += WAYS[code][1] * seconds;
      gone.ahead += this.holding * seconds;
      this.acts.go(gone);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  #listen() {
    window.addEventListener('keydown', (event) => this.#key(event));
    window.addEventListener('keyup', (event) => this.held.delete(event.code));
    window.addEventListener('blur', () => {
      this.held.clear();
      this.holding = 0;
    });
    window.addEventListener('mousemove', (event) => {
      if (this.flying && document.pointerLockElement) this.#look(event.movementX, event.movementY);
    });
    window.addEventListener('wheel', (event) => {
      if (!this.flying) return;
      event.preventDefault();
      this.acts.speed(event.deltaY < 0 ? 1.25 : 0.8);
    }, { passive: false });
    document.addEventListener('pointerlockchange', () => {
      // Esc gives the mouse back, and so ends the flight.
      if (!document.pointerLockElement && this.flying) this.fly(false);
    });
  }

  #key(event) {
    if (isTyping(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    const ofSlider = event.target.type === 'range' && event.code.startsWith('Arrow');
    if (WAYS[event.code] && !ofSlider) {
      event.preventDefault();
      this.held.add(event.code);
      this.#move();
      return;
    }
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const shifted = event.shiftKey && name !== '?' && name !== '+' ? `Shift+${name}` : name;
    const found = this.byKey.get(shifted);
    if (!found || (event.repeat && !found.repeats)) return;
    event.preventDefault();
    this.acts[found.does]?.();
  }
}

function isTyping({ target }) {
  if (target.isContentEditable || ['TEXTAREA', 'SELECT'].includes(target.tagName)) return true;
  return target.tagName === 'INPUT' && !['checkbox', 'range', 'button'].includes(target.type);
}
