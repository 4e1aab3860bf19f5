// Light path expressions in a page, second script: texts of the renderman dialect to trees, as
// lpe/language/parser/parser_renderman.cpp reads them. Grammar: lpe/README.md.
//
// Nodes: { kind: 'event', set }, { kind: 'sequence' | 'alternatives', children }, { kind: 'repeat', child, min, max },
// { kind: 'complement', child }, { kind: 'intersection' | 'difference', left, right }; max -1: without bound.
var raylexReader = (function () {
  'use strict';
  // What both dialects' readers have. A refusal is thrown as { refused, hint, offset }.
  function Reader(text) {
    this.text = text;
    this.position = 0;
    this.depth = 0;
  }
  Reader.limits = { bytes: 65536, nesting: 200, operators: 400, repetitions: 1000, variants: 1024 };
  Reader.prototype.failAt = function (offset, message, hint) {
    throw { refused: message, hint: hint || '', offset: offset };
  };
  Reader.prototype.found = function () {
    var c = this.text[this.position];
    return c === undefined ? 'the end of the expression' : '\'' + c + '\'';
  };
  Reader.prototype.enter = function (offset) {
    if (++this.depth > Reader.limits.nesting)
      this.failAt(offset, 'brackets are nested deeper than ' + Reader.limits.nesting);
  };
  Reader.prototype.digits = function () {
    var begin = this.position, text = this.text;
    while (text[this.position] >= '0' && text[this.position] <= '9') ++this.position;
    return text.slice(begin, this.position);
  };
  /// A count of {n,m}; -1 where there is none.
  Reader.prototype.count = function () {
    var begin = this.position, digits = this.digits();
    if (+digits > Reader.limits.repetitions)
      this.failAt(begin, 'a repetition count is above ' + Reader.limits.repetitions);
    return digits === '' ? -1 : +digits;
  };
  return Reader;
})();

var raylexRenderman = (function (Reader, events) {
  'use strict';
  var universe = events.wildcard.renderman;
  var prefixNames = ['unoccluded', 'noclamp', 'nothruput', 'shadows', 'holdouts', 'overwrite', 'noinfinitecheck',
    'unweighted'];

  var known = {};  // sets that letters stand for: never changed, so made once
  function once(key, test) {
    return known[key] = known[key] || events.both(universe, events.cores(test));
  }
  function ofType(letters) {
    return once(letters, function (type) { return letters.indexOf(type) >= 0; });
  }
  function ofScatter(letters, number) {
    return once(letters + number, function (type, scatter, n) {
      return letters.indexOf(scatter) >= 0 && (number === 0 || n === number);
    });
  }
  function isTechnique(word) {
    var found = /^(?:beyond([0-9]+)|s([0-9]+)t([0-9]+))$/.exec(word);
    return !!found && found.slice(1).every(function (n) { return n === undefined || +n <= 9999; }) &&
      !(found[3] !== undefined && +found[3] === 0);
  }

  function Parser(text) {
    Reader.call(this, text);
    this.operators = 0;
    this.prefixes = [];
  }
  var parser = Parser.prototype = Object.create(Reader.prototype);

  parser.atEnd = function () {
    for (var text = this.text; this.position < text.length;) {
      var c = text[this.position];
      if (c === '#') {
        var line = text.indexOf('\n', this.position);
        this.position = line < 0 ? text.length : line;
      } else if (c === ' ' || c === '\t' || c === '\n' || c === '\r') ++this.position;
      else return false;
    }
    return true;
  };
  parser.at = function (c) { return !this.atEnd() && this.text[this.position] === c; };
  parser.take = function (c) {
    if (!this.at(c)) return false;
    ++this.position;
    return true;
  };
  parser.unexpected = function (expected) {
    this.atEnd();
    var c = this.text[this.position], hint = '';
    if (c === 's') hint = 'straight-through events leave no event in this dialect; osl writes them <Ts>';
    else if (c >= '0' && c <= '9') hint = 'a lobe number follows its letter directly; a repetition is written {n}';
    else if (c === '*' || c === '+' || c === '?' || c === '{') hint = 'one repetition per event; (...) repeats a repetition';
    else if (c >= 'a' && c <= 'z') hint = 'labels are quoted, as in <RD\'floor\'>; a name inside is written $name';
    this.failAt(this.position, 'found ' + this.found() + '; ' + expected, hint);
  };
  parser.closing = function (closer, opener, opening) {
    if (!this.take(closer))
      this.unexpected('expected \'' + closer + '\' for the \'' + opener + '\' at column ' + (opening + 1));
  };

  parser.run = function () {
    this.readPrefixes();
    if (this.atEnd()) this.failAt(this.position, 'the expression is empty; expected an event such as C');
    var root = this.difference();
    if (!this.atEnd()) this.unexpected('expected an event or the end of the expression');
    return { root: root, prefixes: this.prefixes };
  };
  parser.readPrefixes = function () {
    while (!this.atEnd()) {
      var found = /^[A-Za-z0-9_]+/.exec(this.text.slice(this.position, this.position + 256)), word = found ? found[0] : '';
      var mark = this.text[this.position + word.length];
      if (!word || (mark !== ';' && mark !== ':')) return;
      if (mark === ':') {
        if (word !== 'lpe' || this.prefixes.length)
          this.failAt(this.position, 'found \'' + word + ':\'; expected \'lpe:\' at the very beginning, or an event');
      } else if (prefixNames.indexOf(word) < 0 && !isTechnique(word)) {
        this.failAt(this.position, 'unknown prefix \'' + word + '\'; expected ' + prefixNames.join(', ') +
          ', or a technique such as s2t3 or beyond7');
      } else this.prefixes.push(word);
      this.position += word.length + 1;
    }
  };

  // ---- languages ----

  parser.counted = function (offset) {
    if (++this.operators > Reader.limits.operators)
      this.failAt(offset, 'found more than ' + Reader.limits.operators + ' operators \'&\' and \'-\'');
  };
  parser.difference = function () {
    var left = this.intersection();
    for (var offset = this.position; this.take('-'); offset = this.position) {
      this.counted(offset);
      left = { kind: 'difference', left: left, right: this.intersection() };
    }
    return left;
  };
  parser.intersection = function () {
    var left = this.complement();
    for (var offset = this.position; this.take('&'); offset = this.position) {
      this.counted(offset);
      left = { kind: 'intersection', left: left, right: this.complement() };
    }
    return left;
  };
  parser.complement = function () {
    this.atEnd();
    var offset = this.position;
    if (!this.take('!')) return this.sequence();
    this.enter(offset);
    var child = this.complement();
    --this.depth;
    return { kind: 'complement', child: child };
  };
  parser.sequence = function () {
    var children = [];
    do {
      var item = this.item();
      while (this.take('|')) item = { kind: 'alternatives', children: [item, this.item()] };
      children.push(item);
    } while (!(this.atEnd() || this.at(')') || this.at('-') || this.at('&')));
    return { kind: 'sequence', children: children };
  };
  parser.item = function () {
    this.atEnd();
    var opening = this.position, atom;
    if (this.take('(')) {
      this.enter(opening);
      if (this.at(')')) this.unexpected('\'()\' is empty; expected an event inside');
      atom = this.difference();
      this.closing(')', '(', opening);
      --this.depth;
    } else if (this.take('[')) atom = this.list(opening);
    else atom = { kind: 'event', set: this.event() };
    return this.repetition(atom);
  };
  parser.list = function (opening) {
    var list, excluded = [], children = [];
    this.enter(opening);
    if (this.take('^')) {
      do excluded = excluded.concat(this.event().any); while (!this.atEnd() && !this.at(']'));
      list = { kind: 'event', set: { any: events.plain(universe).any, none: excluded } };
    } else {
      do children.push(this.item()); while (!this.atEnd() && !this.at(']'));
      list = { kind: 'alternatives', children: children };
    }
    this.closing(']', '[', opening);
    --this.depth;
    return list;
  };
  parser.repetition = function (atom) {
    var range = [0, -1];
    if (this.take('+')) range = [1, -1];
    else if (this.take('?')) range = [0, 1];
    else if (this.at('{')) range = this.range();
    else if (!this.take('*')) return atom;
    return { kind: 'repeat', child: atom, min: range[0], max: range[1] };
  };
  parser.range = function () {
    var opening = this.position++;
    this.atEnd();
    var min = this.count(), max = min;
    if (min >= 0 && this.take(',')) {
      this.atEnd();
      max = this.count();
      if (max >= 0 && max < min)
        this.failAt(opening, 'the repetition {' + min + ',' + max + '} counts down; expected {n,m} with n <= m');
    }
    if (min < 0 || !this.take('}')) this.unexpected('expected a repetition {n}, {n,} or {n,m}');
    return [min, max];
  };

  // ---- events ----

  parser.event = function () {
    if (this.at('<')) return this.group();
    if (this.at('\''))
      return { any: [{ cores: universe, labels: [this.labels()], strict: false, extra: 'ignored' }], none: [] };
    var cores = this.type() || this.scatter();
    if (!cores) this.unexpected('expected an event: C L O B V R T D G S U . \'label\' <...> [...] or (...)');
    return events.plain(cores);
  };
  parser.type = function () {
    if (this.atEnd()) return null;
    var c = this.text[this.position];
    if (c !== '.' && 'CRTVBOL'.indexOf(c) < 0) return null;
    ++this.position;
    return c === '.' ? universe : ofType(c === 'L' ? 'LB' : c);
  };
  parser.scatter = function () {
    if (this.atEnd()) return null;
    var offset = this.position, number;
    switch (this.text[offset]) {
      case 'G':
        ++this.position;
        return ofScatter('G', 0);
      case 'D':
        return ofScatter('D', this.lobe('D', 4));
      case 'S':
        return ofScatter('GS', this.lobe('S', 8));
      case 'U':
        number = this.lobe('U', 12);
        if (number === 0) this.failAt(offset, '\'U\' needs its number; expected U1 to U12');
        return events.userCore(number);
      default:
        return null;
    }
  };
  parser.lobe = function (letter, highest) {
    var begin = ++this.position, digits = this.digits();
    if (digits !== '' && (+digits < 1 || +digits > highest))
      this.failAt(begin, 'there is no lobe ' + letter + digits + '; expected ' + letter + '1 to ' + letter + highest);
    return +digits;
  };
  parser.group = function () {
    var opening = this.position++, labels = [];
    if (this.at('>')) this.unexpected('\'<>\' is empty; expected an event type: C L O B V R T or .');
    var cores = this.slot('type');
    if (!this.at('>')) {
      var scatter = this.slot('scatter'), foreign = events.without(scatter, universe), same = function (x) { return !x; };
      // User events are no scene events; <.U2'label'> is the way to give one a label.
      var whole = cores.every(function (x, i) { return x === universe[i]; });
      cores = !foreign.every(same) && whole ? scatter : events.both(cores, scatter);
    }
    while (!this.atEnd() && !this.at('>')) labels.push(this.labels());
    this.closing('>', '<', opening);
    while (labels.length && events.isAny(labels[labels.length - 1])) labels.pop();
    return { any: [{ cores: cores, labels: labels, strict: false, extra: 'ignored' }], none: [] };
  };
  parser.slot = function (kind) {
    if (this.at('\''))
      this.unexpected(kind === 'type' ? 'the first slot is the event type: C L O B V R T or .'
        : 'the second slot is the scattering; write \'.\' there, as in <L.\'key\'>');
    var opening = this.position;
    if (!this.take('[')) return this.slotLetter(kind);
    var negated = this.take('^'), cores = this.slotLetter(kind);
    while (!this.atEnd() && !this.at(']')) cores = events.either(cores, this.slotLetter(kind));
    this.closing(']', '[', opening);
    return negated ? events.without(universe, cores) : cores;
  };
  parser.slotLetter = function (kind) {
    var cores = kind === 'type' || this.at('.') ? this.type() : this.scatter();
    if (!cores)
      this.unexpected(kind === 'type' ? 'expected an event type: C L O B V R T . or [...] of them'
        : 'expected a scattering: D G S D1-D4 S1-S8 . or [...] of them');
    return cores;
  };
  parser.labels = function () {
    this.atEnd();
    var opening = this.position, test = { negated: false, names: [], globs: [] };
    if (this.take('.')) return events.anyLabel();
    if (!this.take('[')) {
      this.label(test);
      return test;
    }
    test.negated = this.take('^');
    do this.label(test); while (!this.atEnd() && !this.at(']'));
    this.closing(']', '[', opening);
    return test;
  };
  parser.label = function (test) {
    if (!this.at('\'')) this.unexpected('expected a quoted label such as \'floor\', \'.\' or [...] of labels');
    var opening = this.position++, text = this.text, label = '';
    while (this.position < text.length && text[this.position] !== '\'') {
      if (text[this.position] === '\\' && this.position + 1 < text.length) label += text[this.position++];
      label += text[this.position++];
    }
    if (this.position >= text.length) this.failAt(opening, 'the quote is not closed; expected a second \'');
    ++this.position;
    if (/[*?]/.test(label)) test.globs.push(label);
    else events.addName(test, label.replace(/\\([\s\S])/g, '$1'));
  };

  return function (text) { return new Parser(text).run(); };
})(raylexReader, raylexEvents);
