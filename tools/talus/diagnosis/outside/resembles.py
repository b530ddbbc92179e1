"""`resembles` of the report: what a gap looks like that no effect of the catalogue explains."""

LEAST = 0.05  # probability from which a likeness is told


def resembles(search, verdict):
    """What of it is how probable, and what share of the plain model's excess it closes, alone or beside the effects that are named;
    None where repeats take it for noise, so that there is no excess."""
    beside = verdict.fit.chosen if verdict.effect != "unknown" else []
    found = [_entry(search, beside, probability, candidate) for probability, candidate in verdict.resembles if probability >= LEAST]
    if found and verdict.beyond and verdict.beyond.by_drawing:
        found[0]["rival"] = _rival(search, verdict.beyond.fit)
    return found


def _rival(search, fit):
    """The effects that explain as much, but beside another machine, and what of that is farthest from the model file's."""
    parameter, times = search.farthest_off_drawing(fit)
    return {"effects": [{"effect": c.effect, "joint": c.joint} for c in fit.chosen], "parameter": parameter, "times": times}


def _entry(search, beside, probability, candidate):
    effect, fit = search.dataset.effects[candidate.effect], search.fit([*beside, candidate])
    parameters, gain = candidate.parameters(fit.strengths[-1]), search.fit(beside).excess - fit.excess
    return {"id": effect.id, "title": effect.words, "joint": candidate.joint, "probability": probability,
            "closes": max(min(gain / search.plain.excess, 1.0), 0.0) if search.plain.excess > 0 else None,
            "size": effect.size(parameters), "parameters": parameters}  # fmt: skip
