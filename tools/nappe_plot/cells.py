"""What becomes of the cells (Fig. 8): their grains at the chosen times, a column per cell, a row per time."""

import matplotlib.pyplot as plt
import numpy as np

from . import grains, palette, style


def _extent(x):
    return x.max(axis=0) - x.min(axis=0)


def _scale_bar(axis, half):
    """A bar of a round length in the panel's lower left corner."""
    length = next(m for m in (50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.01) if m <= 0.7 * half)
    left, bottom = -0.92 * half, -0.90 * half
    axis.plot([left, left + length], [bottom, bottom], color=palette.INK, linewidth=3, solid_capstyle="butt")
    axis.text(left, bottom + 0.05 * half, f"{length:g} m", fontsize=11, ha="left", va="bottom")


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
        half = 0.56 * max(_extent(frame.x[frame.members(cell)]).max() for frame in frames)
        for row, frame in enumerate(frames):
            axis = axes[row, column]
            mask = frame.members(cell)
            middle = (frame.x[mask].max(axis=0) + frame.x[mask].min(axis=0)) / 2
            window = grains.Window(middle[0] - half, middle[0] + half, middle[1] - half, middle[1] + half)
            grains.draw(axis, frame, grains.shades(frame, run.n_bed), window, edge=0.3, mask=mask)
            window.apply(axis)
            axis.set_xticks([])
            axis.set_yticks([])
            for spine in axis.spines.values():
                spine.set(visible=True, color="#cccccc")
            stretch = _extent(frame.x[mask]) / at_first
            axis.set_xlabel(rf"$\lambda_x$ = {stretch[0]:.2f}   $\lambda_y$ = {stretch[1]:.2f}", fontsize=12, labelpad=3)
            if row == 0:
                axis.set_title(name, color=colour, fontweight="bold")
            if column == 0:
                axis.set_ylabel(f"t = {style.seconds(frame.time)}", labelpad=8)
        corner = axes[0, column].inset_axes([0, 0, 1, 1], zorder=5)
        corner.set(xlim=(-half, half), ylim=(-half, half), frame_on=False)
        corner.set_axis_off()
        _scale_bar(corner, half)
    yield style.save(figure, out / "cells.png", 220)
