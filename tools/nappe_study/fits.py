"""How a figure depends on cohesion: candidate relations, judged by the beds they were not fitted to."""

import dataclasses
import math

import numpy as np

SCALES = np.logspace(-3, 3, 61)  # of u0, what the cohesion is divided by
WORTH = 0.1  # a relation is supported if it foretells this much better than none does,
SURE = 0.5  # and at least this part of the variance


def _log(u, u0):
    return np.log10(1 + u / u0)


def _saturating(u, u0):
    return u / (u + u0)


@dataclasses.dataclass(frozen=True)
class Relation:
    """y = a + b tan(dip) + c (height / diameter) + e f(u / u0); without f, cohesion plays no part."""

    name: str
    group: str = ""  # attribute of a Result: u
    shape: object = None


RELATIONS = [
    Relation("none"),
    Relation("e log(1 + G / u0)", "by_grain", _log),
    Relation("e log(1 + C / u0)", "by_column", _log),
    Relation("e G / (G + u0)", "by_grain", _saturating),
    Relation("e C / (C + u0)", "by_column", _saturating),
]


class Fit:
    """Least squares of a relation; u0 is the one of SCALES that fits best."""

    def __init__(self, relation, results, y):
        self.relation = relation
        self.u0, self.coefficients, least = math.nan, None, math.inf
        for u0 in SCALES if relation.shape else [math.nan]:
            terms = self._terms(results, u0)
            coefficients = np.linalg.lstsq(terms, y, rcond=None)[0]  # the least norm where a term does not vary
            misfit = ((terms @ coefficients - y) ** 2).sum()
            if misfit < least * (1 - 1e-12):
                self.u0, self.coefficients, least = u0, coefficients, misfit

    def _terms(self, results, u0):
        columns = [
            np.ones(len(results)),
            [math.tan(math.radians(result.run.theta)) for result in results],
            [result.diameters for result in results],
        ]
        if self.relation.shape:
            columns.append(self.relation.shape(np.array([getattr(r, self.relation.group) for r in results]), u0))
        return np.column_stack(columns)

    def __call__(self, results):
        return self._terms(results, self.u0) @ self.coefficients


def _bed(result):
    return result.run.theta, result.run.height


def foretold(relation, results, y):
    """y of each run by the fit to all other beds (dip and height); None with fewer than four beds."""
    beds = [_bed(result) for result in results]
    if len(set(beds)) < 4:
        return None
    guess = np.empty(len(y))
    for bed in set(beds):
        out = np.array([one == bed for one in beds])
        kept = [result for result, left_out in zip(results, out) if not left_out]
        fit = Fit(relation, kept, y[~out])
        guess[out] = fit([result for result, left_out in zip(results, out) if left_out])
    return guess


def _explained(guess, y):
    total = ((y - y.mean()) ** 2).sum()
    return 1 - ((guess - y) ** 2).sum() / total if total > 0 else math.nan


def _rms(values):
    return math.sqrt((values**2).mean())


def scatter(results, y):
    """Standard deviation over seeds, pooled over all conditions with more than one; NaN if there are none."""
    groups = {}
    for result, value in zip(results, y):
        groups.setdefault((*_bed(result), result.run.gamma), []).append(value)
    squares = sum(((np.array(group) - np.mean(group)) ** 2).sum() for group in groups.values())
    freedom = sum(len(group) - 1 for group in groups.values())
    return math.sqrt(squares / freedom) if freedom else math.nan


@dataclasses.dataclass
class Candidate:
    fit: Fit
    r2: float  # of the runs fitted
    r2_foretold: float  # of runs of other beds than those fitted
    rms_foretold: float


class Study:
    """All relations of one outcome; `best` foretells best, `supported` says whether it beats doing without cohesion."""

    def __init__(self, outcome, results):
        self.outcome = outcome
        self.results = [result for result in results if math.isfinite(result.figures[outcome.key])]
        self.y = np.array([result.figures[outcome.key] for result in self.results])
        self.candidates = [self._candidate(relation) for relation in RELATIONS] if len(self.y) > 6 else []
        self.scatter = scatter(self.results, self.y)

    def _candidate(self, relation):
        fit = Fit(relation, self.results, self.y)
        guess = foretold(relation, self.results, self.y)
        if guess is None:
            return Candidate(fit, _explained(fit(self.results), self.y), math.nan, math.nan)
        return Candidate(
            fit, _explained(fit(self.results), self.y), _explained(guess, self.y), _rms(guess - self.y)
        )

    @property
    def best(self):
        known = [one for one in self.candidates if math.isfinite(one.r2_foretold)]
        return max(known, key=lambda one: one.r2_foretold) if known else None

    @property
    def supported(self):
        best = self.best
        if best is None or best.fit.relation.shape is None:
            return False
        return best.r2_foretold >= SURE and best.rms_foretold <= (1 - WORTH) * self.candidates[0].rms_foretold


@dataclasses.dataclass(frozen=True)
class Weakening:
    """ratio = 1 - c f(u / u0): what cohesion leaves of a figure; r2 and rms of the points it was fitted to."""

    u0: float
    c: float
    r2: float
    rms: float
    points: int


def weakening(u, ratio):
    """Of f saturating, least squares; None for fewer than three points or if they do not vary."""
    u, ratio = np.asarray(u, float), np.asarray(ratio, float)
    if len(u) < 3 or ratio.std() == 0:
        return None
    best, least = None, math.inf
    for u0 in SCALES:
        shape = _saturating(u, u0)
        c = float(shape @ (1 - ratio) / (shape @ shape))
        misfit = float(((1 - c * shape - ratio) ** 2).sum())
        if misfit < least:
            variance = float(((ratio - ratio.mean()) ** 2).sum())
            rms = math.sqrt(misfit / len(u))
            best, least = Weakening(float(u0), c, 1 - misfit / variance, rms, len(u)), misfit
    return best
