// Scenes and eyes: those that come with the page, and files of the user's, which are read here and
// go nowhere.

/** The largest files that the page takes: the engine's memory ends at 4 GiB, of which a scene needs
 * several times the size of its file. Chosen, not measured. */
export const MOST_BYTES = { scene: 256 * 2 ** 20, eye: 128 * 2 ** 20 };
const ENDINGS = { scene: ['.glb', '.gltf'], eye: ['.eye', '.csv'] };

const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(bytes < 2 ** 20 ? 2 : 0)} MiB`;

/** What a file with that name is: 'scene' or 'eye'. Throws what is to be said of any other. */
export function kindOf(file) {
  const name = file.name.toLowerCase();
  const kind = Object.keys(ENDINGS).find((one) => ENDINGS[one].some((end) => name.endsWith(end)));
  if (!kind) {
    throw new Error(
      `${file.name}: expected a scene (.glb, or .gltf with all inside) or an eye (.eye, .csv)`,
    );
  }
  if (file.size > MOST_BYTES[kind]) {
    throw new Error(
      `${file.name}: ${megabytes(file.size)}; in a browser's page ${kind === 'eye' ? 'an eye' : 'a scene'} may `
      + `have ${megabytes(MOST_BYTES[kind])}. The package on your machine takes larger ones.`,
    );
  }
  if (file.size === 0) throw new Error(`${file.name}: the file is empty`);
  return kind;
}

/** Things that are read when they are needed: { name, own, bytes() }. */
export function ownFile(file) {
  return { name: file.name, own: true, bytes: () => file.arrayBuffer() };
}

/** What comes with the page: fetched once, kept as it came, so that the network may go. */
export class Bundled {
  constructor(folder) {
    this.folder = folder;
    this.came = new Map();
  }

  thing(name, file) {
    return { name, file: file.replace(/\.gz$/, ''), own: false, bytes: () => this.#bytes(file) };
  }

  /** All of these, one after the other, in the background. */
  async fetchAll(files) {
    for (const file of files) await this.#fetched(file);
  }

  async #bytes(file) {
    const blob = await this.#fetched(file);
    const head = new Uint8Array(await blob.slice(0, 2).arrayBuffer());
    // Some hosts unpack what is packed on its way.
    if (head[0] !== 0x1f || head[1] !== 0x8b) return blob.arrayBuffer();
    const plain = blob.stream().pipeThrough(new DecompressionStream('gzip'));
    return new Response(plain).arrayBuffer();
  }

  #fetched(file) {
    if (!this.came.has(file)) {
      const coming = fetch(new URL(file, this.folder)).then(
        (answer) => {
          if (!answer.ok) throw new Error(`${file}: the page's folder lacks it (${answer.status})`);
          return answer.blob();
        },
        () => { throw new Error(`${file}: the network did not bring it; what is here goes on`); },
      );
      this.came.set(file, coming);
      coming.catch(() => this.came.delete(file)); // asked again the next time
    }
    return this.came.get(file);
  }
}
