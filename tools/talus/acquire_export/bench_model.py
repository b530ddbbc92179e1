"""What the export needs of a model file: plant, transmissions, and how the drives count."""

import numpy as np
import yaml

import talus
from talus import ffi, lib
from talus.refused import Refused


JOINTS = ("knee", "ankle")
BUS = {  # key: (its keys, each with what it must be)
    "motor": {"counts_per_turn": "whole", "sign": "sign"},
    "joint": {"counts_per_turn": "whole", "sign": "sign", "zero_count": "number"},
    "current": {"sign": "sign"},
}
KINDS = {
    "whole": (lambda x: type(x) is int and x >= 2, "a whole number from 2 on"),
    "sign": (lambda x: type(x) in (int, float) and x in (1, -1), "1 or -1"),
    "number": (lambda x: type(x) in (int, float) and x >= 0, "0 or a number above it"),
}


class BenchModel:
    def __init__(self, path):
        self.path = str(path)
        try:
            with open(path, encoding="utf-8") as file:
                self.tree = yaml.safe_load(file)
            self.model = talus.Model.from_tree(self.tree)
        except OSError as error:
            raise Refused(2, f"{path}: cannot be read: {error.strerror}") from error
        except KeyError as error:
            raise Refused(2, f"{path}: {error.args[0]}: missing key") from error
        except (yaml.YAMLError, ValueError, TypeError, AttributeError, talus.TalusError) as error:
            raise Refused(2, f"{path}: no model: {' '.join(str(error).split())[:200]}") from error
        self.plant = self.model.plant

    def columns(self):
        """(all columns that the plant's recording may have, in order; the required ones)."""
        channels = ffi.new("tl_channel_set *")
        lib.tl_channel_set_of(self.model.struct.plant, channels)
        names = [ffi.string(lib.tl_channel_name(channel)).decode() for channel in range(lib.TL_CHANNEL_COUNT)]
        known = [name for bit, name in enumerate(names) if channels.known >> bit & 1]
        return known, [name for bit, name in enumerate(names) if channels.required >> bit & 1]

    def bus(self, joint, part):
        """The checked mapping bus.JOINT.PART."""
        node, path = self.tree, ""
        for key in ("bus", joint, part):
            path = f"{path}.{key}".lstrip(".")
            node = node.get(key) if isinstance(node, dict) else None
            if not isinstance(node, dict):
                raise Refused(2, f"{self.path}: {path}: missing key; signals in counts need it (docs/bus.md)")
        for key, kind in BUS[part].items():
            fits, words = KINDS[kind]
            if key not in node:
                raise Refused(2, f"{self.path}: {path}.{key}: missing key")
            if not fits(node[key]):
                raise Refused(2, f"{self.path}: {path}.{key}: expected {words}, found '{node[key]}'")
        if "zero_count" in node and node["zero_count"] >= node["counts_per_turn"]:
            raise Refused(2, f"{self.path}: {path}.zero_count: expected a count below counts_per_turn")
        return node

    def motor_angles(self, joint, joint_rad):
        """Of one joint's angles, by its transmission."""
        transmission = ffi.addressof(self.model.struct.drive[JOINTS.index(joint)], "transmission")
        angle_of = lib.tl_transmission_motor_angle
        return np.array([angle_of(transmission, angle) for angle in joint_rad.tolist()])
