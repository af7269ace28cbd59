"""The runs of the study: jobs/fault.toml with the geometry, the cohesion and the seed that each of them asks for."""

import dataclasses
import itertools
import math
import tomllib
from pathlib import Path

SCENE = Path(__file__).resolve().parents[2] / "jobs" / "fault.toml"
SPEED = 0.325  # m/s, of the hanging wall along the fault
FACE = 16.0  # m, of the hanging wall's front below the tip: more than it slips


@dataclasses.dataclass(frozen=True)
class Plan:
    """What is varied, and the sizes that are not. Values stand in the order in which they are wanted."""

    thetas: tuple  # degrees, dip of the fault
    heights: tuple  # m
    gammas: tuple  # N
    seeds: tuple
    behind: float  # m of hanging wall behind the tip at the start
    ahead: float  # m of footwall beyond the reach of the zone
    duration: float  # s
    frames_every: int  # steps

    def samples(self):
        """Every (theta, height, seed) once: seed after seed, so that the whole plane is covered before it is repeated;
        within a seed the reference, then what differs from it in one of the two, then the corners."""
        planes = sorted(itertools.product(self.thetas, self.heights), key=self._differences)
        return [(theta, height, seed) for seed in self.seeds for theta, height in planes]

    def _differences(self, plane):
        return (plane[0] != self.thetas[0]) + (plane[1] != self.heights[0])

    def runs(self):
        """In the order of their importance; the gammas of one settled sample follow each other."""
        return [
            StudyRun(self, index, theta, height, gamma, seed)
            for index, (theta, height, seed) in enumerate(self.samples())
            for gamma in self.gammas
        ]


FULL = Plan((30, 20, 45), (15, 10, 22.5), (0.0, 1e3, 1e4, 1e5), (1, 2, 3), 30.0, 20.0, 40.0, 400)
QUICK = Plan((30, 45), (3,), (0.0, 1e5), (1, 2), 6.0, 4.0, 0.2, 10)  # seconds, to try the tool; says nothing of faults


def number(value):
    """As short as it reads back: 30, 22.5, 1e4."""
    text = f"{value:g}"
    short = f"{value:.0e}".replace("e+0", "e") if value >= 1000 else text
    return short if float(short) == value else text


def toml(value):
    """A name, a number or points: what --set takes for it."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(part) for part in value) + "]"
    return f"{value:.10g}"


@dataclasses.dataclass(frozen=True)
class StudyRun:
    """One run; `sample` numbers the settled sample that it shares with the other gammas."""

    plan: Plan
    sample: int
    theta: float  # degrees
    height: float  # m
    gamma: float  # N
    seed: int

    @property
    def name(self):
        return f"theta{number(self.theta)}-h{number(self.height)}-gamma{number(self.gamma)}-seed{self.seed}"

    @property
    def tip(self):
        return [self.plan.behind, 0.0]

    @property
    def direction(self):
        angle = math.radians(self.theta)
        return [math.cos(angle), math.sin(angle)]

    @property
    def length(self):
        """Of the box [m]: 1.35 times the run of the fault up to the surface fits between the tip and the rest, which
        the zone's right limit and the front stay within (`report` checks it)."""
        return self.plan.behind + 1.35 * self.height / math.tan(math.radians(self.theta)) + self.plan.ahead

    @property
    def surface_point(self):
        """x [m] where the line of the fault meets the surface of the bed at the start."""
        return self.plan.behind + self.height / math.tan(math.radians(self.theta))

    def settings(self):
        """Keys of the scene and their values here, in the order of the scene."""
        (tip, _), (along, up), length, height = self.tip, self.direction, self.length, self.height
        back, foot = [tip - FACE * along, -FACE * up], [0.0, 0.0]
        return {
            "materials.rock.gamma": self.gamma,
            "sample.profile": [foot, [length, 0.0], [length, height], [0.0, height]],
            "sample.layers.to": height,
            "sample.seed": self.seed,
            "walls.hanging.points": [[0.0, 2 * height], foot, self.tip, back],
            "walls.hanging.motion.velocity": [SPEED * along, SPEED * up],
            "walls.footwall.points": [self.tip, [length, 0.0], [length, 2 * height]],
            "stages.slip.duration": self.plan.duration,
            "output.frames.every": self.plan.frames_every,
            "output.cells.W1.centre": [tip + 2 * height / 3, height / 2],
            "output.cells.W1.radius": 0.4 * height,
            "output.zone.wall": "hanging",
            "output.zone.tip": self.tip,
        }

    def command(self, nappe, out, scene=SCENE):
        """To be run with one rank; the samples are shared by the whole study."""
        command = [str(nappe), "run", str(scene), "--out", str(out / self.name), "--samples", str(out / "samples")]
        for key, value in self.settings().items():
            command += ["--set", f"{key}={toml(value)}"]
        return command

    def restart_command(self, nappe, out):
        """Goes on where an earlier attempt left a checkpoint."""
        return [str(nappe), "restart", str(out / self.name)]

    def scene_of(self, summary):
        """The scene as run, or None if the summary does not have it."""
        try:
            return tomllib.loads(summary["scene"])
        except (KeyError, TypeError, tomllib.TOMLDecodeError):
            return None

    def is_scene(self, scene):
        """Whether this scene as run is that of this very run."""
        try:
            return all(_equal(_find(scene, key), value) for key, value in self.settings().items())
        except (KeyError, TypeError):
            return False

    def is_done(self, summary):
        """Whether this is the summary of this very run, carried to its end."""
        scene = self.scene_of(summary)
        try:
            whole = not summary["stopped_early"] and summary["steps"] == self.steps(scene)
            return whole and self.is_scene(scene)
        except (KeyError, TypeError):
            return False

    def steps(self, scene):
        return round(self.plan.duration / scene["solver"]["h"])


def _find(scene, key):
    """The value of a dotted key as --set takes it: an element of an array by its name."""
    for part in key.split("."):
        if isinstance(scene, list):
            scene = {element["name"]: element for element in scene}
        scene = scene[part]
    return scene


def _equal(found, wanted):
    if isinstance(wanted, (list, tuple)):
        return len(found) == len(wanted) and all(map(_equal, found, wanted))
    return found == wanted if isinstance(wanted, str) else float(found) == float(toml(wanted))
