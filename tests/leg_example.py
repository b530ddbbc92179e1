"""The example leg of the model format, as structs of the library, for the tests that need one."""

from talus import check, ffi, lib

EXAMPLE_LINKAGE = (0.002, 0.090, 0.040, 0.035, 84.75)  # lead, AB, BO, AC [m], BOF [deg]
EXAMPLE = {
    "gravity_m_s2": 9.81,
    "shank_length_m": 0.3615, "shank_mass_kg": 1.624, "shank_com_m": 0.160, "shank_inertia_kg_m2": 0.0420,
    "foot_mass_kg": 0.442, "foot_com_m": 0.055, "foot_inertia_kg_m2": 0.0021,
    "ankle_motor_mass_kg": 0.4112, "ankle_motor_com_m": 0.120,
}  # fmt: skip
EXAMPLE_DRIVES = {
    0: {"torque_constant_Nm_A": 0.1031, "coulomb_Nm": 1.2, "viscous_Nms_rad": 0.45},
    1: {
        "torque_constant_Nm_A": 0.1031, "rotor_inertia_kg_m2": 2.4e-6,
        "coulomb_Nm": 0.8, "viscous_Nms_rad": 0.30,
    },
}  # fmt: skip


def linkage(dimensions=EXAMPLE_LINKAGE):
    t = ffi.new("tl_transmission *")
    check(lib.tl_transmission_screw_linkage(t, ffi.new("tl_screw_linkage *", dimensions)))
    return t


def fixed(ratio):
    t = ffi.new("tl_transmission *")
    check(lib.tl_transmission_fixed(t, ratio))
    return t


def table(source, knots, first=-0.6, last=0.6):
    """A table of `source`, with the knots that it lives on (keep both)."""
    knot = ffi.new("tl_table_knot[]", knots)
    check(lib.tl_transmission_tabulate(source, first, last, knot, knots))
    t = ffi.new("tl_transmission *")
    check(lib.tl_transmission_table(t, knot, knots, first, (last - first) / (knots - 1)))
    return t, knot


def fourier(omega, a, b):
    """A series with as many harmonics as a and b have."""
    f = ffi.new("tl_fourier *", {"omega": omega, "a": list(a), "b": list(b)})
    t = ffi.new("tl_transmission *")
    check(lib.tl_transmission_fourier(t, f))
    return t


def leg(ankle=None, friction=True):
    """The example leg; `ankle` is its transmission (default: the linkage)."""
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_LEG))
    for name, value in EXAMPLE.items():
        setattr(m, name, value)
    for joint, values in EXAMPLE_DRIVES.items():
        for name, value in values.items():
            setattr(m.drive[joint], name, value)
        if not friction:
            m.drive[joint].coulomb_Nm = m.drive[joint].viscous_Nms_rad = 0.0
    m.drive[0].transmission = fixed(51.0)[0]
    m.drive[1].transmission = (linkage() if ankle is None else ankle)[0]
    check(lib.tl_model_check(m))
    return m
