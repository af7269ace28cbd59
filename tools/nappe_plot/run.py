"""Reads the folder that `nappe run` leaves: frames, series, summary."""

import json
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import h5py
import numpy as np

from . import fields, tables
from .errors import BadRun

WALL_KEY = 1 << 62  # partners of a contact from here on are walls


class Frame:
    """One stored state. Grains are rows sorted by id, the same in every frame of a run."""

    def __init__(self, path):
        try:
            with h5py.File(path, "r") as file:
                self.step = int(np.ravel(file.attrs["step"])[0])
                self.time = float(np.ravel(file.attrs["time"])[0])
                grains = file["VTKHDF/PointData"]
                self.x = file["VTKHDF/Points"][:, :2]
                self.id = grains["id"][:]
                self.radius = grains["radius"][:]
                self.layer = grains["layer"][:].astype(int)
                self.cells = grains["cells"][:].astype(np.uint64) if "cells" in grains else np.zeros(len(self.id), "u8")
                self.contacts = {name: data[:] for name, data in file["contacts"].items()} if "contacts" in file else {}
                self.walls = {name: _points(wall) for name, wall in file["walls"].items()} if "walls" in file else {}
        except (OSError, KeyError) as error:
            raise BadRun(f"{path} is not a frame of nappe: {error}") from error

    def members(self, cell):
        """Mask of the grains of cell `cell` of the scene."""
        return (self.cells >> np.uint64(cell)) & np.uint64(1) == 1


def _points(wall):
    data = wall["points"] if isinstance(wall, h5py.Group) else wall
    return data[:, :2]


class Run:
    """A run's folder. Frames are opened when asked for; `times` [s] and `frame_paths` run parallel."""

    def __init__(self, folder):
        self.folder = Path(folder).resolve()
        self.times, self.frame_paths = self._index()
        self.summary = self._json("summary.json")
        try:
            self.scene = tomllib.loads(self.summary.get("scene", ""))
        except tomllib.TOMLDecodeError:
            self.scene = {}
        self._frames = {}

    def _index(self):
        """Times [s] and paths of the frames that run.xdmf lists: an earlier run may have left more in the folder."""
        path = self.folder / "run.xdmf"
        try:
            grids = ElementTree.parse(path).getroot().findall("./Domain/Grid/Grid")
            times = [float(grid.find("Time").get("Value")) for grid in grids]
            files = [grid.find("./Geometry/DataItem").text.strip().rsplit(":", 1)[0] for grid in grids]
        except FileNotFoundError:
            raise BadRun(f"{self.folder} holds no run.xdmf; give the folder that `nappe run --out` wrote") from None
        except (ElementTree.ParseError, AttributeError, ValueError) as error:
            raise BadRun(f"{path} is not an index of frames as nappe writes it: {error}") from error
        if not times:
            raise BadRun(f"{path} lists no frame")
        return np.array(times), [self.folder / file for file in files]

    def _json(self, name):
        path = self.folder / name
        if not path.exists():
            return {}
        try:
            return json.loads(path.read_text())
        except json.JSONDecodeError as error:
            raise BadRun(f"{path} is not JSON: {error}") from error

    def frame(self, index):
        if index not in self._frames:
            self._frames[index] = Frame(self.frame_paths[index])
        return self._frames[index]

    def field(self, index):
        """The fields measured at frame `index`, or None."""
        name = self.frame_paths[index].name.replace("frame-", "fields-")
        path = self.folder / "measures" / "fields" / name
        return fields.read(path) if path.exists() else None

    def choose(self, wanted=None):
        """Indices of the frames nearest the times [s]; by default the first, those at 40 and 70 %, the last."""
        first, last = self.times[0], self.times[-1]
        if wanted is None:
            wanted = [first, first + 0.4 * (last - first), first + 0.7 * (last - first), last]
        return sorted({int(np.argmin(abs(self.times - t))) for t in wanted})

    def series(self, name):
        """Columns of series/NAME.csv as arrays, or None if the run has no such series or no row in it yet."""
        return tables.read(self.folder / "series" / f"{name}.csv")

    def measured(self, name):
        """The same of measures/NAME.csv."""
        return tables.read(self.folder / "measures" / f"{name}.csv")

    def series_names(self, prefix):
        """NAME of each series/PREFIX-NAME.csv, in alphabetical order."""
        return sorted(path.stem[len(prefix) + 1 :] for path in self.folder.glob(f"series/{prefix}-*.csv"))

    @property
    def cell_names(self):
        """In the scene's order, which is that of the bits in a frame's `cells`."""
        cells = self.scene.get("output", {}).get("cells", [])
        return [cell.get("name", str(k)) for k, cell in enumerate(cells)] or self.series_names("cell")

    @property
    def n_bed(self):
        """Layers of the bed; a grain above it has the next number."""
        layers = self.scene.get("sample", {}).get("layers", {})
        return len(layers) if isinstance(layers, list) else int(layers.get("count", 1))

    @property
    def h(self):
        """The time [s] that a frame's impulses were gathered in: force = impulse / h."""
        if "h" in self.summary:
            return float(self.summary["h"])
        solver = dict(self.scene.get("solver", {}))
        return float(solver.get("h", 1.0)) / float(solver.get("substeps", 1))

    @property
    def gamma(self):
        """Largest cohesion [N] of the scene's materials and laws; None if neither says any."""
        bodies = [*self.scene.get("materials", {}).values(), *self.scene.get("laws", [])]
        return max((float(body["gamma"]) for body in bodies if "gamma" in body), default=None)

    def moving_wall(self):
        """Name and series of the wall that travels farthest, or (None, None)."""
        farthest = (0.0, None, None)
        for name in self.series_names("wall"):
            wall = self.series(f"wall-{name}")
            if wall is None:
                continue
            travel = np.hypot(wall["x"][-1] - wall["x"][0], wall["y"][-1] - wall["y"][0])
            if travel > farthest[0]:
                farthest = (travel, name, wall)
        return farthest[1:]
