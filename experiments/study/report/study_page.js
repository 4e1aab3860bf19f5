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

  document.querySelectorAll('.bench').forEach(bench => raylexBench(bench, study.pictures[+bench.dataset.scene]));
})();
