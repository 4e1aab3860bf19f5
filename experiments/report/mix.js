// Mixes the lights of an image in its page: exposure and colour, solo, mute and reset for each light group and, with an
// atlas, for the colours of labelled objects. `page`: { mix, layers, loaded, addLayer, repaint, words, width } of
// split_page.js. The mix is saved as TOML for `raylex mix --mix` and `raylex ask --mix`, or copied as factors for the
// grade nodes of a compositing application.
const raylexMix = (section, page) => {
  const { mix, layers, words } = page, make = (parent, tag, properties = {}) =>
    parent.appendChild(Object.assign(document.createElement(tag), properties));
  const find = name => layers.find(each => each.name === name), whole = find(mix.whole);
  // The group as `raylex ask` names it: the label in the layer's expression, or the layer's name without its prefix.
  const groupOf = ({ name, expression }) => {
    const label = /<L\.'((?:[^'\\]|\\.)*)'>/.exec(expression || '');
    return label && label[1] ? label[1].replace(/\\(.)/g, '$1') : name.replace(/^(.*\.)?(light|Combined|RGBA)_/, '');
  };
  const plain = { stops: 0, color: '#ffffff', solo: false, mute: false };
  const lights = mix.layers.map(find).filter(each => each && each.data && !each.empty)
    .map(layer => ({ ...plain, table: 'light', name: groupOf(layer), title: layer.name, layer }));
  if (!whole || !(lights.length || words)) return;
  const controls = [...lights];  // and those of the atlas: { ..., hits }

  const linear = byte => byte <= 10.31475 ? byte / 3294.6 : ((byte / 255 + 0.055) / 1.055) ** 2.4;
  const factorsOf = control => {
    const alone = controls.some(each => each.solo && each.table === control.table);
    const gain = (alone ? control.solo : !control.mute) ? 2 ** control.stops : 0;
    return [1, 3, 5].map(at => gain * linear(parseInt(control.color.slice(at, at + 2), 16)));
  };

  // ---- the atlas: lights without a layer, and colours ----

  let atlas = null, note = '';
  const controlsOf = ({ table }) => {
    const ends = event => 'LOB'.includes(event.type), slot = (event, i) => event.labels[i] || '';
    const found = new Map();
    table.events.forEach(event => {
      const name = ends(event) ? slot(event, 0) || 'default' : `${slot(event, 0)}.${slot(event, 1) || 'V'}`;
      const kind = ends(event) ? 'light' : slot(event, 0) && event.scatter !== 's' ? 'what_if' : '';
      const is = other => ends(other) === ends(event) && slot(other, 0) === slot(event, 0)
        && (ends(event) || (other.scatter !== 's' && slot(other, 1) === slot(event, 1)));
      if (kind) found.set(`${kind} ${name}`, { kind, name, object: slot(event, 0), is });
    });
    // raylex ask explains why the light of these is no power of a factor; if path strings are merged, it gives bounds.
    const refused = new Set(table.events.filter(event => ['coat', 'TT', 'subsurface'].includes(slot(event, 1)))
      .map(event => slot(event, 0)));
    const open = table.words.some(word => word.includes(-1)), left = [], made = [];
    for (const { kind, name, object, is } of found.values()) {
      const own = new Set(table.letters.filter((_, i) => is(table.events[i])));
      const shared = table.letters.some((letter, i) => own.has(letter) && !is(table.events[i]));
      if (shared || (kind === 'what_if' && (open || refused.has(object)))) left.push(name);
      else if (kind === 'what_if' || !lights.some(each => each.name === name))
        made.push({ ...plain, table: kind, name, title: 'a factor above 1 can lift an albedo above 1' });
      else continue;
      if (!left.includes(name))
        made[made.length - 1].hits = table.words.map(word => word.filter(letter => own.has(letter)).length);
    }
    if (left.length) note = `raylex ask explains why these have no factor here: ${left.join(', ')}`;
    return made;
  };
  const unpack = ({ table, begin, numbers, rgb }, count) => {
    const light = new Float32Array(3 * count), word = new Uint32Array(count);
    for (let i = 0; i < count; ++i) {
      light.set(rgb(i), 3 * i);
      word[i] = numbers.at(i);
    }
    // The layer of a light applies the factor of its group.
    const last = table.words.map(each => each[each.length - 1]);
    const layered = lights.map(each => ({ each, letters: new Set(table.letters.filter((_, i) =>
      'LOB'.includes(table.events[i].type) && (table.events[i].labels[0] || 'default') === each.name)) }));
    const layerOf = last.map(letter => (layered.find(({ letters }) => letters.has(letter)) || {}).each);
    return { begin, light, word, layerOf };
  };
  // The light that colours, and lights without a layer, add to the mix of the layers: [component * pixels + pixel].
  let cached = { version: -1, light: null };
  const changes = () => {
    if (cached.version === mixed.version) return cached.light;
    const active = atlas ? controls.filter(each => each.hits && factorsOf(each).some(factor => factor !== 1)) : [];
    cached = { version: mixed.version, light: null };
    if (!active.length) return null;
    const more = new Float32Array(3 * atlas.layerOf.length), pixels = atlas.begin.length - 1;
    const to = new Float32Array(3 * pixels);
    const powers = active.map(factorsOf), layered = new Map(lights.map(each => [each, factorsOf(each)]));
    atlas.layerOf.forEach((layer, word) => {
      for (let c = 0; c < 3; ++c) {
        const product = active.reduce((all, each, k) => all * powers[k][c] ** each.hits[word], 1);
        more[3 * word + c] = (product - 1) * (layer ? layered.get(layer)[c] : 1);
      }
    });
    const { begin, light, word } = atlas;
    for (let pixel = 0; pixel < pixels; ++pixel) {
      let r = 0, g = 0, b = 0;
      for (let i = begin[pixel], end = begin[pixel + 1]; i < end; ++i) {
        const k = 3 * word[i];
        r += more[k] * light[3 * i];
        g += more[k + 1] * light[3 * i + 1];
        b += more[k + 2] * light[3 * i + 2];
      }
      [to[pixel], to[pixels + pixel], to[2 * pixels + pixel]] = [r, g, b];
    }
    cached.light = { pixels, values: to };
    return cached.light;
  };
  const addChanges = (image, level) => {
    const more = changes();
    if (!more) return;
    const { width, height, values } = image;
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x) {
        const right = Math.min(page.width, (x + 1) * level), down = Math.min(page.height, (y + 1) * level);
        const part = 1 / ((right - x * level) * (down - y * level));
        for (let v = y * level; v < down; ++v)
          for (let u = x * level; u < right; ++u)
            for (let c = 0, from = words.placeOf(v * page.width + u); c < 3; ++c)
              values[c * width * height + y * width + x] += part * more.values[c * more.pixels + from];
      }
  };

  // While a control moves, the picture has means over 2 x 2 pixels, or more if a frame takes more than a tenth of a
  // second; it is sharp a moment later.
  let moving = 0, coarse = 2;
  const buffers = new Map();
  const reducedAt = async wanted => {
    const level = moving ? Math.max(coarse, wanted) : wanted;
    const all = await page.loaded([whole, ...lights.map(each => each.layer)], level), start = performance.now();
    if (moving) requestAnimationFrame(() => { if (performance.now() - start > 100) coarse = Math.min(8, coarse + 1); });
    const { width, height, values } = all[0], size = values.length;
    if (!buffers.has(level)) buffers.set(level, { width, height, level, values: new Float32Array(size) });
    const image = buffers.get(level), to = image.values;
    if (mix.rest) to.set(values);
    else to.fill(0);
    lights.forEach((light, k) => {
      const factors = factorsOf(light), from = all[k + 1].values;
      for (let c = 0; c < 3; ++c) {
        const factor = factors[c] - (mix.rest ? 1 : 0), end = (c + 1) * size / 3;
        if (factor !== 0) for (let i = c * size / 3; i < end; ++i) to[i] += factor * from[i];
      }
    });
    addChanges(image, level);
    return image;
  };
  const at = (planes, i) => {
    const size = planes[0].count / 3, c = Math.floor(i / size), more = changes();
    const base = (mix.rest ? planes[0].at(i) : 0) + (more ? more.values[c * more.pixels + words.placeOf(i % size)] : 0);
    return lights.reduce((sum, light, k) => sum + (factorsOf(light)[c] - (mix.rest ? 1 : 0)) * planes[k + 1].at(i), base);
  };
  const mixed = { name: 'mix', expression: 'the factors below', planes: ['R', 'G', 'B'], light: true, empty: false, share: null,
    whole: layers.indexOf(whole), data: 'mix', version: 0, reducedAt,
    planesOf: page.loaded([whole, ...lights.map(each => each.layer)]).then(planes => ({ count: planes[0].count, at: i => at(planes, i) })) };

  const panel = make(section.querySelector('.list'), 'details', { className: 'mix' });
  make(panel, 'summary', { textContent: words ? 'Mix lights and colours' : 'Mix the lights' });
  const table = make(panel, 'table'), remark = make(panel, 'p', { className: 'faint' }), text = value => String(+value.toPrecision(6));
  const row = control => {
    const line = make(table, 'tr'), changed = values => { Object.assign(control, values); update(); };
    make(line, 'td', { textContent: control.name, title: control.title });
    const stops = make(make(line, 'td'), 'input', { type: 'range', min: -6, max: 6, step: 0.1, value: 0, title: 'stops',
      oninput: () => changed({ stops: +stops.value }) });
    control.shown = make(line, 'td', { className: 'number' });
    const color = make(make(line, 'td'), 'input', { type: 'color', value: '#ffffff', oninput: () => changed({ color: color.value }) });
    const buttons = make(line, 'td');
    for (const name of ['solo', 'mute'])
      control[name + 'Button'] = make(buttons, 'button', { type: 'button', textContent: name, onclick: () => changed({ [name]: !control[name] }) });
    make(buttons, 'button', { type: 'button', textContent: 'reset', onclick: () => {
      [stops.value, color.value] = [0, '#ffffff'];
      changed(plain);
    } });
  };
  controls.forEach(row);
  const save = make(make(panel, 'p'), 'a', { textContent: 'save as TOML', download: 'mix.toml' });
  const toml = make(panel, 'pre', { className: 'toml' });
  make(panel, 'p', { className: 'faint', textContent: 'Factors for grade or multiply nodes, one layer a line:' });
  const grade = make(panel, 'pre', { className: 'grade' });
  const update = () => {
    controls.forEach(each => {
      each.shown.textContent = (each.stops > 0 ? '+' : '') + each.stops.toFixed(1);
      for (const name of ['solo', 'mute']) each[name + 'Button'].setAttribute('aria-pressed', String(each[name]));
    });
    // An atlas needs no factors of 1, and warns of some.
    const tableOf = name => controls.filter(each => each.table === name && (each.layer || factorsOf(each).some(factor => factor !== 1)))
      .map(each => `${JSON.stringify(each.name)} = [${factorsOf(each).map(text).join(', ')}]\n`).join('');
    toml.textContent = ['light', 'what_if'].map(name => tableOf(name) && `[${name}]\n${tableOf(name)}`).join('');
    grade.textContent = lights.map(light => `${light.layer.name} ${factorsOf(light).map(text).join(' ')}`).join('\n');
    save.href = 'data:text/plain;charset=utf-8,' + encodeURIComponent(toml.textContent);
    clearTimeout(moving);
    moving = setTimeout(() => { moving = 0; ++mixed.version; page.repaint(); }, 250);
    ++mixed.version;
    page.repaint();
  };
  panel.addEventListener('toggle', () => {
    if (!panel.open) return;
    if (!mixed.added) page.addLayer(mixed, panel.appendChild(rowOfMix()));
    if (!mixed.added && words)
      words.loaded.then(found => {
        const { begin } = found, more = controlsOf(found);
        controls.push(...more);
        more.forEach(row);
        remark.textContent = note;
        atlas = unpack(found, begin[begin.length - 1]);
        update();
        section.dataset.mixed = 'yes';
      });
    mixed.added = true;
    update();
  });
  const rowOfMix = () => {
    const button = layersRow().cloneNode(true);
    button.dataset.name = 'mix';
    button.querySelector('.thumb').replaceChildren();
    button.querySelector('.title').textContent = 'mix';
    button.querySelector('.formula').textContent = mixed.expression;
    return button;
  };
  const layersRow = () => section.querySelector('.layer');
};
