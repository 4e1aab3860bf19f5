// One plot as SVG text, from plain data: the same bytes in the page and in plots/*.svg, so nothing here touches a document.
// ECMAScript 5, since an embedded interpreter runs it too; d3 (version 3) gives scales, ticks and paths.
function raylexPlot(d3, spec) {
  var width = 860, height = 430, margin = {top: 42, right: 262, bottom: 52, left: 66};
  var right = width - margin.right, bottom = height - margin.bottom;
  var colors = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#b8860b', '#56b4e9', '#7a5195', '#6b6b6b'];
  var shapes = ['circle', 'square', 'triangle-up', 'diamond', 'triangle-down', 'cross'];
  var out = [];
  function text(value) {
    return String(value).replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;').replace(/"/g, '&quot;');
  }
  function at(value) { return Math.round(value * 100) / 100; }
  function cut(value, length) { return value.length > length ? value.slice(0, length - 1) + '\u2026' : value; }
  function color(series) { return colors[series.slot % colors.length]; }
  // Beyond eight series the dash tells those of one colour apart, beyond six markers repeat in another order.
  function dash(series) { return series.slot >= colors.length ? ' stroke-dasharray="6 3"' : ''; }
  function marker(series, x, y, size, attributes) {
    var shape = shapes[(series.slot + Math.floor(series.slot / colors.length)) % shapes.length];
    return '<path d="' + d3.svg.symbol().type(shape).size(size)() + '" transform="translate(' + at(x) + ',' + at(y) +
        ')" fill="' + color(series) + '"' + (attributes || '') + '/>';
  }

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

  // 1, 2, 5 per decade while they have room, else decades, every second, every third ...
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
  function label(value) {
    if (value >= 1e5 || value < 1e-3) return d3.format('.0e')(value).replace('e+', 'e');
    return String(+value.toPrecision(2));
  }

  out.push('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ' + width + ' ' + height +
      '" role="img" aria-label="' + text(spec.title) + '" color="' + (spec.standalone ? '#1d1c1a' : 'currentColor') +
      '" font-family="system-ui, DejaVu Sans, sans-serif" font-size="12">');
  if (spec.standalone) out.push('<rect width="' + width + '" height="' + height + '" fill="#ffffff"/>');
  out.push('<text x="' + margin.left + '" y="18" font-size="14" font-weight="600" fill="currentColor">' + text(spec.title) + '</text>');
  if (spec.subtitle)
    out.push('<text x="' + margin.left + '" y="33" font-size="11.5" fill="currentColor" fill-opacity="0.65">' + text(spec.subtitle) + '</text>');
  ticks(x).forEach(function (value) {
    out.push('<path d="M' + at(x(value)) + ',' + margin.top + 'V' + bottom + '" stroke="currentColor" stroke-opacity="0.1"/>' +
        '<text x="' + at(x(value)) + '" y="' + (bottom + 17) + '" text-anchor="middle" fill="currentColor" fill-opacity="0.75">' + label(value) + '</text>');
  });
  ticks(y).forEach(function (value) {
    out.push('<path d="M' + margin.left + ',' + at(y(value)) + 'H' + right + '" stroke="currentColor" stroke-opacity="0.1"/>' +
        '<text x="' + (margin.left - 8) + '" y="' + at(y(value) + 4) + '" text-anchor="end" fill="currentColor" fill-opacity="0.75">' + label(value) + ' %</text>');
  });
  out.push('<path d="M' + margin.left + ',' + margin.top + 'V' + bottom + 'H' + right + '" fill="none" stroke="currentColor" stroke-opacity="0.5"/>');
  out.push('<text x="' + (margin.left + right) / 2 + '" y="' + (height - 12) + '" text-anchor="middle" fill="currentColor">' + text(spec.xLabel) + '</text>');
  out.push('<text transform="translate(15,' + (margin.top + bottom) / 2 + ') rotate(-90)" text-anchor="middle" fill="currentColor">' + text(spec.yLabel) + '</text>');
  out.push('<clipPath id="' + text(spec.id) + '-clip"><rect x="' + margin.left + '" y="' + margin.top + '" width="' + (right - margin.left) +
      '" height="' + (bottom - margin.top) + '"/></clipPath><g clip-path="url(#' + text(spec.id) + '-clip)">');

  // How an unbiased method falls: relative error as 1 / sqrt(time).
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
    // Numbers stand where there is none yet: above to the right, else below to the left, above to the left, below to the right.
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

  // The legend: every series by the height of its last point, moved apart where they would touch.
  var entries = spec.series.filter(function (series) { return series.points.length; }).map(function (series) {
    var last = series.points[series.points.length - 1];
    return {series: series, y: inside(last.y > 0 ? last.y : lowest)};
  }).sort(function (a, b) { return a.y - b.y; });
  var room = Math.min(34, (bottom - margin.top + 24) / Math.max(1, entries.length)), notes = room > 26, previous = margin.top - room;
  entries.forEach(function (entry) { entry.y = previous = Math.max(entry.y, previous + room); });
  var over = previous - (bottom + 8);
  for (var i = entries.length - 1; i >= 0 && over > 0; --i) {
    entries[i].y = Math.min(entries[i].y, bottom + 8 - (entries.length - 1 - i) * room);
  }
  entries.forEach(function (entry) {
    var series = entry.series;
    out.push('<g class="legend" data-slot="' + series.slot + '"><title>' + text(series.name + (series.note ? '\n' + series.note : '')) + '</title>' +
        '<path d="M' + (right + 12) + ',' + at(entry.y) + 'h18" stroke="' + color(series) + '" stroke-width="1.8"' + dash(series) + '/>' +
        marker(series, right + 21, entry.y, 42) + '<text x="' + (right + 37) + '" y="' + at(entry.y + 4) + '" fill="currentColor">' + text(cut(series.name, 33)) + '</text>' +
        (series.note && notes ? '<text x="' + (right + 37) + '" y="' + at(entry.y + 17) + '" font-size="10.5" fill="currentColor" fill-opacity="0.65">' + text(cut(series.note, 38)) + '</text>' : '') + '</g>');
  });
  out.push('</svg>');
  return out.join('\n');
}
