// The page of a study: plots from its data, the choice of channel, and the image viewer. Fetches nothing.
(() => {
  const study = JSON.parse(document.getElementById('study').textContent);
  const part = (root, selector) => root.querySelector(selector);

  // ---- Plots, drawn when first seen.
  const draw = figure => {
    if (figure.dataset.drawn || !figure.offsetParent) return;
    figure.dataset.drawn = 'yes';
    figure.innerHTML = raylexPlot(d3, study.plots[figure.dataset.plot]);
    figure.addEventListener('pointerover', event => {
      const group = event.target.closest('.series, .legend');
      figure.classList.toggle('focused', !!group);
      figure.querySelectorAll('.series, .legend').forEach(each =>
        each.classList.toggle('focus', !!group && each.dataset.slot === group.dataset.slot));
    });
    figure.addEventListener('pointerleave', () => figure.classList.remove('focused'));
  };
  const drawAll = () => document.querySelectorAll('.plot').forEach(draw);

  // ---- One channel at a time: buttons with data-choose show the panels with the same key.
  document.querySelectorAll('.scene-study').forEach(section => {
    const buttons = [...section.querySelectorAll('[data-choose]')], panels = [...section.querySelectorAll('[data-panel]')];
    const choose = key => {
      buttons.forEach(each => each.setAttribute('aria-pressed', String(each.dataset.choose === key)));
      panels.forEach(each => { each.hidden = each.dataset.panel !== key; });
      drawAll();
    };
    buttons.forEach(each => each.addEventListener('click', () => choose(each.dataset.choose)));
    if (buttons.length) choose(buttons[0].dataset.choose);
  });
  drawAll();

  // ---- Pictures: base64 of a zlib stream of half floats, high bytes (differences along the picture) before low bytes,
  // all of red before all of green before all of blue.
  const halves = new Float32Array(65536);
  for (let h = 0; h < 65536; ++h) {
    const exponent = h >> 10 & 31, fraction = h & 1023;
    const value = exponent === 0 ? fraction * 2 ** -24 : exponent === 31 ? (fraction ? NaN : Infinity)
      : (1 + fraction / 1024) * 2 ** (exponent - 15);
    halves[h] = h & 32768 ? -value : value;
  }
  const cache = new Map();
  const picture = id => {
    if (!cache.has(id)) cache.set(id, (async () => {
      const raw = atob(document.getElementById('picture-' + id).textContent);
      const packed = new Uint8Array(raw.length);
      for (let i = 0; i < raw.length; ++i) packed[i] = raw.charCodeAt(i);
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
      const bytes = new Uint8Array(await new Response(stream).arrayBuffer()), count = bytes.length / 2;
      const values = new Float32Array(count);
      for (let i = 0, high = 0; i < count; ++i) {
        high = high + bytes[i] & 255;
        values[i] = halves[high << 8 | bytes[count + i]];
      }
      return values;
    })());
    return cache.get(id);
  };

  const curve = new Uint8ClampedArray(4097);  // the sRGB transfer function
  for (let i = 0; i <= 4096; ++i) {
    const v = i / 4096;
    curve[i] = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  }
  const shown = v => v > 0 ? curve[Math.min(4096, Math.round(v * 4096))] : 0;
  const digits = v => Number.isFinite(v) ? +v.toPrecision(3) : Number.isNaN(v) ? '\u2013' : String(v);

  document.querySelectorAll('.bench').forEach(bench => {
    const scene = study.pictures[+bench.dataset.scene], { width, height } = scene, count = width * height;
    const canvas = part(bench, 'canvas'), context = canvas.getContext('2d'), a = part(bench, '.pick-a'), b = part(bench, '.pick-b');
    const exposure = part(bench, '.exposure'), tagA = part(bench, '.tag.a'), tagB = part(bench, '.tag.b');
    const modes = [...bench.querySelectorAll('[data-mode]')], channels = [...bench.querySelectorAll('[data-channel]')];
    const state = { mode: 'a', channel: 0, divide: 0.5, x: -1, y: -1 };
    canvas.width = width;
    canvas.height = height;
    const image = context.createImageData(width, height);
    const none = new Float32Array(3 * count).fill(NaN);  // an image without this channel: black, and no numbers
    const channel = (select, index) => {
      const id = scene.images[select.value].ids[index];
      return id === null ? Promise.resolve(none) : picture(id);
    };
    let turn = 0;
    const paint = async () => {
      const mine = ++turn;
      const [va, vb] = await Promise.all([channel(a, state.channel), channel(b, state.channel)]);
      if (mine !== turn) return;
      const gain = 2 ** +exposure.value, data = image.data, split = Math.round(state.divide * width);
      let mean = 0;
      if (state.mode === 'difference') for (const v of vb) mean += Math.abs(v) / vb.length;
      for (let p = 0; p < count; ++p) {
        const q = 4 * p;
        data[q + 3] = 255;
        if (state.mode === 'difference') {
          let d = 0;  // the mean over red, green and blue of the difference relative to B, dark pixels judged as a tenth of the mean
          for (let c = 0; c < 3; ++c) {
            const reference = vb[c * count + p];
            d += (va[c * count + p] - reference) / Math.max(Math.abs(reference), 0.1 * mean, 1e-30) / 3;
          }
          d = Math.max(-1, Math.min(1, d * gain));
          data[q] = d > 0 ? 40 + 215 * d : 40 * (1 + d);
          data[q + 1] = 40 + 110 * Math.max(0, Math.abs(d) - 0.5);
          data[q + 2] = d < 0 ? 40 - 215 * d : 40 * (1 - d);
        } else {
          const from = state.mode === 'b' || (state.mode === 'split' && p % width >= split) ? vb : va;
          for (let c = 0; c < 3; ++c) data[q + c] = shown(from[c * count + p] * gain);
          if (state.mode === 'split' && p % width === split) data[q] = data[q + 1] = data[q + 2] = 255;
        }
      }
      context.putImageData(image, 0, 0);
      canvas.dataset.painted = state.mode;
      const name = select => scene.images[select.value].name;
      tagA.textContent = state.mode === 'difference' ? name(a) + ' \u2212 ' + name(b) : state.mode === 'b' ? '' : name(a);
      tagB.textContent = state.mode === 'difference' ? 'red too bright, blue too dark; full colour at ' + digits(100 / gain) + ' %'
        : state.mode === 'a' ? '' : name(b);
      tagA.hidden = !tagA.textContent;
      tagB.hidden = !tagB.textContent;
      modes.forEach(each => each.setAttribute('aria-pressed', String(each.dataset.mode === state.mode)));
      channels.forEach((each, i) => each.setAttribute('aria-pressed', String(i === state.channel)));
      part(bench, '.stops').textContent = (exposure.value > 0 ? '+' : '') + exposure.value + ' stops';
    };
    let reading = 0;
    const read = async () => {
      const mine = ++reading, index = state.y * width + state.x;
      if (!(index >= 0 && index < count)) return;
      const load = select => Promise.all(scene.channels.map((_, i) => channel(select, i)));
      const [la, lb] = await Promise.all([load(a), load(b)]);
      if (mine !== reading) return;
      const value = (list, i) => [0, 1, 2].map(c => list[i][c * count + index]);
      const sum = v => v[0] + v[1] + v[2];
      part(bench, '.where').textContent = scene.block > 1
        ? `mean of ${scene.block} x ${scene.block} pixels from (${state.x * scene.block}, ${state.y * scene.block})` : `pixel (${state.x}, ${state.y})`;
      part(bench, '.readout tbody').replaceChildren(...scene.channels.map((label, i) => {
        const row = document.createElement('tr'), va = value(la, i), vb = value(lb, i);
        const share = (v, list) => sum(v) === sum(v) && sum(value(list, 0)) ? (100 * sum(v) / sum(value(list, 0))).toFixed(1) + ' %' : '';
        for (const [cell, number] of [[label, false], [va.map(digits).join('  '), true], [share(va, la), true],
                                      [vb.map(digits).join('  '), true], [share(vb, lb), true]]) {
          const td = row.insertCell();
          td.textContent = cell;
          if (number) td.className = 'number';
        }
        return row;
      }));
      bench.dataset.read = 'yes';
    };
    const setMode = mode => { state.mode = mode; paint(); };
    modes.forEach(each => each.addEventListener('click', () => setMode(each.dataset.mode)));
    channels.forEach((each, i) => each.addEventListener('click', () => { state.channel = i; paint(); }));
    [a, b].forEach(each => each.addEventListener('change', () => { paint(); read(); }));
    exposure.addEventListener('input', paint);
    canvas.addEventListener('pointermove', event => {
      const box = canvas.getBoundingClientRect();
      const u = (event.clientX - box.left) / box.width, v = (event.clientY - box.top) / box.height;
      state.x = Math.min(width - 1, Math.max(0, Math.floor(u * width)));
      state.y = Math.min(height - 1, Math.max(0, Math.floor(v * height)));
      if (state.mode === 'split') { state.divide = u; paint(); }
      read();
    });
    bench.tabIndex = 0;
    bench.addEventListener('keydown', event => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === 'SELECT') return;
      const steps = { f: () => setMode(state.mode === 'a' ? 'b' : 'a'), s: () => setMode('split'), d: () => setMode('difference'),
        ArrowRight: () => { state.channel = (state.channel + 1) % channels.length; paint(); },
        ArrowLeft: () => { state.channel = (state.channel + channels.length - 1) % channels.length; paint(); } };
      if (event.target === exposure || !steps[event.key]) return;
      steps[event.key]();
      event.preventDefault();
    });
    // Decoding waits until the viewer is near the window.
    new IntersectionObserver((entries, observer) => {
      if (!entries.some(each => each.isIntersecting)) return;
      observer.disconnect();
      state.x = width >> 1;
      state.y = height >> 1;
      paint().then(read);
    }, { rootMargin: '200px' }).observe(bench);
  });
})();
