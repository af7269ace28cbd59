"""Reads the coarse-grained fields that are measured at a frame (VTKHDF, ImageData)."""

import h5py
import numpy as np

from .errors import BadRun


class Field:
    """Fields on a grid at one moment; NaN outside the material.

    x (nx), y (ny): nodes [m]; speed, shear_rate, shear_strain (ny, nx) and velocity (ny, nx, 2): [m/s], [1/s], 1.
    """

    def __init__(self, x, y, values):
        self.x, self.y = x, y
        self.velocity = values["velocity"][..., :2]
        self.shear_rate = values["shear_rate"]
        self.shear_strain = values["shear_strain"]

    @property
    def speed(self):
        return np.hypot(self.velocity[..., 0], self.velocity[..., 1])


def first_layer(array, shape):
    """nappe stores an image in the plane as two equal layers (docs/measures.md)."""
    return array[:].reshape(-1, *shape)[0]


def read(path):
    try:
        with h5py.File(path, "r") as file:
            image = file["VTKHDF"]
            extent = np.ravel(image.attrs["WholeExtent"]).astype(int)
            origin, spacing = (np.ravel(image.attrs[name]) for name in ("Origin", "Spacing"))
            axes = [origin[k] + spacing[k] * np.arange(extent[2 * k], extent[2 * k + 1] + 1) for k in (0, 1)]
            shape = len(axes[1]), len(axes[0])
            names = {"velocity": (3,), "shear_rate": (), "shear_strain": ()}
            values = {name: first_layer(image["PointData"][name], (*shape, *tail)) for name, tail in names.items()}
    except (OSError, KeyError, ValueError) as error:
        raise BadRun(f"{path} holds no fields of nappe measure: {error}") from error
    return Field(*axes, values)
