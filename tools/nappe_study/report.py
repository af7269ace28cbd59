"""The study's report: tables in Markdown, the same figures as JSON, pictures."""

import json
import math

import numpy as np

from . import pictures
from .fits import Study, weakening
from .plan import number
from .results import FRONT_SLIPS, MARGIN, OUTCOMES, SLIPS

STEEP = 30  # degrees: from this dip on the zone leans forward only, as the trishear model has it


def conditions(results):
    """Results by (theta, height, gamma), in the order of the plan."""
    groups = {}
    for result in results:
        groups.setdefault((result.run.theta, result.run.height, result.run.gamma), []).append(result)
    return groups


def mean_and_deviation(results, key):
    """Over the seeds whose figure is known: mean, standard deviation (NaN for one seed), number."""
    values = np.array([result.figures[key] for result in results])
    values = values[np.isfinite(values)]
    mean = float(values.mean()) if len(values) else math.nan
    deviation = float(values.std(ddof=1)) if len(values) > 1 else math.nan
    return mean, deviation, len(values)


def _cell(results, outcome):
    mean, deviation, n = mean_and_deviation(results, outcome.key)
    if n == 0:
        return "–"
    text = f"{mean:.{outcome.digits}f}"
    text += f" ± {deviation:.{outcome.digits}f}" if n > 1 else ""
    return text + (f" ({n} of {len(results)})" if n < len(results) else "")


def _row(cells):
    return "| " + " | ".join(map(str, cells)) + " |"


def table(results):
    """A row per dip, height and cohesion."""
    heads = [f"{one.title} [{one.unit}]" if one.unit else one.title for one in OUTCOMES]
    lines = [_row(["dip [°]", "h [m]", "γ [N]", "G", "C", "seeds", *heads]), _row(["---:"] * (6 + len(heads)))]
    for (theta, height, gamma), group in sorted(conditions(results).items()):
        groups = [f"{group[0].by_grain:.3g}", f"{group[0].by_column:.3g}"]
        cells = [number(theta), number(height), number(gamma), *groups, len(group)]
        lines.append(_row(cells + [_cell(group, outcome) for outcome in OUTCOMES]))
    return "\n".join(lines)


def paired(results):
    """What cohesion changes in one sample: (dip, γ) -> outcome key -> differences from the same dip, height and seed at
    γ = 0, over heights and seeds."""
    plain = {(r.run.theta, r.run.height, r.run.seed): r for r in results if r.run.gamma == 0}
    groups = {}
    for result in results:
        run = result.run
        beside = plain.get((run.theta, run.height, run.seed))
        if run.gamma == 0 or beside is None:
            continue
        group = groups.setdefault((run.theta, run.gamma), {outcome.key: [] for outcome in OUTCOMES})
        for key, values in group.items():
            difference = result.figures[key] - beside.figures[key]
            if math.isfinite(difference):
                values.append(difference)
    return groups


def _difference(values, digits):
    """Starred where the mean is more than twice its standard error away from nothing."""
    if len(values) < 2:
        return "–"
    mean, deviation = float(np.mean(values)), float(np.std(values, ddof=1))
    star = " *" if abs(mean) > 2 * deviation / math.sqrt(len(values)) else ""
    return f"{mean:+.{digits}f} ± {deviation:.{digits}f}{star}"


def paired_table(results):
    """A row per dip and cohesion."""
    heads = [f"{one.title} [{one.unit}]" if one.unit else one.title for one in OUTCOMES]
    lines = [_row(["dip [°]", "γ [N]", "samples", *heads]), _row(["---:"] * (3 + len(heads)))]
    for (theta, gamma), group in sorted(paired(results).items()):
        n = max(len(values) for values in group.values())
        cells = [_difference(group[outcome.key], outcome.digits) for outcome in OUTCOMES]
        lines.append(_row([number(theta), number(gamma), n, *cells]))
    return "\n".join(lines)


def ratios(results, key):
    """(result, its figure over that of the same dip, height and seed at γ = 0), for γ > 0."""
    plain = {(r.run.theta, r.run.height, r.run.seed): r.figures[key] for r in results if r.run.gamma == 0}
    pairs = []
    for result in results:
        run = result.run
        beside = plain.get((run.theta, run.height, run.seed), math.nan)
        if run.gamma > 0 and math.isfinite(result.figures[key] / beside):
            pairs.append((result, result.figures[key] / beside))
    return pairs


def zone_relations(results):
    """(dips, group's letter, Weakening) of the half apical angle: for each dip and for those of at least 30° together."""
    pairs = ratios(results, "apical")
    dips = sorted({result.run.theta for result, _ in pairs})
    found = []
    for chosen in [[dip] for dip in dips] + [[dip for dip in dips if dip >= STEEP]]:
        for letter, group in (("G", "by_grain"), ("C", "by_column")):
            points = [(getattr(result, group), ratio) for result, ratio in pairs if result.run.theta in chosen]
            fit = weakening(*zip(*points)) if points else None
            if fit:
                found.append((chosen, letter, fit))
    return found


def zone_table(results):
    lines = [_row(["dips [°]", "relation", "R²", "RMS", "runs"]), _row(["---", "---", "---:", "---:", "---:"])]
    for dips, letter, fit in zone_relations(results):
        relation = f"1 − {fit.c:.2f} {letter} / ({letter} + {fit.u0:.2g})"
        lines.append(_row([", ".join(map(number, dips)), relation, f"{fit.r2:.2f}", f"{fit.rms:.2f}", fit.points]))
    return "\n".join(lines)


def _value(value, digits=3):
    return f"{value:.{digits}g}" if math.isfinite(value) else "–"


def fits_table(studies):
    """A row per outcome: what each relation explains of runs it was not fitted to, and the best one's coefficients."""
    names = [candidate.fit.relation.name for candidate in studies[0].candidates]
    heads = ["outcome", "scatter of seeds", *(f"R² {name}" for name in names), "supported"]
    lines = [_row(heads), _row(["---"] + ["---:"] * (len(names) + 1) + ["---"])]
    for study in studies:
        shown = [f"{_value(one.r2, 2)} ({_value(one.r2_foretold, 2)})" for one in study.candidates]
        lines.append(_row([study.outcome.title, _value(study.scatter, 2), *shown, _verdict(study)]))
    return "\n".join(lines)


def _verdict(study):
    if study.best is None:
        return "it does not vary" if study.y.std() == 0 else "too few beds to tell"
    if not study.supported:
        return "none"
    fit = study.best.fit
    a, *others = fit.coefficients
    terms = ["tan θ", "h/d", fit.relation.name.removeprefix("e ").replace("u0", f"{fit.u0:.2g}")]
    sum_of_terms = " ".join(f"{'−' if k < 0 else '+'} {_value(abs(k))} {term}" for k, term in zip(others, terms))
    return f"{_value(a)} {sum_of_terms}; RMS {_value(study.best.rms_foretold, 2)}"


def near_ends(results):
    lines = [f"- {result.run.name}: {'; '.join(result.too_near)}" for result in results if result.too_near]
    text = "\n".join(lines) if lines else "None."
    return f"Runs whose zone or front came within {MARGIN:g} m of an end of the box, up to the slip used:\n\n{text}"


def markdown(results, n_wanted, studies, paths, folder):
    slips = ", ".join(f"{slip:g}" for slip in FRONT_SLIPS)
    parts = [
        "# Fault propagation: the parametric study",
        f"{len(results)} of {n_wanted} runs. G: γ over the mean weight of a grain. C: γ over the weight of a column as "
        "high as the bed and as wide as a mean grain, γ / (ρ g h d). Angles to the horizontal; limits, opening and the "
        f"trishear fit are medians over the frames at slips of {SLIPS[0]:g} to {SLIPS[1]:g} h; the front's distance is "
        "counted from where the fault's line meets the surface at the start, in heights of the bed, at slips of "
        f"{slips} h. Mean ± standard deviation over the seeds.",
        table(results),
        "## What cohesion changes",
        "Differences from the same sample (dip, height, seed) without cohesion: mean ± standard deviation over heights and "
        "seeds, starred where the mean is more than two standard errors away from 0.",
        paired_table(results),
        "## Relations",
        "y = a + b tan θ + c h/d + a term in cohesion; d: mean diameter, log: to base 10. R² of all runs, and in "
        "brackets of each bed (dip and height) by a fit to the other beds. Supported: that explains at least half of "
        "the variance, with an error a tenth smaller than without cohesion.",
    ]
    parts.append(fits_table(studies) if studies else "Too few runs for a fit.")
    parts += [
        "## The half apical angle, over that without cohesion",
        "Of the same dip, height and seed; with R² and RMS of the runs fitted. A negative R² says that the mean does better.",
        zone_table(results),
    ]
    parts += ["## Checks", near_ends(results), "## Pictures"]
    parts += [f"![{path.stem.replace('-', ' ')}]({_relative(path, folder)})" for path in paths]
    return "\n\n".join(parts) + "\n"


def _relative(path, folder):
    try:
        return path.resolve().relative_to(folder.resolve())
    except ValueError:
        return path


def _clean(value):
    """JSON has no NaN."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def as_json(results, studies):
    runs = [
        {
            "name": result.run.name,
            "theta": result.run.theta,
            "height": result.run.height,
            "gamma": result.run.gamma,
            "seed": result.run.seed,
            "by_grain": result.by_grain,
            "by_column": result.by_column,
            "too_near": result.too_near,
            **{key: _clean(value) for key, value in result.figures.items()},
        }
        for result in results
    ]
    fits = [
        {
            "outcome": study.outcome.key,
            "scatter": _clean(study.scatter),
            "supported": bool(study.supported),
            "best": study.best.fit.relation.name if study.best else None,
            "relations": [
                {
                    "name": one.fit.relation.name,
                    "u0": _clean(float(one.fit.u0)),
                    "coefficients": [float(value) for value in one.fit.coefficients],
                    "r2": _clean(one.r2),
                    "r2_foretold": _clean(one.r2_foretold),
                    "rms_foretold": _clean(one.rms_foretold),
                }
                for one in study.candidates
            ],
        }
        for study in studies
    ]
    zone = [
        {"dips": dips, "group": letter, **{name: _clean(value) for name, value in vars(fit).items()}}
        for dips, letter, fit in zone_relations(results)
    ]
    return {"runs": runs, "fits": fits, "zone": zone}


def write(results, n_wanted, out, folder):
    """OUT/report.md and OUT/report.json, pictures in `folder`; the paths."""
    studies = [study for study in (Study(outcome, results) for outcome in OUTCOMES) if study.candidates]
    paths = pictures.draw(conditions(results), studies, folder)
    text, data = out / "report.md", out / "report.json"
    text.write_text(markdown(results, n_wanted, studies, paths, out))
    data.write_text(json.dumps(as_json(results, studies), indent=1) + "\n")
    return [text, data, *paths]
