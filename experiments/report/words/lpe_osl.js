// Light path expressions in a page, third script: texts of the osl dialect to trees, as
// lpe/language/parser/parser_osl.cpp reads them, with OSL's oddities, which stand there.
var raylexOsl = (function (Reader, events) {
  'use strict';
  var none = events.noneSymbol;

  function slotOf(symbol) {
    return 'CLBVTRO'.indexOf(symbol) >= 0 ? 0 : 'DGSs'.indexOf(symbol) >= 0 ? 1 : -1;
  }
  function one(name) { return { negated: false, names: [name], globs: [] }; }
  function united(a, b) {
    function kept(list, other, wanted) {
      return list.filter(function (name) { return (other.indexOf(name) >= 0) === wanted; });
    }
    if (!a.negated && !b.negated) return { negated: false, names: a.names.concat(kept(b.names, a.names, false)), globs: [] };
    if (a.negated && b.negated) return { negated: true, names: kept(a.names, b.names, true), globs: [] };
    var excluded = a.negated ? a.names : b.names, included = a.negated ? b.names : a.names;
    return { negated: true, names: kept(excluded, included, false), globs: [] };
  }
  // Alternatives of symbol sequences; all single symbols among them are one test, the first.
  function addAlternatives(list, more) {
    more.forEach(function (sequence) {
      if (sequence.length === 1 && list.length && list[0].length === 1) list[0] = [united(list[0][0], sequence[0])];
      else if (sequence.length === 1) list.unshift(sequence);
      else list.push(sequence);
    });
  }
  function eventsOf(sequences, open) {
    return { none: [], any: sequences.map(function (symbols) {
      var takesType = {}, takesScatter = {}, i;
      for (i = 0; i < events.types.length; ++i)
        takesType[events.types[i]] = events.labelMatches(symbols[0], events.types[i]);
      for (i = 0; i < events.scatters.length; ++i)
        takesScatter[events.scatters[i]] = events.labelMatches(symbols[1], i === 0 ? none : events.scatters[i]);
      var cores = events.cores(function (type, scatter) { return takesType[type] && takesScatter[scatter]; });
      var labels = symbols.slice(2).map(function (test) {  // a label that is there is never NONE
        return { negated: test.negated, globs: [], names: test.names.filter(function (name) { return name !== none; }) };
      });
      return { cores: cores, labels: labels, strict: true, extra: open ? 'unreserved' : 'refused' };
    }) };
  }

  function Parser(text) { Reader.call(this, text); }
  var parser = Parser.prototype = Object.create(Reader.prototype);

  parser.at = function (c) { return this.text[this.position] === c; };
  parser.atEnd = function () { return this.position >= this.text.length; };
  parser.closing = function (closer, opener, opening) {
    if (!this.at(closer))
      this.failAt(this.position, 'found ' + this.found() + '; expected \'' + closer + '\' for the \'' + opener +
        '\' at column ' + (opening + 1));
    ++this.position;
  };

  // ---- whole events ----

  parser.run = function () {
    if (this.atEnd()) this.failAt(0, 'the expression is empty; expected an event such as C');
    return { root: this.at('(') ? this.parenthesis() : this.items(''), prefixes: [] };
  };
  parser.items = function (closer) {
    var children = [], canJoin = false, joinNext = false;
    while (!this.atEnd() && !this.at(closer)) {
      if (this.at('|')) {
        if (!canJoin) this.failAt(this.position, '\'|\' has nothing on its left; expected an event before it');
        ++this.position;
        if (this.atEnd() || this.at(closer))
          this.failAt(this.position, '\'|\' has nothing on its right; expected an event after it');
        canJoin = false;
        joinNext = true;
        continue;
      }
      var item = this.item();
      children.push(joinNext ? { kind: 'alternatives', children: [children.pop(), item] } : item);
      joinNext = false;
      canJoin = true;
    }
    return { kind: 'sequence', children: children };
  };
  parser.item = function () {
    var atom = this.at('(') ? this.parenthesis() : this.at('[') ? this.list()
      : { kind: 'event', set: this.at('<') ? this.group() : this.letter() };
    return this.modifier(atom);
  };
  parser.parenthesis = function () {
    var opening = this.position++;
    this.enter(opening);
    var inner = this.items(')');
    if (this.atEnd()) this.closing(')', '(', opening);
    if (!inner.children.length) this.failAt(this.position, '\'()\' is empty; expected an event inside');
    ++this.position;
    --this.depth;
    return inner;
  };
  parser.list = function () {
    var opening = this.position++, children = [];
    if (this.at('^')) {
      var excluded = this.negatedSymbols(opening), symbols = [events.anyLabel(), events.anyLabel()];
      symbols[excluded.slot] = excluded.test;
      return { kind: 'event', set: eventsOf([symbols], true) };
    }
    this.enter(opening);
    while (!this.atEnd() && !this.at(']')) children.push(this.item());
    this.closing(']', '[', opening);
    --this.depth;
    return { kind: 'alternatives', children: children };
  };
  parser.modifier = function (atom) {
    var range = [0, -1];
    if (this.at('{')) range = this.range();
    else if (this.at('*') || this.at('+')) range[0] = this.text[this.position++] === '+' ? 1 : 0;
    else return atom;
    return { kind: 'repeat', child: atom, min: range[0], max: range[1] };
  };
  parser.range = function () {
    var opening = this.position++, min = this.count(), max = min;
    if (min >= 0 && this.at(',')) {
      ++this.position;
      max = this.count();
      max = max < 0 ? -1 : Math.max(min, max);
    }
    if (min < 0 || !this.at('}'))
      this.failAt(this.position, 'found ' + this.found() + ' in the repetition that starts at column ' + (opening + 1) +
        '; expected {n}, {n,} or {n,m}');
    ++this.position;
    return [min, max];
  };
  parser.letter = function () {
    var offset = this.position, symbol = this.symbol(), symbols = [events.anyLabel(), events.anyLabel()], slot, hint = '';
    if (symbol.quoted) symbols.push(one(symbol.name));
    else if (symbol.name !== '.') {
      slot = slotOf(symbol.name);
      this.position = slot < 0 ? offset : this.position;
      if (slot < 0 && /[ \t\n]/.test(this.text[offset])) hint = 'the osl dialect has no blanks between events';
      if (slot < 0)
        this.failAt(offset, 'found ' + this.found() + '; expected an event: C L B V T R O D G S s . \'label\' <...> ' +
          '[...] or (...)', hint);
      symbols[slot] = one(symbol.name);
    }
    return eventsOf([symbols], true);
  };

  // ---- symbols inside <...> ----

  parser.symbol = function () {
    var opening = this.position;
    if (!this.at('\'')) {
      ++this.position;
      return { name: this.text[opening] === 'x' ? none : this.text[opening], quoted: false };
    }
    var end = this.text.indexOf('\'', opening + 1);
    if (end < 0) this.failAt(opening, 'the quote is not closed; expected a second \'');
    this.position = end + 1;
    return { name: this.text.slice(opening + 1, end), quoted: true };
  };
  // [^...] behind its '[': what it excludes, and the slot that the last of it belongs to.
  parser.negatedSymbols = function (opening) {
    var test = events.anyLabel(), slot = -1;
    ++this.position;
    while (!this.atEnd() && !this.at(']')) {
      var offset = this.position, symbol = this.symbol();
      slot = symbol.quoted ? 2 : slotOf(symbol.name);
      if (slot < 0)
        this.failAt(offset, 'found \'' + this.text[offset] + '\' inside [^...]; expected letters of C L B V T R O D G S s ' +
          'or quoted labels');
      events.addName(test, symbol.name);
    }
    if (!this.atEnd() && slot < 0)
      this.failAt(this.position, '\'[^]\' is empty; expected letters or quoted labels to exclude');
    this.closing(']', '[', opening);
    return { test: test, slot: slot };
  };
  parser.group = function () {
    var opening = this.position++, sequences = [[]], items = 0;
    while (!this.atEnd() && !this.at('>')) {
      var offset = this.position;
      sequences = this.concatenated(sequences, this.symbolItem(), offset);
      ++items;
    }
    this.closing('>', '<', opening);
    sequences.forEach(function (sequence) {
      for (var missing = Math.min(items, 2); missing < 2; ++missing) sequence.push(events.anyLabel());
    });
    return eventsOf(sequences, items < 2 + 5);
  };
  parser.symbolItem = function () {
    var item, symbol;
    if (this.at('<')) this.failAt(this.position, 'found \'<\' inside <...>; groups do not nest');
    if (this.at('(')) item = this.symbolParenthesis();
    else if (this.at('[')) item = this.symbolList();
    else {
      symbol = this.symbol();
      item = [[symbol.name === '.' ? events.anyLabel() : one(symbol.name)]];  // a quoted '.' is the wildcard too
    }
    if (this.at('*') || this.at('+') || this.at('{'))
      this.failAt(this.position, 'found ' + this.found() + '; repetitions are not allowed inside <...>');
    return item;
  };
  parser.symbolParenthesis = function () {
    var opening = this.position++, whole = [[]], last = null, joining = false;
    this.enter(opening);
    while (!this.atEnd() && !this.at(')')) {
      var offset = this.position;
      if (this.at('|')) {
        if (!last || joining) this.failAt(offset, '\'|\' has nothing on its left; expected a symbol before it');
        ++this.position;
        joining = true;
        continue;
      }
      var item = this.symbolItem();
      if (joining) addAlternatives(last, item);
      else {
        whole = last ? this.concatenated(whole, last, offset) : whole;
        last = item;
      }
      joining = false;
    }
    if (joining || !last) this.failAt(this.position, 'found ' + this.found() + '; expected a symbol');
    this.closing(')', '(', opening);
    --this.depth;
    return this.concatenated(whole, last, opening);
  };
  parser.symbolList = function () {
    var opening = this.position++, list = [];
    if (this.at('^')) return [[this.negatedSymbols(opening).test]];
    this.enter(opening);
    while (!this.atEnd() && !this.at(']')) addAlternatives(list, this.symbolItem());
    this.closing(']', '[', opening);
    --this.depth;
    return list;
  };
  parser.concatenated = function (left, right, offset) {
    var result = [];
    if (left.length * right.length > Reader.limits.variants)
      this.failAt(offset, 'this <...> stands for more than ' + Reader.limits.variants + ' symbol sequences');
    left.forEach(function (head) { right.forEach(function (tail) { result.push(head.concat(tail)); }); });
    return result;
  };

  return function (text) { return new Parser(text).run(); };
})(raylexReader, raylexEvents);
