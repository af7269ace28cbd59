"""Force chains: every contact that carries a force, as a line as wide and as dark as the force is large."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize

from . import grains, layers, style
from .run import WALL_KEY
from .views import deformed

INKS = LinearSegmentedColormap.from_list("chains", ["#a9bccb", "#3d6c94", "#0d2340", "#020617"])


def segments(frame, h):
    """(n, 2, 2) end points [m] and (n) normal forces [N per metre of depth], weakest first.

    From centre to centre; against a wall from the centre to the contact point.
    """
    lo, hi, r_n = (frame.contacts[name] for name in ("lo", "hi", "r_n"))
    carries = r_n > 0
    lo, hi, force, point = lo[carries], hi[carries], r_n[carries] / h, frame.contacts["point"][carries, :2]
    ends = np.empty((len(lo), 2, 2))
    ends[:, 0] = frame.x[np.searchsorted(frame.id, lo)]
    ends[:, 1] = point
    between = hi < WALL_KEY
    ends[between, 1] = frame.x[np.searchsorted(frame.id, hi[between])]
    order = np.argsort(force, kind="stable")
    return ends[order], force[order]


def draw(views, out):
    """chains.png: the deformed part of each view, all to one scale of force."""
    views = [view for view in views if view.frame.contacts and (view.frame.contacts["r_n"] > 0).any()]
    if not views:
        return
    lines = [segments(view.frame, view.run.h) for view in views]
    strong = max(np.quantile(force, 0.998) for _, force in lines)
    scale, unit = (1e6, "MN") if strong >= 2e6 else (1e3, "kN")
    norm = Normalize(0, strong / scale, clip=True)
    windows = deformed(views)
    figure, axes = layers.stack(windows, key_height=0.9)
    for axis, view, (ends, force), window in zip(axes, views, lines, windows):
        frame = view.frame
        grains.draw(axis, frame, grains.shades(frame, view.run.n_bed, pale=0.72), window)
        grains.draw_walls(axis, frame)
        window.apply(axis)
        # The strongest is as wide as a mean radius: 72 points an inch, and the panel's inches a metre.
        points_per_metre = 72 * axis.get_position().width * figure.get_figwidth() / (window.x[1] - window.x[0])
        widest = 1.1 * frame.radius.mean() * points_per_metre
        seen = window.holds(ends[:, 0]) & (force > 0.03 * strong)
        axis.add_collection(
            LineCollection(
                ends[seen],
                linewidths=widest * np.minimum(force[seen] / strong, 1),
                colors=INKS(norm(force[seen] / scale)),
                capstyle="round",
                zorder=2,
            )
        )
        axis.set_title(view.label, loc="left")
    height = figure.get_figheight()
    bar = figure.add_axes([0.62, 1 - 0.55 / height, 0.3, 0.16 / height])
    figure.colorbar(ScalarMappable(norm, INKS), cax=bar, orientation="horizontal", extend="max")
    bar.set_title(f"normal force [{unit} per metre of depth]", fontsize=13)
    yield style.save(figure, out / "chains.png", style.DPI_CHAINS)
