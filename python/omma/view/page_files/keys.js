// Keys, their list, and clicks and drags on the picture.
'use strict';
{
  const here = {
    layout: () => omma.nextLayout(),
    fly: () => omma.fly(),
    help: () => { help().hidden = !help().hidden; },
    leave: () => {
      if (!help().hidden) help().hidden = true;
      else if (omma.isFlying()) omma.fly(false);
      else omma.leavePage();
    },
  };
  const farthestClick = 4; // pixels; beyond, it is a drag

  const help = () => omma.element('omma-help');
  const act = (what) => (here[what] ? here[what]() : omma.say({ do: what }));

  omma.isTyping = (event) => {
    const where = event.target;
    if (where.isContentEditable || where.tagName === 'TEXTAREA') return true;
    return where.tagName === 'INPUT' && !['checkbox', 'radio', 'range'].includes(where.type);
  };

  const byKey = new Map();
  for (const one of omma.settings.keys) {
    for (const key of one.keys) byKey.set(key, one);
  }

  window.addEventListener('keydown', (event) => {
    if (omma.isTyping(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const found = byKey.get(event.shiftKey && name !== '?' && name !== '+' ? `Shift+${name}` : name);
    if (!found || (event.repeat && !found.repeats)) return;
    act(found.does);
  });

  window.addEventListener('click', (event) => {
    const button = event.target.closest && event.target.closest('[data-omma-do]');
    if (!button) return;
    act(button.dataset.ommaDo);
    button.blur();
  });

  // Where on a picture, 0 to 1; what is not as wide as its frame stands in the middle of it.
  function placeOn(image, event) {
    const box = image.getBoundingClientRect();
    const scale = Math.min(box.width / image.naturalWidth, box.height / image.naturalHeight);
    const [wide, high] = [scale * image.naturalWidth, scale * image.naturalHeight];
    const x = (event.clientX - box.left - (box.width - wide) / 2) / wide;
    const y = (event.clientY - box.top - (box.height - high) / 2) / high;
    return x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null;
  }

  let drag = null;
  window.addEventListener('pointerdown', (event) => {
    const image = event.target.closest && event.target.closest('img[data-omma-picture="eye"]');
    if (!image || event.button !== 0) return;
    event.preventDefault();
    drag = { image, from: [event.clientX, event.clientY], at: [event.clientX, event.clientY], far: false };
  });
  window.addEventListener('pointermove', (event) => {
    if (!drag || document.pointerLockElement) return;
    const { clientX: x, clientY: y } = event;
    drag.far = drag.far || Math.hypot(x - drag.from[0], y - drag.from[1]) > farthestClick;
    // The view is taken along, as a map is.
    if (drag.far) omma.look(drag.at[0] - x, drag.at[1] - y);
    drag.at = [x, y];
  });
  window.addEventListener('pointerup', (event) => {
    const spot = drag && !drag.far ? placeOn(drag.image, event) : null;
    drag = null;
    if (spot) omma.say({ do: 'pick', ...spot });
  });
  window.addEventListener('pointercancel', () => { drag = null; });

  window.addEventListener('DOMContentLoaded', () => {
    const rows = omma.settings.help.map(([keys, says]) => `<dt>${keys}</dt><dd>${says}</dd>`);
    help().innerHTML = `<h2>Keys</h2><dl>${rows.join('')}</dl><button data-omma-do="leave">Close</button>`;
  });
}
