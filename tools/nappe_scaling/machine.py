"""A machine as the model sees it. Every figure is a parameter; where they come from is written beside them in the
machine's file (tools/nappe_scaling/machines/*.json) and in docs/scaling.md."""

import dataclasses
import json
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "machines"


class BadMachine(Exception):
    """The file describes no machine."""


@dataclasses.dataclass
class Machine:
    name: str
    ranks_per_node: int
    near_latency: float  # of a message within a node [s]
    near_bandwidth: float  # of one rank within a node [B/s]
    far_latency: float  # of a message between nodes [s]
    node_bandwidth: float  # of a node's network port, shared by its ranks [B/s]
    overhead: float  # a core's time to post or to complete one message [s]
    pack: float  # a core's time to gather or scatter one byte of a message [s/B]
    relaxation: list  # [[bytes of a rank's contacts and grains, ns per relaxation], ...], one rank alone on its memory
    contact_bytes: float  # of a packed contact, read and partly written in a sweep
    grain_bytes: float  # of a grain's velocities
    traffic: float  # bytes that a relaxation moves to and from memory once nothing stays in cache
    node_cache: float  # last level, of all ranks of a node together [B]
    node_memory_bandwidth: float  # [B/s]
    other: float  # everything of a step but sweeps, exchange and rebuilds [s per grain]
    rebuild: float  # of the lists [s per grain]
    steps_per_rebuild: float
    exchanges_per_rebuild: float  # all-to-all exchanges that a rebuild needs
    alltoall: float  # of one of them, per rank it goes through [s]
    notes: str = ""

    def working_set(self, cut):
        """Bytes that the sweeps of each part go through."""
        return self.contact_bytes * cut.relaxations + self.grain_bytes * cut.grains

    def seconds_per_relaxation(self, cut):
        """Of each part: the table's at its working set; at least the node's memory bandwidth shared out, where what
        the node's ranks sweep is beyond its cache."""
        size = self.working_set(cut)
        table = np.array(self.relaxation, float)
        seconds = 1e-9 * np.interp(np.log(np.maximum(size, 1.0)), np.log(table[:, 0]), table[:, 1])
        ranks = min(self.ranks_per_node, cut.parts)
        beyond = size * ranks > self.node_cache
        return np.where(beyond, np.maximum(seconds, self.traffic * ranks / self.node_memory_bandwidth), seconds)

    def same_node(self, a, b):
        """Parts are placed on nodes in their order: the cut is recursive, so neighbours in number are near in space."""
        return a // self.ranks_per_node == b // self.ranks_per_node

    def latency(self, near):
        return np.where(near, self.near_latency, self.far_latency)

    def seconds_per_byte(self, near, parts):
        ranks = min(self.ranks_per_node, parts)
        return np.where(near, 1 / self.near_bandwidth, ranks / self.node_bandwidth)

    def allreduce(self, parts):
        """A tree up and down: within the nodes, then between them."""
        near = np.ceil(np.log2(min(parts, self.ranks_per_node)))
        far = np.ceil(np.log2(max(1.0, parts / self.ranks_per_node)))
        return near * (self.near_latency + 2 * self.overhead) + far * (self.far_latency + 2 * self.overhead)


def read(name):
    """A machine by the name of a file here, or by a path; fields not given are those of `base`, if it names one."""
    path = FOLDER / f"{name}.json" if "/" not in name and not name.endswith(".json") else Path(name)
    try:
        data = json.loads(path.read_text())
        base = data.pop("base", None)
        fields = dataclasses.asdict(read(base)) | data if base else data
        return Machine(**fields)
    except (OSError, ValueError, TypeError) as error:
        known = ", ".join(sorted(p.stem for p in FOLDER.glob("*.json")))
        raise BadMachine(f'"{name}" is no machine: {error}; known are {known}, or give a file') from error


def fit_messages(measured):
    """(latency [s], bandwidth [B/s], overhead [s]) of what benchmark.ping_pong printed, by its quiet quartile: relative
    least squares of one_way = latency + bytes / bandwidth; overhead is half of what an exchange of 8 bytes takes."""
    size = np.array([row["bytes"] for row in measured["messages"]], float)
    time = np.array([row["one_way"][0] for row in measured["messages"]])
    matrix = np.stack([np.ones_like(size), size], axis=1) / time[:, None]
    (latency, per_byte), *_ = np.linalg.lstsq(matrix, np.ones_like(time), rcond=None)
    return latency, 1 / per_byte, measured["messages"][0]["exchange"][0] / 2


def with_bench(machine, path):
    """The same machine with what `nappe bench` measured of the code: relaxations by its fastest kernel, the other
    stages of a step, lists."""
    try:
        bench = json.loads(Path(path).read_text())
        contacts = {row["grains"]: row["contacts"] for row in bench["bandwidth"]}
        fastest = {}
        for row in bench["kernels"]:
            fastest[row["grains"]] = min(row["ns"], fastest.get(row["grains"], np.inf))
        table = [
            [machine.contact_bytes * contacts[n] + machine.grain_bytes * n, ns] for n, ns in sorted(fastest.items())
        ]
        stages = ("predict_ms", "geometry_ms", "integrate_ms", "check_ms", "measure_ms")
        other = [1e-3 * sum(row[s] for s in stages) / row["grains"] for row in bench["steps"]]
        rebuild = [1e-9 * row["rebuild_ns_per_grain"] for row in bench["memory"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadMachine(f"{path} holds no figures of nappe bench: {error!r}") from error
    return dataclasses.replace(
        machine, relaxation=table, other=float(np.median(other)), rebuild=float(np.median(rebuild))
    )
