"""Recordings from the bench twin: the leg as drawn and as built, and (14) within the bench's limits."""

from dataclasses import dataclass
from pathlib import Path

import numpy
import yaml

import talus
from talus import check, ffi, lib

from . import published

DESIGN = Path(__file__).resolve().parents[2] / "models" / "leg.yaml"
FADE_S = 2.0  # (14) is faded in over this time before the recording begins
JOINTS = ("knee", "ankle")

# how far the leg as built may differ from its drawing, by what a key of the model file holds
SPREAD = {
    "com_m": 0.10,
    "inertia_kg_m2": 0.20,
    "rotor_inertia_kg_m2": 0.20,
    "coulomb_Nm": 0.40,
    "viscous_Nms_rad": 0.40,
}

# columns of a recording and their decimals
COLUMNS = {"time_s": 6, "knee_motor_rad": 6, "ankle_motor_rad": 6, "ankle_joint_rad": 7,
           "knee_current_A": 4, "ankle_current_A": 5}  # fmt: skip


def design():
    """The model file of the leg as drawn (the paper's CAD values), as a mapping."""
    return yaml.safe_load(DESIGN.read_text(encoding="utf-8"))


def as_built(tree, seed):
    """`tree` with every identified parameter off by half to all of its SPREAD, up or down."""
    random = numpy.random.default_rng(seed)

    def changed(node):
        if not isinstance(node, dict):
            return node
        return {
            key: _off(value, SPREAD[key], random) if key in SPREAD else changed(value)
            for key, value in node.items()
        }

    return changed(tree)


def _off(value, spread, random):
    return float(value * (1 + spread * random.choice((-1, 1)) * random.uniform(0.5, 1)))


@dataclass
class Excitation:
    """(14) with other phases (or as printed), scaled into the limits."""

    struct: object
    amplitude: tuple  # factor on each joint's amplitude
    speed: float  # factor on the base frequency
    peaks: list  # as scaled


def series(phase_seed=None):
    """(14) as printed, or with each harmonic of each joint at a phase drawn for the seed."""
    e = ffi.new("tl_excitation *")
    check(lib.tl_excitation_paper(e, len(JOINTS)))
    e.fade_s = FADE_S
    if phase_seed is not None:
        random = numpy.random.default_rng(phase_seed)
        for j in range(len(JOINTS)):
            for i in range(e.harmonics):
                turned = complex(e.sine[j][i], e.cosine[j][i]) * numpy.exp(2j * numpy.pi * random.uniform())
                e.sine[j][i], e.cosine[j][i] = turned.real, turned.imag
    return e


def limits(machine):
    """What the bench with this machine on it can do."""
    out = ffi.new("tl_limits[]", len(JOINTS))
    lib.tl_twin_limits(machine.struct, settings_of(machine, series(), 1), out)
    return out


def peaks(model, bounds, excitation):
    """What the series asks of each joint: dicts of joint, quantity, peak, limit, excess."""
    found = ffi.new("tl_peak[]", talus.constants.TL_MAX_PEAKS)
    lib.tl_excitation_peaks(model.struct, bounds, excitation, found)
    return [
        {"joint": JOINTS[p.joint], "quantity": ffi.string(lib.tl_quantity_name(p.quantity)).decode(),
         "peak": p.peak, "limit": p.limit, "excess": p.excess}
        for p in found
    ]  # fmt: skip


def scaled(model, bounds, phase_seed=None):
    """The series within the bounds, planned with `model`: amplitudes first, then speed."""
    e, factor = series(phase_seed), ffi.new("tl_scaling *")
    check(lib.tl_excitation_fit(model.struct, bounds, e, factor))
    return Excitation(e, tuple(factor.amplitude), factor.speed, peaks(model, bounds, e))


def settings_of(machine, excitation, seed):
    """The bench's settings for one recording."""
    settings = ffi.new("tl_twin_settings *", lib.tl_twin_defaults(machine.struct, excitation))
    settings.sample_hz, settings.seed = published.SAMPLE_HZ, seed
    # whole ticks, so that samples lie amid two of them and a held current is seen neither early nor late
    settings.settle_s = round(settings.settle_s * settings.control_hz) / settings.control_hz
    return settings


def describe(settings):
    """What the page says of the bench."""
    return {"control_hz": settings.control_hz, "sample_hz": settings.sample_hz, "jitter_s": settings.jitter_s,
            "encoder_bits": [float(numpy.log2(2 * numpy.pi / step)) for step in settings.drive_step_rad],
            "current_noise_A": list(settings.current_noise_A)}  # fmt: skip


def record(machine, excitation, seconds, seed, path):
    """A recording of the machine on the bench, written to `path`: (columns, true motor torque)."""
    settings = settings_of(machine, excitation.struct, seed)
    bench, row = ffi.new("tl_twin *"), ffi.new("double[]", lib.TL_CHANNEL_COUNT)
    check(lib.tl_twin_init(bench, machine.struct, excitation.struct, settings))
    number = {ffi.string(lib.tl_channel_name(c)).decode(): c for c in range(lib.TL_CHANNEL_COUNT)}
    n = round(seconds * published.SAMPLE_HZ)
    samples, torque = numpy.empty((n, lib.TL_CHANNEL_COUNT)), numpy.empty((len(JOINTS), n))
    for i in range(n):
        check(lib.tl_twin_next(bench, row))
        samples[i] = numpy.frombuffer(ffi.buffer(row))
        torque[:, i] = bench.torque[0], bench.torque[1]
    columns = {name: numpy.round(samples[:, number[name]], decimals) for name, decimals in COLUMNS.items()}
    numpy.savetxt(path, numpy.column_stack(list(columns.values())), delimiter=",", header=",".join(COLUMNS),
                  comments="", fmt=[f"%.{decimals}f" for decimals in COLUMNS.values()])  # fmt: skip
    return columns, torque
