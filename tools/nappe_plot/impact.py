"""What falls on grains: pressure gauges against time (seeds/004 Figs. 3, 4, 6), how deep a probe's grain goes (Figs. 2, 6),
and grains shaded by the force they bear over bars of the gauges (Fig. 7)."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize

from . import grains, layers, palette, style
from .run import WALL_KEY

# The more force, the lighter, as the report has it.
FORCE = LinearSegmentedColormap.from_list("force", ["#1d2733", "#3f5d7d", "#d9822b", "#ffd27f", "#fffbe8"])
KILO = 1e3


def _gauges(run):
    """name -> (n_rows) pressure [kN/m] of the gauges that have one bin, in alphabetical order."""
    found = {}
    for name in run.series_names("gauge"):
        series = run.series(f"gauge-{name}")
        if series is not None and "normal_1" not in series:
            found[name] = series["time"], series["normal_0"] / KILO
    return found


def _strip(run):
    """The gauge with most bins: its name, times, (n_rows, n_bins) pressure [kN/m]; None if there is none."""
    best = None
    for name in run.series_names("gauge"):
        series = run.series(f"gauge-{name}")
        if series is None:
            continue
        n = sum(column.startswith("normal_") for column in series)
        if n > 1 and (best is None or n > best[2].shape[1]):
            best = name, series["time"], np.stack([series[f"normal_{k}"] for k in range(n)], axis=1) / KILO
    return best


def _draw_gauges(axis, run):
    for k, (name, (time, pressure)) in enumerate(_gauges(run).items()):
        shown = time <= style.UNTIL
        axis.plot(1e3 * time[shown], pressure[shown], color=palette.LINES[k % len(palette.LINES)], linewidth=1.6, label=name)
    axis.set(xlabel="time since first touch [ms]", ylabel="force per length [kN/m]")
    axis.margins(x=0.01)


def draw_gauges(run, chosen, out):
    """gauges.png: pressure on each gauge of one bin."""
    if not _gauges(run):
        return
    figure, axis = plt.subplots(figsize=style.PLOT, layout="constrained")
    _draw_gauges(axis, run)
    axis.legend(loc="upper right")
    yield style.save(figure, out / "gauges.png", style.DPI_CURVES)


def draw_gauges_compared(views, out):
    """gauges.png: a panel a run, all to one scale of time and two to a row."""
    views = [view for view in views if _gauges(view.run)]
    if not views:
        return
    rows = (len(views) + 1) // 2
    figure, axes = plt.subplots(rows, 2, figsize=(15, 4.6 * rows), layout="constrained", squeeze=False, sharex=True)
    for axis, view in zip(axes.flat, views):
        _draw_gauges(axis, view.run)
        axis.set_title(view.label, loc="left")
    for axis in axes.flat[len(views) :]:
        axis.axis("off")
    lowest = axes.flat[max(len(views) - 2, 0) : len(views)]  # of each column, in the last row or the one above
    for axis in axes.flat:
        axis.tick_params(labelbottom=axis in lowest)
        axis.xaxis.label.set_visible(axis in lowest)
    axes[0, 0].legend(loc="upper right")
    yield style.save(figure, out / "gauges.png", style.DPI_CURVES)


def _probes(run):
    return {name: run.series(f"probe-{name}") for name in run.series_names("probe")}


def _draw_fall(axis, lines):
    for k, (label, probe) in enumerate(lines):
        colour = palette.LINES[k % len(palette.LINES)]
        style_of = "-" if k < len(palette.LINES) else "--"
        shown = probe["time"] <= style.UNTIL
        axis.plot(probe["time"][shown], 100 * probe["penetration"][shown], style_of, color=colour, label=label)
    axis.invert_yaxis()
    axis.set(xlabel="time since first touch [s]", ylabel="penetration [cm]")
    axis.margins(x=0.01)
    axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))


def draw_fall(run, chosen, out):
    """penetration.png: how deep each probe's grain has gone."""
    lines = [(name, probe) for name, probe in _probes(run).items() if probe is not None]
    if not lines:
        return
    figure, axis = plt.subplots(figsize=style.PLOT, layout="constrained")
    _draw_fall(axis, lines)
    yield style.save(figure, out / "penetration.png", style.DPI_CURVES)


def draw_fall_compared(views, out):
    """penetration.png: the first probe of each run."""
    lines = [(view.label, next(iter(_probes(view.run).values()), None)) for view in views]
    lines = [(label, probe) for label, probe in lines if probe is not None]
    if not lines:
        return
    figure, axis = plt.subplots(figsize=(13, 7), layout="constrained")
    _draw_fall(axis, lines)
    yield style.save(figure, out / "penetration.png", style.DPI_CURVES)


def _force(frame, h):
    """Sum of the normal forces on each grain [kN/m]."""
    sums = np.zeros(len(frame.id))
    if frame.contacts:
        lo, hi, r_n = (frame.contacts[name] for name in ("lo", "hi", "r_n"))
        np.add.at(sums, np.searchsorted(frame.id, lo), r_n)
        between = hi < WALL_KEY
        np.add.at(sums, np.searchsorted(frame.id, hi[between]), r_n[between])
    return sums / h / KILO


def _ends(frame, wall):
    """Where a level wall begins and ends along x [m]."""
    points = frame.walls[wall]
    return points[:, 0].min(), points[:, 0].max()


def draw_impact(run, chosen, out):
    """impact.png: the chosen times one under the other, grains lighter the more force they bear, the gauges below."""
    strip = _strip(run)
    if strip is None:
        return
    name, time, pressure = strip
    gauged = next(g["wall"] for g in run.scene["output"]["gauges"] if g["name"] == name)
    frames = [run.frame(k) for k in chosen]
    forces = [_force(frame, run.h) for frame in frames]
    small = [frame.radius < 4 * np.median(frame.radius) for frame in frames]  # the block bears everything
    strong = max(np.quantile(force[mask], 0.995) for force, mask in zip(forces, small))
    norm = Normalize(0, strong or 1.0, clip=True)
    window = grains.whole(frames)
    top = max((frame.x[mask, 1] + frame.radius[mask]).max() for frame, mask in zip(frames, small))
    depth = 0.35 * top
    rocks = [(frame.x[~mask, 1] + frame.radius[~mask]).max(initial=0) for frame, mask in zip(frames, small)]
    window = grains.Window(*window.x, -1.15 * depth, min(window.y[1], max(1.6 * top, 1.05 * max(rocks))))
    rows = [pressure[np.argmin(abs(time - frame.time))] for frame in frames]
    largest = max(np.max(rows), 1e-9)
    figure, axes = layers.stack([window] * len(frames), key_height=1.1)
    for axis, frame, force, mask, row in zip(axes, frames, forces, small, rows):
        colours = FORCE(norm(force))[:, :3]
        grains.draw(axis, frame, colours, window)
        grains.draw(axis, frame, colours, window, edge=1.0, mask=~mask)  # white on white else
        grains.draw_walls(axis, frame)
        left, right = _ends(frame, gauged)
        edges = np.linspace(left, right, len(row) + 1)
        axis.bar(edges[:-1], -depth * row / largest, np.diff(edges), align="edge", color=palette.LINES[1], edgecolor="white")
        window.apply(axis)
        axis.locator_params(axis="y", nbins=5)
        axis.set_title(f"{1e3 * frame.time:.0f} ms", loc="left")
    height = figure.get_figheight()
    bar = figure.add_axes([0.55, 1 - 0.8 / height, 0.4, 0.16 / height])
    figure.colorbar(ScalarMappable(norm, FORCE), cax=bar, orientation="horizontal", extend="max")
    bar.set_title(f"force on a grain [kN/m]\n(longest bar: {largest:,.0f} kN/m)", fontsize=12)
    yield style.save(figure, out / "impact.png", style.DPI_CHAINS)
