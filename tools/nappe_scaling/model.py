"""From counts and a machine to the time of a sweep and of a step. Names as in docs/scaling.md."""

import dataclasses

import numpy as np

from .counts import COLOURS

SWEEPS_SIMULATED = 24  # of which the first third, in which waits build up, does not count


@dataclasses.dataclass
class Sweep:
    """Seconds of one sweep."""

    work: float  # no rank ever waits: a lower bound
    coupled: float  # ranks wait for the neighbours they hear from, colour by colour
    barrier: float  # all ranks wait for all after each colour: an upper bound
    exposed: float  # share of the coupled sweep that the mean rank neither relaxes


class _Pieces:
    """What each rank does in each colour, and when its messages are under way, as arrays [part, colour]."""

    def __init__(self, cut, machine):
        self.cut = cut
        c = machine.seconds_per_relaxation(cut)[:, None]
        sends, receives = cut.per_part(cut.sender), cut.per_part(cut.receiver)
        sent, received = cut.per_part(cut.sender, cut.bytes), cut.per_part(cut.receiver, cut.bytes)
        self.relaxing = c * (cut.interface + cut.interior)
        self.interior = c * cut.interior
        self.before = c * cut.interface + machine.pack * sent + machine.overhead * (sends + receives)
        self.after = machine.pack * received + machine.overhead * receives
        # A rank's messages of a colour leave through one port: each arrives when all bytes are out.
        near = machine.same_node(cut.sender, cut.receiver)
        seconds = machine.seconds_per_byte(near, cut.parts) * cut.bytes
        port = cut.per_part(cut.sender, seconds)
        self.flight = machine.latency(near) + port[cut.sender, cut.colour]
        self.of_colour = [np.flatnonzero(cut.colour == k) for k in range(COLOURS)]

    def end_of_colour(self, start, k):
        """When each rank is through colour k, having begun it at `start`."""
        ready = start + self.before[:, k]
        end = ready + self.interior[:, k]
        m = self.of_colour[k]
        np.maximum.at(end, self.cut.receiver[m], ready[self.cut.sender[m]] + self.flight[m])
        return end + self.after[:, k]


def sweep(cut, machine):
    pieces = _Pieces(cut, machine)
    own = pieces.before + pieces.interior + pieces.after
    barrier = sum(pieces.end_of_colour(np.zeros(cut.parts), k).max() for k in range(COLOURS))
    at = np.zeros(cut.parts)
    ends = []
    for _ in range(SWEEPS_SIMULATED):
        for k in range(COLOURS):
            at = pieces.end_of_colour(at, k)
        ends.append(at.max())
    first = SWEEPS_SIMULATED // 3
    coupled = (ends[-1] - ends[first - 1]) / (SWEEPS_SIMULATED - first)
    relaxing = pieces.relaxing.sum(axis=1).mean()
    return Sweep(own.sum(axis=1).max(), coupled, barrier, max(0.0, 1 - relaxing / coupled))


@dataclasses.dataclass
class Step:
    """Seconds of one step, by what they go to."""

    sweeps: float  # coupled
    fastest: float  # the whole step by the lower bound of its sweeps
    slowest: float  # and by the upper
    other: float
    rebuild: float  # mean per step
    allreduce: float
    exposed: float

    @property
    def total(self):
        return self.sweeps + self.other + self.rebuild + self.allreduce


def step(cut, machine, sweeps):
    one = sweep(cut, machine)
    grains = cut.grains.max()
    other = machine.other * grains
    rebuild = machine.rebuild * grains / machine.steps_per_rebuild
    allreduce = 0.0
    if cut.parts > 1:
        rebuild += machine.exchanges_per_rebuild * machine.alltoall * cut.parts / machine.steps_per_rebuild
        allreduce = machine.allreduce(cut.parts)
    rest = other + rebuild + allreduce
    # The warm start is one more pass over contacts and messages.
    passes = sweeps + 1
    return Step(passes * one.coupled, passes * one.work + rest, passes * one.barrier + rest, other, rebuild, allreduce,
                one.exposed)
