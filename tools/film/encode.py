"""Videos with true times: each picture has its own, as a camera that drops and jitters writes them."""

from fractions import Fraction

import av

TICKS_HZ = 90_000
CODECS = {
    "raw": ("rawvideo", "bgr24", {}),
    "h264": ("libx264", "yuv420p", {"crf": "18", "preset": "veryfast", "bf": "0"}),
    "mjpeg": ("mjpeg", "yuvj420p", {"qmin": "2", "qmax": "3"}),
}


class Video:
    """Writes pictures (height, width, 3; blue, green, red) with their times into an .mov or .mp4 file."""

    def __init__(self, path, width, height, codec="h264", rate_hz=120):
        name, pixels, options = CODECS[codec]
        self.container = av.open(str(path), "w", options={"video_track_timescale": str(TICKS_HZ)})
        self.stream = self.container.add_stream(name, rate=rate_hz, options=options)
        self.stream.width, self.stream.height, self.stream.pix_fmt = width, height, pixels
        self.stream.codec_context.time_base = self.stream.time_base = Fraction(1, TICKS_HZ)
        self.stream.codec_context.thread_count = 1

    def add(self, picture, t_s):
        """One picture; times rise."""
        frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
        frame.pts, frame.time_base = round(t_s * TICKS_HZ), Fraction(1, TICKS_HZ)
        self.container.mux(self.stream.encode(frame))

    def close(self):
        """Ends the file."""
        self.container.mux(self.stream.encode())
        self.container.close()
