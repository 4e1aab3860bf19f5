// What path guiding learned, in the page of an image: a layer with the probability of the guide at each pixel, and the
// learned directions of a clicked point. guide_view.h describes the data. `page`: { addLayer, width, block, pointer }
// of split_page.js.
const raylexGuide = (section, page) => {
  const view = JSON.parse(section.querySelector('script.guide').textContent);
  const { step, side, camera, probabilities } = view, grid = view.width * view.height, cells = side * side;
  const make = (parent, tag, properties = {}) =>
    parent.appendChild(Object.assign(document.createElement(tag), properties));
  const scale = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];  // from t = 0 to 1
  const colorOf = t => {
    const at = Math.max(0, Math.min(1, t)) * (scale.length - 1), i = Math.min(scale.length - 2, Math.floor(at));
    return scale[i].map((low, c) => Math.round(low + (at - i) * (scale[i + 1][c] - low)));
  };
  const none = [70, 70, 70];
  const loaded = Promise.all([raylexPixels.integersOf(view.points), raylexPixels.inflated(view.maps)]);

  const panel = make(section.querySelector('.list'), 'details', { className: 'guide' });
  make(panel, 'summary', { textContent: 'Path guiding: what was learned' });
  const row = panel.appendChild(section.querySelector('.layer').cloneNode(true));
  row.classList.remove('light');
  row.dataset.name = row.querySelector('.title').textContent = 'guide';
  row.title = row.querySelector('.formula').textContent = 'probability that the guide draws a direction';
  row.querySelector('.thumb').replaceChildren();
  const legend = entries => {
    const line = make(panel, 'p', { className: 'legend' });
    for (const [text, color] of entries) make(line, 'span', { textContent: text }).style.borderColor = `rgb(${color})`;
  };
  legend([...[0, 0.25, 0.5, 0.75, 0.9].map(each => [each, colorOf(each / 0.9)]), ['none', none]]);
  const answer = make(panel, 'p', { className: 'answer', textContent: 'Click a point of the picture.' });
  const spheres = make(panel, 'div', { className: 'spheres' });
  const discs = ['towards the viewer', 'into the picture'].map(name => {
    const figure = make(spheres, 'figure'), canvas = make(figure, 'canvas', { width: 180, height: 180 });
    make(figure, 'figcaption', { textContent: name });
    return canvas;
  });

  const pointOf = (x, y) => Math.floor(y * page.block / step) * view.width + Math.floor(x * page.block / step);
  const probabilityOf = region => region > 0 ? probabilities[region - 1] : NaN;
  const planesOf = loaded.then(([points]) => ({ count: grid,
    at: i => probabilityOf(points.at(pointOf(i % page.width, Math.floor(i / page.width)))) }));
  const paint = async () => {
    const [points] = await loaded;
    return raylexPixels.painted({ width: view.width, height: view.height, level: step / page.block }, (data, q, i) =>
      data.set(points.at(i) > 0 ? colorOf(probabilityOf(points.at(i)) / 0.9) : none, q));
  };

  // The density of a unit direction in camera space, relative to a uniform one (transport/.../direction_square.h).
  const densityOf = (bytes, x, y, z) => {
    const [dx, dy, dz] = [0, 1, 2].map(i => camera[i] * x + camera[3 + i] * y + camera[6 + i] * z);
    const sum = Math.abs(dx) + Math.abs(dy) + Math.abs(dz), a = Math.abs(dx) / sum, b = Math.abs(dy) / sum;
    const cell = (part, sign) => Math.min(side - 1, Math.floor(side * (0.5 + (sign < 0 ? -0.5 : 0.5) * part)));
    const byte = bytes[cell(dz < 0 ? 1 - a : b, dy) * side + cell(dz < 0 ? 1 - b : a, dx)];
    return byte ? 2 ** ((byte - 128) / 10) * Math.PI / sum ** 3 : 0;
  };
  // A hemisphere; the distance from the middle is proportional to the angle.
  const draw = (canvas, bytes, sign) => {
    const { width } = canvas, radius = width / 2;
    canvas.getContext('2d').clearRect(0, 0, width, width);
    const image = canvas.getContext('2d').createImageData(width, width);
    let most = 0;
    for (let i = 0; bytes && i < width * width; ++i) {
      const u = (i % width + 0.5) / radius - 1, v = 1 - (Math.floor(i / width) + 0.5) / radius, r = Math.hypot(u, v);
      if (r > 1) continue;
      const angle = r * Math.PI / 2, share = r > 0 ? Math.sin(angle) / r : 0;
      const density = densityOf(bytes, u * share, v * share, sign * Math.cos(angle));
      most = Math.max(most, density);
      image.data.set([...colorOf((Math.log2(density) + 4) / 12), 255], 4 * i);
    }
    canvas.getContext('2d').putImageData(image, 0, 0);
    return most;
  };
  const show = async (x, y) => {
    const [points, maps] = await loaded, region = points.at(pointOf(x, y));
    const known = region > 0 && region * cells <= maps.length;
    const bytes = known ? maps.subarray((region - 1) * cells, region * cells) : null;
    const most = Math.max(...discs.map((canvas, i) => draw(canvas, bytes, i ? 1 : -1)));
    const where = `(${x * page.block}, ${y * page.block})`;
    answer.textContent = !region ? `At ${where} the path met no surface that can be guided.`
      : `At ${where} the guide draws a direction with probability ${probabilityOf(region)}.` + (known
        ? ` The density of its directions, at most ${raylexPixels.digits(most)} times the uniform one:`
        : ' The statistics file does not have its directions, because few pixels see this region.');
    section.dataset.guide = `${region} ${most}`;
  };

  make(panel, 'p', { className: 'faint', textContent: 'Up and right as in the picture; the middle is the axis of the '
    + 'camera, the rim is at 90 degrees. Colours are relative to a uniform density, logarithmic:' });
  legend(['1/16', '1/2', '4', '32', '256'].map((text, i) => [text, colorOf(i / 4)]));
  let added = false;
  panel.addEventListener('toggle', () => {
    if (panel.open && !added) page.addLayer({ name: 'guide', expression: '', look: row.title, planes: ['probability'],
      light: false, whole: null, empty: false, share: null, data: 'guide', planesOf, paint }, row);
    added = added || panel.open;
  });
  section.querySelector('.panes').addEventListener('click', () => {
    const { x, y } = page.pointer();
    if (panel.open && x >= 0) show(x, y);
  });
};
