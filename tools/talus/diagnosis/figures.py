"""The gap in the contract's figures: what each model leaves on blocks that its fit has not seen."""

import math

import numpy as np

from .calibration.thresholds import DEVIATIONS
from .dataset import NEAR_STOP

DRAWS = 800
MOST_HARM = -1.0  # of a closed share: effects that double the gap's square
FEWEST_STRETCHES = 10  # of the motion, that tell how much its errors vary
NOISE_KNOWN_TO = 0.1  # of its deviation: by how much estimates from repeats, near repeats and high frequencies differ


class Residuals:
    """Residuals of one fit on the grid, by (record, kind): every block by the fit that left out its fold."""

    def __init__(self, search, chosen):
        dataset = search.dataset
        every = search.columns(chosen)
        strengths = search.gram.fold_strengths(every, search.gram.settled_weights(every))
        self.strengths = strengths[-1]
        self.of = {}
        columns = [column for candidate in chosen for column in candidate.columns]
        for record, terms in enumerate(search.all_terms):
            shown = [column(terms) for column in columns]
            fold = dataset.folds[dataset.block_of[record]]
            for channel in dataset.channels:
                if channel.record == record:
                    self.of[record, channel.kind] = self._of(dataset, channel, shown, strengths[fold])

    @staticmethod
    def _of(dataset, channel, shown, strengths):
        every = np.arange(len(channel.values))
        whole = type(channel)(channel.record, channel.kind, channel.values, np.ones(len(every), bool))
        base = dataset.base_columns(whole)
        out = channel.values - np.einsum("ij,ij->i", base, strengths[:, :base.shape[1]])
        for k, column in enumerate(shown):
            if channel.kind in column:
                out = out - strengths[:, base.shape[1] + k] * column[channel.kind]
        return out


def given_residuals(dataset, record, joint):
    """Residual of the model as given, on the grid."""
    processed = dataset.processed_recordings[record]
    return processed.target[joint] - processed.x[joint] @ dataset.prior[processed.index[joint]]


def root_mean_square(parts):
    values = np.concatenate(parts)
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def torque_rms(dataset, residuals, joint):
    """RMS over the scored rows of one joint."""
    channels = [c for c in dataset.channels if c.kind == f"T{joint}"]
    return root_mean_square([residuals.of[c.record, c.kind][c.rows] for c in channels])


def noise_floor(dataset, joint):
    """RMS of the filtered noise on the scored rows."""
    channels = [c for c in dataset.channels if c.kind == f"T{joint}"]
    total = sum(len(c.rows) for c in channels)
    power = sum(len(c.rows) * dataset.bandwidth[c.record] for c in channels) / max(total, 1)
    return float(dataset.sigma[f"T{joint}"] * np.sqrt(power))


def closed_fraction(identified, extended, floor, least=0.0):
    """Share of the systematic gap that the effects close, from `least` to 1."""
    if identified <= floor:
        return 0.0
    return float(np.clip((identified**2 - extended**2) / (identified**2 - floor**2), least, 1.0))


def block_sums(dataset, residuals, joint):
    """Squares of one joint's residual on its scored rows, and their number, by block."""
    squares, number = np.zeros(dataset.blocks), np.zeros(dataset.blocks)
    for c in dataset.channels:
        if c.kind == f"T{joint}":
            block = dataset.block_of[c.record][c.rows]
            squares += np.bincount(block, residuals.of[c.record, c.kind][c.rows] ** 2, minlength=dataset.blocks)
            number += np.bincount(block, minlength=dataset.blocks)
    return squares, number


def by_other_recordings(search, near, chosen):
    """{kind: [(RMS, RMS beside the effects) of each recording that has it]} by the fits to all others; empty where there is one alone."""
    dataset, out = search.dataset, {}
    if len(dataset.processed_recordings) < 2:
        return out
    plain, beside = (one.gram.by_other_recordings(one.columns(which)) for one, which in ((search, []), (near, chosen)))
    for c in dataset.channels:
        if len(c.thinned):
            chi2 = np.maximum([plain[c.kind][c.record], beside[c.kind][c.record]], 0.0)
            out.setdefault(c.kind, []).append(tuple(dataset.sigma[c.kind] * np.sqrt(chi2 / dataset.thin / len(c.thinned))))
    return out


def closed_interval(dataset, before, after, joint, floor, seed, rough=0.0, elsewhere=()):
    """95 % interval of what will be closed in another motion: that may be as unlike all of these as any one of their blocks is,
    the noise is known to a tenth, and of what reconstruction leaves beyond it (`rough`, a mean square), which no effect closes, any
    share may be there; both cannot be more than all that is left. Where so little is left that the noise cannot be what was estimated,
    any share of it may be noise. The interval holds the closed fraction itself, that of each recording by the fits to all others
    (`elsewhere`: by_other_recordings()), and goes below 0 where effects may do harm, down to -1."""
    random = np.random.Generator(np.random.Philox(seed))
    (old, number), (new, _) = (block_sums(dataset, r, joint) for r in (before, after))
    shown = np.flatnonzero(number)
    one = random.choice(shown, DRAWS) if len(shown) else []
    identified, extended = (float(np.sqrt(x.sum() / max(number.sum(), 1))) for x in (old, new))
    share = random.random(DRAWS)
    is_overrated = floor > np.exp(DEVIATIONS * NOISE_KNOWN_TO) * extended
    left = extended * np.sqrt(share) if is_overrated else np.minimum(np.sqrt(floor**2 + rough * share), extended)
    noises = left * np.exp(NOISE_KNOWN_TO * random.standard_normal(DRAWS))
    rms = np.sqrt(old[one] / number[one]), np.sqrt(new[one] / number[one])
    drawn = [closed_fraction(a, b, noise, MOST_HARM) for a, b, noise in zip(*rms, noises)]
    held = [closed_fraction(identified, extended, floor)]
    held += [closed_fraction(a, b, min(floor, b), MOST_HARM) for a, b in elsewhere if a > floor]
    ends = np.quantile(drawn, [0.025, 0.975]) if drawn else (0.0, 1.0)
    return [float(min(*ends, *held)), float(max(*ends, *held))]


def rough_left(search, joint, floor):
    """Mean square of a joint's torque that reconstruction leaves beyond the noise."""
    kind = f"T{joint}"
    return floor**2 * search.floor_of.get(kind, 0.0) / max(search.dataset.freedom(kind), 1)


def gap(search, near, chosen, before, after, seed):
    """`gap` of the report; `near` is the search beside whose machine the chosen effects stand."""
    dataset, out, elsewhere = search.dataset, {}, by_other_recordings(search, near, chosen)
    for joint, name in enumerate(dataset.model.joints):
        channels = [c for c in dataset.channels if c.kind == f"T{joint}"]
        nominal = root_mean_square([given_residuals(dataset, c.record, joint)[c.rows] for c in channels])
        reversal = root_mean_square([after.of[c.record, c.kind][dataset.processed_recordings[c.record].kind[joint] == NEAR_STOP]
                                     for c in channels])  # fmt: skip
        identified, extended = (torque_rms(dataset, r, joint) for r in (before, after))
        floor = noise_floor(dataset, joint)
        out[name] = {
            "unit": dataset.model.torque_unit,
            "nominal_rms": nominal,
            "identified_rms": identified,
            "extended_rms": extended,
            "noise_floor_rms": floor,
            "closed_fraction": closed_fraction(identified, extended, floor),
            "reversal_rms": reversal,
            "measured_rms": root_mean_square([dataset.processed_recordings[c.record].measured[joint][c.rows] for c in channels]),
            "closed_interval": closed_interval(dataset, before, after, joint, floor, seed, rough_left(search, joint, floor),
                                               elsewhere.get(f"T{joint}", ())),
        }
    return out


def effects(search, fit, before):
    """`effects` of the report: each effect with the gap of its joint before and after it was added, what it closes at every
    joint, and how far its parameters are known."""
    dataset, out, last = search.dataset, [], before
    errors = whole_errors(search, fit)
    for k, candidate in enumerate(fit.chosen):
        now = Residuals(search, fit.chosen[:k + 1])
        joints = dataset.model.joints
        joint = joints.index(candidate.joint) if candidate.joint in joints else 0
        out.append({
            "effect": candidate.effect,
            "joint": candidate.joint,
            "parameters": candidate.parameters(fit.strengths[k]),
            "interval": interval(candidate, fit.strengths[k], errors[k]),
            "closes": closes(dataset, before, last, now),
            "gap_before": torque_rms(dataset, last, joint),
            "gap_after": torque_rms(dataset, now, joint),
        })  # fmt: skip
        last = now
    return out


def closes(dataset, before, last, now):
    """{joint: share of its systematic gap that one more effect closes}; negative where it opens it."""
    out = {}
    for joint, name in enumerate(dataset.model.joints):
        identified, old, new = (torque_rms(dataset, r, joint) for r in (before, last, now))
        systematic = identified**2 - noise_floor(dataset, joint) ** 2
        out[name] = float(np.clip((old**2 - new**2) / systematic, -1.0, 1.0)) if systematic > 0 else 0.0
    return out


def standard_errors(search, fit):
    """Standard deviation of every strength, by the noise and by what is left beside it; one list a candidate."""
    return by_candidate(fit, np.sqrt(np.maximum(np.diag(covariance(search, fit)), 0.0)))


def covariance(search, fit):
    """Of all unknowns of a fit by the same, its strengths last."""
    products = _products(search, fit)
    inverse, scale = _inverse(products)
    variance = search.gram.variance(products, left_of_freedom(search, fit))[:-1, :-1] / np.outer(scale, scale)
    return inverse @ variance @ inverse / np.outer(scale, scale)


def errors_by_stretch(search, fit):
    """The same by what the fit leaves in each stretch of the motion (Liang and Zeger 1986): what a model lacks of a place or a speed stays
    the same for as long as the joint is there. 0 where stretches are too few to tell."""
    (inverse, scale), sums = _inverse(_products(search, fit)), search.gram.by_stretch(search.columns(fit.chosen))
    filled = np.any(sums != 0, axis=1)
    count = np.count_nonzero(filled)
    if count < FEWEST_STRETCHES:
        return by_candidate(fit, np.zeros(len(scale)))
    moved = sums[filled] / scale @ inverse
    return by_candidate(fit, np.sqrt(count / (count - 1) * np.sum(moved**2, axis=0)) / scale)


def _products(search, fit):
    """A fit's normal equations, and its reading."""
    return search.gram.products(search.gram.gathered(search.columns(fit.chosen)))


def _inverse(products):
    """(inverse of normal equations at unit columns, their scale)."""
    products = products[:-1, :-1]
    scale = np.sqrt(np.diag(products))
    scale[scale == 0] = 1
    return np.linalg.inv(products / np.outer(scale, scale) + 1e-10 * np.eye(len(scale))), scale


def by_candidate(fit, errors):
    """Figures of all unknowns, of which the columns of a fit's candidates stand last, as one list a candidate."""
    count = sum(len(candidate.columns) for candidate in fit.chosen)
    every = list(errors[len(errors) - count:])
    return [[every.pop(0) for _ in candidate.columns] for candidate in fit.chosen]


def left_of_freedom(search, fit):
    """What a fit leaves over the noise's freedom, 1 at the least."""
    return max((fit.excess + search.freedom) / search.freedom, 1.0)


def whole_errors(search, fit):
    """Standard errors by noise or by stretches of the motion, whichever are larger, and beside them what reconstruction makes of each
    strength: where an effect gains g by nothing, its strength there is the root of g times the error by noise alone."""
    left, known = left_of_freedom(search, fit), search.calibration
    gains = [known.by_nothing(c.key) if known else 0.0 for c in fit.chosen]
    both = zip(gains, standard_errors(search, fit), errors_by_stretch(search, fit), strict=True)
    return [[math.hypot(max(noise, stretch), noise * math.sqrt(gain / left)) for noise, stretch in zip(own, rough, strict=True)]
            for gain, own, rough in both]  # fmt: skip


def interval(candidate, strengths, errors):
    """{parameter: [low, high]}: 95 % by the strengths; what stands in the shape alone has been chosen, and has none."""
    found = {}
    for k, error in enumerate(errors):
        for side in (-1.96, 1.96):
            moved = list(strengths)
            moved[k] = moved[k] + side * error
            for name, value in candidate.parameters(moved).items():
                found.setdefault(name, []).append(value)
    centre = candidate.parameters(strengths)
    return {name: _spread(centre[name], values) for name, values in found.items() if max(values) > min(values)}


def _spread(centre, values):
    """Independent moves of several strengths, added in squares."""
    below, above = ([(v - centre) ** 2 for v in values if side * (v - centre) > 0] for side in (-1, 1))
    return [float(centre - math.sqrt(sum(below))), float(centre + math.sqrt(sum(above)))]
