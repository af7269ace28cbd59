"""The layers at chosen times (Fig. 6 of Renouf, Dubois and Alart 2006): the whole length, and the deformed part."""

import matplotlib.pyplot as plt
import numpy as np

from . import grains, style


def title_of(run, frame):
    """Time, and where the moving wall stands then."""
    text = f"t = {style.seconds(frame.time)}"
    name, wall = run.moving_wall()
    if wall is not None:
        position = f"{np.interp(frame.time, wall['time'], wall['x']):.1f}".removesuffix(".0")
        text += f",  {name} at x = {position} m"
    return text


def stack(windows, key_height=0.0):
    """A figure with one panel per window, one under another, of the windows' true shape; wide or tall as they ask."""
    room = 0.75, 0.95  # inches: left and right of a panel together; its title and numbers
    width = style.WIDE if windows[0].aspect > 2 else 9.0
    panel = (width - 1.15) / windows[0].aspect
    height = len(windows) * (panel + room[1]) + 0.35 + key_height
    figure = plt.figure(figsize=(width, height))
    axes = []
    for k in range(len(windows)):
        bottom = height - key_height - (k + 1) * (panel + room[1]) + 0.5
        axes.append(figure.add_axes([0.9 / width, bottom / height, (width - 1.15) / width, panel / height]))
        axes[-1].set_ylabel("y [m]")
    axes[-1].set_xlabel("x [m]")
    return figure, axes


def add_key(figure, frame, n_bed):
    handles = grains.layer_key(frame, n_bed)
    figure.legend(
        handles=handles,
        loc="upper right",
        ncol=len(handles),
        title="layer, from the bottom up",
        title_fontsize=13,
        columnspacing=0.9,
        handlelength=1.4,
        handletextpad=0.4,
    )


def _draw(run, chosen, windows, edge, path):
    figure, axes = stack(windows, key_height=0.55)
    for axis, index, window in zip(axes, chosen, windows):
        frame = run.frame(index)
        grains.draw(axis, frame, grains.shades(frame, run.n_bed), window, edge=edge)
        grains.draw_walls(axis, frame)
        window.apply(axis)
        axis.set_title(title_of(run, frame), loc="left")
    add_key(figure, run.frame(chosen[0]), run.n_bed)
    return style.save(figure, path, style.DPI_GRAINS)


def draw(run, chosen, out):
    """layers.png: the whole length at the chosen times."""
    window = grains.whole([run.frame(k) for k in chosen])
    yield _draw(run, chosen, [window] * len(chosen), 0.0, out / "layers.png")


def draw_zoom(run, chosen, out):
    """layers-T.png for each chosen time T: the deformed part, large enough for a slide of its own."""
    frames = [run.frame(k) for k in chosen]
    for index, frame, window in zip(chosen, frames, grains.deformed(run, frames)):
        yield _draw(run, [index], [window], 0.25, out / f"layers-{frame.time:04.0f}s.png")
