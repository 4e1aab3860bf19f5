"""Studies: runs methods x scenes x budgets from one config, and reads and judges the results."""

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
    """A list of :class:`Row`, used without pandas. rows["variant"] returns a column, print(rows) prints a table."""

    def __getitem__(self, key):
        return [row.get(key) for row in self] if isinstance(key, str) else super().__getitem__(key)

    def __repr__(self):
        names = list(dict.fromkeys(name for row in self for name in row))
        table = [names, *([f"{each:.4g}" if isinstance(each, float) else str(each)
                           for each in map(row.get, names)] for row in self)]
        widths = [max(map(len, column)) for column in zip(*table)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in table)


class Results:
    """A results directory. ``print(results)`` prints a summary."""

    def __init__(self, directory):
        self.directory = os.fspath(directory)
        self._judged = None

    def cells(self):
        """Returns one row per cell, finished or failed: a pandas frame if pandas is installed, else :class:`Rows`.

        Columns: id, scene, method, budget_kind, budget, replicate, seed, failed, failure, samples_per_pixel,
        wall_seconds, cpu_seconds, rays, directory, and the swept settings.
        """
        return _frame(_raylex._cells(self.directory))

    def errors(self):
        """Returns the errors of every cell, channel and region against the reference, by every metric, with times. The
        type is that of cells()."""
        import csv
        import io
        rows = list(csv.DictReader(io.StringIO(self._study()["csv"])))
        return _frame([{key: _number(value) for key, value in row.items()} for row in rows])

    def records(self, kind):
        """Returns the records of one kind in results.jsonl, a list of dicts: 'bias', 'slope', 'time_to_error', 'split',
        ..."""
        rows = [json.loads(line) for line in self._study()["jsonl"].splitlines()]
        return [row for row in rows if row["kind"] == kind]

    def bias(self):
        """Returns the results of the bias tests by channel, with the type of cells(). 'convicts' is true if the method
        does not converge to the reference: its images differ, at the level of 1 % for all tests together, and the
        reason is neither rare bright samples ('heavy_tail') nor declared omissions ('omitted'). 'detectable_whole' is
        the smallest relative bias that the test would find."""
        return _frame(self.records("bias"))

    def first_words(self):
        """Returns the shortest light paths that show the error of a biased method, with the type of cells()."""
        return _frame(self.records("first_words"))

    def mean(self, cell, channel="beauty"):
        """Returns a cell's image of a channel: float64 (height, width, 3). `cell` is an id, or a row of cells()."""
        row = cell if not isinstance(cell, str) else None
        if row is None:
            for each in _raylex._cells(self.directory):
                if each["id"] == cell:
                    row = each
            if row is None:
                raise KeyError(f"no cell {cell!r} in {self.directory}")
        return _raylex._cell_mean(row["directory"], channel)

    def report(self, to=""):
        """Writes report.html, tables and plots like ``raylex experiment report``. Returns the path of the page."""
        if _raylex._write_report(self.directory, os.fspath(to)) != 0:
            raise _raylex_error(f"the report of {self.directory} is incomplete; the reasons were printed")
        return os.path.join(os.fspath(to) or self.directory, "report.html")

    def verdicts(self):
        """Returns a sentence about bias for every variant on every scene, as printed by ``raylex experiment
        report``."""
        return self._study()["verdicts"]

    def __str__(self):
        """Returns the number of cells, the error and time of each variant's beauty, and the verdicts on bias."""
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
        """Plots error against time, one line per method, with means over replicates. Returns a matplotlib figure
        (Debian: python3-matplotlib).

        :param error: a column of errors(); of squared errors the root is plotted
        :param against: 'wall_seconds', 'cpu_seconds' or 'samples_per_pixel'; None: the study's clock
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
    """A figure without a window, which notebooks display."""
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
    """Runs a study and stores all images and statistics.

    Runs in this process, so that methods in Python can be used. A scene that crashes the process also ends Python;
    ``raylex experiment run`` survives that.

    :param config: a TOML file; experiments/docs/studies/config.md lists its keys
    :param directory: directory for the results; existing results are an error unless `resume`
    :param overrides: KEY=VALUE, as for --set
    :param verbose: prints the output of the program
    :returns: Results
    :raises RaylexError: an invalid config, failed cells
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
    """Tests an integrator for bias: renders it and a correct one, `replicates` times each, and prints the verdict.

    :param scene: a pbrt-v4 file on which both must agree
    :param integrator: a registered type, or {"type": ..., parameter: value}
    :param against: the integrator that counts as correct and makes the reference
    :param lpe: {channel: expression} tested besides the beauty; by default one per number of scattering events up to
        three
    :param quiet: True: prints nothing
    :returns: Results; ``.bias()`` has the verdicts, ``.first_words()`` the shortest wrong path
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
