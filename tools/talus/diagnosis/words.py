"""The diagnosis in plain words."""

import re

from .calibration.thresholds import PART, TOLERATED_PER_FREEDOM
from .effects import EFFECTS

LIKELY, CERTAIN = 0.5, 0.8  # probabilities from which a cause is called so
HARDLY = 0.1  # of the gap is closed
MUCH = 0.2  # of the measured torque: what hides behind such noise is not small
SLOW_HZ = 20.0  # a low-pass that hides what other recordings show
WORSE = 1.1  # times the error of the model as given
UNITS = {  # by the end of a parameter's name
    "Nm": "Nm", "Nm_rad": "Nm/rad", "Nm_rad2": "Nm/rad²", "Nm_rad3": "Nm/rad³", "Nm_rad4": "Nm/rad⁴", "Nms_rad": "Nms/rad",
    "Nm_10K": "Nm per 10 K", "Nms_rad_10K": "Nms/rad per 10 K", "per_10_C": "per 10 °C",
    "Nms_rad_per_10_C": "Nms/rad per 10 °C", "rad": "rad", "rad_s": "rad/s", "1_rad": "1/rad", "rad_Nm": "rad/Nm",
    "m": "m", "m_N": "m/N", "s": "s", "C": "°C", "Hz": "Hz",
}  # fmt: skip

DOUBTS = {  # why an effect is no surer
    "lowpass": "another low-pass does not show it, or not with this size",
    "uneven": "one half of the motion shows another size of it",
    "replicates": "replicates of these recordings, which hide no effect, gain as much",
    "noise": "the model without any effect leaves no more than the noise",
    "pushes": "such a spring would push the joint away",
    "inertia": "the sensors leave the inertia unknown, and it may stand for that",
    "unjudged": "it was found beside another first effect, and not judged beside this one",
}


class Scale:
    """Figures of one kind in a unit of readable size."""

    def __init__(self, unit, figures):
        small = max(figures, default=0.0) < 1
        self.factor, self.unit = (1e3, f"m{unit}") if small else (1.0, unit)

    def __call__(self, x):
        return self.factor * x

    def number(self, x):
        return f"{self.factor * x:#.4g}".rstrip(".")

    def text(self, x):
        return f"{self.number(x)} {self.unit}"


def name(effect):
    """An effect's id as words."""
    return effect.replace("_", " ")


def share(probability):
    """A probability as words: none is certain, so none reads as 0 or 1."""
    return "over 0.99" if probability > 0.99 else "under 0.01" if probability < 0.01 else f"{probability:.2f}"


def at(effect, joint):
    """A verdict's name and place: "load friction at the knee"; "unknown"."""
    return name(effect) if joint == "none" else f"{name(effect)} at the {joint}"


def figure(x):
    """A number without a unit: to three digits, and no power of ten where it is large."""
    return f"{x:,.0f}" if x >= 100 else f"{x:.3g}"


def doubts(effect):
    """Why an entry of GAP.json's `effects` is no surer: a sentence; "" where nothing speaks against it."""
    if not effect["doubts"]:
        return ""
    named = at(effect["effect"], effect["joint"])
    return f"{named[0].upper()}{named[1:]} is no surer because {', and '.join(DOUBTS[one] for one in effect['doubts'])}."


def nearest(one):
    """What an effect alone would take away: an entry of GAP.json's `nearest`."""
    return f"{at(one['effect'], one['joint'])} would close {100 * one['closes']:.0f} %"


def linear(text):
    """Words or a unit of a rotary joint as those of one that moves straight: force for torque, N for Nm, m for rad, no degrees."""
    text = re.sub(r" \([^)]*°\)", "", text.replace("torque", "force"))
    return re.sub(r"(?<![A-Za-z_])(m?)rad(?![A-Za-z_])", r"\1m", re.sub(r"(?<![A-Za-z_])(m?N)m(?=s?(?![A-Za-z_]))", r"\1", text))


def is_linear(report):
    """Does the joint move straight, under forces?"""
    return any(gap["unit"] == "N" for gap in report["gap"].values())


def unit(parameter, straight=False):
    """The unit of an effect's parameter at a rotary joint, or one that moves straight; "" where it has none."""
    plain = re.sub(r"_\d+$", "", parameter)  # of a second order or mode
    ends = [end for end in UNITS if plain.endswith(f"_{end}")]
    found = UNITS[max(ends, key=len)] if ends else ""
    return linear(found) if straight else found


def titles(report):
    """What a report calls effects of one's own, by id."""
    return {effect: own["title"] for effect, own in report.get("own_effects", {}).items()}


def cause(effect, joint, straight=False, own=()):
    """An effect in plain words, with its name and place; `own`: titles() of the report."""
    if effect in EFFECTS:
        plain = linear(EFFECTS[effect].words) if straight else EFFECTS[effect].words
    elif effect in own:
        plain = own[effect]
    else:
        return at(effect, joint)
    return f"{plain} ({name(effect)}) at the {joint}"


def likeness(one, straight=False):
    """What a gap looks like, and where: an entry of GAP.json's `resembles`."""
    closes = "" if one["closes"] is None else f"; that would close {100 * one['closes']:.0f} % of the gap"
    return f"{looks(one, straight)} at the {one['joint']}{closes}{rival(one)}"


def rival(one):
    """Why it is not the effects that explain as much, where the machine beside these is another one."""
    if "rival" not in one:
        return ""
    other = one["rival"]
    effects = " and ".join(at(each["effect"], each["joint"]) for each in other["effects"])
    return f"; so would {effects}, but only if {name(other['parameter'])} were {other['times']:.2g} times the model file's"


def looks(one, straight=False):
    """The same without its place."""
    text = one["title"] + (f" ({one['size']})" if one["size"] else "")
    return linear(text) if straight else text


def surely_like(report):
    """The likeness that an unknown gap has rather than not, or None."""
    return next((one for one in report["resembles"] if one["probability"] >= LIKELY), None) if report["verdict"]["effect"] == "unknown" else None


def size(effect, parameters, straight=False):
    """How large an effect is: its parameters in words, of each order or mode; "" where there are none."""
    if effect not in EFFECTS:
        return ""
    modes = {}
    for parameter, value in parameters.items():
        plain, _, number = re.fullmatch(r"(.*?)(_(\d+))?", parameter).groups()
        modes.setdefault(number, {})[plain] = value
    said = "; ".join(EFFECTS[effect].size(mode) for mode in modes.values())
    return linear(said) if straight else said


def is_poor(report):
    """Recordings that could not be diagnosed: nothing was held out, so no noise was found."""
    return not report["alternatives"] and all(gap["noise_floor_rms"] == 0 for gap in report["gap"].values())


def shrunk_joint(report):
    """The joint whose gap the verdict speaks of; None where no effect was added."""
    gaps, joint = report["gap"], report["verdict"]["joint"]
    if not report["effects"]:
        return None
    return joint if joint in gaps else max(gaps, key=lambda j: gaps[j]["closed_fraction"])


def closing(report):
    """What modelling the causes does to the error."""
    joint, count = shrunk_joint(report), len(report["effects"])
    if joint is None:
        return ""
    gap = report["gap"][joint]
    scale = Scale(gap["unit"], [gap["identified_rms"]])
    before, after, floor = (scale(gap[f"{k}_rms"]) for k in ("identified", "extended", "noise_floor"))
    it = "it" if count == 1 else f"it and {count - 1} more"
    head = f"modelling {it} takes the {joint}'s error from {before:.3g} to {after:.3g} {scale.unit} on data held out"
    if gap["closed_fraction"] < HARDLY and any(w["coordinate"] == "encoder" for w in report["where"][:1]):
        return "it shows between the encoders and hardly in the torque"
    if gap["closed_fraction"] <= 0:
        return f"modelling {it} does not shrink the {joint}'s error on data held out"
    return f"{head}, where the noise alone is {floor:.3g} {scale.unit}"


def no_effect(report, sure):
    """That none shows. An error well above the noise of torque or current is said with its size, at the joint where it is so most."""
    above = lambda joint: report["gap"][joint]["identified_rms"] / max(report["gap"][joint]["noise_floor_rms"], 1e-300)
    joint = max(report["gap"], key=above)
    gap = report["gap"][joint]
    if above(joint) ** 2 <= 1 + TOLERATED_PER_FREEDOM:
        said = f"The model explains these recordings down to their noise{below(report)}; no further effect is needed ({sure})."
        noise = max(one["identified_rms"] / max(one["measured_rms"], 1e-300) for one in report["gap"].values())
        return f"{said} But that noise is {100 * noise:.0f} % of the torque: smaller effects would not show." if noise > MUCH else said
    scale = Scale(gap["unit"], [gap["identified_rms"]])
    error, floor = (scale(gap[f"{k}_rms"]) for k in ("identified", "noise_floor"))
    said = f"No effect shows{below(report)} ({sure}). The {joint}'s error is {error:.3g} {scale.unit} on data held out, where the noise alone is {floor:.3g} {scale.unit}"
    return f"{said}; such sensors leave about as much without any effect." if report["calibrated"] else f"{said}."


def below(report):
    """In what band, where the data asked for a slower low-pass than the model file's: faster effects cannot show."""
    lowpass = report.get("lowpass") or {}
    return f" below {lowpass['hz']:.3g} Hz" if lowpass.get("from") == "data" and lowpass["hz"] < SLOW_HZ else ""


def worse_than_given(report):
    """A sentence for each joint that the identified model serves worse than the one as given does, both on data that no fit has seen."""
    for joint, gap in report["gap"].items():
        if gap["identified_rms"] > WORSE * gap["nominal_rms"]:
            scale = Scale(gap["unit"], [gap["identified_rms"]])
            given, identified = (scale.number(gap[f"{k}_rms"]) for k in ("nominal", "identified"))
            yield (f"On data held out the identified model is farther off at the {joint} than the one as given ({identified} {scale.unit} instead of "
                   f"{given}): these recordings are too short or too much alike to identify it, or the machine changes in them.")


def does_not_repeat(report):
    """A sentence where a part of the gap is nothing that a model of the joint could have; else ""."""
    share = sum(one["share"] for one in report["irregular"])
    if share < PART:
        return ""
    most = report["irregular"][0]["joint"]
    return f"At least {100 * share:.0f} % of it does not repeat with the motion, most of that at the {most}: a torque that wanders, vibrates, or acts now and then."


def sentence(report):
    """The diagnosis in plain words."""
    verdict = report["verdict"]
    sure = f"probability {share(verdict['probability'])}"
    if report["findings"] and report["findings"][0]["grave"]:
        first = report["findings"][0]
        return f"No cause is named before this is mended: {first['evidence']}."
    if verdict["effect"] == "none":
        return no_effect(report, sure)
    if verdict["effect"] == "unknown":
        head = f"A gap remains that no known effect explains ({sure})."
        if like := surely_like(report):
            return f"{head} It looks like {likeness(like, is_linear(report))}."
        head = f"{head} {does_not_repeat(report)}".rstrip()
        if not report["effects"]:
            return head
        first = report["effects"][0]
        return f"{head} What comes nearest is {cause(first['effect'], first['joint'], is_linear(report), titles(report))}: {closing(report)}."
    named = cause(verdict["effect"], verdict["joint"], is_linear(report), titles(report))
    if verdict["probability"] < LIKELY:
        why = doubts(report["effects"][0]) if report["effects"] else ""
        return f"The cause of the gap is not certain. Likeliest is {named} ({sure}): {closing(report)}. {why}".rstrip()
    how = "comes" if verdict["probability"] >= CERTAIN else "most likely comes"
    return f"The gap {how} from {named} ({sure}): {closing(report)}."
