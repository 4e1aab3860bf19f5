// Pictures of one size, side by side and as large as they fit. They are moved and magnified together, and share the
// cursor and the insets. `root` is an element with a height of its own.
//
//   const panes = raylexPanes(root, { width, height, cursor: (x, y) => ..., wheel: 'always' or 'focused' });
//   panes.show([{ label, key, paint: async level => canvas, over: { key, paint }, frame }]);
//
// paint(level) makes a picture of means over level x level pixels; it is called again when `key` changes. The picture
// of `over` covers the first picture right of the divider, which follows the pointer.
const raylexPanes = (root, { width, height, cursor, wheel = 'always' }) => {
  const insetColors = ['#e4572e', '#2e86de', '#2fa84f', '#b455c8'], gap = 6;
  let panes = [], view = null, point = null, divide = 0.5, insets = [], drag = null, asked = false;

  const element = (tag, name, parent) => {
    const made = document.createElement(tag);
    made.className = name;
    parent.append(made);
    return made;
  };
  const captionHeight = () => panes.length && panes[0].caption.textContent ? panes[0].caption.offsetHeight : 0;
  const stripOf = h => insets.length ? Math.min(Math.round(h * 0.34), 220) : 0;

  const layout = () => {
    const box = root.getBoundingClientRect(), caption = captionHeight();
    let best = 1, most = -1;
    for (let columns = 1; columns <= panes.length; ++columns) {
      const rows = Math.ceil(panes.length / columns), w = (box.width - gap * (columns - 1)) / columns;
      const h = (box.height - gap * (rows - 1)) / rows - caption;
      const scale = Math.min(w / width, (h - stripOf(h)) / height);
      if (scale > most) [best, most] = [columns, scale];
    }
    const rows = Math.ceil(panes.length / best);
    root.style.gridTemplateColumns = `repeat(${best}, minmax(0, 1fr))`;
    root.style.gridTemplateRows = `repeat(${rows}, minmax(0, 1fr))`;
    redraw();
  };

  // The place of the image in a canvas: its corner, and the size of one of its pixels in CSS pixels.
  const place = canvas => {
    const w = canvas.clientWidth, whole = canvas.clientHeight, h = whole - stripOf(whole);
    const fit = Math.min(w / width, h / height), scale = view ? view.scale : fit;
    const x = view ? view.x : width / 2, y = view ? view.y : height / 2;
    return { w, h, whole, fit, scale, left: w / 2 - x * scale, top: h / 2 - y * scale };
  };
  const pictureOf = (pane, slot, spec, level) => {
    const known = pane[slot], wanted = `${spec.key}@${level}`;
    if (!known || known.wanted !== wanted) {
      const next = { wanted, canvas: known ? known.canvas : null, level: known ? known.level : 1 };
      pane[slot] = next;
      spec.paint(level).then(canvas => {
        if (pane[slot] !== next) return;
        Object.assign(next, { canvas, level: canvas.level || 1 });  // some exist at full size only, or coarser
        redraw();
      });
    }
    return pane[slot];
  };

  const drawPicture = (context, picture, at, ratio) => {
    if (!picture.canvas) return;
    const scale = at.scale * picture.level * ratio;
    context.imageSmoothingEnabled = at.scale * ratio < 1.5;
    context.drawImage(picture.canvas, at.left * ratio, at.top * ratio, picture.canvas.width * scale,
      picture.canvas.height * scale);
  };
  const frame = (context, ratio, x, y, w, h, color, line = 2) => {
    context.lineWidth = line * ratio;
    context.strokeStyle = color;
    context.strokeRect(x * ratio, y * ratio, w * ratio, h * ratio);
  };

  const drawInsets = (context, pane, at, ratio) => {
    const full = pictureOf(pane, 'full', pane.spec, 1), strip = stripOf(at.whole), n = insets.length;
    context.fillStyle = getComputedStyle(root).backgroundColor;
    context.fillRect(0, at.h * ratio, at.w * ratio, strip * ratio);
    insets.forEach((inset, i) => {
      frame(context, ratio, at.left + inset.x * at.scale, at.top + inset.y * at.scale, inset.w * at.scale,
        inset.h * at.scale, inset.color);
      const cell = (at.w - gap * (n - 1)) / n, room = strip - gap - 4;
      const scale = Math.min((cell - 4) / inset.w, room / inset.h), w = inset.w * scale, h = inset.h * scale;
      const left = i * (cell + gap) + (cell - w) / 2, top = at.h + gap + 2 + (room - h) / 2;
      context.imageSmoothingEnabled = false;
      if (full.canvas)
        context.drawImage(full.canvas, inset.x / full.level, inset.y / full.level, inset.w / full.level,
          inset.h / full.level, left * ratio, top * ratio, w * ratio, h * ratio);
      frame(context, ratio, left, top, w, h, inset.color, 3);
    });
  };

  const drawPane = pane => {
    const { canvas, spec } = pane, ratio = devicePixelRatio || 1, at = place(canvas);
    if (!(at.w > 0 && at.h > 0)) return;
    if (canvas.width !== Math.round(at.w * ratio) || canvas.height !== Math.round(at.whole * ratio)) {
      canvas.width = Math.round(at.w * ratio);
      canvas.height = Math.round(at.whole * ratio);
    }
    const context = canvas.getContext('2d'), level = Math.max(1, Math.floor(1 / (at.scale * ratio)));
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.save();
    context.beginPath();
    context.rect(0, 0, at.w * ratio, at.h * ratio);
    context.clip();
    const picture = pictureOf(pane, 'picture', spec, level);
    drawPicture(context, picture, at, ratio);
    if (spec.over) {
      const edge = (at.left + divide * width * at.scale) * ratio;
      context.save();
      context.beginPath();
      context.rect(edge, 0, canvas.width, canvas.height);
      context.clip();
      drawPicture(context, pictureOf(pane, 'above', spec.over, level), at, ratio);
      context.restore();
      context.fillStyle = '#fff';
      context.fillRect(edge - ratio / 2, Math.max(0, at.top) * ratio, ratio, height * at.scale * ratio);
    }
    if (drag && drag.inset)
      frame(context, ratio, at.left + drag.inset.x * at.scale, at.top + drag.inset.y * at.scale,
        drag.inset.w * at.scale, drag.inset.h * at.scale, '#fff', 1);
    if (point && panes.length + (at.scale > 3) > 1) {
      const x = at.left + point.x * at.scale, y = at.top + point.y * at.scale, side = Math.max(at.scale, 5);
      frame(context, ratio, x + (at.scale - side) / 2, y + (at.scale - side) / 2, side, side, '#000', 3);
      frame(context, ratio, x + (at.scale - side) / 2, y + (at.scale - side) / 2, side, side, '#fff', 1);
    }
    context.restore();
    if (insets.length) drawInsets(context, pane, at, ratio);
    if (picture.canvas) canvas.dataset.painted = spec.key;
  };
  const redraw = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      panes.forEach(drawPane);
    });
  };

  const under = (canvas, event) => {
    const box = canvas.getBoundingClientRect(), at = place(canvas);
    const x = (event.clientX - box.left - at.left) / at.scale, y = (event.clientY - box.top - at.top) / at.scale;
    return { x, y, inside: x >= 0 && y >= 0 && x < width && y < height && event.clientY - box.top < at.h };
  };
  const zoomAt = (canvas, spot, factor) => {
    const at = place(canvas), scale = Math.max(at.fit / 2, Math.min(64, at.scale * factor));
    const middle = view || { x: width / 2, y: height / 2 };
    view = scale <= at.fit && factor < 1 ? null : { scale,
      x: spot.x + (middle.x - spot.x) * at.scale / scale, y: spot.y + (middle.y - spot.y) * at.scale / scale };
    redraw();
  };
  const moved = event => {
    const canvas = event.currentTarget, spot = under(canvas, event);
    if (drag && drag.inset) {
      const clampX = Math.max(0, Math.min(width, spot.x)), clampY = Math.max(0, Math.min(height, spot.y));
      drag.inset = { x: Math.floor(Math.min(drag.x, clampX)), y: Math.floor(Math.min(drag.y, clampY)) };
      drag.inset.w = Math.max(1, Math.ceil(Math.max(drag.x, clampX)) - drag.inset.x);
      drag.inset.h = Math.max(1, Math.ceil(Math.max(drag.y, clampY)) - drag.inset.y);
      redraw();
    } else if (drag) {
      const at = place(canvas), middle = view || { x: width / 2, y: height / 2 };
      view = { scale: at.scale, x: middle.x - (event.clientX - drag.clientX) / at.scale,
        y: middle.y - (event.clientY - drag.clientY) / at.scale };
      [drag.clientX, drag.clientY] = [event.clientX, event.clientY];
      redraw();
      return;
    }
    point = spot.inside ? { x: Math.floor(spot.x), y: Math.floor(spot.y) } : null;
    if (spot.inside) divide = spot.x / width;
    cursor(point ? point.x : -1, point ? point.y : -1);
    redraw();
  };
  const pressed = event => {
    if (event.button !== 0) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    const spot = under(event.currentTarget, event);
    drag = event.shiftKey && spot.inside ? { ...spot, inset: { x: Math.floor(spot.x), y: Math.floor(spot.y), w: 1, h: 1 } }
      : { clientX: event.clientX, clientY: event.clientY };
  };
  const released = () => {
    if (drag && drag.inset && drag.inset.w > 1 && drag.inset.h > 1) addInset(drag.inset);
    drag = null;
    redraw();
  };
  const addInset = box => {
    insets = [...insets, box].slice(-insetColors.length);
    insets.forEach((inset, i) => { inset.color = insetColors[i]; });
    layout();
  };

  const makePane = () => {
    const figure = element('figure', 'pane', root), canvas = element('canvas', '', figure);
    const caption = element('figcaption', '', figure);
    canvas.addEventListener('pointermove', moved);
    canvas.addEventListener('pointerdown', pressed);
    canvas.addEventListener('pointerup', released);
    canvas.addEventListener('pointercancel', released);
    canvas.addEventListener('pointerleave', () => {
      point = null;
      cursor(-1, -1);
      redraw();
    });
    canvas.addEventListener('dblclick', () => fit());
    canvas.addEventListener('wheel', event => {
      if (wheel === 'focused' && !event.ctrlKey && !root.closest('[tabindex]').contains(document.activeElement)) return;
      event.preventDefault();
      zoomAt(canvas, under(canvas, event), 2 ** (-event.deltaY / (event.deltaMode ? 6 : 240)));
    }, { passive: false });
    return { figure, canvas, caption };
  };
  const show = specs => {
    while (panes.length > specs.length) panes.pop().figure.remove();
    while (panes.length < specs.length) panes.push(makePane());
    panes.forEach((pane, i) => {
      pane.spec = specs[i];
      pane.caption.textContent = specs[i].label || '';
      pane.caption.title = specs[i].label || '';
      pane.figure.onclick = specs[i].click || null;
    });
    layout();
  };
  const fit = () => { view = null; redraw(); };
  const zoom = factor => {
    if (panes.length) zoomAt(panes[0].canvas, view || { x: width / 2, y: height / 2 }, factor);
  };
  const actual = () => {
    view = { ...(view || { x: width / 2, y: height / 2 }), scale: 1 / (devicePixelRatio || 1) };
    redraw();
  };
  new ResizeObserver(layout).observe(root);
  return { show, fit, zoom, actual, redraw, addInset,
    clearInsets: () => { insets = []; layout(); }, insetCount: () => insets.length };
};
