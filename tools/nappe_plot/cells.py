"""What becomes of the cells (Fig. 8): their grains at the chosen times, a column per cell, a row per time."""

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


def draw(run, chosen, out):
    """cells.png. The stretches are those of eq. 11: extent of the centres over that of the first frame."""
    first = run.frame(0)
    cells = [(k, name) for k, name in enumerate(run.cell_names) if first.members(k).sum() > 1]
    if not cells:
        return
    frames = [run.frame(k) for k in chosen]
    n_rows, n_columns = len(frames), len(cells)
    side = min(2.55, (style.WIDE - 1.3) / n_columns)
    width, height = 1.2 + n_columns * side, 0.75 + n_rows * (side + 0.38)
    figure, axes = plt.subplots(n_rows, n_columns, figsize=(width, height), squeeze=False)
    figure.subplots_adjust(
        left=1.1 / width, right=1 - 0.1 / width, top=1 - 0.45 / height, bottom=0.42 / height, wspace=0.04, hspace=0.16
    )
    for column, (cell, name) in enumerate(cells):
        colour = palette.LINES[cell % len(palette.LINES)]
        at_first = _extent(first.x[first.members(cell)])
        mask = first.members(cell)
        first_window = _window(first.x[mask], first.radius[mask])
        bar = next(m for m in BARS if m <= 0.3 * (first_window.x[1] - first_window.x[0]))
        for row, frame in enumerate(frames):
            axis = axes[row, column]
            mask = frame.members(cell)
            window = _window(frame.x[mask], frame.radius[mask])
            grains.draw(axis, frame, grains.shades(frame, run.n_bed), window, edge=0.3, mask=mask)
            window.apply(axis)
            _scale_bar(axis, window, bar)
            axis.set_xticks([])
            axis.set_yticks([])
            for spine in axis.spines.values():
                spine.set(visible=True, color="#cccccc")
            stretch = _extent(frame.x[mask]) / at_first
            text = rf"$\lambda_x$ = {stretch[0]:.2f}   $\lambda_y$ = {stretch[1]:.2f}"
            axis.set_xlabel(text, fontsize=12, labelpad=3)
            if row == 0:
                axis.set_title(name, color=colour, fontweight="bold")
            if column == 0:
                axis.set_ylabel(f"t = {style.seconds(frame.time)}", labelpad=8)
    yield style.save(figure, out / "cells.png", 220)
