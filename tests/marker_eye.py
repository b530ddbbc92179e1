"""The library's tracker on NumPy pictures, for the tests of markers."""

import numpy as np
from talus import check, ffi, lib

HUES = (358, 134, 225, 52)  # the film's red, green, blue and yellow
SEEN, PARTIAL, SATURATED, MERGED, EDGE, REACQUIRED = 1, 2, 4, 8, 16, 32
RUNS = 4096


def image_of(picture):
    """A tl_image of rows by columns by channels; rows may be part of longer ones."""
    height, width, channels = picture.shape
    size = picture.strides[0] * (height - 1) + width * channels
    return ffi.new("tl_image *", {"pixel": ffi.cast("uint8_t *", picture.ctypes.data), "size": size,
                                  "stride": picture.strides[0], "width": width, "height": height,
                                  "channels": channels})  # fmt: skip


class Eye:
    """One tracker: `see` takes a picture and answers flags (markers) and centres (markers, 2)."""

    def __init__(self, hues=HUES, radius_px=14, color_of=None, start_px=None, links=((0, 1), (2, 3))):
        self.setup = ffi.new("tl_marker_setup *", {"colors": len(hues), "links": len(links)})
        self.markers = self.setup.markers = len(color_of or hues)
        for c, hue in enumerate(hues):
            self.setup.color[c] = (hue, 18, 0.45, 0.2)
        for m in range(self.markers):
            self.setup.color_of[m], self.setup.radius_px[m] = (color_of or range(4))[m], radius_px
            self.setup.start_px[m] = (0, 0) if start_px is None else tuple(map(float, start_px[m]))
        for k, link in enumerate(links):
            self.setup.link[k] = link
        self.classes, self.state = ffi.new("tl_marker_classes *"), ffi.new("tl_marker_state *")
        self.run, self.sample = ffi.new("tl_marker_run[]", RUNS), ffi.new("tl_marker_sample[4]")
        check(lib.tl_marker_classes_init(self.classes, self.setup.color, len(hues)))
        check(lib.tl_marker_start(self.setup, self.state))

    def see(self, picture, t_s):
        image = image_of(picture)
        check(lib.tl_marker_track(self.setup, self.classes, self.state, image, t_s, self.sample, self.run, RUNS))
        samples = self.sample[0 : self.markers]
        return np.array([s.flags for s in samples]), np.array([(s.x_px, s.y_px) for s in samples])

    def sigma(self):
        """Standard deviations of the last centres (markers, 2)."""
        return np.sqrt([(s.cov_px2[0], s.cov_px2[2]) for s in self.sample[0 : self.markers]])
