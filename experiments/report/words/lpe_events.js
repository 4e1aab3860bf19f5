// Light path expressions in a page, first of four scripts: predicates on single events, as lpe/language/pattern.h has
// them. ES5 throughout, so that the tests run the very scripts of the page in an embedded interpreter.
//
// Texts are strings of bytes (UTF-8, a byte a character): expressions speak of bytes, and so do these scripts.
// An event is { type, scatter, number, labels }: type one of CRTVLBO or 'U' for user events, scatter x (none) D G S s.
var raylexEvents = (function () {
  'use strict';
  var types = 'CRTVLBO', scatters = 'xDGSs', lobeNumbers = 9, userNumbers = 13;
  var userBase = types.length * scatters.length * lobeNumbers;
  var noneSymbol = '\'';  // OSL's unquoted x: equal to no text, for quoted texts hold no quote
  var reserved = ['B', 'C', 'D', 'G', 'L', 'O', 'R', 'S', 'T', 'V', 's'];

  function bytes(text) {
    return unescape(encodeURIComponent(text.replace(/[\ud800-\udfff]/g, function (half, at) {
      var code = half.charCodeAt(0), next = text.charCodeAt(at + 1), before = text.charCodeAt(at - 1);
      var paired = code < 0xdc00 ? next >= 0xdc00 && next < 0xe000 : before >= 0xd800 && before < 0xdc00;
      return paired ? half : '\ufffd';
    })));
  }
  function characters(text) {
    try {
      return decodeURIComponent(escape(text));
    } catch (broken) {
      return text;
    }
  }

  // ---- cores: (type, scatter, lobe number) ----

  function coreOf(event) {
    if (event.type === 'U') return userBase + (event.number < userNumbers ? event.number : 0);
    var number = event.number < lobeNumbers ? event.number : 0;
    return (types.indexOf(event.type) * scatters.length + scatters.indexOf(event.scatter)) * lobeNumbers + number;
  }
  // The set of the cores that test(type, scatter, number) takes, an array of booleans; user events have their own.
  function cores(test) {
    var set = [], t, s, n;
    for (t = 0; t < types.length; ++t)
      for (s = 0; s < scatters.length; ++s)
        for (n = 0; n < lobeNumbers; ++n) set.push(!!test(types[t], scatters[s], n));
    for (n = 0; n < userNumbers; ++n) set.push(false);
    return set;
  }
  function userCore(number) {
    var set = cores(function () { return false; });
    set[userBase + number] = true;
    return set;
  }
  function combined(a, b, join) {
    return a.map(function (one, i) { return join(one, b[i]); });
  }
  function both(a, b) { return combined(a, b, function (x, y) { return x && y; }); }
  function either(a, b) { return combined(a, b, function (x, y) { return x || y; }); }
  function without(a, b) { return combined(a, b, function (x, y) { return x && !y; }); }

  var straight = cores(function (type, scatter) { return type === 'T' && scatter === 's'; });
  var wildcard = { osl: cores(function () { return true; }) };
  wildcard.renderman = without(wildcard.osl, straight);

  // ---- labels ----

  function anyLabel() { return { negated: true, names: [], globs: [] }; }
  function isAny(test) { return test.negated && !test.names.length && !test.globs.length; }
  function addName(test, name) {
    if (test.names.indexOf(name) < 0) test.names.push(name);
  }
  function isContinuation(byte) { return (byte.charCodeAt(0) & 0xc0) === 0x80; }

  function globSteps(glob) {
    var steps = [], i;
    for (i = 0; i < glob.length; ++i) {
      if (glob[i] === '*') steps.push({ many: true });
      else if (glob[i] === '?') steps.push({ one: true });
      else {
        if (glob[i] === '\\' && i + 1 < glob.length) ++i;
        steps.push({ byte: glob[i] });
      }
    }
    return steps;
  }
  function globMatches(glob, label) {
    var steps = globSteps(glob), here = {};
    function add(places, at) {
      for (;; ++at) {
        places[at] = true;
        if (at >= steps.length || !steps[at].many) return;
      }
    }
    add(here, 0);
    for (var i = 0; i < label.length; ++i) {
      var byte = label[i], next = {};
      for (var key in here) {
        var at = +key, step = steps[at];
        if (at > 0 && steps[at - 1].one && isContinuation(byte)) add(next, at);  // the rest of what '?' took
        if (!step) continue;
        if (step.many) add(next, at);
        else if (step.one ? !isContinuation(byte) : step.byte === byte) add(next, at + 1);
      }
      here = next;
    }
    return here[steps.length] === true;
  }
  function labelMatches(test, label) {
    var listed = test.names.indexOf(label) >= 0 ||
      test.globs.some(function (glob) { return globMatches(glob, label); });
    return listed !== test.negated;
  }

  // ---- patterns and sets ----

  // A pattern is { cores, labels, strict, extra }: strict refuses labels that an event lacks, which otherwise are
  // empty; extra is 'ignored', 'unreserved' or 'refused', for labels beyond those tested.
  function patternMatches(pattern, event) {
    if (!pattern.cores[coreOf(event)]) return false;
    var labels = event.labels, count = labels.length, slot;
    while (count > 0 && labels[count - 1] === '') --count;
    for (slot = 0; slot < pattern.labels.length; ++slot) {
      if (slot >= count && pattern.strict) return false;
      if (!labelMatches(pattern.labels[slot], slot < count ? labels[slot] : '')) return false;
    }
    for (slot = pattern.labels.length; slot < count && pattern.extra !== 'ignored'; ++slot)
      if (pattern.extra === 'refused' || reserved.indexOf(labels[slot]) >= 0) return false;
    return true;
  }
  // A set is { any, none }: events that some pattern of `any` matches and none of `none` does.
  function setMatches(set, event) {
    function matches(pattern) { return patternMatches(pattern, event); }
    return set.any.some(matches) && !set.none.some(matches);
  }
  function plain(coreSet) {
    return { any: [{ cores: coreSet, labels: [], strict: false, extra: 'ignored' }], none: [] };
  }

  return { types: types, scatters: scatters, noneSymbol: noneSymbol, bytes: bytes, characters: characters, cores: cores,
    userCore: userCore, both: both, either: either, without: without, straight: straight, wildcard: wildcard,
    anyLabel: anyLabel, isAny: isAny, addName: addName, labelMatches: labelMatches, setMatches: setMatches, plain: plain,
    isStraight: function (event) { return straight[coreOf(event)]; } };
})();
