"""What becomes of the cells (Figs. 8 and 16): their grains at the chosen times, or in several runs."""

import matplotlib.pyplot as plt
from matplotlib.patheffects import withStroke

from . import grains, palette, style


BARS = [factor * 10**power for power in range(3, -5, -1) for factor in (5, 2, 1)]  # m


def _extent(x):
    return x.max(axis=0) - x.min(axis=0)


def _window(x, radius):
    """A square that holds the disks, with room for the scale bar below them."""
    low, high = (x - radius[:, None]).min(axis=0), (x + radius[:, None]).max(axis=0)
    side = 1.24 * (high - low).max()
    left, bottom = (low + high - side) / 2
    bottom -= 0.06 * side
    return grains.Window(left, left + side, bottom, bottom + side)


def _scale_bar(axis, window, length):
    """In the panel's lower left corner; of one length in a column, so that a bar that shrinks tells of the scale."""
    side = window.x[1] - window.x[0]
    left, bottom = window.x[0] + 0.05 * side, window.y[0] + 0.04 * side
    halo = [withStroke(linewidth=5, foreground="white")]
    ends = [left, left + length], [bottom, bottom]
    axis.plot(*ends, color=palette.INK, linewidth=3, solid_capstyle="butt", path_effects=halo)
    axis.text(left, bottom + 0.025 * side, f"{length:g} m", fontsize=11, ha="left", va="bottom", path_effects=halo)


def _of(run):
    """(number, name) of the cells with enough grains to have an extent."""
    first = run.frame(0)
    return [(k, name) for k, name in enumerate(run.cell_names) if first.members(k).sum() > 1]


def _axes(n_rows, n_columns):
    side = min(2.55 if n_rows > 1 else 3.4, (style.WIDE - 1.3) / n_columns)
    width, height = 1.2 + n_columns * side, 0.75 + n_rows * (side + 0.38)
    figure, axes = plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False)
    figure.subplots_adjust(
        left=1.1 / width, right=1 - 0.1 / width, top=1 - 0.45 / height, bottom=0.42 / height, wspace=0.04, hspace=0.16
    )
    return figure, axes


def _bar_of(frame, cell):
    """Length of the scale bar [m] that suits the cell in this frame."""
    mask = frame.members(cell)
    window = _window(frame.x[mask], frame.radius[mask])
    return next(m for m in BARS if m <= 0.3 * (window.x[1] - window.x[0]))


def _panel(axis, run, frame, cell, bar):
    """The cell's grains, and the stretches of eq. 11: extent of the centres over that of the first frame."""
    mask = frame.members(cell)
    window = _window(frame.x[mask], frame.radius[mask])
    grains.draw(axis, frame, grains.shades(frame, run.n_bed), window, edge=0.3, mask=mask)
    window.apply(axis)
    _scale_bar(axis, window, bar)
    axis.set_xticks([])
    axis.set_yticks([])
    for spine in axis.spines.values():
        spine.set(visible=True, color="#cccccc")
    first = run.frame(0)
    stretch = _extent(frame.x[mask]) / _extent(first.x[first.members(cell)])
    axis.set_xlabel(rf"$\lambda_x$ = {stretch[0]:.2f}   $\lambda_y$ = {stretch[1]:.2f}", fontsize=12, labelpad=3)


def draw(run, chosen, out):
    """cells.png."""
    cells = _of(run)
    if not cells:
        return
    frames = [run.frame(k) for k in chosen]
    figure, axes = _axes(len(frames), len(cells))
    for column, (cell, name) in enumerate(cells):
        bar = _bar_of(run.frame(0), cell)
        for axis, frame in zip(axes[:, column], frames):
            _panel(axis, run, frame, cell, bar)
        axes[0, column].set_title(name, color=palette.LINES[cell % len(palette.LINES)], fontweight="bold")
    for axis, frame in zip(axes[:, 0], frames):
        axis.set_ylabel(f"t = {style.seconds(frame.time)}", labelpad=8)
    yield style.save(figure, out / "cells.png", 220)


def draw_compared(views, out):
    """cells.png of several runs (Fig. 16): a row per cell, as it lay at the start and as it is in each run."""
    cells = _of(views[0].run)
    if not cells or any(_of(view.run) != cells for view in views):
        return
    figure, axes = _axes(len(cells), 1 + len(views))
    for row, (cell, name) in zip(axes, cells):
        bar = _bar_of(views[0].run.frame(0), cell)
        _panel(row[0], views[0].run, views[0].run.frame(0), cell, bar)
        for axis, view in zip(row[1:], views):
            _panel(axis, view.run, view.frame, cell, bar)
        row[0].set_ylabel(name, labelpad=8, fontweight="bold")
    axes[0, 0].set_title("at the start")
    for k, view in enumerate(views):
        axes[0, 1 + k].set_title(view.label, color=palette.LINES[k % len(palette.LINES)])
    yield style.save(figure, out / "cells.png", 220)
