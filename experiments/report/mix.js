// Mixes the lights of an image in its page: exposure and colour, solo, mute and reset for each light group. `page`:
// { mix, layers, loaded, addLayer, repaint } of split_page.js. The mix is saved as TOML for `raylex mix --mix` and
// `raylex ask --mix`, or copied as factors for the grade nodes of a compositing application.
const raylexMix = (section, page) => {
  const { mix, layers } = page, make = (parent, tag, properties = {}) =>
    parent.appendChild(Object.assign(document.createElement(tag), properties));
  const find = name => layers.find(each => each.name === name);
  const whole = find(mix.whole), lights = mix.layers.map(find).filter(each => each && each.data && !each.empty)
    .map(layer => ({ layer, stops: 0, color: '#ffffff', solo: false, mute: false }));
  if (!whole || !lights.length) return;

  // The group as `raylex ask` names it: the label in the layer's expression, or the layer's name without its prefix.
  const groupOf = ({ name, expression }) => {
    const label = /<L\.'((?:[^'\\]|\\.)*)'>/.exec(expression || '');
    return label && label[1] ? label[1].replace(/\\(.)/g, '$1') : name.replace(/^(.*\.)?(light|Combined|RGBA)_/, '');
  };
  const linear = byte => byte <= 10.31475 ? byte / 3294.6 : ((byte / 255 + 0.055) / 1.055) ** 2.4;
  const factorsOf = light => {
    const on = lights.some(each => each.solo) ? light.solo : !light.mute, gain = on ? 2 ** light.stops : 0;
    return [1, 3, 5].map(at => gain * linear(parseInt(light.color.slice(at, at + 2), 16)));
  };

  // While a control moves, the picture has means over 2 x 2 pixels; it is sharp a moment later.
  let moving = 0;
  const buffers = new Map();
  const reducedAt = async wanted => {
    const level = moving ? Math.max(2, wanted) : wanted, all = await page.loaded([whole, ...lights.map(each => each.layer)], level);
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
    return image;
  };
  const at = (planes, i) => {
    const c = Math.floor(i / (planes[0].count / 3));
    return lights.reduce((sum, light, k) => sum + (factorsOf(light)[c] - (mix.rest ? 1 : 0)) * planes[k + 1].at(i),
      mix.rest ? planes[0].at(i) : 0);
  };
  const mixed = { name: 'mix', expression: 'the lights below', planes: ['R', 'G', 'B'], light: true, empty: false, share: null,
    whole: layers.indexOf(whole), data: 'mix', version: 0, reducedAt,
    planesOf: page.loaded([whole, ...lights.map(each => each.layer)]).then(planes => ({ count: planes[0].count, at: i => at(planes, i) })) };

  const panel = make(section.querySelector('.list'), 'details', { className: 'mix' });
  make(panel, 'summary', { textContent: 'Mix the lights' });
  const table = make(panel, 'table'), text = value => String(+value.toPrecision(6));
  const row = light => {
    const line = make(table, 'tr'), changed = values => { Object.assign(light, values); update(); };
    make(line, 'td', { textContent: groupOf(light.layer), title: light.layer.name });
    const stops = make(make(line, 'td'), 'input', { type: 'range', min: -6, max: 6, step: 0.1, value: 0, title: 'stops',
      oninput: () => changed({ stops: +stops.value }) });
    light.shown = make(line, 'td', { className: 'number' });
    const color = make(make(line, 'td'), 'input', { type: 'color', value: '#ffffff', oninput: () => changed({ color: color.value }) });
    const buttons = make(line, 'td');
    for (const name of ['solo', 'mute'])
      light[name + 'Button'] = make(buttons, 'button', { type: 'button', textContent: name, onclick: () => changed({ [name]: !light[name] }) });
    make(buttons, 'button', { type: 'button', textContent: 'reset', onclick: () => {
      [stops.value, color.value] = [0, '#ffffff'];
      changed({ stops: 0, color: '#ffffff', solo: false, mute: false });
    } });
  };
  lights.forEach(row);
  const save = make(make(panel, 'p'), 'a', { textContent: 'save as TOML', download: 'mix.toml' });
  const toml = make(panel, 'pre', { className: 'toml' });
  make(panel, 'p', { className: 'faint', textContent: 'Factors for grade or multiply nodes, one layer a line:' });
  const grade = make(panel, 'pre', { className: 'grade' });
  const update = () => {
    lights.forEach(light => {
      light.shown.textContent = (light.stops > 0 ? '+' : '') + light.stops.toFixed(1);
      for (const name of ['solo', 'mute']) light[name + 'Button'].setAttribute('aria-pressed', String(light[name]));
    });
    toml.textContent = '[light]\n' + lights.map(light => `${JSON.stringify(groupOf(light.layer))} = [${factorsOf(light).map(text).join(', ')}]\n`).join('');
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
