// The page of a render's layers: one large picture or all of them, and beside it a row for every layer. This script
// fills the rows with the layer's value and its share of the light at the pointer.
(() => {
  const part = (root, selector) => root.querySelector(selector);
  const { digits } = raylexPixels;

  const percent = share => !Number.isFinite(share) ? '' : share === 0 ? '0' : Math.abs(share) < 0.0005 ? '<0.1 %'
    : (100 * share).toFixed(Math.abs(share) < 0.0995 ? 1 : 0) + ' %';

  const start = section => {
    const image = JSON.parse(part(section, 'script.data').textContent), { width, height, block } = image;
    const layers = image.layers, rows = [...section.querySelectorAll('.layer')];
    const exposure = part(section, '.exposure'), stops = part(section, '.stops'), views = part(section, '.view');
    const status = part(section, '.status'), stage = part(section, '.panes'), where = part(section, '.where');
    const state = { layer: 0, all: false, x: -1, y: -1 };
    const pixels = width * height;

    const planesOf = layer => layer.planesOf ? layer.planesOf : layer.integers ? raylexPixels.integers(layer.data)
      : raylexPixels.halves(layer.data, layer.scale);
    const gain = () => 2 ** +exposure.value;

    // The page contains painted pictures of geometry, which rows show small. Light is painted here, through the view.
    const fixed = new Map();
    const paintFixed = async index => {
      const element = part(rows[index], 'img');
      await element.decode();
      if (!fixed.has(index)) fixed.set(index, createImageBitmap(element));
      return fixed.get(index);
    };
    const paintLight = async (layer, level) => {
      const [planes, tone] = await Promise.all([planesOf(layer), raylexPixels.view(image.views[+views.value || 0].data)]);
      const means = layer.reducedAt ? await layer.reducedAt(level) : raylexPixels.reduced(layer.data, planes, width, height, level);
      return raylexPixels.light(means, gain(), tone);
    };
    // The planes of layers, or their means over level x level pixels.
    const loaded = async (list, level) => {
      const planes = await Promise.all(list.map(planesOf));
      return level ? planes.map((each, i) => raylexPixels.reduced(list[i].data, each, width, height, level)) : planes;
    };
    const paneOf = index => {
      const layer = layers[index];
      return { label: state.all ? layer.name : '', key: layer.light ? `${index} ${exposure.value} ${views.value}${layer.version ? ' ' + layer.version : ''}` : `${index}`,
        paint: level => layer.paint ? layer.paint() : layer.light ? paintLight(layer, level) : paintFixed(index),
        click: state.all ? () => choose(index) : null };
    };
    const panes = raylexPanes(stage, { width, height, cursor: (x, y) => { Object.assign(state, { x, y }); read(); } });
    const paint = () => {
      const lit = layers.map((_, i) => i).filter(i => !layers[i].empty);
      panes.show(state.all ? lit.map(paneOf) : [paneOf(state.layer)]);
      rows.forEach((row, i) => row.setAttribute('aria-pressed', String(!state.all && i === state.layer)));
      part(section, '[data-show="one"]').setAttribute('aria-pressed', String(!state.all));
      part(section, '[data-show="all"]').setAttribute('aria-pressed', String(state.all));
      stops.textContent = (exposure.value > 0 ? '+' : '') + (+exposure.value).toFixed(1) + ' stops';
      const layer = layers[state.layer];
      part(section, '.name').textContent = state.all ? (lit.length < layers.length ? `${lit.length} of ` : '') + `${layers.length} layers` : layer.name;
      part(section, '.expression').textContent = state.all ? '' : layer.expression || layer.look || '';
      read();
    };

    // A share is relative to the layer that the partition splits, by the sum of red, green and blue.
    const setShare = (row, share, known) => {
      part(row, '.share').textContent = known ? percent(share) || '\u2013' : '';
      part(row, '.bar').style.width = known && share > 0 ? Math.min(100, 100 * share) + '%' : '0';
    };
    const writeValues = (row, layer, values) => {
      part(row, '.value').textContent = values.map(digits).join('  ');
      row.classList.toggle('broken', layer.light && !values.every(Number.isFinite));
    };
    let reading = 0;
    const read = async () => {
      const mine = ++reading, index = state.y * width + state.x, inside = state.x >= 0;
      section.classList.toggle('reading', inside);
      where.textContent = inside ? `at (${state.x * block}, ${state.y * block})` : 'of the whole image';
      if (!inside) {
        rows.forEach((row, i) => setShare(row, layers[i].share, layers[i].share !== null));
        status.textContent = status.dataset.hint;
        if (words) words.read(-1, -1);
        return;
      }
      if (words) words.read(state.x * block, state.y * block);
      const shown = await Promise.all(layers.map(each => each.data && !each.empty ? planesOf(each) : null));
      if (mine !== reading) return;
      const at = i => shown[i] ? layers[i].planes.map((_, c) => shown[i].at(c * pixels + index)) : null;
      const sum = values => values.reduce((a, b) => a + b, 0);
      const values = layers.map((_, i) => at(i));
      rows.forEach((row, i) => {
        const layer = layers[i], whole = layer.whole === null ? null : values[layer.whole];
        if (values[i]) writeValues(row, layer, values[i]);
        const known = layer.light && (whole || layer.wholeAt) && values[i];
        setShare(row, known ? sum(values[i]) / (whole ? sum(whole) : layer.wholeAt(index)) : NaN, known);
      });
      const layer = layers[state.layer], own = values[state.layer];
      const spot = block > 1 ? `mean of ${block} x ${block} pixels from (${state.x * block}, ${state.y * block})`
        : `pixel (${state.x}, ${state.y})`;
      status.textContent = state.all || !own ? spot : `${spot}: ${layer.name}  `
        + layer.planes.map((name, c) => `${name} ${digits(own[c])}`).join('  ');
      section.dataset.read = 'yes';
    };

    const choose = index => { Object.assign(state, { layer: index, all: false }); paint(); };
    const step = by => {
      let next = state.layer;
      do next = (next + by + layers.length) % layers.length; while (layers[next].empty && next !== state.layer);
      choose(next);
      rows[next].scrollIntoView({ block: 'nearest' });
    };
    rows.forEach((row, i) => row.addEventListener('click', () => choose(i)));
    // Adds a layer that is not in the file: { name, expression, planes, light, share, data, planesOf, wholeAt }, and
    // paint() if it is no light.
    const addLayer = (layer, row) => {
      const index = layers.push(layer) - 1;
      rows.push(row);
      row.addEventListener('click', () => choose(index));
      const painted = layer.paint ? layer.paint() : paintLight(layer, Math.max(1, Math.ceil(width / 96)));
      painted.then(small => part(row, '.thumb').append(small));
      choose(index);
    };
    section.querySelectorAll('[data-show]').forEach(each =>
      each.addEventListener('click', () => { state.all = each.dataset.show === 'all'; paint(); }));
    part(section, '[data-fit]').addEventListener('click', panes.fit);
    part(section, '[data-actual]').addEventListener('click', panes.actual);
    exposure.addEventListener('input', paint);
    stops.addEventListener('click', () => { exposure.value = 0; paint(); });
    views.addEventListener('change', paint);
    const lift = by => { exposure.value = +exposure.value + by; paint(); };
    const keys = { ArrowRight: () => step(1), ArrowLeft: () => step(-1), b: () => choose(0), '0': panes.fit, '1': panes.actual,
      a: () => { state.all = !state.all; paint(); }, e: () => lift(0.5), E: () => lift(-0.5),
      '+': () => panes.zoom(2), '-': () => panes.zoom(0.5) };
    const words = part(section, 'script.words') ? raylexWords(section, { width, height, block, addLayer }) : null;
    if (part(section, 'script.guide')) raylexGuide(section, { addLayer, width, block, pointer: () => state });
    if (image.mix) raylexMix(section, { mix: image.mix, layers, words, width, height, loaded, addLayer, repaint: () => paint() });
    paint();
    return { section, key: name => keys[name] };
  };

  const sections = [...document.querySelectorAll('section.image')].filter(each => part(each, 'script.data')).map(start);
  const visible = () => {
    let best = sections[0], most = -1;
    for (const each of sections) {
      const box = each.section.getBoundingClientRect();
      const seen = Math.min(box.bottom, innerHeight) - Math.max(box.top, 0);
      if (seen > most) [best, most] = [each, seen];
    }
    return best;
  };
  addEventListener('keydown', event => {
    if (event.ctrlKey || event.altKey || event.metaKey || !sections.length || event.target.tagName === 'SELECT' ||
      event.target.type === 'text') return;
    const act = event.target.type === 'range' && event.key.startsWith('Arrow') ? null : visible().key(event.key);
    if (!act) return;
    act();
    event.preventDefault();
  });
})();
