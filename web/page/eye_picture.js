// The picture of what the eye sees: a canvas in which each pixel has the colour of its ommatidium.

const MARK = 0xffdc00ff; // the picked one's frame, as in the window of `omma view`
const MOST_PIXELS = 700000;
// How many times as wide as high, of the others twice.
const ASPECTS = { lambert: 1, facets: 1.25 };
const ROUND = ['mollweide', 'lambert'];
const WITHOUT_DIRECTIONS = ['facets', 'single_dimension', 'hemisphere'];

export class EyePicture {
  constructor(canvas) {
    this.canvas = canvas;
    // Pixels are written one by one: they stay in the processor's memory.
    this.context = canvas.getContext('2d', { willReadFrequently: true });
    this.ids = null;
    this.edge = [];
  }

  /** Pixels (width, height) of a projection's picture that fits into the canvas's place. */
  size(kind) {
    const place = this.canvas.parentElement.getBoundingClientRect();
    const aspect = ASPECTS[kind] ?? 2;
    const fits = Math.max(64, Math.min(place.width, place.height * aspect));
    this.canvas.style.width = `${fits}px`;
    this.canvas.style.height = `${fits / aspect}px`;
    const sharp = fits * Math.min(globalThis.devicePixelRatio || 1, 2);
    const width = 2 * Math.round(Math.min(sharp, Math.sqrt(MOST_PIXELS * aspect)) / 2);
    return [width, Math.round(width / aspect)];
  }

  /** Which ommatidium each pixel shows, of the engine's. */
  show({ kind, width, height, ids }, number) {
    this.ids = ids;
    this.kind = kind;
    this.lookup = new Uint32Array(ids.length);
    for (let k = 0; k < ids.length; k += 1) this.lookup[k] = ids[k] < 0 ? number : ids[k];
    [this.canvas.width, this.canvas.height] = [width, height];
    this.image = this.context.createImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.canvas.classList.toggle('round', ROUND.includes(kind));
    this.canvas.classList.toggle('hatched', !WITHOUT_DIRECTIONS.includes(kind));
  }

  /** Frames that ommatidium; none below 0. */
  pick(picked) {
    this.edge = [];
    if (picked < 0 || !this.ids) return;
    const { width, height } = this.canvas;
    const { ids } = this;
    for (let y = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        const at = y * width + x;
        if (ids[at] !== picked && nearTo(ids, picked, x, y, width, height)) this.edge.push(at);
      }
    }
  }

  paint(colours) {
    const { pixels, lookup } = this;
    for (let k = 0; k < lookup.length; k += 1) pixels[k] = colours[lookup[k]];
    for (const at of this.edge) pixels[at] = MARK;
    this.context.putImageData(this.image, 0, 0);
  }

  /** The ommatidium at a place of the browser's window; -1 for none. */
  at(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((clientX - box.left) / box.width) * this.canvas.width);
    const y = Math.floor(((clientY - box.top) / box.height) * this.canvas.height);
    const inside = x >= 0 && y >= 0 && x < this.canvas.width && y < this.canvas.height;
    return inside && this.ids ? this.ids[y * this.canvas.width + x] : -1;
  }
}

// Whether a pixel at most two away, along rows or columns, shows it: a frame of two pixels.
function nearTo(ids, picked, x, y, width, height) {
  for (let dy = -2; dy <= 2; dy += 1) {
    const reach = 2 - Math.abs(dy);
    const row = y + dy;
    if (row < 0 || row >= height) continue;
    for (let dx = -reach; dx <= reach; dx += 1) {
      const column = x + dx;
      if (column >= 0 && column < width && ids[row * width + column] === picked) return true;
    }
  }
  return false;
}
