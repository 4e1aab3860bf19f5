// The page of a study: draws plots from its data, chooses a channel and starts the image viewer. It fetches nothing.
(() => {
  const study = JSON.parse(document.getElementById('study').textContent);
  const part = (root, selector) => root.querySelector(selector);

  // ---- Plots are drawn when first visible. Figures side by side share one legend below them.
  const focus = (group, slot) => {
    group.classList.toggle('focused', slot !== undefined);
    group.querySelectorAll('[data-slot]').forEach(each => each.classList.toggle('focus', each.dataset.slot === slot));
  };
  const legendOf = group => {
    const legend = part(group, '.plot-legend'), notes = new Map();
    const plots = [...group.querySelectorAll('.plot')].map(each => study.plots[each.dataset.plot]);
    plots.forEach(plot => plot.series.forEach(series => {
      if (series.points.length) notes.set(series.slot, series);
    }));
    legend.replaceChildren(...[...notes.values()].map(series => {
      const entry = document.createElement('div');
      entry.className = 'entry';
      entry.dataset.slot = series.slot;
      entry.innerHTML = raylexPlot(d3, { markOf: series });
      const name = document.createElement('span'), note = document.createElement('small');
      name.textContent = series.name;
      note.textContent = series.note;
      entry.append(name, note);
      return entry;
    }));
  };
  const draw = group => {
    if (group.dataset.drawn || !group.offsetParent) return;
    group.dataset.drawn = 'yes';
    group.querySelectorAll('.plot').forEach(figure => {
      figure.innerHTML = raylexPlot(d3, { ...study.plots[figure.dataset.plot], legend: false });
    });
    legendOf(group);
    group.addEventListener('pointerover', event => {
      const under = event.target.closest('[data-slot]');
      focus(group, under ? under.dataset.slot : undefined);
    });
    group.addEventListener('pointerleave', () => focus(group, undefined));
  };
  const drawAll = () => document.querySelectorAll('.plots').forEach(draw);

  // ---- Panels show one channel at a time: a button with data-choose shows the panels with its key.
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

  document.querySelectorAll('.bench').forEach(bench => raylexBench(bench, study.pictures[+bench.dataset.scene]));
})();
