"""Series against time: stress and stretch of the cells (Fig. 9 and 10), front against wall (Fig. 7)."""

import matplotlib.pyplot as plt
import numpy as np

from . import palette, style

STRESSES = [("p", "pressure p"), ("q", "deviatoric stress q")]
STRETCHES = [("lambda_x", r"stretch $\lambda_x$"), ("lambda_y", r"stretch $\lambda_y$")]
MANY_ROWS = 200  # from here on a line is smoothed
SMOOTHED = "bold: mean over 1 % of the run; pale: as stored"


def running_mean(values):
    """Over 1 % of the rows, half of them before and half after; at the ends over those there are."""
    half = len(values) // 200
    total = np.concatenate([[0.0], np.cumsum(values)])
    row = np.arange(len(values))
    first, last = np.maximum(row - half, 0), np.minimum(row + half + 1, len(values))
    return (total[last] - total[first]) / (last - first)


def _per_cell(run, quantities, out, unit_of=lambda values: (1.0, "")):
    """Two panels side by side, one per quantity (column, label), a line per cell."""
    names = [name for name in run.cell_names if run.series(f"cell-{name}") is not None]
    if not names:
        return None
    series = {name: run.series(f"cell-{name}") for name in names}
    scale, unit = unit_of(np.concatenate([cell[column] for cell in series.values() for column, _ in quantities]))
    figure, axes = plt.subplots(1, 2, figsize=(15, 6.4), layout="constrained")
    for axis, (column, label) in zip(axes, quantities):
        for k, (name, cell) in enumerate(series.items()):
            colour = palette.LINES[k % len(palette.LINES)]
            values = cell[column] / scale
            if len(values) >= MANY_ROWS:
                axis.plot(cell["time"], values, color=colour, linewidth=0.8, alpha=0.3)
            axis.plot(cell["time"], running_mean(values), color=colour, label=name, zorder=3)
        axis.set_xlabel("time [s]")
        axis.set_ylabel(label + unit)
        axis.margins(x=0.01)
    axes[1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    if max(len(cell["time"]) for cell in series.values()) >= MANY_ROWS:
        figure.text(0.995, 0.005, SMOOTHED, ha="right", va="bottom", fontsize=10, color=palette.MUTED)
    return style.save(figure, out, style.DPI_CURVES)


def pascals(values):
    largest = np.nanmax(abs(values))
    return (1e6, " [MPa]") if largest >= 1e6 else (1e3, " [kPa]")


def draw_stress(run, chosen, out):
    """stress.png: mean and deviatoric stress of each cell."""
    path = _per_cell(run, STRESSES, out / "stress.png", pascals)
    if path:
        yield path


def draw_lambda(run, chosen, out):
    """lambda.png: stretch of each cell along x and y."""
    path = _per_cell(run, STRETCHES, out / "lambda.png")
    if path:
        yield path


def draw_front(run, chosen, out):
    """front.png: the wedge's front against the moving wall, beside a wedge that would slide as one rigid block."""
    front = run.series("front")
    name, wall = run.moving_wall()
    if front is None or wall is None or not np.isfinite(front["front"]).any():
        return
    known = np.isfinite(front["front"])
    position = np.interp(front["time"][known], wall["time"], wall["x"])
    reached = front["front"][known]
    figure, axis = plt.subplots(figsize=style.PLOT, layout="constrained")
    rigid = reached[0] + position - position[0]
    axis.plot(position, rigid, color=palette.MUTED, linestyle="--", label="front at first + wall travel")
    axis.plot(position, reached, color=palette.LINES[0], drawstyle="steps-post", label="wedge front")
    axis.set_xlabel(f"position of the {name} [m]")
    axis.set_ylabel("wedge front [m]")
    axis.legend(loc="upper left")
    yield style.save(figure, out / "front.png", style.DPI_CURVES)
