// Responses as colours of the screen: linear numbers to sRGB, one number in grey or in false colours.

const STEPS = 16384;
const SRGB = new Uint8Array(STEPS + 1);
for (let k = 0; k <= STEPS; k += 1) {
  const linear = k / STEPS;
  const shown = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
  SRGB[k] = Math.round(255 * shown);
}
// matplotlib's viridis (CC0) at eighths, and straight lines between, within 5 of 255.
const VIRIDIS = [
  [68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128],
  [94, 201, 98], [173, 220, 48], [253, 231, 37],
];
const WHITE_SHARE = 0.98; // of the numbers lie below what is white where exposure is automatic
const OPAQUE = 0xff000000;

const level = (linear) => SRGB[linear > 0 ? Math.min(STEPS, Math.round(linear * STEPS)) : 0];

/** Red, green and blue (0 to 255) of one number from 0 to 1 in false colours. */
export function falseColour(value) {
  const at = Math.min(Math.max(value, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
  return VIRIDIS[low].map((one, k) => Math.round(one + (at - low) * (VIRIDIS[low + 1][k] - one)));
}

/** Which bands are shown as red, green and blue: three, or one three times. */
export function bandsShown(shown, labels, responses) {
  const band = labels.indexOf(shown.replace(/^receptor /, ''));
  if (band >= 0) return [band, band, band];
  if (shown !== 'receptors, false colours') return [0, 1, 2];
  // The longest waves in red, as the window of `omma view` has them.
  const [first, second, third] = mostFrequent(responses, labels.length);
  if (third !== undefined) return [third, second, first];
  return second !== undefined ? [first, first, second] : [first, first, first];
}

// Of the receptors the three that most ommatidia have, in their order; a fly's eye has ten.
function mostFrequent(responses, width) {
  const counts = new Array(width).fill(0);
  for (let k = 0; k < responses.length; k += 1) {
    if (!Number.isNaN(responses[k])) counts[k % width] += 1;
  }
  const sorted = [...counts.keys()].sort((a, b) => counts[b] - counts[a] || a - b);
  return sorted.slice(0, 3).sort((a, b) => a - b);
}

/** What is shown as white: 1, or what nearly all numbers of these bands stay below. */
export function whiteOf(responses, width, bands, automatic) {
  if (!automatic) return 1;
  const number = responses.length / width;
  const stride = Math.max(1, Math.floor(number / 2000));
  const some = [];
  for (let i = 0; i < number; i += stride) {
    for (const k of bands) {
      const value = responses[i * width + k];
      if (!Number.isNaN(value)) some.push(value);
    }
  }
  some.sort((a, b) => a - b);
  const white = some[Math.min(some.length - 1, Math.floor(WHITE_SHARE * some.length))];
  return white > 0 ? white : 1;
}

/** A colour of the canvas for each ommatidium, and a clear one at the end for what none sees; clear
 * too where an ommatidium has no such receptor. */
export function coloursOf(responses, width, bands, gain, palette) {
  const number = responses.length / width;
  const colours = new Uint32Array(number + 1);
  const [r, g, b] = bands;
  const isFalse = palette === 'false colours' && r === g && g === b;
  for (let i = 0; i < number; i += 1) {
    const at = i * width;
    if (Number.isNaN(responses[at + r])) continue; // it has no such receptor
    if (isFalse) {
      const [x, y, z] = falseColour(gain * responses[at + r]);
      colours[i] = OPAQUE | (z << 16) | (y << 8) | x;
    } else {
      colours[i] = OPAQUE | (level(gain * responses[at + b]) << 16)
        | (level(gain * responses[at + g]) << 8) | level(gain * responses[at + r]);
    }
  }
  return colours;
}
