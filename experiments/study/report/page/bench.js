// Compares a scene's images: side by side, flipped, split at the pointer, or as differences from one of them. All share
// one zoom and have insets. A table shows every channel's value at the pointer.
const raylexBench = (bench, scene) => {
  const part = selector => bench.querySelector(selector), all = selector => [...bench.querySelectorAll(selector)];
  const { width, height, block } = scene, count = width * height;
  const { digits } = raylexPixels;
  const exposure = part('.exposure'), gain = part('.gain'), against = part('.against'), status = part('.status');
  const chips = all('[data-image]'), modes = all('[data-mode]'), channels = all('[data-channel]');
  const state = { mode: 'side', channel: 0, flipped: 0, x: -1, y: -1,
    chosen: new Set(chips.map((_, i) => i).filter(i => i < 2 || i === chips.length - 1)) };

  // Pixels of an image without this channel: every value is NaN.
  const nothing = { count: 3 * count, at: () => NaN };
  const idOf = (image, channel) => scene.images[image].ids[channel];
  const planesOf = (image, channel) => {
    const id = idOf(image, channel);
    return id === null ? Promise.resolve(nothing) : raylexPixels.halves('picture-' + id);
  };
  const reducedOf = async (image, level) => {
    const planes = await planesOf(image, state.channel);
    return raylexPixels.reduced(`${scene.scene}/${image}/${state.channel}`, planes, width, height, level);
  };
  const paintLight = async (image, level) =>
    raylexPixels.light(await reducedOf(image, level), 2 ** +exposure.value, raylexPixels.srgb);

  // Equal pixels are black; too dark ones go through blue to white, too bright ones through red to yellow.
  const stops = [[[22, 22, 26], [28, 110, 214], [205, 238, 255]], [[22, 22, 26], [214, 62, 36], [255, 228, 140]]];
  const colorOf = t => {
    const row = stops[t > 0 ? 1 : 0], u = 2 * Math.min(1, Math.abs(t)), i = Math.min(1, Math.floor(u));
    return row[i].map((low, c) => low + (row[i + 1][c] - low) * (u - i));
  };
  // Returns the mean over red, green and blue of the difference relative to the reference. A dark pixel of the reference
  // counts as a tenth of the reference's mean.
  const paintDifference = async (image, level) => {
    const [a, b] = await Promise.all([reducedOf(image, level), reducedOf(+against.value, level)]);
    const n = a.width * a.height, scale = 2 ** +gain.value;
    let mean = 0;
    for (const v of b.values) mean += Math.abs(v) / b.values.length;
    return raylexPixels.painted(a, (data, q, i) => {
      let d = 0;
      for (let c = 0; c < 3; ++c) {
        const reference = b.values[c * n + i];
        d += (a.values[c * n + i] - reference) / Math.max(Math.abs(reference), 0.1 * mean, 1e-30) / 3;
      }
      data.set(Number.isNaN(d) ? raylexPixels.broken : colorOf(d * scale), q);
    });
  };

  const panes = raylexPanes(part('.panes'), { width, height, wheel: 'focused',
    cursor: (x, y) => { if (x >= 0) { Object.assign(state, { x, y }); read(); } if (state.mode === 'split') panes.redraw(); } });
  const lightKey = image => `${image} ${state.channel} ${exposure.value}`;
  const lightPane = (image, label = scene.images[image].name) =>
    ({ label, key: lightKey(image), paint: level => paintLight(image, level) });
  const specs = () => {
    const chosen = [...state.chosen].sort((a, b) => a - b), base = +against.value;
    if (state.mode === 'flip') return [lightPane(chosen[state.flipped % chosen.length])];
    if (state.mode === 'split') {
      const right = chosen.length > 1 ? chosen[1] : base;
      return [{ ...lightPane(chosen[0], `${scene.images[chosen[0]].name}  |  ${scene.images[right].name}`),
        over: { key: lightKey(right), paint: level => paintLight(right, level) } }];
    }
    if (state.mode === 'difference') {
      const others = chosen.filter(each => each !== base);
      return others.map(image => ({ label: `${scene.images[image].name} \u2212 ${scene.images[base].name}`,
        key: `${image}-${base} ${state.channel} ${gain.value}`, paint: level => paintDifference(image, level) }));
    }
    return chosen.map(image => lightPane(image));
  };

  const drawBar = () => {
    const bar = part('.colorbar'), full = 100 / 2 ** +gain.value;
    bar.hidden = state.mode !== 'difference';
    const colors = [...Array(21).keys()].map(i => `rgb(${colorOf(i / 10 - 1).map(Math.round).join(',')})`);
    part('.colorbar .ramp').style.background = `linear-gradient(to right, ${colors.join(',')})`;
    all('.colorbar .mark').forEach((each, i) => {
      each.textContent = [-full, -full / 2, 0, full / 2, full].map(v => (v > 0 ? '+' : '') + digits(v) + ' %')[i];
    });
  };
  const paint = () => {
    panes.show(specs());
    drawBar();
    modes.forEach(each => each.setAttribute('aria-pressed', String(each.dataset.mode === state.mode)));
    chips.forEach((each, i) => each.setAttribute('aria-pressed', String(state.chosen.has(i))));
    channels.forEach((each, i) => each.setAttribute('aria-pressed', String(i === state.channel)));
    part('.for-light').hidden = state.mode === 'difference';
    part('.for-difference').hidden = state.mode !== 'difference';
    part('.stops').textContent = (exposure.value > 0 ? '+' : '') + (+exposure.value).toFixed(1) + ' stops';
    part('.times').textContent = 'x ' + digits(2 ** +gain.value);
    part('.clear').hidden = panes.insetCount() === 0;
  };

  let reading = 0;
  const read = async () => {
    const mine = ++reading, index = state.y * width + state.x, chosen = [...state.chosen].sort((a, b) => a - b);
    if (!(state.x >= 0)) return;
    const planes = await Promise.all(chosen.map(image => Promise.all(scene.channels.map((_, c) => planesOf(image, c)))));
    if (mine !== reading) return;
    status.textContent = block > 1
      ? `mean of ${block} x ${block} pixels from (${state.x * block}, ${state.y * block})` : `pixel (${state.x}, ${state.y})`;
    const value = (i, channel) => [0, 1, 2].map(c => planes[i][channel].at(c * count + index));
    const sum = v => v[0] + v[1] + v[2];
    const cell = (row, text, kind) => {
      const made = document.createElement(kind);
      made.textContent = text;
      if (kind === 'td' && row.cells.length) made.className = 'number';
      row.append(made);
    };
    const head = document.createElement('tr');
    cell(head, 'Red, green, blue; share', 'th');
    chosen.forEach(image => cell(head, scene.images[image].name, 'th'));
    part('.readout thead').replaceChildren(head);
    part('.readout tbody').replaceChildren(...scene.channels.map((label, channel) => {
      const row = document.createElement('tr');
      cell(row, label, 'td');
      chosen.forEach((_, i) => {
        const v = value(i, channel), share = sum(v) / sum(value(i, 0));
        cell(row, Number.isNaN(sum(v)) && idOf(chosen[i], channel) === null ? '\u2013'
          : v.map(digits).join('  ') + (Number.isFinite(share) ? `   ${(100 * share).toFixed(1)} %` : ''), 'td');
      });
      return row;
    }));
    bench.dataset.read = 'yes';
  };

  const setMode = mode => { state.mode = mode; paint(); };
  modes.forEach(each => each.addEventListener('click', () => setMode(each.dataset.mode)));
  channels.forEach((each, i) => each.addEventListener('click', () => { state.channel = i; paint(); }));
  chips.forEach((each, i) => each.addEventListener('click', () => {
    if (!state.chosen.delete(i)) state.chosen.add(i);
    if (!state.chosen.size) state.chosen.add(i);
    paint();
    read();
  }));
  [exposure, gain].forEach(each => each.addEventListener('input', paint));
  against.addEventListener('change', paint);
  part('.stops').addEventListener('click', () => { exposure.value = 0; paint(); });
  part('[data-fit]').addEventListener('click', panes.fit);
  part('[data-actual]').addEventListener('click', panes.actual);
  part('.clear').addEventListener('click', () => { panes.clearInsets(); paint(); });
  part('.panes').addEventListener('pointerup', () => { part('.clear').hidden = panes.insetCount() === 0; });
  const turn = by => { state.channel = (state.channel + by + channels.length) % channels.length; paint(); };
  const keys = { f: () => { state.flipped += state.mode === 'flip' ? 1 : 0; setMode('flip'); }, s: () => setMode('split'),
    d: () => setMode('difference'), g: () => setMode('side'), '0': panes.fit, '1': panes.actual, '+': () => panes.zoom(2),
    '-': () => panes.zoom(0.5), ArrowRight: () => turn(1), ArrowLeft: () => turn(-1) };
  bench.addEventListener('keydown', event => {
    if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key] || event.target.tagName === 'SELECT') return;
    if (event.target.type === 'range' && event.key.startsWith('Arrow')) return;
    keys[event.key]();
    event.preventDefault();
  });
  // Decoding waits until the viewer is near the window.
  new IntersectionObserver((entries, observer) => {
    if (!entries.some(each => each.isIntersecting)) return;
    observer.disconnect();
    Object.assign(state, { x: width >> 1, y: height >> 1 });
    scene.insets.forEach(panes.addInset);
    paint();
    read();
  }, { rootMargin: '200px' }).observe(bench);
};
