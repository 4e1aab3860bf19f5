// Light path expressions in a page, last script: from trees to tables, and which words of an atlas they take.
//
// A state is a language: what may still follow. It is the derivative of the state before it by the event read
// (Brzozowski, Derivatives of Regular Expressions, JACM 1964), languages that are written alike being one, so that a
// table grows row by row as words ask for it. Columns are kinds of events that no predicate of the expression tells
// apart. Complements and intersections are what they are elsewhere.
var raylexLpe = (function (Reader, readRenderman, readOsl, events) {
  'use strict';
  var tooLarge = 'the expression is too large to be followed in a page; raylex ask takes it';
  function refuse(message, hint, offset) { throw { refused: message, hint: hint || '', offset: offset || 0 }; }

  // ---- names of the renderman dialect (lpe/language/names.h); macros of one's own are no matter of a page ----

  function skipBlank(text, at) { return at + /^(?:[ \t\r\n]|#[^\n]*)*/.exec(text.slice(at))[0].length; }
  function headOf(text) {
    var head = { mark: 0, body: 0, prefix: '' }, at = skipBlank(text, 0), found;
    while ((found = /^([A-Za-z_][A-Za-z_0-9]*)([;:])/.exec(text.slice(at)))) {
      if (found[2] === ':' && (found[1] !== 'lpe' || head.body)) break;
      if (found[2] === ':') head.mark = at + found[0].length;
      else head.prefix = head.prefix || found[1];
      head.body = at + found[0].length;
      at = skipBlank(text, head.body);
    }
    return head;
  }
  function Names(table) { this.table = table; }
  Names.prototype.find = function (name) {
    if (this.table.hasOwnProperty(name)) return { text: this.table[name], group: '' };
    for (var bar = name.lastIndexOf('_'); bar > 0; bar = name.lastIndexOf('_', bar - 1)) {
      var stem = name.slice(0, bar);
      if (bar + 1 < name.length && this.table.hasOwnProperty(stem))
        return { text: this.table[stem], group: name.slice(bar + 1) };
    }
    return null;
  };
  Names.prototype.unknown = function (name) {
    refuse('unknown name \'' + name + '\'; expected an expression, or one of: ' + Object.keys(this.table).join(', '));
  };
  // What a text without 'lpe:' and prefixes says, names replaced; `<L.>` becomes the light group.
  Names.prototype.body = function (text, group) {
    var self = this, blank = '(?:[ \\t\\r\\n]|#[^\\n]*)*';
    var piece = new RegExp('\'(?:\\\\[\\s\\S]|[^\'\\\\])*\'?|#[^\\n]*|\\$(\\{?)([A-Za-z_0-9]*)(\\}?)|' +
      '<' + blank + 'L' + blank + '\\.' + blank + '>', 'g');
    return text.replace(piece, function (all, open, name, close) {
      if (all[0] === '<') return group ? '<L.\'' + group.replace(/[\'\\*?]/g, '\\$&') + '\'>' : all;
      if (all[0] !== '$') return all;
      if (!/^[A-Za-z_]/.test(name)) refuse('expected a name after \'$\', as in $diffuse or ${diffuse}');
      if (open && !close) refuse('expected \'}\' after the name \'' + name + '\'');
      var known = self.find(name) || self.unknown(name);
      if (headOf(known.text).prefix) refuse('\'' + name + '\' carries a prefix, so it can only stand for a whole channel');
      return '(' + self.body(known.text, known.group || group) + ')' + (open ? '' : close);
    });
  };
  Names.prototype.whole = function (text) {
    var head = headOf(text), begin = skipBlank(text, head.body), found = /^[A-Za-z_][A-Za-z_0-9]*/.exec(text.slice(begin));
    var name = found && skipBlank(text, begin + found[0].length) === text.length ? found[0] : '';
    var known = name ? this.find(name) : null;
    if (known) {
      var inner = headOf(known.text);
      return text.slice(0, begin) + known.text.slice(inner.mark, inner.body) +
        this.body(known.text.slice(inner.body), known.group);
    }
    if (/[a-z][a-z]/.test(name)) this.unknown(name);
    return text.slice(0, head.body) + this.body(text.slice(head.body), '');
  };

  // ---- languages, each once ----

  function Languages(alphabet) {
    this.alphabet = alphabet;  // the events of the words within which '!' complements
    this.sets = [];
    this.setOf = {};
    this.nodes = [];
    this.nodeOf = {};
    this.none = this.made('none', 'none', { nullable: false });
    this.empty = this.made('empty', 'empty', { nullable: true });
    this.columns = [];
    this.columnOf = {};
  }
  Languages.prototype.made = function (key, kind, node) {
    if (this.nodeOf.hasOwnProperty(key)) return this.nodeOf[key];
    if (this.nodes.length >= 200000) refuse(tooLarge);
    node.kind = kind;
    node.id = this.nodes.length;
    node.next = [];
    this.nodes.push(node);
    return (this.nodeOf[key] = node);
  };
  Languages.prototype.one = function (set) {
    var key = JSON.stringify(set);
    if (!this.setOf.hasOwnProperty(key)) this.setOf[key] = this.sets.push(set) - 1;
    return this.made('=' + this.setOf[key], 'one', { set: this.setOf[key], nullable: false });
  };
  Languages.prototype.sequence = function (a, b) {
    var self = this;
    if (a === this.none || b === this.none) return this.none;
    if (a === this.empty) return b;
    if (b === this.empty) return a;
    if (a.kind === 'sequence') return this.sequence(a.a, this.sequence(a.b, b));
    // Alternatives stay outermost: so a state has no more of them than the expression has places.
    if (a.kind === 'any') return this.any(a.list.map(function (each) { return self.sequence(each, b); }));
    return this.made('.' + a.id + ',' + b.id, 'sequence', { a: a, b: b, nullable: a.nullable && b.nullable });
  };
  Languages.prototype.any = function (list) {
    var seen = {}, flat = [];
    list.forEach(function add(node) {
      if (node.kind === 'any') node.list.forEach(add);
      else if (node.kind !== 'none' && !seen[node.id]) {
        seen[node.id] = true;
        flat.push(node);
      }
    });
    if (!flat.length) return this.none;
    if (flat.length === 1) return flat[0];
    flat.sort(function (a, b) { return a.id - b.id; });
    var key = '|' + flat.map(function (node) { return node.id; }).join(',');
    return this.made(key, 'any', { list: flat, nullable: flat.some(function (node) { return node.nullable; }) });
  };
  Languages.prototype.both = function (a, b) {
    if (a === this.none || b === this.none) return this.none;
    if (a === b) return a;
    if (a.id > b.id) return this.both(b, a);
    return this.made('&' + a.id + ',' + b.id, 'both', { a: a, b: b, nullable: a.nullable && b.nullable });
  };
  Languages.prototype.less = function (a, b) {
    if (a === this.none || b === this.none) return a;
    if (a === b) return this.none;
    return this.made('-' + a.id + ',' + b.id, 'less', { a: a, b: b, nullable: a.nullable && !b.nullable });
  };
  Languages.prototype.not = function (a) {
    return this.made('!' + a.id, 'not', { a: a, nullable: !a.nullable });
  };
  Languages.prototype.repeat = function (a, min, max) {
    if (max === 0 || a === this.empty) return this.empty;
    if (a === this.none) return min === 0 ? this.empty : this.none;
    if (min === 1 && max === 1) return a;
    return this.made('*' + a.id + ',' + min + ',' + max, 'repeat',
      { a: a, min: min, max: max, nullable: min === 0 || a.nullable });
  };
  Languages.prototype.of = function (tree) {
    var self = this, whole, i;
    switch (tree.kind) {
      case 'event':
        return this.one(tree.set);
      case 'sequence':
        for (whole = this.empty, i = tree.children.length; i-- > 0;) whole = this.sequence(this.of(tree.children[i]), whole);
        return whole;
      case 'alternatives':
        return this.any(tree.children.map(function (child) { return self.of(child); }));
      case 'repeat':
        return this.repeat(this.of(tree.child), tree.min, tree.max);
      case 'complement':
        return this.not(this.of(tree.child));
      case 'intersection':
        return this.both(this.of(tree.left), this.of(tree.right));
      default:
        return this.less(this.of(tree.left), this.of(tree.right));
    }
  };

  // ---- the table ----

  Languages.prototype.column = function (event) {
    var inside = events.setMatches(this.alphabet, event);
    var bits = this.sets.map(function (set) { return events.setMatches(set, event); });
    var key = (inside ? '1' : '0') + bits.map(Number).join('');
    if (!this.columnOf.hasOwnProperty(key)) this.columnOf[key] = this.columns.push({ inside: inside, bits: bits }) - 1;
    return this.columnOf[key];
  };
  Languages.prototype.after = function (node, column) {
    if (node.next[column] === undefined) node.next[column] = this.derivative(node, column);
    return node.next[column];
  };
  Languages.prototype.derivative = function (node, column) {
    var self = this, rest;
    function after(each) { return self.after(each, column); }
    switch (node.kind) {
      case 'one':
        return this.columns[column].bits[node.set] ? this.empty : this.none;
      case 'sequence':
        rest = this.sequence(after(node.a), node.b);
        return node.a.nullable ? this.any([rest, after(node.b)]) : rest;
      case 'any':
        return this.any(node.list.map(after));
      case 'both':
        return this.both(after(node.a), after(node.b));
      case 'less':
        return this.less(after(node.a), after(node.b));
      case 'not':
        return this.columns[column].inside ? this.not(after(node.a)) : this.none;
      case 'repeat':
        rest = this.repeat(node.a, Math.max(node.min - 1, 0), node.max < 0 ? -1 : node.max - 1);
        return this.sequence(after(node.a), rest);
      default:
        return this.none;
    }
  };

  function guarded(work) {
    try {
      return work();
    } catch (failed) {
      if (failed && failed.refused !== undefined) throw failed;
      if (failed instanceof RangeError) refuse(tooLarge);  // the interpreter's stack
      throw failed;
    }
  }

  // `text` in bytes, `names` from name to expression. What it refuses is thrown as { refused, hint, offset }.
  function compile(text, dialect, names) {
    return guarded(function () {
      var renderman = dialect === 'renderman';
      if (text.length > Reader.limits.bytes)
        refuse('the expression has ' + text.length + ' bytes; at most ' + Reader.limits.bytes + ' are read');
      var expanded = renderman ? new Names(names || {}).whole(text) : text;
      var read, languages = new Languages(events.plain(events.wildcard[dialect]));
      try {
        read = renderman ? readRenderman(expanded) : readOsl(expanded);
      } catch (failed) {
        if (failed && expanded !== text) failed.offset = 0;  // a place in what the names stand for
        throw failed;
      }
      return { prefixes: read.prefixes, start: languages.of(read.root),
        // The state behind an event; light straight through leaves no event in renderman.
        move: function (state, event) {
          return renderman && events.isStraight(event) ? state : languages.after(state, languages.column(event));
        } };
    });
  }
  function match(text, dialect, names, path) {
    return guarded(function () {
      var program = compile(text, dialect, names);
      return path.reduce(program.move, program.start).nullable;
    });
  }

  // ---- words of an atlas, which may stand for several paths (experiments/atlas/word_answers.h) ----

  // Of each word 2: all its light is the expression's, 1: some of it may be, 0: none. `table`: { events, letters, words },
  // letter -1 being one scattering or more.
  function answers(program, table) {
    return guarded(function () {
      var ofLetter = {}, sets = [], setOf = {}, move = program.move;
      var scatterings = table.events.filter(function (event) { return 'RTV'.indexOf(event.type) >= 0; });
      table.events.forEach(function (event, i) {
        var letter = table.letters[i];
        (ofLetter[letter] = ofLetter[letter] || []).push(event);
      });
      function setNumber(states) {  // a set of states, by number
        var seen = {}, list = states.filter(function (state) { return seen[state.id] ? false : (seen[state.id] = true); });
        list.sort(function (a, b) { return a.id - b.id; });
        var key = list.map(function (state) { return state.id; }).join(',');
        if (!setOf.hasOwnProperty(key)) setOf[key] = sets.push({ states: list, next: {} }) - 1;
        return setOf[key];
      }
      function moved(states, through) {
        var reached = [];
        states.forEach(function (state) { through.forEach(function (event) { reached.push(move(state, event)); }); });
        return setNumber(reached);
      }
      function beyond(states) {
        var now = moved(states, scatterings);
        for (;;) {
          var wider = setNumber(sets[now].states.concat(sets[moved(sets[now].states, scatterings)].states));
          if (wider === now) return now;
          now = wider;
        }
      }
      var camera = { type: 'C', scatter: 'x', number: 0, labels: [] };
      var first = setNumber([move(program.start, camera)]);
      return table.words.map(function (word) {
        var set = word.reduce(function (from, letter) {
          var next = sets[from].next;
          if (next[letter] === undefined)
            next[letter] = letter < 0 ? beyond(sets[from].states) : moved(sets[from].states, ofLetter[letter]);
          return next[letter];
        }, first);
        var states = sets[set].states, taken = states.filter(function (state) { return state.nullable; }).length;
        return taken === states.length ? 2 : taken > 0 ? 1 : 0;
      });
    });
  }

  return { compile: compile, match: match, answers: answers, bytes: events.bytes, characters: events.characters };
})(raylexReader, raylexRenderman, raylexOsl, raylexEvents);
