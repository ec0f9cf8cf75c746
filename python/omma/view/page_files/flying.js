// Flying: the head goes where keys and the mouse say, and the camera of this browser goes with it.
'use strict';
{
  const degreesPerPixel = 0.12;
  const turnDegreesPerS = 60;
  const sendMs = 33;
  const ways = {
    KeyW: ['ahead', 1], KeyS: ['ahead', -1], KeyA: ['right', -1], KeyD: ['right', 1],
    KeyE: ['up', 1], KeyQ: ['up', -1],
    ArrowLeft: ['yaw', -turnDegreesPerS], ArrowRight: ['yaw', turnDegreesPerS],
    ArrowUp: ['pitch', turnDegreesPerS], ArrowDown: ['pitch', -turnDegreesPerS],
  };
  const held = new Set();
  let flying = false;
  let holding = 0;
  let before = 0;
  let gone = null;

  const nothing = () => ({ ahead: 0, right: 0, up: 0, yaw: 0, pitch: 0 });

  // viser says in each browser which of its clients that is.
  const client = () => {
    const found = document.querySelector('[data-omma-client]');
    return found ? Number(found.dataset.ommaClient) : -1;
  };

  function tick() {
    const now = performance.now();
    const seconds = Math.min((now - before) / 1000, 0.25);
    before = now;
    gone = gone || nothing();
    for (const code of held) {
      const [way, sign] = ways[code];
      gone[way] += sign * seconds;
    }
    gone.ahead += holding * seconds;
    if (Object.values(gone).some((one) => one !== 0)) {
      omma.say({ do: 'fly', client: flying ? client() : -1, ...gone });
      gone = null;
    }
  }

  omma.look = (right, down) => {
    gone = gone || nothing();
    gone.yaw += degreesPerPixel * right;
    gone.pitch -= degreesPerPixel * down;
  };

  omma.fly = (wanted = !flying) => {
    if (wanted === flying) return;
    flying = wanted;
    held.clear();
    document.body.classList.toggle('omma-flying', flying);
    omma.say({ do: 'flying', client: client(), on: flying });
    if (flying) {
      omma.note('Flying: W A S D, Q E, mouse; wheel: speed; F or Esc ends it');
      // The mouse is caught where the browser allows it; else arrows turn, and drags on the picture.
      const caught = document.body.requestPointerLock && document.body.requestPointerLock();
      if (caught && caught.catch) caught.catch(() => {});
    } else if (document.pointerLockElement) {
      document.exitPointerLock();
    }
  };
  omma.isFlying = () => flying;

  // Before viser, whose own camera these keys would move too.
  function onKey(event) {
    if (!flying || !ways[event.code] || omma.isTyping(event)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.type === 'keydown' && !(event.ctrlKey || event.metaKey || event.altKey)) {
      held.add(event.code);
    } else {
      held.delete(event.code);
    }
  }
  window.addEventListener('keydown', onKey, true);
  window.addEventListener('keyup', onKey, true);
  window.addEventListener('blur', () => held.clear());
  window.addEventListener('mousemove', (event) => {
    if (flying && document.pointerLockElement) omma.look(event.movementX, event.movementY);
  }, true);
  window.addEventListener('wheel', (event) => {
    if (!flying) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    omma.say({ do: 'speed', factor: event.deltaY < 0 ? 1.25 : 0.8 });
  }, { capture: true, passive: false });
  document.addEventListener('pointerlockchange', () => {
    // Esc gives the mouse back, and so ends the flight.
    if (!document.pointerLockElement && flying) omma.fly(false);
  });

  // What fingers hold.
  window.addEventListener('pointerdown', (event) => {
    const button = event.target.closest && event.target.closest('[data-hold]');
    if (!button) return;
    event.preventDefault();
    holding = Number(button.dataset.hold);
  });
  for (const name of ['pointerup', 'pointercancel']) {
    window.addEventListener(name, () => { holding = 0; });
  }

  window.addEventListener('DOMContentLoaded', () => {
    before = performance.now();
    setInterval(tick, sendMs);
  });
}
