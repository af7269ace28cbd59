"""The layers with the marks of a fault: its direction, the limits of its zone, the front (Fig. 12)."""

from . import fault, grains, layers, style
from .views import whole_windows


def draw(views, out):
    """profile.png: a panel per view."""
    if any(fault.of(view.run) is None for view in views):
        return
    figure, axes = layers.stack(whole_windows(views), key_height=0.55)
    for axis, view, window in zip(axes, views, whole_windows(views)):
        frame = view.frame
        grains.draw(axis, frame, grains.shades(frame, view.run.n_bed), window)
        grains.draw_walls(axis, frame)
        fault.draw_marks(axis, view.run, frame)
        window.apply(axis)
        axis.set_title(view.label, loc="left")
    layers.add_key(figure, views[0].frame, views[0].run.n_bed)
    yield style.save(figure, out / "profile.png", style.DPI_GRAINS)
