"""Every shape that talus-gap can choose, as an entry of a model file: what the library then adds to a recording's torque
is strength times the diagnosis's column."""

import math
import numpy
import pytest
import yaml
from talus.diagnosis.catalogue import sparse
from talus.diagnosis.effects import candidates
from talus.diagnosis.dataset import Dataset
from talus.diagnosis.kinds import kind_of
from talus.diagnosis.torque_terms import Extent, TorqueTerms
from talus.diagnosis.processed_recording import ProcessedRecording
from support import REPOSITORY, run

import talus
from talus import check, ffi, lib

# of the column's RMS on scored rows: both are the library's. A ripple goes by the motor's recorded angle in the one case and
# by the smoothed one in the other, and a constant's by what the score's filter leaves of the current.
CLOSE = 1e-6
TOLERANCE = {"kinematic_error": 1e-3, "cogging": 1e-3, "torque_constant": 3e-3}


def leg_tree():
    return yaml.safe_load((REPOSITORY / "models/leg.yaml").read_text())


@pytest.fixture(scope="module")
def leg(tmp_path_factory):
    """A bench's recording with camera and temperatures."""
    folder = tmp_path_factory.mktemp("saved")
    run("talus-sim", "--model", REPOSITORY / "models/leg.yaml", "--out", folder / "leg.csv", "--duration", 40, "--camera")
    recording = talus.Recording.read(folder / "leg.csv")
    random, t = numpy.random.default_rng(4), recording.t
    warm = {f"{j}_temp_C": 25 + 10 * (1 - numpy.exp(-t / 20)) + random.normal(0, 0.2, len(t)) for j in ("knee", "ankle")}
    return setting(leg_tree(), talus.Recording({**recording.columns, **warm}))


def setting(tree, recording):
    """(dataset, torque terms, candidates) of a recording at the model's own parameters."""
    model = talus.Model.from_tree(tree)
    dataset = Dataset(model, [ProcessedRecording(model, recording)], tree)
    terms = TorqueTerms(dataset, 0, dataset.prior)
    return dataset, terms, candidates(dataset, [terms], Extent([terms]))


def library_effect(dataset, candidate, strengths):
    """The entry of the model file, as the C struct that the file's reader makes of it."""
    kind = lib.tl_effect_find(candidate.effect.encode())
    entry, joints = candidate.entry(strengths), dataset.model.joints
    effect = ffi.new("tl_effect *", {"kind": kind})
    effect.joint = joints.index(candidate.joint) if candidate.joint in joints else talus.constants.TL_MAX_JOINTS
    names = [p.name for p in kind_of(candidate.effect).parameters]
    assert set(entry) <= set(names), (candidate.effect, candidate.shape, entry)
    for k, name in enumerate(names):
        effect.value[k] = entry.get(name, kind.parameter[k].default_value)
    check(lib.tl_effect_check(effect, dataset.model.struct))
    return effect


def library_adds(dataset, candidate, strengths):
    """What the entry adds to each joint's torque, after the score's operator."""
    processed = dataset.processed_recordings[0]
    regression = talus.Regression(dataset.model, processed.recording)
    effect = library_effect(dataset, candidate, strengths)
    check(lib.tl_regression_set_effects(regression.struct, effect, 1, processed.t_s[0]))
    base = numpy.array(list(dataset.model.base.values()))
    with_effect = [predicted(parts, base) for parts in regression.rows()]
    plain = [predicted(parts, base) for parts in talus.Regression(dataset.model, processed.recording).rows()]
    return [a - b for a, b in zip(with_effect, plain)]


def predicted(parts, base):
    return numpy.concatenate([part.measured - part.target + part.x @ base[part.index] for part in parts])


def mismatch(setting, candidate):
    """The largest relative difference over the joints that show the effect, and the joint."""
    dataset, terms, _ = setting
    strengths = typical(candidate)
    column = sum_of([column(terms) for column in candidate.columns], strengths)
    added, worst = library_adds(dataset, candidate, strengths), (0.0, None)
    size = max(rms(column[c.kind][c.rows]) / dataset.sigma[c.kind] for c in torques(dataset, column))
    for channel in torques(dataset, column):
        j = int(channel.kind[1])
        here = column[channel.kind][channel.rows]
        # a joint where little shows counts by what shows at the other
        unit = max(rms(here), 0.05 * size * dataset.sigma[channel.kind], 1e-9 * dataset.sigma[channel.kind])
        off = rms(here - added[j][channel.rows]) / unit
        worst = max(worst, (off, dataset.model.joints[j]), key=lambda x: x[0])
    return worst


def torques(dataset, column):
    return [c for c in dataset.channels if c.kind in column and c.kind[0] == "T"]


def sum_of(shown, strengths):
    out = {}
    for columns, strength in zip(shown, strengths):
        for kind, values in columns.items():
            out[kind] = out.get(kind, 0.0) + strength * values
    return out


def rms(x):
    return float(numpy.sqrt(numpy.mean(x**2)))


def typical(candidate):
    """Strengths for which first order holds: half way where the range is known, small elsewhere."""
    small = {"delay": 1e-3, "linkage_error": 1e-5, "kinematic_error": 1e-3, "encoder_eccentricity": 1e-3}
    if candidate.effect == "delay":  # its columns stand for the shift they are named after
        return [1e-3 * float(candidate.shape.split()[1])]
    if candidate.low and candidate.high:
        return [min(1.0, 0.5 * (a + b)) for a, b in zip(candidate.low, candidate.high)]
    return [small.get(candidate.effect, 0.01) * (1 + 0.3 * k) for k in range(len(candidate.columns))]


def check_every(setting, stride=1):
    """All candidates of a setting, or some of each effect; what is off is listed."""
    off, seen = [], {}
    for candidate in setting[2]:
        seen[candidate.key] = seen.get(candidate.key, -1) + 1
        if seen[candidate.key] % stride:
            continue
        if not any(kind[0] == "T" for kind in candidate.columns[0](setting[1])):
            library_effect(setting[0], candidate, typical(candidate))  # shows between sensors alone
            continue
        found, joint = mismatch(setting, candidate)
        if not found < TOLERANCE.get(candidate.effect, CLOSE):
            off.append(f"{candidate.effect} of {candidate.joint}, {candidate.shape}: {found:.4f} at the {joint}")
    assert not off, "\n".join(off)


def test_a_first_look_has_every_value_of_a_grid(leg):
    """Whatever the order of its loops: of six gaps, every third shape had two."""
    every = [c for c in leg[2] if c.key == ("backlash", "knee")]
    few = sparse(every)
    assert 0.25 < len(few) / len(every) < 0.4
    for number in range(len(every[0].family.values)):
        assert {c.family.values[number] for c in few} == {c.family.values[number] for c in every}, number


def test_shapes_of_the_leg_are_predicted_as_they_were_fitted(leg):
    check_every(leg, 20)


@pytest.mark.long
def test_every_shape_of_the_leg_is_predicted_as_it_was_fitted(leg):
    check_every(leg)


def pendulum_setting(load=None):
    """A pendulum with a gear, whose currents are those of its model; `load`: what a sensor at the output shows."""
    tree = yaml.safe_load((REPOSITORY / "models/pendulum.yaml").read_text())
    t = numpy.arange(0, 20, 0.004)
    q = 0.8 * numpy.sin(1.3 * t) + 0.3 * numpy.sin(3.7 * t + 1)
    v, a = (numpy.gradient(x, t) for x in (q, numpy.gradient(q, t)))
    torque = talus.Model.from_tree(tree).inverse(q[None], v[None], a[None])[0] + (0.0 if load is None else load(t))
    gain = tree["joint"]["torque_constant_Nm_A"] * tree["joint"]["transmission"]["ratio"]
    columns = {"time_s": t, "joint_rad": q, "joint_current_A": torque / gain}
    if load is not None:
        columns["joint_load_Nm"] = load(t)
    return setting(tree, talus.Recording(columns))


def test_every_strength_that_is_allowed_fits_a_model_file(leg):
    """Also at the limits of shapes that are moved between the grid's points: what a file refuses would be lost."""
    dataset, _, every = leg
    tried = 0
    for candidate in every:
        family = candidate.family
        moved = [family.make(*values) for values in (family.low, family.high)] if family else []
        for one in (candidate, *moved):
            limits = [limit for limit in (one.low, one.high) if limit and all(map(math.isfinite, limit)) and any(limit)]
            for strengths in limits:
                library_effect(dataset, one, strengths)
                tried += 1
    assert tried > 1000


def test_a_legs_sensors_are_off_by_what_such_sensors_can_be(leg):
    """Beside a spring's preload an offset of any size would cancel it, and on another motion the rest of both is huge."""
    dataset, _, every = leg
    for joint in ("knee", "ankle"):
        ampere = dataset.tree[joint]["torque_constant_Nm_A"]
        (offset,) = (c for c in every if c.key == ("current_offset", joint))
        assert offset.within_range([-0.2 * ampere]) and not offset.within_range([2.0 * ampere])
        late = [c for c in every if c.key == ("delay", joint)]
        assert any(c.within_range([0.008]) for c in late) and any(c.within_range([-0.001]) for c in late)
        assert not any(c.within_range([x]) for c in late for x in (-0.02, 0.0, 0.02))


def test_shapes_of_a_geared_pendulum_are_predicted_as_they_were_fitted():
    check_every(pendulum_setting(), 3)


def test_shapes_beside_a_sensor_at_the_output_are_predicted_as_they_were_fitted():
    check_every(pendulum_setting(lambda t: 1.5 * numpy.sin(2.1 * t)), 3)


def test_shapes_of_a_slider_are_predicted_as_they_were_fitted():
    tree = yaml.safe_load((REPOSITORY / "models/slider.yaml").read_text())
    t = numpy.arange(0, 20, 0.004)
    q = 0.1 * numpy.sin(1.3 * t) + 0.04 * numpy.sin(3.7 * t + 1)
    v, a = (numpy.gradient(x, t) for x in (q, numpy.gradient(q, t)))
    force = talus.Model.from_tree(tree).inverse(q[None], v[None], a[None])[0]
    check_every(setting(tree, talus.Recording({"time_s": t, "slider_m": q, "slider_force_N": force})), 3)
