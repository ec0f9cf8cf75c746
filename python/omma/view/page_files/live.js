// The page's own web socket: pictures come in, what hands do goes out. Where it does not open, the
// page says why.
'use strict';
{
  const streams = ['eye', 'camera'];
  const file = 255;
  const waitMs = 1000;
  const urls = {};
  let socket = null;
  let everOpen = false;

  omma.say = (message) => {
    if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
  };

  // A line for a moment.
  let noteTimer = 0;
  omma.note = (text) => {
    const note = omma.element('omma-note');
    note.textContent = text;
    note.hidden = false;
    clearTimeout(noteTimer);
    noteTimer = setTimeout(() => { note.hidden = true; }, 2000);
  };

  omma.element = (id) => {
    let found = document.getElementById(id);
    if (!found) {
      found = document.createElement('div');
      found.id = id;
      found.hidden = true;
      document.body.append(found);
    }
    return found;
  };

  const imagesOf = (name) => document.querySelectorAll(`img[data-omma-picture="${name}"]`);

  const loaded = (image) => new Promise((resolve) => {
    image.onload = image.onerror = resolve;
    setTimeout(resolve, waitMs);
  });

  async function show(name, blob) {
    const before = urls[name];
    urls[name] = URL.createObjectURL(blob);
    const images = [...imagesOf(name)];
    const all = images.map(loaded);
    for (const image of images) image.src = urls[name];
    await Promise.all(all);
    if (before) URL.revokeObjectURL(before);
    omma.say({ do: 'took' });
  }

  // viser makes parts of its panel anew: what is new there gets the last picture.
  setInterval(() => {
    for (const name of streams) {
      for (const image of imagesOf(name)) {
        if (!image.getAttribute('src') && urls[name]) image.src = urls[name];
      }
    }
  }, 250);

  function keep(blob) {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = 'view.png';
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  }

  async function sayWhy() {
    let text = 'omma has ended, or cannot be reached any more.';
    try {
      // The folder that the page's own is in, which is named by the last word of its path.
      const folder = location.pathname.replace(/[^/]*\/$/, '');
      const asked = new URLSearchParams({ origin: location.origin, folder });
      const answer = await fetch(`why?${asked}`);
      if (answer.ok && everOpen) return;
      text = await answer.text();
    } catch { /* nobody is there: that is what is said */ }
    const trouble = omma.element('omma-trouble');
    trouble.textContent = text;
    trouble.hidden = false;
  }

  function connect() {
    const address = new URL('live', location.href);
    address.protocol = address.protocol.replace('http', 'ws');
    socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      everOpen = true;
      omma.element('omma-trouble').hidden = true;
      omma.forgetSize();
    };
    socket.onmessage = (event) => {
      if (typeof event.data === 'string') return omma.note(event.data);
      const kind = new Uint8Array(event.data, 0, 1)[0];
      const rest = event.data.slice(1);
      if (kind === file) keep(new Blob([rest], { type: 'image/png' }));
      else show(streams[kind], new Blob([rest], { type: 'image/jpeg' }));
    };
    socket.onclose = async () => {
      await sayWhy();
      setTimeout(connect, waitMs);
    };
  }

  window.addEventListener('DOMContentLoaded', connect);
}
