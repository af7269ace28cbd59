"""Disks and walls on a picture's axes, to scale."""

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.patches import Patch

from . import palette


class Window:
    """A rectangle of the plane [m]."""

    def __init__(self, x_min, x_max, y_min, y_max):
        self.x = (x_min, x_max)
        self.y = (y_min, y_max)

    @property
    def aspect(self):
        return (self.x[1] - self.x[0]) / (self.y[1] - self.y[0])

    def holds(self, x, margin=0.0):
        """Mask of the points inside, or outside by less than the margin."""
        return (
            (x[:, 0] > self.x[0] - margin)
            & (x[:, 0] < self.x[1] + margin)
            & (x[:, 1] > self.y[0] - margin)
            & (x[:, 1] < self.y[1] + margin)
        )

    def apply(self, axes):
        axes.set_xlim(self.x)
        axes.set_ylim(self.y)
        axes.set_aspect("equal")
        axes.grid(False)


def whole(frames):
    """The window that holds every grain of every frame, and the walls up to a little above the highest grain."""
    low = np.min([(f.x - f.radius[:, None]).min(axis=0) for f in frames], axis=0)
    high = np.max([(f.x + f.radius[:, None]).max(axis=0) for f in frames], axis=0)
    walls = [points for f in frames for points in f.walls.values()]
    if walls:
        corners = np.concatenate(walls)
        low = np.minimum(low, [corners[:, 0].min(), max(corners[:, 1].min(), low[1] - 0.1 * (high[1] - low[1]))])
        high[0] = max(high[0], corners[:, 0].max())
    margin = 0.01 * (high[0] - low[0])
    return Window(low[0] - margin, high[0] + margin, low[1] - margin / 2, high[1] + 0.06 * (high[1] - low[1]))


def deformed(run, frames):
    """One window per frame, all of one size, from behind the moving side to where the grains still lie as at first.

    What has moved by more than two mean diameters counts; of those the farthest 0.2 % do not, since grains that
    tumbled down the slope would stretch the picture.
    """
    first = run.frame(0)
    box = whole(frames)
    length = box.x[1] - box.x[0]
    left, reach = [], 0.0
    for frame in frames:
        left.append((frame.x[:, 0] - frame.radius).min())
        moved = np.hypot(*(frame.x - first.x).T) > 4 * first.radius.mean()
        if moved.sum() > 20:
            reach = max(reach, np.quantile(frame.x[moved, 0], 0.998) - left[-1])
    width = min(1.12 * reach, length) if reach > 0 else length
    width = max(width, 2.0 * (box.y[1] - box.y[0]))
    margin = 0.02 * width
    return [Window(x - margin, x - margin + width, *box.y) for x in left]


def shades(frame, n_bed, pale=0.0):
    """An RGB row per grain: its layer's colour, a little lighter or darker from grain to grain, as sand is.

    pale in [0, 1] moves all towards white.
    """
    table = np.array([palette.rgb(palette.layer_colour(k, n_bed)) for k in range(1, max(frame.layer.max(), 1) + 1)])
    colours = table[np.maximum(frame.layer, 1) - 1]
    scatter = (frame.id.astype(np.uint64) * np.uint64(11400714819323198485) >> np.uint64(40)) / 2.0**24
    colours = np.clip(colours * (0.90 + 0.18 * scatter[:, None]), 0, 1)
    return colours + (1 - colours) * pale


def draw(axes, frame, colours, window, edge=0.0, mask=None):
    """Every disk as a filled circle of its own radius; `edge` is the outline's width in points."""
    seen = window.holds(frame.x, margin=frame.radius.max())
    if mask is not None:
        seen &= mask
    size = 2 * frame.radius[seen]
    axes.add_collection(
        EllipseCollection(
            size,
            size,
            np.zeros(seen.sum()),
            units="xy",
            offsets=frame.x[seen],
            offset_transform=axes.transData,
            facecolors=colours[seen],
            edgecolors=colours[seen] * 0.55 if edge else "none",
            linewidths=edge,
        )
    )


def draw_walls(axes, frame):
    for points in frame.walls.values():
        axes.plot(points[:, 0], points[:, 1], color=palette.WALL, linewidth=2.5, solid_capstyle="round", zorder=3)


def layer_key(frame, n_bed):
    """Handles of a legend: the layers that occur, from the bottom up."""
    return [
        Patch(
            facecolor=palette.layer_colour(layer, n_bed),
            edgecolor=palette.INK,
            linewidth=0.6,
            label="wedge" if layer > n_bed else f"{layer}",
        )
        for layer in np.unique(frame.layer)
    ]
