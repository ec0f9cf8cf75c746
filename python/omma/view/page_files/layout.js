// Where what the animal sees is: in the panel, beside the scene, or all over the page.
'use strict';
{
  const layouts = ['panel', 'page', 'beside'];
  const phone = window.matchMedia('(max-width: 576px), (max-height: 480px)');
  const gap = 6;
  let layout = 'panel';
  let sent = '';

  const buttons = [
    ['layout', 'Layout'], ['fly', 'Fly'], ['next_camera', 'Camera'], ['save', 'Save'],
    ['help', 'Keys'],
  ];

  function build() {
    const big = omma.element('omma-big');
    big.innerHTML =
      '<div id="omma-bar"></div><div id="omma-frame">' +
      '<img id="omma-big-eye" data-omma-picture="eye" alt="what the animal sees" draggable="false">' +
      '</div><div id="omma-big-status"></div>' +
      '<div id="omma-hold"><button data-hold="1">▲</button><button data-hold="-1">▼</button></div>';
    for (const [what, name] of buttons) {
      const button = document.createElement('button');
      button.dataset.ommaDo = what;
      button.textContent = name;
      document.getElementById('omma-bar').append(button);
    }
    set(phone.matches ? 'page' : 'panel');
    if (phone.matches) fold(40);
    setInterval(place, 200);
    window.addEventListener('resize', place);
  }

  // On small screens viser's panel is a sheet over half of the page: folded until it is wanted.
  function fold(tries) {
    const handle = [...document.querySelectorAll('div[style*="cursor: pointer"]')]
      .find((one) => one.textContent.includes('Omma'));
    if (handle) handle.click();
    else if (tries > 0) setTimeout(() => fold(tries - 1), 250);
  }

  // The element that holds viser's canvas, and the space that it has.
  function stage() {
    let canvas = null;
    for (const one of document.querySelectorAll('canvas[data-engine]')) canvas = one;
    const holder = canvas && canvas.closest('div[style*="z-index: 0"]');
    return holder && holder.parentElement ? [holder, holder.parentElement] : [null, null];
  }

  // Of a space, the share for the picture: beside the scene or above it, whichever shows more.
  function partOf(space, ratio) {
    const size = (w, h) => Math.min(w, h * ratio);
    const half = { width: (space.width - gap) / 2, height: (space.height - gap) / 2 };
    return size(half.width, space.height) > size(space.width, half.height)
      ? { left: space.left, top: space.top, width: half.width, height: space.height, across: true }
      : { left: space.left, top: space.top, width: space.width, height: half.height, across: false };
  }

  function place() {
    const big = document.getElementById('omma-big');
    const [holder, parent] = stage();
    if (!big || !holder) return;
    big.hidden = layout === 'panel';
    const image = document.getElementById('omma-big-eye');
    const ratio = image.naturalWidth ? image.naturalWidth / image.naturalHeight : 2;
    let space = parent.getBoundingClientRect();
    const part = layout === 'beside' ? partOf(space, ratio) : null;
    const scene = { height: '100%', width: '100%', marginTop: '0', marginLeft: '0' };
    if (part && part.across) {
      scene.width = `calc(50% - ${gap / 2}px)`;
      scene.marginLeft = `calc(50% + ${gap / 2}px)`;
    } else if (part) {
      scene.height = `calc(50% - ${gap / 2}px)`;
      scene.marginTop = `${(space.height + gap) / 2}px`;
    }
    for (const [name, value] of Object.entries(scene)) {
      if (holder.style[name] !== value) holder.style[name] = value;
    }
    if (layout === 'page') space = { left: 0, top: 0, width: innerWidth, height: innerHeight };
    const at = part || space;
    for (const name of ['left', 'top', 'width', 'height']) big.style[name] = `${at[name]}px`;
    const status = document.getElementById('omma-status');
    if (status) document.getElementById('omma-big-status').textContent = status.textContent;
    omma.sendSize();
  }

  // How many pixels the picture can have, so that no more and no fewer are painted.
  omma.sendSize = () => {
    const frame = layout === 'panel'
      ? document.getElementById('omma-eye') : document.getElementById('omma-frame');
    if (!frame) return;
    const { width, height } = frame.getBoundingClientRect();
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const wide = Math.round(width * scale);
    const high = Math.round((layout === 'panel' ? width : height) * scale);
    const key = `${wide} ${high}`;
    if (wide < 1 || key === sent) return;
    sent = key;
    omma.say({ do: 'size', width: wide, height: high });
  };

  function set(name) {
    layout = name;
    document.body.dataset.ommaLayout = name;
    place();
  }

  omma.nextLayout = () => set(layouts[(layouts.indexOf(layout) + 1) % layouts.length]);
  omma.leavePage = () => { if (layout === 'page') set('panel'); };
  omma.forgetSize = () => { sent = ''; };
  window.addEventListener('DOMContentLoaded', build);
}
