"""The algebra of light path expressions: proofs, counterexamples, meanings. No scene and no image is needed.

Channels are given as ``{name: expression}``, as pairs, or as bare expressions. An expression may begin with ``osl:`` or
``renderman:`` to say its own dialect. Every proof is relative to the light paths that a scene can produce: all of them,
or with ``scene=`` (a file, a :class:`raylex.Scene`) or ``words=`` (:class:`Words`) those that remain.
"""

from . import _raylex
from ._raylex import Check, Event, Explanation, Path, PathSet, WhyNot, Words

__all__ = ["Check", "Event", "Explanation", "Path", "PathSet", "WhyNot", "Words", "check", "overview", "equal",
           "contains", "empty", "paths", "match", "why_not", "explain", "parse", "read", "shipped", "words_of"]


def _channel(expression, name="", dialect="renderman"):
    if isinstance(expression, tuple):
        return expression
    if not isinstance(expression, str):
        raise TypeError(f"{expression!r} is no expression; expected a string such as 'C<RD>L'")
    for known in ("osl", "renderman"):
        if expression.startswith(known + ":"):
            return (name, expression[len(known) + 1:], known)
    return (name, expression, dialect)


def _channels(channels, dialect):
    if isinstance(channels, dict):
        channels = channels.items()
    elif isinstance(channels, str):
        channels = [(channels, channels)]
    result = []
    for each in channels:
        if isinstance(each, str):
            result.append(_channel(each, each, dialect))
        elif len(each) == 3:
            result.append(tuple(each))
        else:
            result.append(_channel(each[1], each[0], dialect))
    return result


def words_of(scene):
    """The light paths that a scene can produce.

    :param scene: a pbrt-v4 file, a TOML job, or a :class:`raylex.Scene`
    :returns: Words
    """
    return scene.words() if hasattr(scene, "words") else _raylex._words_of_file(str(scene))


def _words(words, scene):
    if words is not None and scene is not None:
        raise TypeError("both words= and scene= were given; expected one of them")
    if scene is not None:
        return words_of(scene)
    return words if words is not None else Words()


def check(channels, of=None, *, what="partition", words=None, scene=None, dialect="renderman"):
    """Proves that the channels are a partition, or finds the shortest light path that shows the contrary.

    :param of: what is split, an expression; by default the beauty, every path
    :param what: 'partition' (each path in exactly one channel), 'disjoint' (none in two), 'covers' (each in some)
    :returns: Check; it is true when proved, else ``.counterexample`` is a :class:`Path`
    :raises RaylexError: an expression that cannot be read, with its column

    >>> check({"direct": "C<RD>L", "indirect": "C<RD>[DS]+L"}).counterexample.sentence
    'camera, light'
    """
    whole = None if of is None else _channel(of, "of", dialect)
    return _raylex._check(_channels(channels, dialect), whole, what, _words(words, scene))


def overview(channels, of=None, *, words=None, scene=None, dialect="renderman"):
    """Every pair of channels that share a path, every kind of path that none has, every channel that goes outside.

    :returns: dict: overlaps [(first, second, Path)], holes [(kind, Path, [Path])], outside [(channel, Path)],
        empty [name], unknown (why holes were not looked for, '' else)
    """
    whole = None if of is None else _channel(of, "of", dialect)
    return _raylex._overview(_channels(channels, dialect), whole, _words(words, scene))


def equal(*expressions, words=None, scene=None, dialect="renderman"):
    """Whether all expressions accept the same paths. Returns Check."""
    return _raylex._equal(_channels(list(expressions), dialect), _words(words, scene))


def contains(outer, inner, *, words=None, scene=None, dialect="renderman"):
    """Whether `outer` accepts every path that `inner` does. Returns Check."""
    return _raylex._contains(_channel(outer, "outer", dialect), _channel(inner, "inner", dialect), _words(words, scene))


def empty(expression, *, words=None, scene=None, dialect="renderman"):
    """Whether the expression accepts no path at all. Returns Check; the counterexample is a path it accepts."""
    return _raylex._empty(_channel(expression, "expression", dialect), _words(words, scene))


def paths(expression, *others, operation="words", samples=5, longest_counted=8, words=None, scene=None,
          dialect="renderman"):
    """Paths of an expression, or of what `operation` makes of several.

    :param operation: 'words', 'complement', 'intersection', 'union', 'difference'
    :returns: PathSet: the shortest paths, how many there are of each length
    """
    return _raylex._paths(operation, _channels([expression, *others], dialect), _words(words, scene), samples,
                          longest_counted)


def _path(path):
    return path if isinstance(path, Path) else Path(path)


def match(expression, path, *, dialect="renderman"):
    """Whether the expression accepts the path, a :class:`Path` or text such as 'C,- R,D,floor L,-,key'."""
    return _raylex._match(_channel(expression, "expression", dialect), _path(path))


def why_not(expression, path, *, dialect="renderman"):
    """How far the path matches and what was wanted next. Returns WhyNot."""
    return _raylex._why_not(_channel(expression, "expression", dialect), _path(path))


def explain(expression, *, words=None, scene=None, dialect="renderman"):
    """The expression in words, with sample paths and what it leaves out. Returns Explanation."""
    return _raylex._explain(_channel(expression, "expression", dialect), _words(words, scene))


def parse(expression, *, dialect="renderman"):
    """Reads an expression, and gives it back with names replaced by what they stand for.

    :raises RaylexError: with ``.column`` where it cannot be read
    """
    return explain(expression, dialect=dialect).expression


def read(path, *, format="", dialect="renderman"):
    """The channels of a file: RIB, USD ASCII, rendermn.ini or TOML.

    :param format: 'toml', 'rib', 'usda', 'ini'; '' goes by the file's name and content
    :returns: list of (name, expression, dialect), names in expressions resolved
    """
    import warnings
    channels, told = _raylex._read_channels(str(path), format, dialect)
    for each in told:
        warnings.warn(each, stacklevel=2)
    return channels


def shipped(dialect="renderman"):
    """The shipped partition as {name: expression}."""
    return dict(_raylex._shipped(dialect))
