// What this browser can do, and what the page says where it lacks something.

// A module of one function with an instruction of 128 bits (i8x16.splat of 0, popcnt).
const SIMD = Uint8Array.of(
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15,
  253, 98, 11,
);

export const hasWebAssembly = () => typeof WebAssembly === 'object';
export const hasSimd = () => hasWebAssembly() && WebAssembly.validate(SIMD);
export const hasThreads = () => globalThis.crossOriginIsolated === true;

/** Which of the builds that are there runs here, best first; the page's '?engine=' asks for one. */
export function enginesHere(there, asked) {
  const works = { threads: hasSimd() && hasThreads(), simd: hasSimd(), plain: hasWebAssembly() };
  const found = ['threads', 'simd', 'plain'].filter((kind) => there.includes(kind) && works[kind]);
  return found.includes(asked) ? [asked] : found;
}

/** What makes this engine slower than the best one, in words; '' where nothing does, or it was
 * asked for. */
export function slower(kind, there, asked) {
  if (kind === asked) return '';
  if (kind === 'plain') return 'This browser has no WebAssembly SIMD: the same numbers, slower.';
  if (kind === 'simd' && there.includes('threads')) {
    return hasThreads() ? 'One thread: the engine with threads did not start.'
      : 'One thread: this address is not isolated (headers COOP and COEP), so that there are no more.';
  }
  return '';
}

/** The WebGL of a canvas, or null. */
export function webgl(canvas) {
  const wanted = { antialias: true, alpha: false };
  return canvas.getContext('webgl2', wanted) ?? canvas.getContext('webgl', wanted);
}
