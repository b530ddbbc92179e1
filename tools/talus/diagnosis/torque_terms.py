"""The plain model's torque terms along one recording, at its samples: what the effects' columns are made of. The library
computes them (tl_effect_instants)."""

import functools
import threading

import numpy as np

from talus import constants, ffi, lib, pointer

from .machine.physical import physical

TEMPERATURE_WINDOW_S = 2.0  # a gear's temperature changes slower, its sensor's noise faster
INSTANT = np.dtype([(name, float) for name, _ in ffi.typeof("tl_effect_instant").fields])
INERTIA_WITHIN = 4.0  # of the given model's, that a link's stays where an effect drives the fit far out of range
MOTION = ("q", "v", "a", "slip")


def rows_of(instants, name):
    """One field of every joint's instants, one row a joint."""
    return np.array([now[name] for now in instants])


class TorqueTerms:
    """Torques of one recording at identified base parameters, the drive giving 1 + `torque_constant_error` of what current and
    constant say. Arrays have one row a joint."""

    def __init__(self, dataset, record, base, torque_constant_error=0.0):
        self.dataset, self.record, self.base = dataset, record, np.asarray(base, float)
        self.torque_constant_error = torque_constant_error
        self.processed = processed = dataset.processed_recordings[record]
        self.q, self.v, self.a, self.slip = processed.q, processed.v, processed.a, processed.slip
        self.t_s, self.step_s, self.columns = processed.t_s, processed.step_s, processed.columns
        self.drive_Nm, self._kept, self._one_at_a_time = None, {}, threading.RLock()
        if dataset.load_sensor:
            self.given_drive_Nm = (self.columns["joint_current_A"] * dataset.drive_gain())[None]
            self.drive_Nm = (1 + torque_constant_error) * self.given_drive_Nm
        self.model = model_at(dataset, self.base)
        self.segments = [self._segment(number) for number in range(len(processed.parts))]
        self._take_instants()
        drives = [self.model.struct.drive[j] for j in range(dataset.joints)]
        self.coulomb_Nm = [drive.coulomb_Nm for drive in drives]
        self.viscous = [drive.viscous_Nms_rad for drive in drives]
        if dataset.at_motor:
            self.travel_rad = np.array([dataset.transmissions[0].joint_rad(self.motor_rad[0]), dataset.ankle_rad[record]])

    def once(self, key, make):
        """A value that several columns share, also those that another thread makes."""
        with self._one_at_a_time:
            if key not in self._kept:
                self._kept[key] = make()
            return self._kept[key]

    def give_up(self):
        """Lets go of what columns are made of; it would be made anew for one more."""
        self._kept.clear()
        self._instants = None

    def at(self, base, torque_constant_error=0.0):
        """The same recording at other base parameters."""
        return TorqueTerms(self.dataset, self.record, base, torque_constant_error)

    # ---- segments ------------------------------------------------------------------

    def _segment(self, number):
        """A part of the recording for the library; what it points to stands beside it."""
        part, processed = self.processed.parts[number], self.processed
        begin, end = part["begin"], part["end"]
        segment, alive = ffi.new("tl_effect_segment *"), [self.model, np.ascontiguousarray(self.t_s[begin:end])]
        segment.model, segment.n, segment.t_s = self.model.struct, end - begin, pointer(alive[1])
        for j in range(self.dataset.joints):
            stops, sensing = part["stops"][j], processed.regression.struct.sensing[j]
            recorded_speed = processed.regression.struct.layout.position[j] == lib.TL_CHANNEL_COUNT  # runs on through stops
            segment.stop[j], segment.stops[j] = stops, 0 if recorded_speed else len(stops)
            segment.window[j] = ffi.NULL if sensing.across else ffi.addressof(sensing, "window")
            for name in MOTION:
                alive.append(np.ascontiguousarray(getattr(self, name)[j][begin:end]))
                getattr(segment, name)[j] = pointer(alive[-1])
        if self.drive_Nm is not None:
            alive.append(np.ascontiguousarray(self.drive_Nm[0][begin:end]))
            segment.effort_Nm = pointer(alive[-1])
        self._limit_inertia(segment)
        return segment, alive

    def _limit_inertia(self, segment):
        """An effect can drive the fitted inertia far out of range: links swing with one near the given model's."""
        mine, given = straight_inertia(self.model), straight_inertia(self.dataset.model)
        for j in range(self.dataset.joints if self.dataset.at_motor else 0):
            segment.link_inertia_kg_m2[j] = np.clip(mine[j], given[j] / INERTIA_WITHIN, given[j] * INERTIA_WITHIN)

    def prepared(self, number):
        """A segment ready for the library's columns; what its columns share is made once."""
        def make():
            segment = self.segments[number][0]
            memory = np.empty(lib.tl_effect_prepared_memory(self.dataset.joints, segment.n))
            out = ffi.new("tl_effect_prepared *")
            lib.tl_effect_prepare(out, segment, pointer(memory))
            return out, memory
        return self.once(("prepared", number), make)[0]

    def link_rad_s(self, j, motor_share, stiffness):
        """Frequency of a link on a spring beyond its transmission, undamped."""
        return lib.tl_effect_link_rad_s(self.prepared(0), j, motor_share, stiffness)

    def channels_of(self, joint):
        """Channels that can show an effect at a joint, or at the base, that is no law of the instant."""
        angles = {0: ("K",), 1: ("E", "F"), constants.TL_MAX_JOINTS: ("K",)}[joint]
        return [*(f"T{j}" for j in range(self.dataset.joints)), *(name for name in angles if name in self.dataset.kinds)]

    def operated(self, samples, joint):
        """(columns, samples) of torques at a joint -> (columns, grid), as the score has its rows."""
        parts = [self.operated_part(samples[:, part["begin"]:part["end"]], joint, number)
                 for number, part in enumerate(self.processed.parts)]  # fmt: skip
        return np.concatenate(parts, axis=1)

    def operated_part(self, samples, joint, number, bridged=False):
        """The same of one part; of an angle where `joint` is None. `bridged`: has gone through short stops already."""
        part = self.processed.parts[number]
        rows = slice(part["begin"], part["end"])
        columns = np.ascontiguousarray(samples if joint is None else samples / self.ratio[joint][rows])
        columns = columns.copy() if columns is samples else columns
        out = np.empty((len(columns), part["n"]))
        lib.tl_regression_columns(self.processed.regression.struct, self.segments[number][0], -1 if joint is None or bridged else joint,
                                  part["begin_s"], pointer(columns), len(columns), pointer(out), part["n"])  # fmt: skip
        return out

    # ---- torque terms --------------------------------------------------------------

    def instants(self, j, session=False):
        """What the library's laws depend on at a joint: its tl_effect_instant at every sample. Time counts from the
        recording's begin, or over all recordings one after the other; the array is the same, and holds either until the other
        is asked for."""
        if self._instants is None:
            self._take_instants()
        begin_s = self.dataset.session_begin_s[self.record] if session else 0.0
        if self._counted_from_s[j] != begin_s:
            self._counted_from_s[j] = begin_s
            self._instants[j]["t_s"] = self._since_begin_s + begin_s
        return self._instants[j]

    def _take_instants(self):
        """Instants of every joint, and their fields as arrays with one row a joint."""
        joints = range(self.dataset.joints)
        self._instants = [np.zeros(len(self.t_s), INSTANT) for _ in joints]
        for j, now in enumerate(self._instants):
            for (segment, _), part in zip(self.segments, self.processed.parts):
                rows = now[part["begin"]:part["end"]]
                lib.tl_effect_instants(segment, j, ffi.from_buffer("tl_effect_instant[]", rows, require_writable=True))
            self._add_recorded(j, now)
        self._since_begin_s, self._counted_from_s = self._instants[0]["t_s"].copy(), [0.0 for _ in joints]
        every = functools.partial(rows_of, self._instants)
        whole, rotor_Nm, friction_Nm = every("load_Nm"), every("rotor_Nm"), every("friction_Nm")
        known = np.array([[self.has_rotor(j)] for j in joints])  # else how much of the joint's inertia is its rotor's is not
        self.link_Nm, self.joint_Nm = np.where(known, whole - rotor_Nm, whole), whole + friction_Nm
        self.motor_rad, self.motor_Nm, self.ratio = every("motor_rad"), every("motor_Nm"), every("ratio")
        self.gear = 1.0
        if not self.dataset.at_motor:  # torques and angles are the joint's here: motor turns for one of it
            self.gear = float(self.ratio[0, self.processed.parts[0]["begin"]])
            self.motor_Nm, self.ratio = self.gear * self.motor_Nm, np.ones_like(self.ratio)
            self.motor_rad = self.travel_rad = self.q

    def has_rotor(self, j):
        """Has a joint's motor a rotor of its own in the model? Else the joint's inertia holds it."""
        torque = ffi.new("double *")
        return lib.tl_motor_inertia(self.model.struct, j, 0.0, ffi.new("tl_motion *"), torque) > 0.0

    def _add_recorded(self, j, now):
        """What the recording itself tells, and the motor's torque through short stops."""
        now["t_s"] -= self.processed.recording.origin.begin_s
        now["temp_C"] = self._temperature(j)
        if self.drive_Nm is None:
            now["motor_Nm"] = self.processed.bridge(now["motor_Nm"], j)
        if self.dataset.at_motor:
            now["motor_rad"] = self.columns[f"{self.dataset.model.joints[j]}_motor_rad"]

    def _temperature(self, j):
        """Of a joint's drive, smoothed [C]; 0 where it was not recorded."""
        values = self.columns.get(f"{self.dataset.model.joints[j]}_temp_C")
        if values is None:
            return 0.0
        n = max(1, int(TEMPERATURE_WINDOW_S / self.step_s))
        return np.convolve(np.pad(values, (n // 2, n - 1 - n // 2), mode="edge"), np.ones(n) / n, "valid")

    def grid(self, name, joint):
        """An array of these terms on the grid."""
        return self.once(("grid", name, joint), lambda: self.processed.resample(getattr(self, name)[joint]))


def model_at(dataset, base):
    """The library's model with these base parameters; physical or not, its laws take them. One at a time is kept."""
    key = id(dataset.model), np.asarray(base, float).tobytes()
    kept = dataset.models.get("kept")
    if not kept or kept[0] != key:
        kept = dataset.models["kept"] = key, _model_at(dataset, base)
    return kept[1]


def _model_at(dataset, base):
    model = dataset.model.copy()
    model.set_parameters(**(physical(model, base) or {}))
    if dataset.velocity_only:  # gravity at an angle that is not known
        model.struct.gravity_moment_kg_m = 0.0
    return model


def straight_inertia(model):
    """Inertia at each joint with its transmission rigid and without the rotor beyond, all joints at 0."""
    bare, joints = model.copy(), len(model.joints)
    for j in range(joints):
        bare.struct.drive[j].rotor_inertia_kg_m2 = 0.0
    matrix = np.zeros(constants.TL_MAX_JOINTS**2)
    lib.tl_inertia_matrix(bare.struct, pointer(np.zeros(constants.TL_MAX_JOINTS)), pointer(matrix))
    return matrix[::joints + 1][:joints].copy()


class Extent:
    """How far the recordings go, over all of them: scales of the candidates' shapes. One entry a joint."""

    def __init__(self, all_terms):
        joints = range(all_terms[0].dataset.joints)

        def each(name, j):
            return [getattr(terms, name)[j][terms.processed.inside] for terms in all_terms]

        self.speed = [max(np.quantile(np.abs(v), 0.98) for v in each("v", j)) + 1e-9 for j in joints]
        self.middle = [float(np.median(np.concatenate(each("q", j)))) for j in joints]
        self.half_range = [max(max(np.ptp(q) / 2 for q in each("q", j)), 1e-9) for j in joints]
        self.motor_Nm = [max(np.quantile(np.abs(x), 0.999) for x in each("motor_Nm", j)) + 1e-12 for j in joints]
