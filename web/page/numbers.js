// Numbers for people and programs: those of the picked ommatidium, and all responses as CSV.

const DEGREES = 180 / Math.PI;

/** Azimuth to the right of ahead and elevation of an axis, degrees. */
export function directionOf(axes, index) {
  const [x, y, z] = axes.subarray(3 * index, 3 * index + 3);
  return [Math.atan2(x, -z) * DEGREES, Math.asin(Math.max(-1, Math.min(1, y))) * DEGREES];
}

/** The number of the eye that an ommatidium belongs to; eyes: runs of ommatidia of one eye. */
export function eyeOf(eyes, index) {
  return eyes.find(({ first, count }) => index >= first && index < first + count)?.name ?? '0';
}

/** What is known of one ommatidium, as HTML. seen: { responses, errors, labels, rays }. */
export function numbersHtml(eye, index, seen) {
  const [azimuth, elevation] = directionOf(eye.axes, index);
  const acceptance = eye.acceptance[index] * DEGREES;
  const width = seen.labels.length;
  const row = (label, k) => {
    const at = index * width + k;
    const value = seen.responses[at];
    if (Number.isNaN(value)) return '';
    const error = seen.errors ? `± ${shortly(seen.errors[at])}` : '';
    return `<tr><th>${escaped(label)}</th><td class="response">${Number(value.toPrecision(7))}</td><td>${error}</td></tr>`;
  };
  const rays = seen.errors ? `8 × ${seen.rays} rays` : `${seen.rays} rays`;
  return `<h2>Ommatidium ${index}</h2> eye ${escaped(eyeOf(eye.eyes, index))} · azimuth `
    + `${azimuth.toFixed(2)}° · elevation ${elevation.toFixed(2)}° · Δρ ${acceptance.toFixed(2)}°`
    + `<table><tr><th></th><th>response, relative</th><th>${seen.errors ? 'standard error, ' : ''}${rays}</th></tr>`
    + `${seen.labels.map(row).join('')}</table>`;
}

/** All responses as `omma render -o view.csv` writes them. */
export function csvOf(eye, { responses, labels }) {
  const rgb = labels.join() === 'red,green,blue';
  const names = rgb ? ['r', 'g', 'b'] : labels.map(quoted);
  const lines = [['pose', 'ommatidium', 'eye_id', 'azimuth_deg', 'elevation_deg', ...names].join()];
  for (let k = 0; k < responses.length / labels.length; k += 1) {
    const values = responses.subarray(k * labels.length, (k + 1) * labels.length);
    const angles = directionOf(eye.axes, k).map((one) => Number(one.toPrecision(6)));
    const said = Array.from(values, (one) => (Number.isNaN(one) ? '' : Number(one.toPrecision(9))));
    lines.push([0, k, eyeOf(eye.eyes, k), ...angles, ...said].join());
  }
  return `${lines.join('\n')}\n`;
}

const shortly = (value) => Number(value.toPrecision(3));
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
export const escaped = (text) => text.replace(/[&<>"]/g, (one) => `&#${one.charCodeAt(0)};`);
