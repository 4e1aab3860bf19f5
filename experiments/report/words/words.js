// The words of a path atlas in the page of a render: which of them make the pixel under the pointer, and the layer of any
// expression that is typed. `page`: { width, height, block, addLayer } of split_page.js.
const raylexWords = (section, page) => {
  const info = JSON.parse(section.querySelector('script.words').textContent);
  const { digits } = raylexPixels, pixels = info.width * info.height, shown = 10;
  const make = (parent, tag, properties = {}) => parent.appendChild(Object.assign(document.createElement(tag), properties));

  const bytesOf = event => ({ ...event, labels: event.labels.map(raylexLpe.bytes) });
  const load = async () => {
    const [text, counts, numbers, light, errors] = await Promise.all([raylexPixels.unpacked(info.id + '-table'),
      raylexPixels.integers(info.id + '-counts'), raylexPixels.integers(info.id + '-numbers'),
      raylexPixels.halves(info.id + '-light', info.scale), raylexPixels.halves(info.id + '-errors', info.errorScale)]);
    const table = JSON.parse(new TextDecoder().decode(text)), begin = new Uint32Array(pixels + 1);
    for (let i = 0; i < pixels; ++i) begin[i + 1] = begin[i] + counts.at(i);
    const ofLetter = new Map([[-1, '...']]);  // events of one letter were not told apart
    table.events.forEach((event, i) => {
      const letter = table.letters[i];
      ofLetter.set(letter, ofLetter.has(letter) ? `${ofLetter.get(letter)}/${event.text}` : event.text);
    });
    table.events = table.events.map(bytesOf);
    const found = number => table.techniques ? ` (s${table.techniques[number].join('t')})` : '';
    const textOf = number => ['C', ...table.words[number].map(letter => ofLetter.get(letter))].join(' ') + found(number);
    const count = begin[pixels], rgb = entry => [light.at(entry), light.at(count + entry), light.at(2 * count + entry)];
    return { table, begin, numbers, errors, rgb, textOf };
  };
  const loaded = load();

  // ---- the words of a pixel ----

  const panel = make(section.querySelector('.stage'), 'div', { className: 'words' });
  const title = make(panel, 'p', { className: 'faint' }), list = make(panel, 'table');
  const mean = rgb => (rgb[0] + rgb[1] + rgb[2]) / 3;
  let taken = null, reading = 0;
  const hint = `The pointer on the picture shows which words make the pixel, from ${info.name}`
    + (info.block > 1 ? `; this page keeps their means over ${info.block} x ${info.block} pixels.` : '.');
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
    title.textContent = `${entries.length} ${entries.length === 1 ? 'word' : 'words'} at ${where}`
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
  const refusal = failed => {
    if (failed.refused === undefined) throw failed;
    const before = raylexLpe.characters(raylexLpe.bytes(input.value).slice(0, failed.offset)).length;
    input.setSelectionRange(before, before + 1);
    return `${failed.refused} (column ${before + 1})` + (failed.hint ? `; ${failed.hint}` : '');
  };
  const compiled = () => {
    const program = raylexLpe.compile(raylexLpe.bytes(input.value), dialect.value, raylexNames);
    const other = program.prefixes.find(each => !/^(s[0-9]+t|beyond)[0-9]+$/.test(each)) || program.prefixes[1];
    if (other) throw { refused: `the prefix '${other}' changes light, and an atlas keeps it as it is`, offset: 0 };
    if (program.prefixes.length && !info.techniques)
      throw { refused: 'this atlas does not tell how light was found', offset: 0,
        hint: 'render it with --atlas-by label,lobe,group,technique' };
    if (dialect.value === 'osl' && info.straightDropped)
      throw { refused: 'osl sees light pass straight through cutouts, which this atlas did not keep', offset: 0,
        hint: 'render it with --atlas-by label,lobe,group,straight' };
    return program;
  };

  // What of the answers a technique found: as they were, or 0; 1 where the atlas counts no further.
  const byTechnique = (answers, prefix, techniques) => {
    if (!prefix) return answers;
    const [, s, t, beyond] = /^(?:s([0-9]+)t([0-9]+)|beyond([0-9]+))$/.exec(prefix).map(Number), most = info.mostVertices;
    const isCount = (wanted, is) => is < most ? (is === wanted ? 2 : 0) : wanted < most ? 0 : 1;
    return answers.map((answer, i) => {
      const [u, v] = techniques[i];
      return Math.min(answer, prefix[0] === 's' ? Math.min(isCount(s, u), isCount(t, v)) : u + v > beyond ? 2
        : Math.max(u, v) < most ? 0 : 1);
    });
  };

  // Planes of the page's pixels: what surely is the expression's, and what may be more of it.
  const sumsOf = (atlas, answers) => {
    const sums = [new Float32Array(3 * pixels), new Float32Array(3 * pixels)], all = new Float32Array(pixels);
    const total = [0, 0, 0];
    for (let pixel = 0; pixel < pixels; ++pixel)
      for (let entry = atlas.begin[pixel]; entry < atlas.begin[pixel + 1]; ++entry) {
        const kind = answers[atlas.numbers.at(entry)], rgb = atlas.rgb(entry);
        total[2] += rgb[0] + rgb[1] + rgb[2];
        all[pixel] += rgb[0] + rgb[1] + rgb[2];
        if (kind === 0) continue;
        total[kind === 2 ? 0 : 1] += rgb[0] + rgb[1] + rgb[2];
        for (let c = 0; c < 3; ++c) sums[kind === 2 ? 0 : 1][c * pixels + pixel] += rgb[c];
      }
    return { sure: sums[0], more: sums[1], all, share: total[0] / total[2], moreShare: total[1] / total[2] };
  };
  // The atlas's pixel that a pixel of the page is in.
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
    const program = compiled(), expression = input.value, atlas = await loaded;
    const { table } = atlas;
    const answers = byTechnique(raylexLpe.answers(program, table), program.prefixes[0], table.techniques);
    const count = kind => answers.filter(each => each === kind).length;
    const { sure, more, all, share, moreShare } = sumsOf(atlas, answers), open = count(1), name = `asked ${asked + 1}`;
    if (open > 0 && info.signed)
      throw { refused: `'${atlas.textOf(answers.indexOf(1))}' is kept together, and light of words may be negative here`,
        offset: 0 };
    taken = answers;
    if (open > 0) add(`${name}, at most`, expression, sure.map((value, i) => value + more[i]), all,
      share + moreShare);
    add(open > 0 ? `${name}, at least` : name, expression, sure, all, share);
    say(`${count(2)} of ${answers.length} words, ${percent(share)} of the light`
      + (open > 0 ? `; ${open} more stand for paths that it tells apart, such as '${atlas.textOf(answers.indexOf(1))}': up to `
        + `${percent(share + moreShare)}` : '')
      + `. In full precision: raylex ask ${quoted(info.name)}${dialect.value === 'osl' ? ' --dialect osl' : ''}`
      + ` --lpe ${quoted(`asked=${expression}`)} -o layers.exr`);
    section.dataset.asked = expression;
  };
  const quoted = text => `'${text.replace(/'/g, '\'\\\'\'')}'`;
  form.addEventListener('submit', event => {
    event.preventDefault();
    const refused = failed => say(refusal(failed), true);
    try {
      ask().catch(refused);
    } catch (failed) {
      refused(failed);
    }
  });
  input.addEventListener('input', () => {  // what is wrong is told while it is typed; the layer comes when asked for
    try {
      if (input.value) compiled();
      say('');
    } catch (failed) {
      say(failed.refused === undefined ? String(failed) : failed.refused, true);
    }
  });
  read(-1, -1);
  return { read };
};
