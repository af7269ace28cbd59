"""Several runs against each other: stress and stretch of a cell (Figs. 14, 15), its last shape (Fig. 16), limits of the
zone and front against time."""

import matplotlib.pyplot as plt
import numpy as np

from . import cells, curves, fault, palette, style


def colour(k):
    return palette.LINES[k % len(palette.LINES)]


def _line(axis, k, label, time, values):
    if len(values) >= curves.MANY_ROWS:
        axis.plot(time, values, color=colour(k), linewidth=0.8, alpha=0.3)
        values = curves.running_mean(values)
    axis.plot(time, values, color=colour(k), label=label, zorder=3)


def _cell_curves(views, quantities, stem, out, unit_of):
    """A picture per cell that all runs have; a line per run."""
    names = [name for name in views[0].run.cell_names if all(v.run.series(f"cell-{name}") is not None for v in views)]
    for name in names:
        series = [view.run.series(f"cell-{name}") for view in views]
        scale, unit = unit_of(np.concatenate([one[column] for one in series for column, _ in quantities]))
        figure, axes = plt.subplots(1, 2, figsize=(15, 6.4), layout="constrained")
        for axis, (column, label) in zip(axes, quantities):
            for k, (view, one) in enumerate(zip(views, series)):
                _line(axis, k, view.label, one["time"], one[column] / scale)
            axis.set(xlabel="time [s]", ylabel=label + unit)
            axis.margins(x=0.01)
        axes[1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title=f"cell {name}", title_fontsize=13)
        if max(len(one["time"]) for one in series) >= curves.MANY_ROWS:
            figure.text(0.995, 0.005, curves.SMOOTHED, ha="right", va="bottom", fontsize=10, color=palette.MUTED)
        suffix = f"-{name}" if len(names) > 1 else ""
        yield style.save(figure, out / f"{stem}{suffix}.png", style.DPI_CURVES)


def draw_stress(views, out):
    """stress.png: mean and deviatoric stress of the cell."""
    yield from _cell_curves(views, curves.STRESSES, "stress", out, curves.pascals)


def draw_lambda(views, out):
    """lambda.png: stretch of the cell along x and y."""
    yield from _cell_curves(views, curves.STRETCHES, "lambda", out, lambda values: (1.0, ""))


def draw_cells(views, out):
    """cells.png: the grains of the cells, a column per run; above it as they lay at the start."""
    yield from cells.draw_compared(views, out)


ZONE = [("left_angle", "left limit"), ("right_angle", "right limit"), ("opening", "opening of the zone")]


def draw_zone(views, out):
    """zone.png: inclination of the limits and the angle between them, and how far the front is from the fault."""
    known = [(k, v, v.run.measured("zone"), v.run.measured("surface"), fault.of(v.run)) for k, v in enumerate(views)]
    known = [one for one in known if one[2] is not None and one[4] is not None]
    if not known:
        return
    figure, axes = plt.subplots(2, 2, figsize=(15, 10), layout="constrained", sharex=True)
    for axis, (column, title) in zip(axes.flat, ZONE):
        for k, view, zone, _, _ in known:
            axis.plot(zone["time"], np.degrees(zone[column]), color=colour(k), marker=".", label=view.label)
        axis.set(title=title, ylabel="angle [°]")
    for axis in axes.flat[:2]:
        dips = {round(np.degrees(np.arctan2(one.along[1], one.along[0])), 6) for _, _, _, _, one in known}
        for dip in dips:
            axis.axhline(dip, color=palette.MUTED, linestyle="--", linewidth=1.4, zorder=1)
            axis.annotate("dip of the fault", (1, dip), xycoords=("axes fraction", "data"), ha="right", va="bottom")
    last = axes[1, 1]
    for k, view, _, surface, one in known:
        if surface is not None:
            bed = view.run.frame(0).x[:, 1].max()
            last.plot(surface["time"], surface["front"] - one.line(bed), color=colour(k), marker=".", label=view.label)
    last.set(title="front, beyond where the fault would meet the surface", ylabel="distance [m]")
    axes[0, 1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    for axis in axes[1]:
        axis.set_xlabel("time [s]")
    yield style.save(figure, out / "zone.png", style.DPI_CURVES)
