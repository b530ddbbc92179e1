"""Markers in 1080p pictures: tl_marker_track against OpenCV's colour conversion, thresholds and moments, and its
SimpleBlobDetector; the whole of talus-track against the decoder alone."""

import resource
import subprocess
import sys

import cv2
import numpy
from measure import Comparison, Outcome, alternate
from talus import check, ffi, lib

HUES = (358, 134, 225, 52)
RUNS = 65_536


class Ours:
    """One tracker that sees picture after picture."""

    def __init__(self, pictures):
        setup = {"markers": 4, "colors": 4, "links": 2, "link": [[0, 1], [2, 3]], "color_of": [0, 1, 2, 3],
                 "color": [(hue, 18, 0.45, 0.2) for hue in HUES], "radius_px": [14] * 4}  # fmt: skip
        self.setup, self.images, self.t_s = ffi.new("tl_marker_setup *", setup), [image_of(p) for p in pictures], 0.0
        self.classes, self.state = ffi.new("tl_marker_classes *"), ffi.new("tl_marker_state *")
        self.sample, self.run = ffi.new("tl_marker_sample[4]"), ffi.new("tl_marker_run[]", RUNS)
        check(lib.tl_marker_classes_init(self.classes, self.setup.color, 4))
        check(lib.tl_marker_start(self.setup, self.state))

    def see(self, image):
        """One picture."""
        self.t_s += 1 / 120
        check(lib.tl_marker_track(self.setup, self.classes, self.state, image, self.t_s, self.sample, self.run, RUNS))

    def see_all(self):
        """There and back, so that the markers never jump."""
        for image in self.images:
            self.see(image)
        self.images.reverse()

    def centers(self):
        """As they were seen last."""
        return numpy.array([(s.x_px, s.y_px) for s in self.sample])


def image_of(picture):
    """The picture for the library."""
    height, width, channels = picture.shape
    return ffi.new("tl_image *", {"pixel": ffi.cast("uint8_t *", picture.ctypes.data), "size": picture.nbytes, "stride": width * channels,
                                  "width": width, "height": height, "channels": channels})  # fmt: skip


def threshold(picture):
    """Centres by cvtColor, inRange and moments over the whole picture, a colour each."""
    hsv, centers = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV), []
    for hue in HUES:
        low, high = max(hue / 2 - 9, 0), min(hue / 2 + 9, 179)
        m = cv2.moments(cv2.inRange(hsv, (low, 115, 51), (high, 255, 255)), binaryImage=True)
        centers.append((m["m10"] / m["m00"], m["m01"] / m["m00"]) if m["m00"] else (numpy.nan, numpy.nan))
    return numpy.array(centers)


def pictures_of(size):
    """Pictures of a leg, and as many without one."""
    from film.camera import Camera
    from film.pictures import Film
    from film.scene import Scene

    t = numpy.linspace(-1, 10, 1101)
    shank = 0.3 * numpy.sin(2 * numpy.pi * 0.6 * t)
    film = Film(Camera(), Scene.leg(t, shank, shank + 0.2 * numpy.sin(2 * numpy.pi * 0.8 * t)), seed=1)
    empty = film.empty.copy()
    taken = [film.take(i / 120) for i in range(size.scaled(24, 3))]
    return film, empty, taken


def decoder(size, film, empty):
    """Processor time of the whole program and of decoding alone, on one compressed film."""
    from film.encode import Video

    path, setup = size.folder / "markers.mp4", size.folder / "markers.yaml"
    video = Video(path, film.camera.width, film.camera.height)
    for i in range(size.scaled(240, 8)):
        video.add(film.take(i / 120)[0], i / 120)
    video.close()
    program = str(size.build / "bin" / "talus-track")
    subprocess.run([program, "calibrate", "--out", setup, "--shank-length", "0.3615", path], check=True, capture_output=True)
    alone = "import cv2, sys\ncv2.setNumThreads(1)\nv = cv2.VideoCapture(sys.argv[1])\nwhile v.read()[0]: pass\n"
    pairs = []
    for _ in range(size.scaled(5, 1)):
        pairs.append([children([program, "--setup", setup, "--out", "/dev/null", path]), children([sys.executable, "-c", alone, path])])
    start = children([sys.executable, "-c", "import cv2"])
    for name in (path, setup):
        name.unlink()
    return [ours for ours, _ in pairs], [max(peer - start, 1e-3) for _, peer in pairs]


def children(command):
    """Processor seconds of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(c) for c in command], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def accuracy(ours, taken):
    """Worst distance from the truth of both sides in the last picture [px]."""
    picture, truth = taken[-1]
    return [float(numpy.nanmax(numpy.abs(c - truth.center_px))) for c in (ours, threshold(picture))]


def bench(size):
    """Four comparisons."""
    cv2.setNumThreads(1)
    film, empty, taken = pictures_of(size)
    taken = [(picture.copy(), truth) for picture, truth in taken]
    pictures, nothing = [picture for picture, _ in taken], [empty] * len(taken)
    ours, lost = Ours(pictures), Ours(nothing)
    for image in ours.images:
        ours.see(image)
    off = accuracy(ours.centers(), taken)
    ours.images.reverse()
    lost.state[0] = ours.state[0]  # markers were there, and are gone
    lost.t_s = ours.t_s
    detector = cv2.SimpleBlobDetector_create()
    n = len(pictures)
    per = {name: [s / n for s in seconds] for name, seconds in alternate(
        size.scaled(9, 1), tracked=ours.see_all, lost=lost.see_all, threshold=lambda: [threshold(p) for p in pictures],
        empty=lambda: [threshold(p) for p in nothing], blobs=lambda: [detector.detect(p) for p in pictures[:3]]).items()}  # fmt: skip
    per["blobs"] = [s * n / min(n, 3) for s in per["blobs"]]
    whole = decoder(size, film, empty)
    peer = "cvtColor, inRange and moments over the picture, four colours"
    return Outcome(
        [Comparison("markers tracked, 1080p", "tl_marker_track", peer, per["tracked"], per["threshold"], 30.0),
         Comparison("all markers lost, 1080p", "tl_marker_track searches the whole picture", peer, per["lost"], per["empty"], 1.0),
         Comparison("markers tracked, 1080p, blobs", "tl_marker_track", "SimpleBlobDetector", per["tracked"], per["blobs"]),
         Comparison("a film in H.264, 1080p", "talus-track, decoding included", "OpenCV's decoder alone", *whole, None,
                    "above 0.5: following takes less than decoding")],
        [f"centres off by {off[0]:.3f} px, thresholds and moments by {off[1]:.3f} px"],
        {"marker_error_px": off},
    )  # fmt: skip
