"""The runs: scenes of jobs/ with changed keys."""

import dataclasses
import re
from pathlib import Path

JOBS = Path(__file__).resolve().parents[2] / "jobs"
ROWS = ["1-10", "0.5-10-a", "0.5-10-b", "0.5-10-c", "0.5-2.5-c", "1-2.5-c", "1-10-c"]  # table 1
LATTICES = ["1-10-c-square", "1-10-c-staggered"]
RIGID = ["0.5-10-rigid", "1-10-rigid"]
FRICTIONS = [0.1, 0.3, 0.8]  # the scenes have 0.5
SEEDS = [2, 3, 4, 5]  # the scenes have 1
SEEDED = ["1-10", "0.5-10-b", "0.5-10-c", "0.5-2.5-c", "1-2.5-c", "1-10-c", *RIGID]  # other samples of the same
BOTH = ["0.5-10-c", "1-10-c"]  # that RIGID has without springs
N_LAWS = 5


@dataclasses.dataclass
class Planned:
    name: str
    job: str
    keys: dict
    group: str

    @property
    def scene(self):
        return JOBS / f"rockfall-{self.job}.toml"


def printed_step(job):
    """The step of table 1, which the scene names beside its own."""
    return re.search(r"# printed: ([0-9.e-]+)", (JOBS / f"rockfall-{job}.toml").read_text())[1]


def _own_step(job):
    return float(re.search(r'name = "fall".*?h = ([0-9.e-]+)', (JOBS / f"rockfall-{job}.toml").read_text(), re.S)[1])


def _rarer(job, h):
    """Intervals of output in steps of h, for the same times as the scene's."""
    text = (JOBS / f"rockfall-{job}.toml").read_text()
    ratio = _own_step(job) / h
    keys = {}
    for path, pattern in (("output.frames.every", r"frames = { every = (\d+)"), ("output.series.every", r"series = { every = (\d+)")):
        keys[path] = max(1, round(ratio * int(re.search(pattern, text)[1])))
    every = max(1, round(ratio * int(re.search(r'name = "block".*?every = (\d+)', text)[1])))
    keys |= {"output.probes.0.every": every}
    keys |= {f"output.gauges.{k}.every": every for k in range(6)}
    return keys


def planned():
    runs = [Planned(job, job, {}, "table") for job in ROWS]
    for job in ROWS:
        h = printed_step(job)
        keys = {"stages.fall.solver.h": h, "stages.fall.solver.unsafe": "true"} | _rarer(job, float(h))
        runs.append(Planned(f"{job}-printed", job, keys, "printed"))
    runs += [Planned(job, job, {}, "lattice") for job in LATTICES]
    runs += [Planned(job, job, {}, "rigid") for job in RIGID]
    for job in ("0.5-10-c", "0.5-10-rigid"):
        for mu in FRICTIONS:
            keys = {f"laws.{k}.friction": mu for k in range(N_LAWS)}
            runs.append(Planned(f"{job}-mu{mu}", job, keys, "friction"))
    for job in SEEDED:
        for seed in SEEDS:
            runs.append(Planned(seeded(job, seed), job, {"sample.seed": seed}, "seed"))
    for job in ("0.5-10-c", "0.5-10-rigid"):
        half = _own_step(job) / 2
        keys = {"stages.fall.solver.h": half} | _rarer(job, half)
        runs.append(Planned(f"{job}-half-step", job, keys, "step"))
    runs.append(Planned("0.5-10-rigid-400-sweeps", "0.5-10-rigid", {"stages.fall.solver.sweeps": 400}, "step"))
    solved = {"stages.fall.solver.tolerance": 1e-2, "stages.fall.solver.max_sweeps": 20000}
    runs += [Planned(f"{job}-solved", job, solved, "step") for job in RIGID]
    return runs + undamped()


def seeded(job, seed):
    """Name of the run of another sample."""
    return f"{job}-seed{seed}"


UNDAMPED = ["free-rock", "spins", "free-rock-spins", "undamped"]


def undamped():
    """Springs without some of the global damping that rigid grains have none of: without C and C* of the rock, without C* of
    all, without both, without any."""
    rock, rock_spin = {"materials.rock.damping": 0}, {"materials.rock.spin_damping": 0}
    soil, soil_spin = {"materials.soil.damping": 0}, {"materials.soil.spin_damping": 0}
    keys = [rock | rock_spin, rock_spin | soil_spin, rock | rock_spin | soil_spin, rock | rock_spin | soil | soil_spin]
    return [Planned(f"{job}-{name}", job, key, "undamped") for job in BOTH for name, key in zip(UNDAMPED, keys)]
