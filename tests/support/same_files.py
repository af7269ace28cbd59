"""Two runs that must have left the same: state hash, series, indices, frames and fields (but for the owning rank)."""

import h5py
import numpy as np

from nappe_driver import NappeTest


def contents(path):
    """Everything in an HDF5 file, by name, but the owning ranks."""
    found = {}

    def visit(name, item):
        found.update({f"{name}@{key}": np.asarray(value).tobytes() for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset) and not name.endswith("/rank"):
            found[name] = (item.dtype.str, item.shape, item[()].tobytes())

    with h5py.File(path, "r") as file:
        visit("", file)
        file.visititems(visit)
    return found


class SameFiles(NappeTest):
    def assert_same(self, one, many, but=()):
        self.assertEqual(many.hash, one.hash)
        names = [name for name in one.files() if not name.startswith("checkpoints/")]
        self.assertEqual([name for name in many.files() if not name.startswith("checkpoints/")], names)
        for name in set(names) - set(but):
            a, b = one.out / name, many.out / name
            if name.endswith(".hdf"):
                expected, found = contents(a), contents(b)
                self.assertEqual([k for k in expected if found.get(k) != expected[k]], [], name)
                self.assertEqual(found.keys(), expected.keys())
            elif name != "summary.json":
                self.assertEqual(b.read_bytes(), a.read_bytes(), name)
        same = ["grains", "contacts", "candidates", "steps", "time_simulated", "relaxations", "sweeps", "rebuilds"]
        same += ["redone_lists", "redone_packs", "overlap_mean", "overlap_max", "overlap_max_of_rows", "residual"]
        same += ["residual_max_of_rows"]
        for key in same:
            self.assertEqual(many.summary[key], one.summary[key], key)
