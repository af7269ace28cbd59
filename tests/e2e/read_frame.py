"""Reads the frames of tests/e2e/write_run.cpp with h5py and compares every dataset with the formulas of
tests/parallel/made_up_frame.hpp. Usage: read_frame.py DIR"""
import pathlib
import sys

import h5py
import numpy as np

WALL_KEY = 1 << 62


def grains(n):
    i = np.arange(n)
    zero = np.zeros(n)
    radius = 0.42 + 0.01 * (i % 15)
    return {
        "Points": np.stack([i / 3, -i / 7, zero], axis=1),
        "Connectivity": i,
        "Offsets": np.arange(n + 1),
        "Types": np.full(n, 1, np.uint8),
        "NumberOfPoints": np.array([n]),
        "NumberOfCells": np.array([n]),
        "NumberOfConnectivityIds": np.array([n]),
        "PointData/id": i,
        "PointData/velocity": np.stack([0.1 * i, -zero, zero], axis=1),
        "PointData/spin": 1 / (i + 1),
        "PointData/rotation": -i.astype(float),
        "PointData/radius": radius,
        "PointData/mass": 2800 * radius * radius,
        "PointData/layer": (1 + i % 9).astype(np.int32),
        "PointData/material": (i % 2).astype(np.int32),
        "PointData/coordination": (i % 4).astype(np.int32),
        "PointData/pressure": 1e3 * i,
        "PointData/rank": zero.astype(np.int32),  # two ranks: all grains on the first
        "PointData/cells": i.astype(np.uint64) | np.uint64(1 << 63),
    }


def contacts(n, there):
    rows = []
    for i in range(n if there else 0):
        if i + 1 < n:
            rows.append((i, i + 1, -1, i / 11, -i / 13))
        if i % 3 == 0:
            rows.append((i, WALL_KEY + 2 * i, 1, 5.0 * i, 0.25))
    lo = np.array([row[0] for row in rows], np.int64)
    zero = np.zeros(len(rows))
    return {
        "index": np.arange(len(rows)),
        "lo": lo,
        "hi": np.array([row[1] for row in rows], np.int64),
        "wall": np.array([row[2] for row in rows], np.int32),
        "point": np.stack([lo.astype(float), zero + 0.5, zero], axis=1),
        "normal": np.stack([zero, zero - 1, zero], axis=1),
        "gap": -1e-3 * lo,
        "r_n": np.array([row[3] for row in rows], float),
        "r_t": np.array([row[4] for row in rows], float),
        "status": (lo % 3).astype(np.int32),
    }


def datasets(group):
    names = []
    group.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return set(names)


def compare(group, expected):
    assert datasets(group) == set(expected), datasets(group) ^ set(expected)
    for name, values in expected.items():
        found = group[name]
        assert found.dtype == values.dtype, (name, found.dtype, values.dtype)
        assert found.shape == values.shape, (name, found.shape, values.shape)
        # The formulas are evaluated in the same order in both languages: equal to the last bit.
        assert np.array_equal(found[()], values), name


def main(folder):
    for k in range(3):
        n = 100 + 10 * k
        with h5py.File(folder / "frames" / f"frame-{250 * k:08}.hdf", "r") as file:
            assert set(file) == {"VTKHDF", "contacts", "walls"}, set(file)
            assert file.attrs["step"] == 250 * k
            assert file.attrs["time"] == 6.25 * k
            assert file.attrs["title"].decode() == "a fold, made up — in UTF-8", file.attrs["title"]
            assert file.attrs["version"]
            vtk = file["VTKHDF"]
            assert list(vtk.attrs["Version"]) == [1, 0]
            assert vtk.attrs["Type"] == b"UnstructuredGrid"
            compare(vtk, grains(n))
            compare(file["contacts"], contacts(n, k != 1))
            compare(file["walls"], {"floor": np.array([[0.0, 0, 0], [10, 0, 0], [10, 5, 0]]),
                                    "left_wall": np.array([[0.0, 60, 0], [0, 0, 0]])})
            assert [file["walls"][name].attrs["index"] for name in ("floor", "left_wall")] == [0, 1]
    print("three frames read as they were written")


main(pathlib.Path(sys.argv[1]))
