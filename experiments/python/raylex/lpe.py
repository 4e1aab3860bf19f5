"""The algebra of light path expressions: proofs, counterexamples, explanations. Needs no scene and no image.

Channels are ``{name: expression}``, pairs, or bare expressions. An expression may begin with ``osl:`` or ``renderman:``
to set its dialect. Every proof is relative to a set of light paths: by default those of any scene, or those of
``scene=`` (a file, a :class:`raylex.Scene`) or ``words=`` (:class:`Words`).
"""

from . import _raylex
from ._raylex import Check, Event, Explanation, Path, PathSet, WhyNot, Words

__all__ = ["Check", "Event", "Explanation", "Path", "PathSet", "WhyNot", "Words", "check", "overview", "equal",
           "contains", "empty", "paths", "match", "why_not", "explain", "parse", "read", "shipped", "words_of"]


def _channel(expression, name="", dialect="renderman"):
    if isinstance(expression, tuple):
        return expression
    if not isinstance(expression, str):
        raise TypeError(f"{expression!r} is not an expression; expected a string such as 'C<RD>L'")
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
    """Returns the light paths that a scene can produce.

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
    """Proves that the channels are a partition, or finds the shortest counterexample.

    :param of: the whole that is split, an expression; by default the beauty, which is every path
    :param what: 'partition' (each path in exactly one channel), 'disjoint' (in at most one), 'covers' (in at least one)
    :returns: Check; true if proved, otherwise ``.counterexample`` is a :class:`Path`
    :raises RaylexError: an expression that cannot be read, with its column

    >>> check({"direct": "C<RD>L", "indirect": "C<RD>[DS]+L"}).counterexample.sentence
    'camera, light'
    """
    whole = None if of is None else _channel(of, "of", dialect)
    return _raylex._check(_channels(channels, dialect), whole, what, _words(words, scene))


def overview(channels, of=None, *, words=None, scene=None, dialect="renderman"):
    """Finds all pairs of channels that share a path, all kinds of paths that no channel has, and all channels with
    paths outside `of`.

    :returns: dict: overlaps [(first, second, Path)], holes [(kind, Path, [Path])], outside [(channel, Path)],
        empty [name], unknown (why holes were not searched for, or '')
    """
    whole = None if of is None else _channel(of, "of", dialect)
    return _raylex._overview(_channels(channels, dialect), whole, _words(words, scene))


def equal(*expressions, words=None, scene=None, dialect="renderman"):
    """Proves that all expressions accept the same paths, or finds a counterexample. Returns Check."""
    return _raylex._equal(_channels(list(expressions), dialect), _words(words, scene))


def contains(outer, inner, *, words=None, scene=None, dialect="renderman"):
    """Proves that `outer` accepts every path of `inner`, or finds a counterexample. Returns Check."""
    return _raylex._contains(_channel(outer, "outer", dialect), _channel(inner, "inner", dialect), _words(words, scene))


def empty(expression, *, words=None, scene=None, dialect="renderman"):
    """Proves that the expression accepts no path. Returns Check; the counterexample is a path that it accepts."""
    return _raylex._empty(_channel(expression, "expression", dialect), _words(words, scene))


def paths(expression, *others, operation="words", samples=5, longest_counted=8, words=None, scene=None,
          dialect="renderman"):
    """Returns paths of an expression, or of several combined by `operation`.

    :param operation: 'words', 'complement', 'intersection', 'union', 'difference'
    :returns: PathSet: the shortest paths, and the number of paths of each length
    """
    return _raylex._paths(operation, _channels([expression, *others], dialect), _words(words, scene), samples,
                          longest_counted)


def _path(path):
    return path if isinstance(path, Path) else Path(path)


def match(expression, path, *, dialect="renderman"):
    """Returns whether the expression accepts the path, a :class:`Path` or text such as 'C,- R,D,floor L,-,key'."""
    return _raylex._match(_channel(expression, "expression", dialect), _path(path))


def why_not(expression, path, *, dialect="renderman"):
    """Finds where a path fails to match and what was expected there. Returns WhyNot."""
    return _raylex._why_not(_channel(expression, "expression", dialect), _path(path))


def explain(expression, *, words=None, scene=None, dialect="renderman"):
    """Explains the expression in words, with sample paths and omissions. Returns Explanation."""
    return _raylex._explain(_channel(expression, "expression", dialect), _words(words, scene))


def parse(expression, *, dialect="renderman"):
    """Parses an expression and returns it with names expanded.

    :raises RaylexError: with ``.column`` of the error
    """
    return explain(expression, dialect=dialect).expression


def read(path, *, format="", dialect="renderman"):
    """Reads the channels of a file: RIB, USD ASCII, rendermn.ini or TOML.

    :param format: 'toml', 'rib', 'usda', 'ini'; '' decides by the file's name and content
    :returns: list of (name, expression, dialect), names in expressions resolved
    """
    import warnings
    channels, told = _raylex._read_channels(str(path), format, dialect)
    for each in told:
        warnings.warn(each, stacklevel=2)
    return channels


def shipped(dialect="renderman"):
    """Returns the shipped partition as {name: expression}."""
    return dict(_raylex._shipped(dialect))
