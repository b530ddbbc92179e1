"""Which experiment next: from the menu the one that tells apart what is still confusable, soonest."""

import math
from dataclasses import dataclass, field

import numpy as np

from .. import verdict as judging
from ..calibration.thresholds import RIGHT_TO
from ..words import name as effect_name
from . import camera
from .gain import Contest, Explanation
from .menu import ANY_MOTION, LONGEST_S, MARGIN, TRAJECTORIES, beyond, by_effect
from .path import Limits, after, held, length_s
from .planned import PAYLOAD_KG, Planned
from .words import figure, listed, margins, to_text, told

SHAPES = 3  # that an explanation may take
MOST_REPEATS = 4
SLOWER = 0.8  # factor on speed where a trajectory would need more torque than was recorded
REST_S = 10.0
UNKNOWN = ("slow_ramps", "fast_multisine")  # where no cause is known


@dataclass
class Proposal:
    """`why` in words; the trajectory's file or None; what it needs beside the trajectory, if anything; and the rivals of the
    named effect that it is predicted to part."""

    why: str
    text: str | None = None
    needs: str | None = None
    parts: list = field(default_factory=list)


class Option:
    """One entry of the menu as planned; `gains` are (others, 2) as Contest.gains."""

    def __init__(self, name, q, planned, limits, contest):
        self.name, self.q, self.length_s, self.contest = name, q, planned.length_s, contest
        self.torque = planned.torque() / limits.torque
        self.gains, self.growth = contest.gains(planned)
        self.most = max(1, min(MOST_REPEATS, int(LONGEST_S / self.length_s)))

    def worst(self, k):
        """Gain for one pair, the smaller of both truths. A form with more strengths can often imitate a simpler one:
        evidence between them comes only where the richer one is true."""
        named, other = self.contest.sizes[k]
        return float(min(self.gains[k]) if named == other else self.gains[k][int(other > named)])

    def needed(self, repeats):
        """Chi-square at which the verdict's odds leave what is confusable: its likelihood temperature grows with the plain model's excess,
        and so with the experiment itself."""
        temperature = self.contest.temperature + RIGHT_TO**2 * repeats * self.growth
        return -2 * MARGIN * temperature * math.log(judging.CONFUSABLE_ABOVE)

    def share(self, k, repeats):
        """Of the chi-square that is needed for one pair."""
        return repeats * self.worst(k) / self.needed(repeats)

    def reached(self, repeats):
        """The pairs that it parts."""
        return [k for k in range(len(self.gains)) if self.share(k, repeats) >= 1.0]

    def repeats(self):
        """How often it must run for all that it can reach."""
        return min(range(1, self.most + 1), key=lambda n: (-len(self.reached(n)), n if self.reached(self.most) else -n))

    def rank(self):
        """Smaller is better: what it can reach, then its length, then what it brings."""
        pairs, repeats = range(len(self.gains)), self.repeats()
        reached = self.reached(repeats)
        brings = sum(min(self.share(k, repeats), 1.0) for k in pairs)
        return -len(reached), repeats * self.length_s if len(reached) == len(pairs) else 0.0, -brings


# ---- what is to be told apart -------------------------------------------------------


def explanation(search, chosen, key):
    """The effect `key` in the first one's place, in its best shapes, or None."""
    mine = [c for c in search.gram.candidates if c.key == key]
    fits = search.beside(chosen[1:], mine)
    if key == chosen[0].key:  # between the grid's shapes
        fits.append(search.fit([*chosen[1:], chosen[0]]))
    fits = sorted(fits, key=lambda fit: fit.excess)[:SHAPES]
    name = f"{effect_name(key[0])} of the {key[1]}"
    return Explanation(name, [[fit.chosen[-1], *chosen[1:]] for fit in fits], fits[0].excess) if fits else None


def rivals(search, verdict):
    """What is confusable with the named effect; where it stands alone, that the plain model is enough."""
    chosen = verdict.fit.chosen
    found = [explanation(search, chosen, (effect, joint)) for _, effect, joint in verdict.confusable()]
    found = [x for x in found if x]
    return found or [Explanation("no effect", [chosen[1:]], search.fit(chosen[1:]).excess)]


# ---- the menu -----------------------------------------------------------------------


def plan(search, make, limits, loaded=False):
    """(path, planned) of one entry within the recorded torque, slower where need be; None where it cannot be, or takes too long."""
    slower = limits
    for _ in range(3):
        q = held(make(slower))
        if length_s(q) > LONGEST_S:
            return None
        planned = Planned(search, q, loaded)
        if planned.terms.processed.parts and np.all(planned.torque() <= limits.torque):
            return q, planned
        slower = slower.slowed(SLOWER)
    return None


def options(search, contest, limits):
    menu = {name: make for name, (make, _) in TRAJECTORIES.items() if limits.joints > 1 or name != "one_by_one"}
    plans = ((name, plan(search, make, limits)) for name, make in menu.items())
    return [Option(name, *found, limits, contest) for name, found in plans if found]


# ---- the proposal -------------------------------------------------------------------


def head_of(verdict, contest):
    if verdict.effect == "unknown":
        return "A systematic gap remains that no known effect explains"
    named = f"{effect_name(verdict.fit.chosen[0].effect)} of the {verdict.fit.chosen[0].joint}"
    if verdict.confusable():
        return f"{listed([named, *(x.name for x in contest.others)])} are not told apart by these recordings"
    return f"Nothing rivals {named}; what follows would confirm it"


def why(search, verdict, contest, option, limits):
    """(words on the chosen option, what else it needs)."""
    repeats, trajectory = option.repeats(), TRAJECTORIES[option.name][1]
    short = [k for k in range(len(contest.others)) if k not in option.reached(repeats)]
    effects = [verdict.effect, *(contest.others[k].sets[0][0].effect for k in short if contest.others[k].sets[0])]
    needs, more = beyond(effects) if short else (None, None)
    head = head_of(verdict, contest)
    if needs in ANY_MOTION and len(short) == len(contest.others):
        words = [f"{head}, nor by any trajectory within them. Next: {more}."]
        return " ".join([*words, *beside_trajectory(search, contest, option, short, limits)]), needs
    words = [f"{head}. Next: {trajectory}; {repeats * option.length_s:.0f} s; {told(option, contest, repeats)}."]
    if more:
        words.append(f"It does not part all of them; then {more}.")
        words += beside_trajectory(search, contest, option, short, limits)
    words.append(margins(option.q, option.torque, limits, search.dataset.model.joints))
    return " ".join(words), None


def beside_trajectory(search, contest, option, short, limits):
    """Words on the gain of what needs more than a trajectory."""
    if at_rest(search, contest):
        yield f"Predicted gain of the rest: {figure(rest_gain(search, contest))}."
    elif "known mass" in needed(search, contest.candidates):
        loaded = Option(option.name, option.q, Planned(search, option.q, loaded=True), limits, contest)
        mass = f"{PAYLOAD_KG:g} kg at the foot's centre" if search.dataset.at_motor else "half the load more"
        for k in short:
            yield (f"Predicted gain over {contest.others[k].name} with {mass}: {figure(loaded.worst(k))} in "
                   f"{option.length_s:.0f} s, at {100 * loaded.torque.max():.0f} % of the recorded torque.")  # fmt: skip


def needed(search, candidates):
    """What some effects need beside a trajectory."""
    return {search.dataset.effects[candidate.effect].needs for candidate in candidates}


def at_rest(search, contest):
    """Is what needs more than a trajectory a rest?"""
    return "rest" in needed(search, contest.candidates)


def rest_gain(search, contest):
    """Chi-square of a current offset over its absence in REST_S without current."""
    best = 0.0
    for one in (contest.named, *contest.others):
        first = one.sets[0][:1]
        if "rest" in needed(search, first):
            fit, dataset = search.fit(one.sets[0]), search.dataset
            sigma = dataset.sigma[f"T{dataset.model.joints.index(first[0].joint)}"]
            best = REST_S / dataset.processed_recordings[0].step_s * (fit.strengths[0][0] / sigma) ** 2
    return best


def named_effect(search, verdict):
    """The proposal where there is a cause, or a part of one."""
    chosen, limits = verdict.fit.chosen, Limits(search.all_terms)
    named = explanation(search, chosen, chosen[0].key)
    if not named:
        return Proposal(in_words(verdict))
    contest = Contest(search, named, rivals(search, verdict), search.temperature_of(verdict.fit))
    found = options(search, contest, limits)
    if not found:
        return Proposal(in_words(verdict))
    option = min(found, key=Option.rank)
    left = [effect for _, effect, _ in verdict.confusable()]
    parted = option.reached(option.repeats()) if left else []
    if left and not parted and camera.helps(search, {verdict.effect, *left}):
        film = camera.best(search, verdict, contest, found)
        if film.parts:
            return filmed(search, verdict, contest, film, limits)
    words, needs = why(search, verdict, contest, option, limits)
    if needs:
        return Proposal(words, needs=needs)
    q = np.concatenate([option.q] * option.repeats(), axis=1)
    text = to_text(q, search.dataset.model, TRAJECTORIES[option.name][1])
    return Proposal(words, text, None, contest.keys(parted))


def filmed(search, verdict, contest, found, limits):
    """The proposal of a motion before a camera."""
    option, trajectory = found.option, TRAJECTORIES[found.option.name][1]
    gains = "; ".join(f"predicted gain in evidence over {other.name} (chi-square) {figure(found.repeats * gain)}, where "
                      f"{figure(least)} are needed" for other, gain, least in zip(contest.others, found.each, found.needed))
    words = (f"{head_of(verdict, contest)}, nor by any trajectory within them. Next: {beyond([verdict.effect])[1]}. The motion "
             f"for it: {trajectory}; {found.length_s:.0f} s; with {1e3 * camera.CAMERA_RAD:g} mrad of noise {gains}. "
             f"{margins(option.q, option.torque, limits, search.dataset.model.joints)}")  # fmt: skip
    text = to_text(np.concatenate([option.q] * found.repeats, axis=1), search.dataset.model, trajectory)
    return Proposal(words, text, "camera", contest.keys(found.parts))


def unknown_effect(search):
    """The proposal where nothing explains the gap."""
    limits = Limits(search.all_terms)
    plans = [(name, plan(search, TRAJECTORIES[name][0], limits)) for name in UNKNOWN]
    words = "; then ".join(TRAJECTORIES[name][1] for name, found in plans if found) or TRAJECTORIES[UNKNOWN[0]][1]
    head = f"A systematic gap remains that no known effect explains. Next: {words}."
    plans = [found for _, found in plans if found]
    if not plans:
        return Proposal(head)
    q, torque = after(*(q for q, _ in plans)), np.max([planned.torque() / limits.torque for _, planned in plans], axis=0)
    joints = search.dataset.model.joints
    return Proposal(f"{head} {margins(q, torque, limits, joints)}", to_text(q, search.dataset.model, words))


def in_words(verdict):
    """Where no trajectory can be planned: the motion is not the drive's, or its angle was not recorded."""
    names = [verdict.effect, *(effect for _, effect, _ in verdict.confusable())]
    alone = f"Nothing rivals {effect_name(verdict.effect)}; what follows would confirm it"
    head = f"{listed(names)} are not told apart" if len(names) > 1 else alone
    if verdict.effect == "unknown":
        head = "A systematic gap remains that no known effect explains"
    return f"{head}. Next: {beyond(names)[1] or TRAJECTORIES[by_effect(names)][1]}."


def propose(search, verdict):
    """What to record next."""
    if verdict.effect == "none":
        return Proposal("No effect shows, so nothing needs to be told apart. What these recordings cannot show is listed with its least size.")
    if search.dataset.load_sensor or search.dataset.velocity_only:
        return Proposal(in_words(verdict))
    return named_effect(search, verdict) if verdict.fit.chosen else unknown_effect(search)
