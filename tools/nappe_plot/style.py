"""How the pictures look: sizes made for a slide 13 inches wide, letters no smaller than 10 points there."""

import matplotlib

matplotlib.use("Agg")  # no display needed; must come before pyplot
import matplotlib.pyplot as plt

from . import palette

WIDE = 16.0  # inches: a picture of the whole length
PLOT = (11.0, 7.0)  # inches: curves
DPI_GRAINS = 300  # the 1000 m fold then has 4.5 pixels a metre, enough to see its grains
DPI_CHAINS = 200  # zoomed already
DPI_FIELDS = 150
DPI_CURVES = 160
UNTIL = float("inf")  # s: where curves of a fall end


def apply():
    plt.rcParams.update(
        {
            "font.family": "DejaVu Sans",
            "font.size": 14,
            "axes.titlesize": 15,
            "axes.labelsize": 15,
            "axes.edgecolor": palette.INK,
            "axes.linewidth": 1.0,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "grid.color": "#dddddd",
            "grid.linewidth": 0.8,
            "axes.axisbelow": True,
            "legend.frameon": False,
            "legend.fontsize": 13,
            "lines.linewidth": 2.2,
            "figure.facecolor": "white",
            "axes.formatter.useoffset": False,
            "axes.formatter.limits": (-4, 5),
            "axes.formatter.use_mathtext": True,
        }
    )


def save(figure, path, dpi):
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi)
    plt.close(figure)
    return path


def seconds(time):
    """A time as a title shows it."""
    return f"{time:.0f} s" if abs(time - round(time)) < 5e-3 or time >= 100 else f"{time:.3g} s"
