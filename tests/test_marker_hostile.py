"""Pictures of any size and content: the tracker stays within their bytes, and always answers."""

import ctypes
import mmap

import numpy as np
import pytest
from marker_eye import RUNS, Eye
from talus import ffi, lib

PAGE = mmap.PAGESIZE
MIB = 1 << 20


@pytest.fixture(scope="module")
def fenced():
    """A MiB of memory with pages before and behind that nobody may touch."""
    libc = ctypes.CDLL(None, use_errno=True)
    area = mmap.mmap(-1, MIB + 2 * PAGE)
    base = ctypes.addressof(ctypes.c_char.from_buffer(area))
    for fence in (base, base + PAGE + MIB):
        assert libc.mprotect(ctypes.c_void_p(fence), ctypes.c_size_t(PAGE), 0) == 0
    yield base + PAGE
    for fence in (base, base + PAGE + MIB):
        libc.mprotect(ctypes.c_void_p(fence), ctypes.c_size_t(PAGE), 3)


def content(random, size):
    """Noise, one colour, or coloured stripes."""
    kind = random.integers(4)
    if kind == 0:
        return random.integers(0, 256, size, dtype=np.uint8)
    if kind == 1:
        return np.resize(np.array((45, 40, 205), np.uint8), size)
    if kind == 2:
        return np.full(size, random.integers(256), np.uint8)
    return np.repeat(random.integers(0, 256, size // 7 + 1, dtype=np.uint8), 7)[:size]


def put(fenced, random, at_end):
    """An image that ends (or begins) where the fence does."""
    channels, width, height = int(random.integers(3, 5)), int(random.integers(1, 200)), int(random.integers(1, 200))
    stride = width * channels + int(random.integers(0, 9))
    size = stride * (height - 1) + width * channels
    start = fenced + (MIB - size if at_end else 0)
    ctypes.memmove(start, content(random, size).tobytes(), size)
    return {"pixel": ffi.cast("uint8_t *", start), "size": size, "stride": stride, "width": width, "height": height,
            "channels": channels}  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_any_picture(fenced, seed):
    random = np.random.default_rng(seed)
    for _ in range(60):
        eye = Eye(radius_px=float(random.uniform(1.5, 40)), start_px=random.uniform(-1e5, 1e5, (4, 2)))
        runs = int(random.choice((0, 1, 7, RUNS)))
        for i in range(6):
            image = ffi.new("tl_image *", put(fenced, random, i % 2))
            assert lib.tl_marker_track(eye.setup, eye.classes, eye.state, image, float(i), eye.sample, eye.run, runs) == 0
            for sample in eye.sample[0:4]:
                numbers = (sample.x_px, sample.y_px, *sample.cov_px2, sample.area_px2)
                assert np.all(np.isfinite(numbers))
                if sample.flags & 1:
                    assert -2 < sample.x_px < image.width + 1 and -2 < sample.y_px < image.height + 1


def lies_within(size, stride, width, height, channels):
    """Whether such an image needs no byte beyond its own; in whole numbers that do not overflow."""
    return (1 <= width <= 32767 and 1 <= height <= 32767 and channels in (3, 4) and width * channels <= stride
            and stride * (height - 1) + width * channels <= size)  # fmt: skip


def hostile(random):
    """(size, an image's numbers), which need fit neither each other nor the bytes: any at all, or a byte too few or too many."""
    channels = int(random.choice((0, 3, 3, 3, 4, 4, 5)))
    if random.uniform() < 0.5:
        width, height = map(int, random.integers(1, 50, 2))
        stride = width * channels + int(random.choice((-1, 0, 1, 7)))
        size = stride * (height - 1) + width * channels + int(random.choice((-1, 0, 0, 1)))
        return max(size, 0), {"stride": stride % 2**64, "width": width, "height": height, "channels": channels}
    width, height = (int(random.choice((-1, 0, 1, 2, 59, 32767, 32768, 2**31 - 1))) for _ in "wh")
    size = int(random.choice((0, 1, 3, random.integers(0, 9000))))
    stride = (0, 1, 3, size, 2**32, 2**62, 2**63, 2**64 - 1, 2**64 // max(height, 1) % 2**64)[random.integers(9)]
    return size, {"stride": stride, "width": width, "height": height, "channels": channels}


@pytest.mark.parametrize("seed", range(4))
def test_any_size_and_stride(fenced, seed):
    """Buffers from no byte to some thousands, right before the fence: what does not fit them is refused, to the byte."""
    random, taken, blob = np.random.default_rng(seed), 0, ffi.new("tl_marker_blob[8]")
    eye = Eye(radius_px=9)
    for _ in range(1500):
        size, given = hostile(random)
        start = fenced + MIB - size
        ctypes.memmove(start, content(random, size).tobytes(), size)
        image = ffi.new("tl_image *", {"pixel": ffi.cast("uint8_t *", start), "size": size, **given})
        for m in range(4):
            eye.setup.start_px[m] = tuple(random.uniform(-50, 100, 2))
        assert lib.tl_marker_start(eye.setup, eye.state) == lib.TL_OK
        fits = lies_within(size, **given)
        answer = lib.tl_marker_track(eye.setup, eye.classes, eye.state, image, 0.0, eye.sample, eye.run, RUNS)
        assert answer == (lib.TL_OK if fits else lib.TL_ERR_ARGUMENT), (size, given)
        found = lib.tl_marker_find(eye.classes, image, int(random.integers(-1, 80)), blob, int(random.integers(1, 9)), eye.run, RUNS)
        assert 0 <= found <= 8 and (fits or found == 0)
        taken += fits
    assert 100 < taken < 1400


@pytest.mark.parametrize("change", [{"size": 29}, {"size": 0}, {"stride": 8}, {"width": 0}, {"height": -1}, {"width": 40000},
                                    {"channels": 1}, {"channels": 5}, {"pixel": ffi.NULL}, {"stride": 2**63}])  # fmt: skip
def test_an_image_beyond_its_bytes_is_refused(change):
    memory = ffi.new("uint8_t[30]")
    sound = {"pixel": memory, "size": 30, "stride": 15, "width": 5, "height": 2, "channels": 3}
    eye, blob = Eye(), ffi.new("tl_marker_blob[2]")
    for image, expected in ((sound, lib.TL_OK), ({**sound, **change}, lib.TL_ERR_ARGUMENT)):
        image = ffi.new("tl_image *", image)
        answer = lib.tl_marker_track(eye.setup, eye.classes, eye.state, image, 0.0, eye.sample, eye.run, RUNS)
        assert answer == expected
    assert lib.tl_marker_find(eye.classes, image, 1, blob, 2, eye.run, RUNS) == 0


@pytest.mark.parametrize("field, value, expected", [("markers", 5, "ARGUMENT"), ("markers", 0, "ARGUMENT"), ("colors", 9, "ARGUMENT"),
                                                    ("links", 3, "ARGUMENT")])  # fmt: skip
def test_an_impossible_setup_is_refused(field, value, expected):
    eye = Eye()
    setattr(eye.setup, field, value)
    assert lib.tl_marker_start(eye.setup, eye.state) == getattr(lib, f"TL_ERR_{expected}")


def test_impossible_colours_sizes_and_times_are_refused():
    eye = Eye()
    for color in ((400, 10, 0.5, 0.5), (10, 90, 0.5, 0.5), (10, 10, 0, 0.5), (10, 10, 0.5, float("nan"))):
        assert lib.tl_marker_classes_init(eye.classes, ffi.new("tl_marker_color[1]", [color]), 1) == lib.TL_ERR_RANGE
    eye.setup.radius_px[2] = float("nan")
    assert lib.tl_marker_start(eye.setup, eye.state) == lib.TL_ERR_RANGE
    picture = ffi.new("uint8_t[3]", [0, 0, 0])
    image = ffi.new("tl_image *", {"pixel": picture, "size": 3, "stride": 3, "width": 1, "height": 1, "channels": 3})
    eye = Eye()
    answer = lib.tl_marker_track(eye.setup, eye.classes, eye.state, image, float("nan"), eye.sample, eye.run, RUNS)
    assert answer == lib.TL_ERR_RANGE
