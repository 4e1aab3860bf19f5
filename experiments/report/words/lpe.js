// Light path expressions in a page: the renderman dialect (its grammar is in lpe/README.md), matched against the path
// strings of an atlas.
//
// An expression is a graph of immutable nodes, each with a number. Its derivative by an event is the expression for
// what may follow that event (Brzozowski, Derivatives of Regular Expressions, JACM 1964). A path string matches if its
// events, one after the other, lead to a derivative that matches the empty path. Alternatives are kept outermost and
// without duplicates (Antimirov, Partial Derivatives, TCS 1996), so few different derivatives occur.
//
// An event is { type, scatter, number, labels }. Its type is one of C R T V L B O, or U for user events. Its scatter is
// x (none), D, G, S, or s for light that goes straight through, which leaves no event in this dialect.
//
//   const expression = raylexLpe.parse('C<RD>L', names);   // errors have `offset`, their place in the text
//   raylexLpe.answers(expression, { events, letters, words });
const raylexLpe = (() => {
  const mostNodes = 200000, mostRepetitions = 1000, sceneTypes = 'CRTVLBO';
  const isScene = event => event.type !== 'U';

  const failAt = (offset, message) => { throw Object.assign(new Error(message), { offset }); };
  const failTooLarge = () => failAt(null, 'the expression is too large; expected a shorter one');
  const bounded = work => {
    try {
      return work();
    } catch (failed) {
      if (failed instanceof RangeError) failTooLarge();  // the stack is full
      throw failed;
    }
  };

  // ---- expressions and their derivatives ----

  class Algebra {
    constructor() {
      this.tests = [];  // of single events
      this.nodes = new Map();  // by what a node consists of, so that equal expressions are one node
      this.none = this.node('none', [], false);  // matches nothing
      this.empty = this.node('empty', [], true);  // matches the empty path alone
      this.sceneEvents = this.repeat(this.event(isScene), 0, Infinity);
    }
    // `nullable`: whether the empty path matches.
    node(kind, parts, nullable, fields = {}) {
      const key = [kind, ...parts.map(part => part.id), fields.min, fields.max].join(' ');
      return this.nodes.get(key) || this.added(key, { kind, parts, nullable, ...fields });
    }
    added(key, node) {
      if (this.nodes.size >= mostNodes) failTooLarge();
      node.id = this.nodes.size;
      this.nodes.set(key, node);
      return node;
    }
    event(test) {
      this.tests.push(test);
      return this.added(test, { kind: 'event', parts: [], nullable: false, test });
    }
    sequence(a, b) {
      if (a === this.none || b === this.none) return this.none;
      if (a === this.empty) return b;
      if (b === this.empty) return a;
      if (a.kind === 'sequence') return this.sequence(a.parts[0], this.sequence(a.parts[1], b));
      if (a.kind === 'any') return this.any(a.parts.map(part => this.sequence(part, b)));
      return this.node('sequence', [a, b], a.nullable && b.nullable);
    }
    any(list) {
      const flat = list.flatMap(each => each.kind === 'any' ? each.parts : each === this.none ? [] : [each]);
      const parts = [...new Set(flat)].sort((a, b) => a.id - b.id);
      if (parts.length < 2) return parts[0] || this.none;
      return this.node('any', parts, parts.some(part => part.nullable));
    }
    both(a, b) {
      if (a === this.none || b === this.none) return this.none;
      if (a === b) return a;
      return this.node('both', a.id < b.id ? [a, b] : [b, a], a.nullable && b.nullable);
    }
    not(a) { return this.node('not', [a], !a.nullable); }
    repeat(a, min, max) {
      if (max === 0 || a === this.empty) return this.empty;
      if (a === this.none) return min === 0 ? this.empty : this.none;
      return this.node('repeat', [a], min === 0 || a.nullable, { min, max });
    }

    // The expression for what may follow `event`.
    move(node, event) {
      if (event.type === 'T' && event.scatter === 's') return node;
      node.after ??= new Map();
      if (!node.after.has(event)) node.after.set(event, this.derivative(node, event));
      return node.after.get(event);
    }
    derivative(root, event) {
      const known = new Map();  // parts that stand in several places are derived once
      const after = node => known.get(node) || known.set(node, rules[node.kind](node, ...node.parts)).get(node);
      const rules = {
        none: () => this.none, empty: () => this.none, event: node => node.test(event) ? this.empty : this.none,
        sequence: (node, a, b) => this.any([this.sequence(after(a), b), a.nullable ? after(b) : this.none]),
        any: node => this.any(node.parts.map(after)),
        both: (node, a, b) => this.both(after(a), after(b)),
        not: (node, a) => this.not(after(a)),
        repeat: ({ min, max }, a) => this.sequence(after(a), this.repeat(a, Math.max(min - 1, 0), max - 1))
      };
      return after(root);
    }
  }

  // ---- from text to expressions ----

  const hints = [[/s/, 'light that goes straight through leaves no event in this dialect'],
    [/[0-9]/, 'a lobe number follows its letter directly; a repetition is written {n}'],
    [/[a-z]/, 'labels are quoted, as in <RD\'floor\'>; a name inside an expression is written $name']];

  // Each method reads what it is named after and moves `position` behind it. A single event is read as a predicate.
  class Parser {
    constructor(text, names, algebra, lightGroup = '') {
      Object.assign(this, { text, names, algebra, lightGroup, position: 0 });
    }
    unexpected(expected) {
      const next = this.peek(), hint = hints.find(([pattern]) => next && pattern.test(next));
      const found = next ? `'${String.fromCodePoint(this.text.codePointAt(this.position))}'` : 'the end';
      failAt(this.position, `found ${found}; expected ${expected}` + (hint ? `; ${hint[1]}` : ''));
    }
    // `pattern` is sticky, so what it finds begins at the position.
    read(pattern) {
      pattern.lastIndex = this.position;
      const found = pattern.exec(this.text);
      if (found) this.position = pattern.lastIndex;
      return found;
    }
    // The next character behind blanks and comments; undefined at the end.
    peek() {
      this.read(/(?:[ \t\r\n]|#[^\n]*)*/y);
      return this.text[this.position];
    }
    take(character) {
      if (this.peek() !== character) return false;
      ++this.position;
      return true;
    }
    endsBefore(closers) {
      return !this.peek() || closers.includes(this.peek());
    }
    several(closers, read) {
      const list = [read()];
      while (!this.endsBefore(closers)) list.push(read());
      return list;
    }
    // The opening bracket has been read.
    bracketed(closer, read) {
      const opening = this.position - 1, inside = read();
      if (!this.take(closer)) this.unexpected(`'${closer}' for the '${this.text[opening]}' at column ${opening + 1}`);
      return inside;
    }

    channel() {
      let technique = null;
      for (let found; this.peek() && (found = this.read(/([A-Za-z0-9_]+)([;:])/y));) {
        const [whole, word, mark] = found, offset = this.position - whole.length;
        if (technique || (mark === ':' && word !== 'lpe')) failAt(offset, `found '${whole}'; expected an event`);
        if (mark === ';') technique = this.technique(word, offset);
      }
      return { root: this.language(), technique };
    }
    technique(word, offset) {
      const found = /^(?:beyond([0-9]{1,4})|s([0-9]{1,4})t([0-9]{1,4}))$/.exec(word);
      if (!found || Number(found[3]) === 0)
        failAt(offset, `found the prefix '${word}'; expected a technique such as s2t3 or beyond7: others change `
          + 'light, and an atlas keeps it unchanged');
      return { beyond: Number(found[1]), s: Number(found[2]), t: Number(found[3]) };
    }
    language() {
      this.peek();
      const begin = this.position, [name] = this.read(/(?:[A-Za-z_][A-Za-z_0-9]*)?/y);
      if (name && this.peek() === undefined && (this.resolve(name) || /[a-z][a-z]/.test(name)))
        return this.named(name, begin);
      this.position = begin;
      const root = this.difference();
      if (this.peek() !== undefined) this.unexpected('an event or the end of the expression');
      return root;
    }

    // `diffuse_key` is the expression named `diffuse` for the light group `key`.
    resolve(name) {
      for (let end = name.length; end > 0; end = name.lastIndexOf('_', end - 1)) {
        const text = this.names.get(name.slice(0, end)), group = name.slice(end + 1);
        if (text && (group || end === name.length)) return { text, group };
      }
      return null;
    }
    named(name, offset) {
      const known = this.resolve(name)
        || failAt(offset, `unknown name '${name}'; expected events or one of ${[...this.names.keys()].join(', ')}`);
      if (known.text.includes(';')) failAt(offset, `'${name}' has a prefix; expected an expression without one`);
      return new Parser(known.text, this.names, this.algebra, known.group || this.lightGroup).language();
    }
    nameInside() {
      const found = this.read(/(\{?)([A-Za-z_][A-Za-z_0-9]*)/y)
        || failAt(this.position, 'expected a name after \'$\', as in $diffuse or ${diffuse}');
      const offset = this.position - found[2].length;
      if (found[1] && !this.read(/\}/y)) failAt(this.position, `expected '}' after the name '${found[2]}'`);
      return this.named(found[2], offset);
    }

    difference() {
      let left = this.intersection();
      while (this.take('-')) left = this.algebra.both(left, this.algebra.not(this.intersection()));
      return left;
    }
    intersection() {
      let left = this.complement();
      while (this.take('&')) left = this.algebra.both(left, this.complement());
      return left;
    }
    complement() {
      if (!this.take('!')) return this.sequence();
      return this.algebra.both(this.algebra.not(this.complement()), this.algebra.sceneEvents);
    }
    sequence() {
      const items = this.several(')-&', () => {
        const choices = [this.item()];
        while (this.take('|')) choices.push(this.item());
        return this.algebra.any(choices);
      });
      return items.reduceRight((rest, item) => this.algebra.sequence(item, rest), this.algebra.empty);
    }
    item() {
      if (this.take('(')) return this.repetition(this.bracketed(')', () => this.difference()));
      if (this.take('[')) return this.repetition(this.bracketed(']', () => this.list()));
      if (this.take('$')) return this.repetition(this.nameInside());
      return this.repetition(this.algebra.event(this.event()));
    }
    list() {
      if (!this.take('^')) return this.algebra.any(this.several(']', () => this.item()));
      const excluded = this.several(']', () => this.event());
      return this.algebra.event(event => isScene(event) && !excluded.some(test => test(event)));
    }
    repetition(item) {
      if (this.take('*')) return this.algebra.repeat(item, 0, Infinity);
      if (this.take('+')) return this.algebra.repeat(item, 1, Infinity);
      if (this.take('?')) return this.algebra.repeat(item, 0, 1);
      if (!this.take('{')) return item;
      const opening = this.position - 1, min = this.count();
      const max = !this.take(',') ? min : this.peek() === '}' ? Infinity : this.count();
      if (!this.take('}')) this.unexpected('a repetition {n}, {n,} or {n,m}');
      if (max < min) failAt(opening, `the repetition {${min},${max}} counts down; expected {n,m} with n <= m`);
      return this.algebra.repeat(item, min, max);
    }
    count() {
      this.peek();
      const begin = this.position, found = this.read(/[0-9]+/y) || this.unexpected('a repetition {n}, {n,} or {n,m}');
      if (Number(found[0]) > mostRepetitions)
        failAt(begin, `found the repetition count ${found[0]}; expected at most ${mostRepetitions}`);
      return Number(found[0]);
    }

    event() {
      if (this.take('<')) return this.bracketed('>', () => this.group());
      if (this.peek() === '\'') {
        const label = this.labels();
        return event => isScene(event) && label(event.labels[0] || '');
      }
      return this.type() || this.scatter()
        || this.unexpected('an event: C L O B V R T D G S U . \'label\' <...> [...] or (...)');
    }
    type() {
      if (!this.peek() || !`.${sceneTypes}`.includes(this.peek())) return null;
      const letter = this.text[this.position++], types = letter === '.' ? sceneTypes : letter === 'L' ? 'LB' : letter;
      return event => types.includes(event.type);
    }
    scatter() {
      const found = this.peek() && this.read(/G|([DSU])([0-9]*)/y);
      if (!found) return null;
      const [whole, letter, digits] = found, most = { D: 4, S: 8, U: 12 }[letter], number = Number(digits || 0);
      if ((digits || letter === 'U') && !(number >= 1 && number <= most))
        failAt(this.position - digits.length, `there is no lobe ${whole}; expected ${letter}1 to ${letter}${most}`);
      if (letter === 'U') return event => event.type === 'U' && event.number === number;
      const scatters = letter === 'S' ? 'GS' : whole[0];
      return event => scatters.includes(event.scatter) && (number === 0 || event.number === number);
    }
    // What stands between < and >. <.U2'label'> is a user event with a label.
    group() {
      const begin = this.position, nextType = 'an event type: C L O B V R T . or [...] of them';
      const nextScatter = 'a scattering: D G S D1-D4 S1-S8 . or [...] of them; labels follow it, as in <L.\'key\'>';
      const type = this.slot(() => this.type() || this.unexpected(nextType));
      const everyType = [...sceneTypes].every(letter => type({ type: letter }));
      const scatter = this.endsBefore('>') ? isScene
        : this.slot(() => this.take('.') ? isScene : this.scatter() || this.unexpected(nextScatter), isScene);
      let labels = this.endsBefore('>') ? [] : this.several('>', () => this.labels());
      const written = this.text.slice(begin, this.position).replace(/#[^\n]*|[ \t\r\n]/g, '');
      if (this.lightGroup && written === 'L.') labels = [label => label === this.lightGroup];
      return event => (isScene(event) ? type(event) : everyType) && scatter(event)
        && labels.every((label, slot) => label(event.labels[slot] || ''));
    }
    // One predicate, or several in brackets; [^...] matches what is `within` and matches none of them.
    slot(read, within = () => true) {
      if (!this.take('[')) return read();
      return this.bracketed(']', () => {
        const negated = this.take('^'), tests = this.several(']', read);
        return value => tests.some(test => test(value)) ? !negated : negated && within(value);
      });
    }
    labels() { return this.take('.') ? () => true : this.slot(() => this.label()); }
    label() {
      if (!this.take('\'')) this.unexpected('a quoted label such as \'floor\', \'.\' or [...] of labels');
      const found = this.read(/((?:\\[^]|[^'\\])*)'/uy)
        || failAt(this.position - 1, 'the quote is not closed; expected a second \'');
      const pattern = found[1].replace(/\*|\?|\\?([^])/gu, (piece, character) => character
        ? `\\u{${character.codePointAt(0).toString(16)}}` : piece === '*' ? '[^]*' : '[^]');
      const glob = new RegExp(`^${pattern}$`, 'u');
      return text => glob.test(text);
    }
  }

  // `names`: from a name to its expression. The result's `technique` is null or { beyond, s, t }, each a number or NaN.
  const parse = (text, names) => bounded(() => {
    const algebra = new Algebra();
    return { algebra, ...new Parser(text, new Map(Object.entries(names)), algebra).channel() };
  });

  // ---- path strings of an atlas, which may stand for several paths (experiments/atlas/word_answers.h) ----

  // For each path string 2 if all its light belongs to the expression, 1 if some of it may, 0 if none does. The events
  // of one letter were not told apart; the letter -1 stands for one scattering or more.
  const answers = ({ algebra, root }, { events, letters, words }) => bounded(() => {
    const kinds = new Map(), ofLetter = new Map(), sets = new Map();
    events.forEach((event, i) => {  // one event stands for all events that no test distinguishes
      const kind = [event.type, event.scatter === 's', ...algebra.tests.map(test => test(event))].join();
      if (!kinds.has(kind)) kinds.set(kind, event);
      ofLetter.set(letters[i], [...new Set(ofLetter.get(letters[i])).add(kinds.get(kind))]);
    });
    const scatterings = [...kinds.values()].filter(event => 'RTV'.includes(event.type));
    const setOf = nodes => {
      const list = [...new Set(nodes)].sort((a, b) => a.id - b.id), key = list.map(node => node.id).join();
      if (!sets.has(key)) sets.set(key, { nodes: list, after: new Map() });
      return sets.get(key);
    };
    const moved = (set, through) => setOf(set.nodes.flatMap(node => through.map(event => algebra.move(node, event))));
    const grown = set => {
      const wider = setOf([...set.nodes, ...moved(set, scatterings).nodes]);
      return wider === set ? set : grown(wider);
    };
    const after = (set, letter) => {
      if (!set.after.has(letter))
        set.after.set(letter, letter < 0 ? grown(moved(set, scatterings)) : moved(set, ofLetter.get(letter)));
      return set.after.get(letter);
    };
    const first = moved(setOf([root]), [{ type: 'C', scatter: 'x', number: 0, labels: [] }]);
    return words.map(word => {
      const { nodes } = word.reduce(after, first), matching = nodes.filter(node => node.nullable).length;
      return matching === nodes.length ? 2 : matching > 0 ? 1 : 0;
    });
  });

  return { parse, answers };
})();
