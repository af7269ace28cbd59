"""What a picture with several panels shows: a run at a moment, with the panel's title. One run at several times, or
several runs at their last."""

import dataclasses
import math

import numpy as np

from . import fault, grains, layers
from .run import Run


@dataclasses.dataclass
class View:
    run: Run
    index: int  # of the frame
    label: str

    @property
    def frame(self):
        return self.run.frame(self.index)

    @property
    def field(self):
        return self.run.field(self.index)

    @property
    def zone(self):
        """Figures of the fault's zone at this moment, or None."""
        return fault.row_at(self.run.measured("zone"), self.frame.time)


def of_one(run, chosen):
    """A view per chosen frame."""
    return [View(run, index, layers.title_of(run, run.frame(index))) for index in chosen]


def of_several(runs, labels, wanted=None):
    """A view per run, at its last frame or at the one nearest the time wanted [s]."""
    indices = [len(run.times) - 1 if wanted is None else int(np.argmin(abs(run.times - wanted))) for run in runs]
    return [View(run, index, label) for run, index, label in zip(runs, indices, labels)]


def default_labels(runs):
    """By cohesion if that tells them apart, else by the folders' names."""
    gammas = [run.gamma for run in runs]
    if None in gammas or len(set(gammas)) < len(runs):
        return [run.folder.name for run in runs]
    return [rf"$\gamma$ = {_power(gamma)} N" for gamma in gammas]


def _power(value):
    """0, 250, 10⁴, 2·10⁴."""
    if value < 1000:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-12)
    factor = value / 10**exponent
    shown = f"10^{{{exponent}}}" if abs(factor - 1) < 1e-9 else rf"{factor:g}\cdot 10^{{{exponent}}}"
    return f"${shown}$"


def whole_windows(views):
    return [grains.whole([view.frame for view in views])] * len(views)


def zoomed(views):
    """A window per view, all of one size: around the fault's zone, or what is deformed where there is no fault."""
    faults = [fault.of(view.run) for view in views]
    if None in faults:
        return deformed(views)
    low = min(one.tip[1] for one in faults)
    high = max(view.frame.x[:, 1].max() for view in views)
    height = high - low
    left = min(one.tip[0] for one in faults) - 1.5 * height
    right = max(one.line(high) for one in faults) + 1.5 * height
    return [grains.Window(left, right, low - 0.06 * height, high + 0.06 * height)] * len(views)


def deformed(views):
    """A window per view, all of one size: what is deformed."""
    windows = {}
    for run in {id(view.run): view.run for view in views}.values():
        own = [view for view in views if view.run is run]
        windows |= zip(map(id, own), grains.deformed(run, [view.frame for view in own]))
    width = max(window.x[1] - window.x[0] for window in windows.values())
    low, high = (pick(w.y[k] for w in windows.values()) for k, pick in ((0, min), (1, max)))
    return [_from(windows[id(view)].x[0], width, low, high) for view in views]


def _from(left, width, low, high):
    return grains.Window(left, left + width, low, high)
