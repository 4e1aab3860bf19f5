"""Studies: methods x scenes x budgets from one config, run, read and judged."""

import json
import os

from . import _raylex


class Row(dict):
    """A row with named columns: row["variant"] or row.variant."""

    def __getattr__(self, name):
        if name in self:
            return self[name]
        raise AttributeError(f"there is no column {name!r}; expected one of: {', '.join(self)}")


class Rows(list):
    """A list of :class:`Row`, for where pandas is not installed. rows["variant"] is a column, print(rows) a table."""

    def __getitem__(self, key):
        return [row.get(key) for row in self] if isinstance(key, str) else super().__getitem__(key)

    def __repr__(self):
        names = list(dict.fromkeys(name for row in self for name in row))
        table = [names, *([f"{each:.4g}" if isinstance(each, float) else str(each)
                           for each in map(row.get, names)] for row in self)]
        widths = [max(map(len, column)) for column in zip(*table)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in table)


class Results:
    """A directory of results. ``print(results)`` summarises it."""

    def __init__(self, directory):
        self.directory = os.fspath(directory)
        self._judged = None

    def cells(self):
        """Every cell, done or failed, a row each: a pandas frame where pandas is installed, else :class:`Rows`.

        Columns: id, scene, method, budget_kind, budget, replicate, seed, failed, failure, samples_per_pixel,
        wall_seconds, cpu_seconds, rays, directory, and the swept settings.
        """
        return _frame(_raylex._cells(self.directory))

    def errors(self):
        """The error of every cell, channel and region against its reference by every metric, with times: as cells()."""
        import csv
        import io
        rows = list(csv.DictReader(io.StringIO(self._study()["csv"])))
        return _frame([{key: _number(value) for key, value in row.items()} for row in rows])

    def records(self, kind):
        """What results.jsonl says of this kind, a list of dicts: 'bias', 'slope', 'time_to_error', 'split', ..."""
        rows = [json.loads(line) for line in self._study()["jsonl"].splitlines()]
        return [row for row in rows if row["kind"] == kind]

    def bias(self):
        """Whether each method converges to the reference, channel by channel: as cells(). 'convicts' says that it does
        not: its images differ, at the level of 1 % for all tests together, and neither rare bright samples
        ('heavy_tail') nor paths that it says it leaves out ('omitted') are why. 'detectable_whole' is the smallest
        relative bias that would have been found."""
        return _frame(self.records("bias"))

    def first_words(self):
        """The shortest light paths by which a biased method can be told: as cells()."""
        return _frame(self.records("first_words"))

    def mean(self, cell, channel="beauty"):
        """A cell's image of a channel: float64 (height, width, 3). `cell`: its id, or a row of cells()."""
        row = cell if not isinstance(cell, str) else None
        if row is None:
            for each in _raylex._cells(self.directory):
                if each["id"] == cell:
                    row = each
            if row is None:
                raise KeyError(f"no cell {cell!r} in {self.directory}")
        return _raylex._cell_mean(row["directory"], channel)

    def report(self, to=""):
        """Writes report.html, tables and plots as ``raylex experiment report`` does; returns the path of the page."""
        if _raylex._write_report(self.directory, os.fspath(to)) != 0:
            raise _raylex_error(f"the report of {self.directory} is not complete; the reasons were printed")
        return os.path.join(os.fspath(to) or self.directory, "report.html")

    def verdicts(self):
        """A sentence on bias for every variant on every scene, as ``raylex experiment report`` prints them."""
        return self._study()["verdicts"]

    def __str__(self):
        """How many cells there are, the error and time of each variant's beauty, and the verdicts on bias."""
        cells = _raylex._cells(self.directory)
        failed = sum(cell["failed"] for cell in cells)
        lines = [f"{self.directory}: {len(cells) - failed} cells done" + (f", {failed} FAILED" if failed else "")]
        clock = self._study()["clock"]
        last = {}  # budgets ascend
        for row in self.records("budget"):
            if row["channel"] == "beauty" and not row["region"]:
                last[row["variant"], row["scene"]] = row
        for (variant, scene), row in last.items():
            error = row["relative_error"]["value"]
            error = "unknown" if error is None else f"{100 * error:.3g} %"
            lines.append(f"{variant} on {scene}: error {error} in {row[clock]:.3g} {clock.replace('_', ' ')}")
        return "\n".join(lines + self.verdicts())

    def plot(self, scene=None, channel="beauty", *, error="relmse_mean", against=None):
        """Error against time, a line a method, means over replicates: a matplotlib figure (Debian: python3-matplotlib).

        :param error: a column of errors(); the root of a squared one is drawn as it is
        :param against: 'wall_seconds', 'cpu_seconds' or 'samples_per_pixel'; None: the clock of the study
        """
        against = against or self._study()["clock"]
        rows = self.errors()
        rows = rows.to_dict("records") if hasattr(rows, "to_dict") else rows
        scenes = list(dict.fromkeys(row["scene"] for row in rows))
        scene = scenes[0] if scene is None and scenes else scene
        rows = [row for row in rows if row["scene"] == scene and row["channel"] == channel and not row["region"]]
        if not rows:
            raise _raylex_error(f"nothing was measured of scene {scene!r}, channel {channel!r}; scenes: {scenes}")
        figure = _figure()
        axes = figure.subplots()
        for variant in dict.fromkeys(row["variant"] for row in rows):
            points = {}
            for row in rows:
                if row["variant"] == variant:
                    points.setdefault(row["budget"], []).append((row[against], row[error]))
            means = sorted(tuple(sum(c) / len(c) for c in zip(*each)) for each in points.values())
            axes.loglog(*zip(*means), marker="o", label=variant)
        axes.set(xlabel=against.replace("_", " "), ylabel=error.replace("_", " "), title=f"{scene}, {channel}")
        axes.grid(True, which="both", alpha=0.3)
        axes.legend()
        return figure

    def _study(self):
        if self._judged is None:
            self._judged = _raylex._study(self.directory)
        return self._judged

    def __repr__(self):
        return f"Results({self.directory!r})"


def _figure():
    """A figure of no window, which notebooks show by themselves."""
    import io
    from matplotlib.figure import Figure

    class Shown(Figure):
        def _repr_png_(self):
            file = io.BytesIO()
            self.savefig(file, format="png", dpi=100)
            return file.getvalue()

    return Shown(figsize=(6, 4), layout="constrained")


def _raylex_error(text):
    from .errors import RaylexError
    return RaylexError(text)


def _number(text):
    try:
        return float(text) if "." in text or "e" in text or text in ("nan", "inf", "-inf") else int(text)
    except ValueError:
        return text


def _frame(rows):
    try:
        import pandas
    except ImportError:
        return Rows(Row(row) for row in rows)
    return pandas.DataFrame(rows)


def run(config, directory, *, overrides=(), resume=False, retry=False, verbose=False):
    """Runs a study and keeps every image and its statistics.

    In this process, so that methods written in Python take part: a scene that ends the process ends Python with it;
    ``raylex experiment run`` outlives that.

    :param config: a TOML file; experiments/docs/studies/config.md lists its keys
    :param directory: of the results; what is there already is an error unless `resume`
    :param overrides: KEY=VALUE, as --set has them
    :param verbose: prints what the program prints
    :returns: Results
    :raises RaylexError: a config that cannot be used, cells that failed
    """
    outcome = _raylex._run_experiment(os.fspath(config), os.fspath(directory), list(overrides), resume, retry,
                                      verbose)
    results = Results(directory)
    if outcome["failed"] + outcome["references_failed"] > 0:
        reasons = [f"{row['id']}: {row['failure']}" for row in _raylex._cells(results.directory) if row["failed"]]
        told = f"{outcome['failed']} cells failed, {outcome['references_failed']} references"
        raise _raylex_error("\n".join([told, *reasons]))
    return results


def verdict(scene, integrator, directory, *, against="path", resolution=(128, 128), spp=(4, 16), replicates=8,
            reference_spp=256, max_depth=5, lpe=None, seed=1, quiet=False):
    """Is an integrator right? Renders it beside one that is, `replicates` times each, tests for bias, and prints the
    verdict.

    :param scene: a pbrt-v4 file in which both must agree
    :param integrator: a registered type, or {"type": ..., parameter: value}
    :param against: what is held to be right, and makes the reference
    :param lpe: {channel: expression} judged beside the beauty; by default one for each number of scatterings to three
    :param quiet: True: prints nothing
    :returns: Results; ``.bias()`` has the verdicts, ``.first_words()`` the shortest path that is wrong
    """
    from .rendering import _channels, _entity
    from ._toml import text_of
    if lpe is None:
        lpe = {"emission": "CL", "bounce1": "C[DS]L", "bounce2": "C[DS][DS]L", "bounce3": "C[DS][DS][DS]L"}
    mine = _entity(integrator)
    tables = {
        "replicates": replicates, "seed": seed,
        "scene": [{"name": "scene", "file": os.path.abspath(os.fspath(scene)), "resolution": list(resolution)}],
        "method": [{"name": "right", "integrator": _entity(against), "max_depth": max_depth},
                   {"name": "judged", "integrator": mine, "max_depth": max_depth}],
        "budget": {"samples": list(spp)},
        "reference": {"method": "right", "spp": reference_spp},
        "channel": _channels(lpe, "renderman"),
    }
    os.makedirs(directory, exist_ok=True)
    config = os.path.join(os.fspath(directory), "verdict.toml")
    with open(config, "w", encoding="utf-8") as file:
        file.write(text_of(tables))
    results = run(config, os.path.join(os.fspath(directory), "results"))
    if not quiet:
        name = mine["type"]
        for line in results.verdicts():
            if line.startswith("judged on "):
                print(name + line[len("judged"):])
    return results
