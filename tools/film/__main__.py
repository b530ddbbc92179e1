"""Films a simulated leg: python -m film --motion motion.csv --out film.mp4 --truth truth.csv

The motion is what `talus-sim --motion` writes. The camera has a clock of its own; --truth holds, for each picture, both clocks'
times, where the markers are and how much of each is to be seen.
"""

import argparse
import sys

import numpy as np

from film.camera import Camera
from film.encode import CODECS, Video
from film.pictures import Film, Look
from film.scene import Passing, Scene

LAMP_M = (0.22, -0.06)
NAMES = ("knee", "ankle", "heel", "toe")


def parse():
    """What is asked for."""
    parser = argparse.ArgumentParser(prog="film", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motion", required=True, help="the leg's true motion (talus-sim --motion)")
    parser.add_argument("--out", required=True, help="the video: .mp4 or .mov")
    parser.add_argument("--truth", help="CSV of what the pictures show")
    parser.add_argument("--codec", choices=CODECS, default="h264")
    parser.add_argument("--width", type=int, default=960, help="pixels; the height is 9/16 of it")
    parser.add_argument("--rate", type=float, default=120.0, help="pictures a second")
    parser.add_argument("--begin", type=float, default=1.0, help="of the film in the motion [s]")
    parser.add_argument("--duration", type=float, default=10.0, help="[s]")
    parser.add_argument("--offset", type=float, default=0.0, help="motion's time = camera's time * (1 + drift) + offset [s]")
    parser.add_argument("--drift-ppm", type=float, default=0.0)
    parser.add_argument("--jitter", type=float, default=0.0, help="of the pictures' instants, about which the file tells the truth [s]")
    parser.add_argument("--drop", type=float, default=0.0, help="share of pictures that are lost")
    parser.add_argument("--turn", type=float, nargs=3, default=(0, 0, 0), help="the camera's yaw, pitch, roll [rad]")
    parser.add_argument("--distortion", type=float, nargs=4, default=(0, 0, 0, 0), help="k1 k2 p1 p2")
    parser.add_argument("--passing", type=float, default=0.0, help="a bar passes each so many seconds")
    parser.add_argument("--flashes", help="a lamp flashes; CSV of its edges on the motion's clock")
    parser.add_argument("--hidden", choices=NAMES, nargs="*", default=[], help="markers that are not there")
    parser.add_argument("--near-markers", action="store_true", help="draw the links around the markers only, which is faster")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def instants(asked, random):
    """Times of the pictures on the motion's clock."""
    t = asked.begin + np.arange(int(asked.duration * asked.rate)) / asked.rate
    t += random.uniform(-1, 1, len(t)) * min(asked.jitter, 0.4 / asked.rate)
    return t[random.uniform(size=len(t)) >= asked.drop]


def bars(asked, random):
    """What passes in front of the leg."""
    if not asked.passing:
        return []
    begin = np.arange(asked.begin + 0.5 * asked.passing, asked.begin + asked.duration, asked.passing)
    return [Passing(b, b + 1.2, (-0.42, -random.uniform(0.02, 0.42)), (0.7, 0), length_m=0.15) for b in begin]


def flashes(asked, random):
    """(edges, states) of a lamp: on and off for 30 to 300 ms."""
    edges = asked.begin - 0.5 + np.cumsum(random.uniform(0.03, 0.3, int(asked.duration * 8) + 12))
    states = np.arange(len(edges)) % 2
    np.savetxt(asked.flashes, np.c_[edges, 1 - states], delimiter=",", header="time_s,on", comments="", fmt="%.6f")
    return lambda t_s: 1 - states[max(np.searchsorted(edges, t_s, side="right") - 1, 0)] if t_s >= edges[0] else 0


def film_of(asked, random):
    """The film that is asked for."""
    motion = np.genfromtxt(asked.motion, delimiter=",", names=True)
    shank = motion["knee_position_rad"]
    scale = asked.width / 1920
    camera = Camera(asked.width, asked.width * 9 // 16, 1800 * scale, yaw=asked.turn[0], pitch=asked.turn[1], roll=asked.turn[2],
                    distortion=tuple(asked.distortion))  # fmt: skip
    lamp = {"lamp_m": LAMP_M, "lamp_on": flashes(asked, random)} if asked.flashes else {}
    scene = Scene.leg(motion["time_s"], shank, shank + motion["ankle_position_rad"], passing=bars(asked, random),
                      hidden=tuple(map(NAMES.index, asked.hidden)), **lamp)  # fmt: skip
    # a lamp's light within an exposure needs more instants than a motion's blur
    return Film(camera, scene, Look(instants=24 if asked.flashes else 3), asked.seed, whole=not asked.near_markers)


def truth_row(truth, camera_s):
    """One line of the truth."""
    return [camera_s, truth.t_s, *truth.center_px.ravel(), *truth.visible, *truth.clear, truth.shank_rad, truth.foot_rad]


def main():
    """Writes video and truth."""
    asked = parse()
    random = np.random.default_rng(asked.seed)
    film, rows = film_of(asked, random), []
    video = Video(asked.out, film.camera.width, film.camera.height, asked.codec, round(asked.rate))
    times = instants(asked, random)
    camera = (times - asked.offset) / (1 + 1e-6 * asked.drift_ppm)
    camera -= camera[0]  # a file's first picture has the time 0
    for done, (t_s, camera_s) in enumerate(zip(times, camera, strict=True)):
        picture, truth = film.take(t_s)
        video.add(picture, camera_s)
        rows.append(truth_row(truth, camera_s))
        if sys.stderr.isatty() and done % 20 == 0:
            print(f"\r{done} of {len(times)} pictures", end="", file=sys.stderr)
    video.close()
    columns = [f"{n}_{c}_px" for n in NAMES for c in "xy"] + [f"{n}_visible" for n in NAMES] + [f"{n}_clear" for n in NAMES]
    header = ",".join(["time_s", "motion_s", *columns, "shank_rad", "foot_rad"])
    if asked.truth:
        np.savetxt(asked.truth, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    lamp = film.camera.pixel(np.array(LAMP_M)) if asked.flashes else None
    if lamp is not None:
        print(f"{lamp[0]:.1f},{lamp[1]:.1f},{0.008 * film.camera.px_per_m:.1f}")


if __name__ == "__main__":
    main()
