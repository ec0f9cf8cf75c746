// Short lines of text that come and go.

const $ = (id) => document.getElementById(id);
const NOTE_MS = 4000;
let fading = 0;

/** The line below the picture. */
export function say(text) {
  $('status').textContent = text;
}

/** A line for some seconds. */
export function note(text) {
  clearTimeout(fading);
  $('note').textContent = text;
  $('note').hidden = !text;
  fading = setTimeout(() => { $('note').hidden = true; }, NOTE_MS);
}

/** What went wrong, until it is closed. */
export function trouble(text) {
  $('trouble').querySelector('p').textContent = text;
  $('trouble').hidden = false;
}

/** In the place of the scene's view: why it is not there. */
export function explain(text) {
  $('scene').hidden = true;
  $('scene-note').textContent = text;
  $('scene-note').hidden = false;
}

/** Hands a file to the user. */
export function download(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
