"""The plain model's torques along one recording, at its samples: what the effects' columns are made of."""

import copy

import numpy as np

from talus import ffi

from .physical import physical

SMALL_ANGLE = 1e-4  # rad, of differences
GRAVITY_M_S2 = 9.81
TEMPERATURE_WINDOW_S = 2.0  # a gear's temperature changes slower, its sensor's noise faster
INSTANT = np.dtype([(name, float) for name, _ in ffi.typeof("tl_effect_instant").fields])


class Scene:
    """Torques of one recording at identified base parameters, the drive giving 1 + `torque_constant_error` of what current and
    constant say. Arrays have one row a joint."""

    def __init__(self, evidence, record, base, torque_constant_error=0.0):
        self.evidence, self.record, self.base = evidence, record, np.asarray(base, float)
        self.torque_constant_error = torque_constant_error
        self.track = track = evidence.tracks[record]
        self.q, self.v, self.a, self.slip = track.q, track.v, track.a, track.slip
        self.t_s, self.step_s, self.columns = track.t_s, track.step_s, track.columns
        self.offset_Nm, self.drive_Nm, self._kept, self._latest = 0.0, None, {}, (None, None)
        if evidence.leg:
            self._leg()
        else:
            self._single()
        if evidence.load_sensor:
            self._load_sensor()
        joints = range(evidence.joints)
        self.friction_Nm = np.array([self.coulomb_Nm[j] * self.slip[j] + self.viscous[j] * self.v[j] for j in joints])
        self.joint_Nm = self.link_Nm + self.rotor_Nm + self.friction_Nm
        self.motor_Nm = np.array([track.bridge(self.joint_Nm[j] / self.ratio[j], j) for j in joints]) + self.offset_Nm
        if self.drive_Nm is not None:
            self.joint_Nm = self.motor_Nm = self.drive_Nm

    def copied(self):
        """The same scene, to be changed: nothing that was made of it is kept."""
        out = copy.copy(self)
        out._kept, out._latest = {}, (None, None)
        return out

    def once(self, key, make):
        """A value that several columns share."""
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    def latest(self, key, make):
        """As once(), but only the last value is kept: columns that share it are made one after the other."""
        if self._latest[0] != key:
            self._latest = key, make()
        return self._latest[1]

    def library_model(self):
        """A model of the library with this scene's parameters; physical or not, its laws take them."""
        def make():
            model = self.evidence.model.copy()
            model.set_parameters(**(physical(model, self.base) or {}))
            return model
        return self.once("library model", make)

    def instants(self, j):
        """What the library's laws depend on at a joint: its tl_effect_instant at every sample."""
        return self.once(("instants", j), lambda: self._instants(j))

    def _instants(self, j):
        now, load = np.zeros(len(self.t_s), INSTANT), self.link_Nm[j] + self.rotor_Nm[j]
        now["q"], now["v"], now["slip"], now["t_s"] = self.q[j], self.v[j], self.slip[j], self.t_s - self.t_s[0]
        now["ratio"], now["motor_rad"] = self.gear * self.ratio[j], self.gear * self.motor_rad[j]
        now["motor_Nm"], now["temp_C"] = self.motor_Nm[j] / self.gear, self._temperature(j)
        now["load_Nm"], now["rotor_Nm"], now["friction_Nm"] = load, self.rotor_Nm[j], self.friction_Nm[j]
        if self.evidence.leg:
            now["gravity_tilt_Nm"] = self.tilt_Nm()[j]
        if self.drive_Nm is not None:  # the gear carries what the drive gives
            now["effort_Nm"], now["rotor_Nm"], now["friction_Nm"] = self.drive_Nm[j], 0.0, 0.0
        return now

    def _temperature(self, j):
        """Of a joint's drive, smoothed [C]; 0 where it was not recorded."""
        values = self.columns.get(f"{self.evidence.model.joints[j]}_temp_C")
        if values is None:
            return 0.0
        n = max(1, int(TEMPERATURE_WINDOW_S / self.step_s))
        return np.convolve(np.pad(values, (n // 2, n - 1 - n // 2), mode="edge"), np.ones(n) / n, "valid")

    def grid(self, name, joint):
        """An array of this scene on the grid."""
        return self.once(("grid", name, joint), lambda: self.track.resample(getattr(self, name)[joint]))

    # ---- leg -----------------------------------------------------------------------

    def _leg(self):
        tree, b = self.evidence.tree, self.base
        self.shank_m, self.foot_kg = tree["shank"]["length_m"], tree["foot"]["mass_kg"]
        self.gravity = tree.get("gravity_m_s2", GRAVITY_M_S2)
        knee, ankle = self.evidence.transmissions
        ratio = ankle.ratio(self.q[1])
        bend = (ankle.ratio(self.q[1] + 1e-5) - ankle.ratio(self.q[1] - 1e-5)) / 2e-5
        self.ratio, self.gear = np.array([knee.ratio(self.q[0]), ratio]), 1.0
        self.link_Nm = self.links(self.q, self.v, self.a)
        rotor = b[4] * (ratio * ratio * self.a[1] + ratio * bend * self.v[1] ** 2)
        self.rotor_Nm = np.array([np.zeros_like(rotor), rotor])
        self.coulomb_Nm, self.viscous = (b[5], b[7]), (b[6], b[8])
        self.motor_rad = np.array([self.columns["knee_motor_rad"], self.columns["ankle_motor_rad"]])
        self.travel_rad = np.array([knee.joint_rad(self.motor_rad[0]), self.evidence.ankle_rad[self.record]])
        self.inertia, effective = self._leg_inertia(b)
        # an effect can drive the fitted inertia far out of range: kept within a factor 4 of the file's
        near = self._leg_inertia(self.evidence.prior)[1]
        self.link_inertia = [float(np.clip(x, 0.25 * y, 4 * y)) for x, y in zip(effective, near)]

    def _leg_inertia(self, b):
        coupling = b[2] * self.shank_m * np.cos(self.q[1])
        whole = b[0] + self.foot_kg * self.shank_m**2 + b[3] + 2 * coupling
        foot = np.full_like(whole, b[3])
        straight = b[0] + self.foot_kg * self.shank_m**2 + b[3] + 2 * b[2] * self.shank_m
        return np.array([[whole, b[3] + coupling], [b[3] + coupling, foot]]), (straight, b[3])

    def links(self, q, v, a):
        """Torques of both links' inertia and gravity at the joints, (2, n)."""
        b, shank, cosine, sine = self.base, self.shank_m, np.cos(q[1]), np.sin(q[1])
        knee_gravity, foot_gravity = self.gravity * np.sin(q[0]), self.gravity * np.sin(q[0] + q[1])
        foot_a = a[0] + a[1]
        of_knee = shank * cosine * (a[0] + foot_a) - shank * sine * (2 * v[0] + v[1]) * v[1] + foot_gravity
        of_ankle = shank * cosine * a[0] + shank * sine * v[0] ** 2 + foot_gravity
        known = self.foot_kg * shank * (shank * a[0] + knee_gravity)
        knee = b[0] * a[0] + b[1] * knee_gravity + b[2] * of_knee + b[3] * foot_a + known
        return np.array([knee, b[2] * of_ankle + b[3] * foot_a])

    def tilt_Nm(self):
        """Change of both joints' torque per rad of tilt of the base."""
        def make():
            turned = self.links(np.array([self.q[0] + SMALL_ANGLE, self.q[1]]), self.v, self.a)
            return (turned - self.link_Nm) / SMALL_ANGLE
        return self.once("tilt", make)

    # ---- single joint --------------------------------------------------------------

    def _single(self):
        names, b = list(self.evidence.model.base), self.base
        dry = [k for k, name in enumerate(names) if "coulomb" in name]
        viscous = [k for k, name in enumerate(names) if "viscous" in name]
        offset = [k for k, name in enumerate(names) if "offset" in name]
        inertia = next((b[k] for k, name in enumerate(names) if "inertia" in name or "mass" in name), 0.0)
        self.ratio, self.rotor_Nm = np.ones_like(self.q), np.zeros_like(self.q)
        self.link_Nm = self._single_link(dict(zip(names, b)))
        self.offset_Nm = sum(b[k] for k in offset)
        self.coulomb_Nm, self.viscous = (b[dry[0]],), (b[viscous[0]],)
        self.inertia, self.link_inertia = np.full((1, 1, self.q.shape[1]), inertia), [max(float(inertia), 1e-9)]
        self.motor_rad = self.travel_rad = self.q
        # torques and angles are the joint's here: motor turns for one of it
        pendulum = self.evidence.model.plant == "pendulum"
        self.gear = float(self.evidence.tree["joint"].get("transmission", {}).get("ratio", 1.0)) if pendulum else 1.0

    def _single_link(self, base):
        """Inertia and gravity at the samples as they are; the regressor's columns are bridged."""
        gravity = 0.0
        if self.evidence.model.plant == "pendulum" and not self.evidence.velocity_only:
            g = self.evidence.tree.get("gravity_m_s2", GRAVITY_M_S2)
            gravity = g * (base["gravity_sin"] * np.sin(self.q) + base["gravity_cos"] * np.cos(self.q))
        return base["mass" if "mass" in base else "inertia"] * self.a + gravity

    def _load_sensor(self):
        """A sensor at the output: load = drive - friction - inertia. The gear carries the drive's torque."""
        self.given_drive_Nm = (self.columns["joint_current_A"] * self.evidence.drive_gain())[None]
        self.drive_Nm = (1 + self.torque_constant_error) * self.given_drive_Nm
        self.link_Nm = self.drive_Nm


class Extent:
    """How far the recordings go, over all of them: scales of the candidates' shapes. One entry a joint."""

    def __init__(self, scenes):
        joints = range(scenes[0].evidence.joints)

        def each(name, j):
            return [getattr(scene, name)[j][scene.track.inside] for scene in scenes]

        self.speed = [max(np.quantile(np.abs(v), 0.98) for v in each("v", j)) + 1e-9 for j in joints]
        self.middle = [float(np.median(np.concatenate(each("q", j)))) for j in joints]
        self.half_range = [max(max(np.ptp(q) / 2 for q in each("q", j)), 1e-9) for j in joints]
        self.motor_Nm = [max(np.quantile(np.abs(x), 0.999) for x in each("motor_Nm", j)) + 1e-12 for j in joints]
