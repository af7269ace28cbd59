"""Pictures of the study: figures against cohesion, with their scatter over seeds; relations against what was found."""

import math

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from nappe_plot import palette, style

from .plan import number
from .results import OUTCOMES

MARKERS = "osD^v"
GROUPS = {
    "limits": (["left", "right", "opening", "apical"], (2, 2)),
    "trishear": (["s", "residual"], (1, 2)),
    "front": ([outcome.key for outcome in OUTCOMES if outcome.key.startswith("front")], (1, 3)),
}
TITLES = {outcome.key: outcome for outcome in OUTCOMES}


class _Looks:
    """A colour per dip, a marker per height, and a little sideways so that error bars stay apart."""

    def __init__(self, conditions):
        self.thetas = sorted({theta for theta, _, _ in conditions})
        self.heights = sorted({height for _, height, _ in conditions})
        gammas = sorted({gamma for _, _, gamma in conditions})
        self.place = {gamma: k for k, gamma in enumerate(gammas)}
        self.tick_labels = [self._tick(conditions, gamma) for gamma in gammas]

    @staticmethod
    def _tick(conditions, gamma):
        by_grain = next(group[0].by_grain for (_, _, one), group in conditions.items() if one == gamma)
        return f"{by_grain:.2g}"

    def of(self, theta, height):
        """Colour, marker, and offset in places of the axis."""
        k, j = self.thetas.index(theta), self.heights.index(height)
        n = len(self.thetas) * len(self.heights)
        offset = 0.7 * ((k * len(self.heights) + j + 0.5) / n - 0.5)
        return palette.LINES[k % len(palette.LINES)], MARKERS[j % len(MARKERS)], offset

    def key(self):
        dips = [
            Line2D([], [], color=palette.LINES[k % len(palette.LINES)], label=f"dip {number(theta)}°")
            for k, theta in enumerate(self.thetas)
        ]
        point = {"color": palette.INK, "linestyle": ""}
        heights = [
            Line2D([], [], marker=MARKERS[j % len(MARKERS)], label=f"{number(height)} m high", **point)
            for j, height in enumerate(self.heights)
        ]
        return dips + heights


def _known(group, key):
    values = np.array([result.figures[key] for result in group])
    return values[np.isfinite(values)]


def _panel(axis, conditions, looks, outcome):
    """Means with standard deviations over seeds; cohesions in equal steps, as they are powers of ten and 0."""
    for theta in looks.thetas:
        for height in looks.heights:
            colour, marker, offset = looks.of(theta, height)
            points = []
            for gamma, place in looks.place.items():
                values = _known(conditions.get((theta, height, gamma), []), outcome.key)
                if len(values):
                    points.append((place + offset, values.mean(), values.std(ddof=1) if len(values) > 1 else 0.0))
            if points:
                x, y, error = zip(*points)
                axis.errorbar(x, y, error, color=colour, marker=marker, linewidth=1.2, markersize=7, capsize=3)
    axis.set_xticks(list(looks.place.values()), looks.tick_labels)
    axis.set_xlim(-0.5, len(looks.place) - 0.5)
    label = {"°": "angle [°]", "h": "distance / height"}.get(outcome.unit, "")
    axis.set(title=outcome.title, ylabel=label)
    axis.grid(axis="x", visible=False)


def _against_cohesion(conditions, looks, keys, shape, path):
    size = {(2, 2): (14, 10.5), (1, 2): (14, 5.6), (1, 3): (16, 5.6)}[shape]
    figure, axes = plt.subplots(*shape, figsize=size, layout="constrained", squeeze=False, sharex=True)
    for axis, key in zip(axes.flat, keys):
        _panel(axis, conditions, looks, TITLES[key])
    for axis in axes[-1]:
        axis.set_xlabel(r"cohesion $\gamma$ / mean weight of a grain")
    axes[0, -1].legend(handles=looks.key(), loc="center left", bbox_to_anchor=(1.01, 0.5))
    return style.save(figure, path, 100)


def _against_relation(studies, looks, path):
    """Each supported relation, drawn against what the runs gave; on the line it would be right."""
    n_columns = min(3, len(studies))
    n_rows = math.ceil(len(studies) / n_columns)
    figure, axes = plt.subplots(
        n_rows, n_columns, figsize=(4.9 * n_columns + 1.8, 4.9 * n_rows), layout="constrained", squeeze=False
    )
    for axis, study in zip(axes.flat, studies):
        guess = study.best.fit(study.results)
        for result, x, y in zip(study.results, guess, study.y):
            colour, marker, _ = looks.of(result.run.theta, result.run.height)
            axis.plot(x, y, marker=marker, color=colour, linestyle="", markersize=6, alpha=0.75)
        ends = [min(guess.min(), study.y.min()), max(guess.max(), study.y.max())]
        axis.plot(ends, ends, color=palette.INK, linewidth=1.2, zorder=1)
        unit = f" [{study.outcome.unit}]" if study.outcome.unit else ""
        axis.set(title=study.outcome.title, xlabel=f"relation{unit}", ylabel=f"runs{unit}")
        axis.set_aspect("equal", adjustable="datalim")
    for axis in axes.flat[len(studies) :]:
        axis.remove()
    axes[0, n_columns - 1].legend(handles=looks.key(), loc="center left", bbox_to_anchor=(1.01, 0.5))
    return style.save(figure, path, 100)


def draw(conditions, studies, folder):
    """fault-study-*.png; their paths."""
    style.apply()
    looks = _Looks(conditions)
    paths = [
        _against_cohesion(conditions, looks, keys, shape, folder / f"fault-study-{name}.png")
        for name, (keys, shape) in GROUPS.items()
    ]
    supported = [study for study in studies if study.supported]
    if supported:
        paths.append(_against_relation(supported, looks, folder / "fault-study-relations.png"))
    return paths
