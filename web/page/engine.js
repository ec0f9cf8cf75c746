// The page's side of the engine, which runs in a worker of its own: what is asked of it comes back
// as a promise. An engine that has died, as for want of memory, is told of by `Died`.

export class Died extends Error {}

export class Engine {
  /** kind: 'threads', 'simd' or 'plain', which build of the engine. */
  constructor(kind) {
    this.kind = kind;
    this.waiting = new Map();
    this.next = 0;
    this.worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    this.worker.onmessage = ({ data }) => this.#take(data);
    this.worker.onerror = (event) => this.#die(event.message || 'its file could not be loaded');
  }

  /** Does what worker.js knows under that name. Buffers in `given.data` change hands. */
  ask(name, given = {}) {
    if (this.dead) return Promise.reject(new Died(this.dead));
    return new Promise((done, failed) => {
      this.waiting.set(this.next, { done, failed });
      const handed = given.data instanceof ArrayBuffer ? [given.data] : [];
      this.worker.postMessage({ id: this.next, name, given }, handed);
      this.next += 1;
    });
  }

  end() {
    this.#die('it was ended');
  }

  #take({ id, result, error, dead }) {
    const { done, failed } = this.waiting.get(id);
    this.waiting.delete(id);
    if (dead) {
      failed(new Died(error));
      this.#die(error);
    } else if (error !== undefined) {
      failed(new Error(error));
    } else {
      done(result);
    }
  }

  #die(why) {
    this.dead = why;
    this.worker.terminate();
    for (const { failed } of this.waiting.values()) failed(new Died(why));
    this.waiting.clear();
  }
}
