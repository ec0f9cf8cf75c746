// Owns the engine: scene, eye, renderer and picture. Each request is answered before the next one
// is looked at; one that fails leaves all as it was.

const FILES = { threads: 'omma_threads.js', simd: 'omma.js', plain: 'omma_plain.js' };

let omma = null;
let scene = null;
let world = null;
let eye = null; // as the file has it
let seeing = null; // the same with its acceptance angles scaled; itself where they are not
let renderer = null;
let settings = { rays: 4, seed: 0, receptors: false, widths: 1 };
let projected = null; // { kind, width, height }

const free = (handle) => handle?.delete();

const requests = {
  async start({ kind }) {
    const { default: createOmma } = await import(new URL(`./engine/${FILES[kind]}`, import.meta.url));
    omma = await createOmma();
    return { version: omma.version(), projections: Array.from(omma.projections()) };
  },

  scene({ name, data }) {
    const found = omma.load_scene(name, new Uint8Array(data));
    let made = null;
    let ready = null;
    try {
      made = omma.make_world(found);
      ready = eye ? rendererOf(made, seeing) : null;
      const info = found.info();
      const drawn = drawnOf(found);
      [renderer, world, scene].forEach(free);
      [renderer, world, scene] = [ready, made, found];
      return { ...info, drawn, renderer: infoOf() };
    } catch (error) {
      [ready, made, found].forEach(free);
      throw error;
    }
  },

  eye({ name, data, metresPerUnit }) {
    const found = omma.load_eye(name, new Uint8Array(data), metresPerUnit);
    let ready = null;
    try {
      const info = found.info();
      // Not every eye can be scaled or has receptors: another one is first shown as it is.
      const wanted = { ...settings, widths: 1, receptors: false };
      ready = world ? rendererOf(world, found, wanted) : null;
      [renderer, seeing === eye ? null : seeing, eye].forEach(free);
      [renderer, seeing, eye, settings] = [ready, found, found, wanted];
      return { ...info, receptors: [...new Set(info.receptors)], ...axesOf(), renderer: infoOf() };
    } catch (error) {
      [ready, found].forEach(free);
      throw error;
    }
  },

  settings(wanted) {
    const scaled = scaledTo(wanted.widths);
    let ready;
    try {
      ready = rendererOf(world, scaled, wanted);
    } catch (error) {
      if (scaled !== seeing && scaled !== eye) free(scaled);
      throw error;
    }
    free(renderer);
    if (seeing !== scaled && seeing !== eye) free(seeing);
    [renderer, seeing, settings] = [ready, scaled, wanted];
    return { ...axesOf(), renderer: infoOf() };
  },

  picture({ kind, width, height }) {
    const made = omma.make_projection(seeing, kind, width, height);
    try {
      projected = { kind, width, height };
      return { ...projected, ids: made.pixels() };
    } finally {
      free(made);
    }
  },

  render({ pose, frame }) {
    const before = performance.now();
    const responses = renderer.render(pose, frame);
    return { responses, milliseconds: performance.now() - before, memory: omma.memory_bytes() };
  },

  // The same with its standard error, by a renderer of its own.
  errors({ pose }) {
    const exact = rendererOf(world, seeing, settings, true);
    try {
      return { responses: exact.render(pose, 0), errors: exact.error() };
    } finally {
      free(exact);
    }
  },
};

function scaledTo(widths) {
  if (widths === settings.widths) return seeing;
  return widths === 1 ? eye : eye.scaled(widths);
}

function rendererOf(ofWorld, ofEye, { rays, seed, receptors } = settings, error = false) {
  return omma.make_renderer(ofWorld, ofEye, { rays, seed, receptors, error });
}

function infoOf() {
  return renderer?.info() ?? null;
}

function axesOf() {
  return { axes: seeing.axes(), acceptance: seeing.acceptance_rad() };
}

function drawnOf(found) {
  const parts = found.parts();
  const used = [...new Set(parts.map(({ image }) => image))].filter((image) => image >= 0);
  return { parts, images: new Map(used.map((image) => [image, found.image(image)])) };
}

// Requests wait for each other: loading the engine takes its time.
let before = Promise.resolve();
onmessage = ({ data: { id, name, given } }) => {
  before = before.then(async () => {
    try {
      const result = await requests[name](given);
      const handed = [result.responses, result.ids].filter(Boolean).map((one) => one.buffer);
      postMessage({ id, result }, handed);
    } catch (error) {
      // What the engine throws by itself leaves it whole; a trap of the machine does not.
      const dead = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
      postMessage({ id, error: error?.message ?? String(error), dead });
    }
  });
};
