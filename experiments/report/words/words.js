// The path strings of an atlas in the page of a render: which of them contribute to the pixel under the pointer, and
// the layer of any expression that is typed. `page`: { width, height, block, addLayer } of split_page.js.
const raylexWords = (section, page) => {
  const info = JSON.parse(section.querySelector('script.words').textContent);
  const { digits } = raylexPixels, pixels = info.width * info.height, shown = 10;
  const make = (parent, tag, properties = {}) => parent.appendChild(Object.assign(document.createElement(tag), properties));

  const load = async () => {
    const [text, counts, numbers, light, errors] = await Promise.all([raylexPixels.unpacked(info.id + '-table'),
      raylexPixels.integers(info.id + '-counts'), raylexPixels.integers(info.id + '-numbers'),
      raylexPixels.halves(info.id + '-light', info.scale), raylexPixels.halves(info.id + '-errors', info.errorScale)]);
    const table = JSON.parse(new TextDecoder().decode(text)), begin = new Uint32Array(pixels + 1);
    for (let i = 0; i < pixels; ++i) begin[i + 1] = begin[i] + counts.at(i);
    const ofLetter = new Map([[-1, '...']]);  // one letter can stand for several events
    table.events.forEach((event, i) => {
      const letter = table.letters[i];
      ofLetter.set(letter, ofLetter.has(letter) ? `${ofLetter.get(letter)}/${event.text}` : event.text);
    });
    const found = number => table.techniques ? ` (s${table.techniques[number].join('t')})` : '';
    const textOf = number => ['C', ...table.words[number].map(letter => ofLetter.get(letter))].join(' ') + found(number);
    const count = begin[pixels], rgb = entry => [light.at(entry), light.at(count + entry), light.at(2 * count + entry)];
    return { table, begin, numbers, errors, rgb, textOf };
  };
  const loaded = load();

  // ---- the path strings of a pixel ----

  const panel = make(section.querySelector('.stage'), 'div', { className: 'words' });
  const title = make(panel, 'p', { className: 'faint' }), list = make(panel, 'table');
  const mean = rgb => (rgb[0] + rgb[1] + rgb[2]) / 3;
  let taken = null, reading = 0;
  const hint = `Point at the picture to see the path strings of a pixel, from ${info.name}`
    + (info.block > 1 ? `; this page keeps means over ${info.block} x ${info.block} pixels.` : '.');
  const rowOf = (atlas, entry, whole) => {
    const number = atlas.numbers.at(entry.at), error = atlas.errors.at(entry.at);
    const row = make(list, 'tr', { className: taken && taken[number] ? 'taken' : '' });
    const share = entry.luminance / whole;
    make(row, 'td', { className: 'number', textContent: Number.isFinite(share) ? (100 * share).toFixed(1) + ' %' : '' });
    make(row, 'td', { className: 'number', textContent: digits(entry.luminance) });
    make(row, 'td', { className: 'number', textContent: '\u00b1 ' + (Number.isFinite(error) ? digits(error) : 'unknown') });
    make(make(row, 'td'), 'code', { textContent: atlas.textOf(number) });
  };
  const read = async (x, y) => {
    const mine = ++reading;
    if (x < 0) {
      title.textContent = hint;
      list.replaceChildren();
      delete section.dataset.words;
      return;
    }
    const atlas = await loaded;
    if (mine !== reading) return;
    const u = Math.floor(x / info.block), v = Math.floor(y / info.block), at = v * info.width + u, entries = [];
    for (let entry = atlas.begin[at]; entry < atlas.begin[at + 1]; ++entry)
      entries.push({ at: entry, luminance: mean(atlas.rgb(entry)) });
    const whole = entries.reduce((sum, entry) => sum + entry.luminance, 0);
    entries.sort((a, b) => Math.abs(b.luminance) - Math.abs(a.luminance));
    const where = info.block > 1
      ? `${info.block} x ${info.block} pixels from (${u * info.block}, ${v * info.block})` : `(${x}, ${y})`;
    title.textContent = `${entries.length} path ${entries.length === 1 ? 'string' : 'strings'} at ${where}`
      + (entries.length > shown ? `, the brightest ${shown}` : '') + ': share, mean of R G B, its standard error, path';
    list.replaceChildren();
    entries.slice(0, shown).forEach(entry => rowOf(atlas, entry, whole));
    section.dataset.words = String(entries.length);
  };

  // ---- the layer of an expression ----

  const form = document.createElement('form');
  form.className = 'ask';
  section.querySelector('.list').prepend(form);
  const input = make(form, 'input', { type: 'text', placeholder: 'an expression, such as C<RD>L', spellcheck: false });
  input.setAttribute('aria-label', 'light path expression');
  const dialect = make(form, 'select', { ariaLabel: 'dialect' });
  ['renderman', 'osl'].forEach(name => make(dialect, 'option', { textContent: name }));
  make(form, 'button', { type: 'submit', textContent: 'ask' });
  const answer = make(form, 'p', { className: 'answer' }), heading = make(form, 'div');
  const say = (text, fails) => {
    answer.textContent = text;
    answer.classList.toggle('fails', !!fails);
  };
  const refuse = message => { throw Object.assign(new Error(message), { offset: null }); };
  // Errors without `offset` are errors of this script.
  const explained = failed => {
    if (failed.offset === undefined) throw failed;
    return failed.offset === null ? failed.message : `column ${failed.offset + 1}: ${failed.message}`;
  };
  const quoted = text => `'${text.replace(/'/g, '\'\\\'\'')}'`;
  const command = () => `raylex ask ${quoted(info.name)}${dialect.value === 'osl' ? ' --dialect osl' : ''}`
    + ` --lpe ${quoted(`asked=${input.value}`)} -o layers.exr`;
  const isOsl = () => {
    if (dialect.value === 'osl' && input.value)
      say(`This page answers renderman expressions only. This command answers the osl expression: ${command()}`);
    return dialect.value === 'osl';
  };
  const parsed = () => {
    const expression = raylexLpe.parse(input.value, raylexNames);
    if (expression.technique && !info.techniques)
      refuse('this atlas does not record how light was found; render it with --atlas-by label,lobe,group,technique');
    return expression;
  };

  // The answers, lowered to 0 where another technique found the light. An atlas counts vertices up to
  // info.mostVertices, which stands for any larger number too: the answer is then at most 1.
  const byTechnique = (answers, technique, found) => {
    if (!technique) return answers;
    const most = info.mostVertices, { s, t, beyond } = technique;
    const ofCount = (wanted, count) => count < most ? (count === wanted ? 2 : 0) : wanted < most ? 0 : 1;
    const ofTechnique = ([u, v]) => Number.isNaN(beyond) ? Math.min(ofCount(s, u), ofCount(t, v))
      : u + v > beyond ? 2 : Math.max(u, v) < most ? 0 : 1;
    return answers.map((each, i) => Math.min(each, ofTechnique(found[i])));
  };

  // Planes of the page's pixels: light that belongs to the expression (answer 2), and light that may (answer 1).
  const sumsOf = (atlas, answers) => {
    const sums = [new Float32Array(3 * pixels), new Float32Array(3 * pixels)], all = new Float32Array(pixels);
    const total = [0, 0, 0];
    for (let pixel = 0; pixel < pixels; ++pixel)
      for (let entry = atlas.begin[pixel]; entry < atlas.begin[pixel + 1]; ++entry) {
        const kind = answers[atlas.numbers.at(entry)], rgb = atlas.rgb(entry), sum = rgb[0] + rgb[1] + rgb[2];
        total[2] += sum;
        all[pixel] += sum;
        if (kind === 0) continue;
        total[2 - kind] += sum;
        for (let c = 0; c < 3; ++c) sums[2 - kind][c * pixels + pixel] += rgb[c];
      }
    return { sure: sums[0], more: sums[1], all, share: total[0] / total[2], moreShare: total[1] / total[2] };
  };
  // The pixel of the atlas that contains a pixel of the page.
  const placeOf = i => {
    if (page.block === info.block) return i;
    const x = (i % page.width) * page.block, y = Math.floor(i / page.width) * page.block;
    return Math.floor(y / info.block) * info.width + Math.floor(x / info.block);
  };
  const placed = values => {
    const size = page.width * page.height;
    return { count: 3 * size, at: i => values[Math.floor(i / size) * pixels + placeOf(i % size)] };
  };
  const rowElement = (name, expression) => {
    const row = section.querySelector('.layer.light').cloneNode(true), image = row.querySelector('.thumb');
    image.replaceChildren();
    row.dataset.name = name;
    row.title = `${name}: ${expression}`;
    row.querySelector('.title').textContent = name;
    row.querySelector('.formula').textContent = expression;
    row.querySelector('.value').textContent = '';
    heading.prepend(row);
    return row;
  };
  let asked = 0;
  const add = (name, expression, values, all, share) => page.addLayer({ name, expression, planes: ['R', 'G', 'B'],
    light: true, whole: null, look: '', empty: false, data: `asked-${info.id}-${++asked}`, planesOf: placed(values), share,
    wholeAt: index => all[placeOf(index)] }, rowElement(name, expression));

  const percent = share => `${digits(100 * share)} %`;
  const ask = async () => {
    const expression = parsed(), text = input.value, full = command(), atlas = await loaded, { table } = atlas;
    const answers = byTechnique(raylexLpe.answers(expression, table), expression.technique, table.techniques);
    const count = kind => answers.filter(each => each === kind).length, open = count(1);
    const { sure, more, all, share, moreShare } = sumsOf(atlas, answers), name = `asked ${asked + 1}`;
    const example = open > 0 ? `'${atlas.textOf(answers.indexOf(1))}'` : '';
    if (open > 0 && info.signed)
      refuse(`the atlas merged the paths of ${example}, and light can be negative here, so there are no bounds`);
    taken = answers;
    if (open > 0) add(`${name}, at most`, text, sure.map((value, i) => value + more[i]), all, share + moreShare);
    add(open > 0 ? `${name}, at least` : name, text, sure, all, share);
    say(`${count(2)} of ${answers.length} path strings, ${percent(share)} of the light`
      + (open > 0 ? `; ${open} more, such as ${example}, match in part: up to ${percent(share + moreShare)}` : '')
      + `. In full precision: ${full}`);
    section.dataset.asked = text;
  };
  form.addEventListener('submit', event => {
    event.preventDefault();
    if (isOsl()) return;
    ask().catch(failed => {
      say(explained(failed), true);
      if (failed.offset !== null) input.setSelectionRange(failed.offset, failed.offset + 1);
    });
  });
  const check = () => {  // while the expression is typed; its layer comes with `ask`
    say('');
    if (!input.value || isOsl()) return;
    try {
      parsed();
    } catch (failed) {
      say(explained(failed), true);
    }
  };
  input.addEventListener('input', check);
  dialect.addEventListener('change', check);
  read(-1, -1);
  return { read, loaded, placeOf };
};
