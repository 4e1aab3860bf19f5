// Draws one plot as SVG text from plain data. The page and plots/*.svg have the same bytes, so no code uses a document.
// The code is ECMAScript 5 because an embedded interpreter runs it too; d3 (version 3) computes scales, ticks and paths.
function raylexPlot(d3, spec) {
  var width = 640, margin = {top: 46, right: 14, bottom: 50, left: 70};
  var right = width - margin.right, bottom = 400 - margin.bottom;
  var colors = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#b8860b', '#56b4e9', '#7a5195', '#6b6b6b'];
  var shapes = ['circle', 'square', 'triangle-up', 'diamond', 'triangle-down', 'cross'];
  var out = [];
  function text(value) {
    return String(value).replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;').replace(/"/g, '&quot;');
  }
  function at(value) { return Math.round(value * 100) / 100; }
  // Breaks text into lines of at most `length` letters, at blanks if there are any. No letter is cut off.
  function wrapped(value, length) {
    var lines = [''];
    value.split(' ').forEach(function (word) {
      while (word.length > length) { lines.push(word.slice(0, length)); word = word.slice(length); }
      var last = lines[lines.length - 1];
      if (last && last.length + 1 + word.length > length) lines.push(word);
      else lines[lines.length - 1] = last ? last + ' ' + word : word;
    });
    return lines.filter(function (line) { return line; });
  }
  function color(series) { return colors[series.slot % colors.length]; }
  // Dashes distinguish series of the same colour, beyond eight series; beyond six, markers repeat in another order.
  function dash(series) { return series.slot >= colors.length ? ' stroke-dasharray="6 3"' : ''; }
  function marker(series, x, y, size, attributes) {
    var shape = shapes[(series.slot + Math.floor(series.slot / colors.length)) % shapes.length];
    return '<path d="' + d3.svg.symbol().type(shape).size(size)() + '" transform="translate(' + at(x) + ',' + at(y) +
        ')" fill="' + color(series) + '"' + (attributes || '') + '/>';
  }

  if (spec.markOf)  // a page's own legend: line and marker of one series
    return '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30 14" width="30" height="14"><path d="M1,7h28" stroke="' +
        color(spec.markOf) + '" stroke-width="1.8"' + dash(spec.markOf) + '/>' + marker(spec.markOf, 15, 7, 42) + '</svg>';

  // The legend stands below the plot, in as many columns as the longest name permits. A page with its own legend omits it.
  var entries = spec.legend === false ? [] : spec.series.filter(function (series) { return series.points.length; });
  var longest = d3.max(entries.map(function (series) { return Math.max(series.name.length, 0.85 * series.note.length); })) || 0;
  var columns = Math.max(1, Math.min(3, entries.length, Math.floor((width - 20) / (44 + 7.3 * longest))));
  var column = (width - 20) / columns, letters = Math.floor((column - 44) / 7.3), legendTop = 400 + 8, legendHeight = 0, rowHeight = 0;
  entries = entries.map(function (series, i) {
    var lines = wrapped(series.name, letters);
    if (i % columns === 0) { legendHeight += rowHeight; rowHeight = 0; }
    var entry = {series: series, lines: lines, x: 10 + (i % columns) * column, y: legendTop + legendHeight + 10};
    rowHeight = Math.max(rowHeight, 15 * lines.length + (series.note ? 14 : 0) + 6);
    return entry;
  });
  legendHeight += rowHeight;
  var height = 400 + (entries.length ? legendHeight + 14 : 0);

  var xs = [], ys = [];
  function see(list, value) { if (value > 0 && isFinite(value)) list.push(value); }
  spec.series.forEach(function (series) {
    series.points.forEach(function (p) { see(xs, p.x); see(ys, p.y); see(ys, p.high); if (p.low > p.y / 10) see(ys, p.low); });
  });
  if (!xs.length || !ys.length)
    return '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ' + width + ' 60" font-family="sans-serif" font-size="13">' +
        '<text x="12" y="34" fill="currentColor">' + text(spec.title) + ': nothing was measured above 0.</text></svg>';
  if (spec.floor > 0 && spec.floor > d3.min(ys) / 30) see(ys, spec.floor);
  function padded(list) {
    var low = d3.min(list), high = d3.max(list), share = Math.max(1.12, Math.pow(high / low, 0.05));
    if (high / low < 2) share = 1.5;
    return [low / share, high * share];
  }
  var x = d3.scale.log().domain(padded(xs)).range([margin.left, right]);
  var y = d3.scale.log().domain(padded(ys)).range([bottom, margin.top]);

  // Ticks are at 1, 2, 5 of each decade if these have room, else at decades, at every second decade, every third ...
  function ticks(scale) {
    var domain = scale.domain(), decades = Math.log(domain[1] / domain[0]) / Math.LN10, list = [], k, m;
    var steps = decades < 0.7 ? [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9] : decades < 3.2 ? [1, 2, 5] : [1];
    var every = Math.max(1, Math.ceil(decades / 8));
    for (k = Math.floor(Math.log(domain[0]) / Math.LN10) - 1; k <= Math.log(domain[1]) / Math.LN10 + 1; ++k)
      for (m = 0; m < steps.length; ++m) {
        var value = steps[m] * Math.pow(10, k);
        if (value >= domain[0] && value <= domain[1] && (steps.length > 1 || k % every === 0)) list.push(value);
      }
    return list;
  }
  // Ticks are at the rendered budgets if the axis shows budgets; at every second, every third ... if labels have no room.
  function budgetTicks(scale) {
    function crowded(value, i, list) { return i > 0 && scale(value) - scale(list[i - 1]) < 34; }
    var budgets = spec.ticks || [], list = budgets, every = 2;
    for (; list.some(crowded); ++every) list = budgets.filter(function (value, i) { return (budgets.length - 1 - i) % every === 0; });
    return list.length > 1 ? list : ticks(scale);
  }
  function label(value) {
    if (value >= 1e6 || value < 1e-4) return d3.format('.0e')(value).replace('e+', 'e');
    return String(+value.toPrecision(value < 1 ? 2 : 4));
  }

  out.push('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ' + width + ' ' + height +
      '" role="img" aria-label="' + text(spec.title) + '" color="' + (spec.standalone ? '#1d1c1a' : 'currentColor') +
      '" font-family="system-ui, DejaVu Sans, sans-serif" font-size="12">');
  if (spec.standalone) out.push('<rect width="' + width + '" height="' + height + '" fill="#ffffff"/>');
  out.push('<text x="' + margin.left + '" y="18" font-size="14" font-weight="600" fill="currentColor">' + text(spec.title) + '</text>');
  if (spec.subtitle)
    out.push('<text x="' + margin.left + '" y="33" font-size="11.5" fill="currentColor" fill-opacity="0.65">' + text(spec.subtitle) + '</text>');
  budgetTicks(x).forEach(function (value) {
    out.push('<path d="M' + at(x(value)) + ',' + margin.top + 'V' + bottom + '" stroke="currentColor" stroke-opacity="0.1"/>' +
        '<text x="' + at(x(value)) + '" y="' + (bottom + 17) + '" text-anchor="middle" fill="currentColor" fill-opacity="0.75">' + label(value) + '</text>');
  });
  ticks(y).forEach(function (value) {
    out.push('<path d="M' + margin.left + ',' + at(y(value)) + 'H' + right + '" stroke="currentColor" stroke-opacity="0.1"/>' +
        '<text x="' + (margin.left - 8) + '" y="' + at(y(value) + 4) + '" text-anchor="end" fill="currentColor" fill-opacity="0.75">' + label(value) + ' %</text>');
  });
  out.push('<path d="M' + margin.left + ',' + margin.top + 'V' + bottom + 'H' + right + '" fill="none" stroke="currentColor" stroke-opacity="0.5"/>');
  out.push('<text x="' + (margin.left + right) / 2 + '" y="' + (bottom + 40) + '" text-anchor="middle" fill="currentColor">' + text(spec.xLabel) + '</text>');
  out.push('<text transform="translate(15,' + (margin.top + bottom) / 2 + ') rotate(-90)" text-anchor="middle" fill="currentColor">' + text(spec.yLabel) + '</text>');
  out.push('<clipPath id="' + text(spec.id) + '-clip"><rect x="' + margin.left + '" y="' + margin.top + '" width="' + (right - margin.left) +
      '" height="' + (bottom - margin.top) + '"/></clipPath><g clip-path="url(#' + text(spec.id) + '-clip)">');

  // The guide shows how the relative error of an unbiased method decreases: as 1 / sqrt(time).
  if (spec.guide) {
    var cx = Math.sqrt(x.domain()[0] * x.domain()[1]), cy = Math.sqrt(y.domain()[0] * y.domain()[1]);
    var ends = x.domain().map(function (value) { return [x(value), y(cy * Math.sqrt(cx / value))]; });
    out.push('<path d="' + d3.svg.line()(ends) + '" stroke="currentColor" stroke-opacity="0.3" stroke-dasharray="2 4" fill="none"/>');
  }
  if (spec.floor >= y.domain()[0])
    out.push('<path d="M' + margin.left + ',' + at(y(spec.floor)) + 'H' + right + '" stroke="#8a8a8a" stroke-width="1.5" stroke-dasharray="8 4"/>' +
        '<text x="' + (right - 6) + '" y="' + at(y(spec.floor) - 5) + '" text-anchor="end" font-size="11" fill="currentColor" fill-opacity="0.7">reference\u2019s own error</text>');
  var lowest = y.domain()[0];
  function inside(value) { return y(Math.max(value, lowest)); }
  spec.series.forEach(function (series) {
    var sure = series.points.filter(function (p) { return p.high > 0 && p.y > 0; });
    out.push('<g class="series" data-slot="' + series.slot + '">');
    if (sure.length > 1 && !spec.scatter) {
      var area = d3.svg.area().x(function (p) { return at(x(p.x)); }).y0(function (p) { return at(inside(p.low)); })
          .y1(function (p) { return at(inside(p.high)); });
      out.push('<path d="' + area(sure) + '" fill="' + color(series) + '" fill-opacity="0.14"/>');
    }
    var drawn = series.points.filter(function (p) { return p.y > 0; });
    if (!spec.scatter && drawn.length > 1)
      out.push('<path d="' + d3.svg.line().x(function (p) { return at(x(p.x)); }).y(function (p) { return at(y(p.y)); })(drawn) +
          '" fill="none" stroke="' + color(series) + '" stroke-width="1.8"' + dash(series) + '/>');
    drawn.forEach(function (p) {
      if (p.high > 0 && !spec.scatter)
        out.push('<path d="M' + at(x(p.x)) + ',' + at(inside(p.low)) + 'V' + at(inside(p.high)) + '" stroke="' + color(series) + '"/>');
      out.push('<g><title>' + text(series.name + '\n' + p.label) + '</title>' +
          marker(series, x(p.x), y(p.y), 42, p.weak ? ' fill-opacity="0.25" stroke="' + color(series) + '"' : '') + '</g>');
    });
    out.push('</g>');
  });
  if (spec.front && spec.front.length) {
    var step = d3.svg.line().interpolate('step-after');
    out.push('<path d="' + step(spec.front.map(function (p) { return [at(x(p.x)), at(y(p.y))]; })) +
        '" fill="none" stroke="currentColor" stroke-width="1.4" stroke-opacity="0.6"/>');
    // A number's place is the first free one: above right, below left, above left, below right of its point.
    var placed = [], corners = [[7, -6], [-18, 15], [-18, -6], [7, 15]];
    spec.front.forEach(function (p, i) {
      var spots = corners.map(function (corner) { return [x(p.x) + corner[0], y(p.y) + corner[1]]; });
      var free = spots.filter(function (spot) {
        return placed.every(function (other) { return Math.abs(spot[0] - other[0]) > 16 || Math.abs(spot[1] - other[1]) > 11; });
      });
      var spot = free.length ? free[0] : spots[0];
      placed.push(spot);
      out.push('<text x="' + at(spot[0]) + '" y="' + at(spot[1]) + '" font-size="11" font-weight="600" fill="currentColor">' + (i + 1) + '</text>');
    });
  }
  out.push('</g>');

  entries.forEach(function (entry) {
    var series = entry.series, below = entry.y + 4 + 15 * (entry.lines.length - 1);
    out.push('<g class="legend" data-slot="' + series.slot + '"><path d="M' + at(entry.x) + ',' + at(entry.y) + 'h18" stroke="' +
        color(series) + '" stroke-width="1.8"' + dash(series) + '/>' + marker(series, entry.x + 9, entry.y, 42));
    entry.lines.forEach(function (line, k) {
      out.push('<text x="' + at(entry.x + 27) + '" y="' + at(entry.y + 4 + 15 * k) + '" fill="currentColor">' + text(line) + '</text>');
    });
    if (series.note)
      out.push('<text x="' + at(entry.x + 27) + '" y="' + at(below + 14) + '" font-size="10.5" fill="currentColor" fill-opacity="0.65">' +
          text(series.note) + '</text>');
    out.push('</g>');
  });
  out.push('</svg>');
  return out.join('\n');
}
