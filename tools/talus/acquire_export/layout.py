"""What a DBC says, for whole columns of frames at once: cantools reads the file, NumPy decodes.

    database = Database.read("leg.dbc")
    for message in database.messages.values():
        message.decode("Current", data)   # as cantools' own decode, for every row of data (n, bytes)

Attributes of the DBC that count here: `Channel` of a signal names its column of the recording, `SampleTick` of a
message says that its counter numbers the ticks of an even clock at which its payload was measured, and
`GenMsgCycleTime` is the time between two frames in milliseconds.
"""

import logging
from pathlib import Path

import numpy as np
from talus.refused import Refused

from . import bounds
from .record import EXTENDED
from .slim_cantools import cantools

COUNTER = "Counter"
EXACT = 2**53  # larger whole numbers have no exact double
COUNTER_BITS = 48  # of a longer counter these are looked at: no record has so many frames


class Field:
    """One signal: which bits of which bytes, and what they are worth."""

    def __init__(self, signal):
        self.name, self.bits, self.signed = signal.name, signal.length, signal.is_signed
        self.float = signal.conversion.is_float
        self.scale, self.offset = factors(signal.conversion)
        self.is_exact = isinstance(self.scale, int) and (self.scale, self.offset) != (1, 0) and not self.float
        self.reach = abs(self.scale) * 2**self.bits + abs(self.offset)  # no value is larger
        self.unit = signal.unit or ""
        self.channel = attribute(signal, "Channel", "")
        self.multiplexer = signal.multiplexer_signal  # name of the signal that says whether it is there; None: it always is
        self.selected_by = np.array(signal.multiplexer_ids or [], np.int64)
        self.pieces = list(little_endian(signal) if signal.byte_order == "little_endian" else big_endian(signal))
        self.bytes = 1 + max(piece[0] for piece in self.pieces)  # that a frame must have for it

    def raw(self, data):
        """The whole numbers that lie in the frames; bits of a floating-point number as such."""
        value = np.zeros(len(data), np.uint64)
        for byte, low, bits, place in self.pieces:
            piece = data[:, byte].astype(np.uint64) >> np.uint64(low) & np.uint64((1 << bits) - 1)
            value |= piece << np.uint64(place)
        if not self.signed or self.float:
            return value
        shift = np.uint64(64 - self.bits)
        return (value << shift).view(np.int64) >> np.int64(shift)

    def physical(self, data):
        raw = self.raw(data)
        if self.float:
            return self.physical_of_float(raw.astype(f"u{self.bits // 8}").view(f"f{self.bits // 8}"))
        if self.scale == 1 and self.offset == 0:
            return raw.astype(float)
        if self.is_exact and self.reach > EXACT:  # the product is rounded once, also where the offset is broken
            return np.array([float(value * self.scale + self.offset) for value in raw.tolist()], float)
        return raw.astype(float) * self.scale + self.offset

    @np.errstate(invalid="ignore", over="ignore")  # a frame may hold a signalling NaN, or what the scale makes infinite
    def physical_of_float(self, value):
        return value.astype(float) * float(self.scale) + float(self.offset)


def factors(conversion):
    """Scale and offset; where both are whole they count as such, however the DBC writes them."""
    both = conversion.scale, conversion.offset
    is_whole = not conversion.is_float and all(float(number).is_integer() for number in both)
    return tuple(int(number) for number in both) if is_whole else both


def little_endian(signal):
    """(byte, its lowest bit, bits, their place in the value)."""
    bit, place = signal.start, 0
    while place < signal.length:
        bits = min(8 - bit % 8, signal.length - place)
        yield bit // 8, bit % 8, bits, place
        bit, place = bit + bits, place + bits


def big_endian(signal):
    """The same for Motorola's order, where `start` is the highest bit and bytes follow downwards."""
    byte, high, left = signal.start // 8, signal.start % 8, signal.length
    while left:
        bits = min(high + 1, left)
        left -= bits
        yield byte, high + 1 - bits, bits, left
        byte, high = byte + 1, 7


def attribute(item, name, default):
    found = item.dbc.attributes.get(name) if item.dbc and item.dbc.attributes else None
    return found.value if found else default


class Message:
    def __init__(self, message):
        self.name, self.length = message.name, message.length
        self.key = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
        self.sender = (message.senders or [""])[0]
        self.cycle_s = (message.cycle_time or 0) / 1000
        self.sample_tick = bool(attribute(message, "SampleTick", 0))
        self.fields = {signal.name: Field(signal) for signal in message.signals}
        counter = self.fields.get(COUNTER)
        self.counter = counter if counter and not (counter.float or counter.multiplexer) else None
        self.counter_bits = min(self.counter.bits, COUNTER_BITS) if self.counter else 0
        if self.sample_tick and not (self.counter and self.cycle_s):
            raise Refused(2, f"{self.name}: SampleTick needs a signal {COUNTER} and GenMsgCycleTime")

    def decode(self, name, data):
        return self.fields[name].physical(data)

    def holds(self, name, data):
        """In which frames a signal is: of a multiplexed one, its multiplexer has one of its values and is there itself."""
        field, there = self.fields[name], np.ones(len(data), bool)
        while field.multiplexer is not None:
            selector = self.fields[field.multiplexer]
            there &= np.isin(selector.raw(data).astype(np.int64), field.selected_by)
            field = selector
        return there


class Database:
    def __init__(self, messages):
        self.messages = {message.key: message for message in messages}

    @classmethod
    def read(cls, path):
        """Refused with status 2 when it does not parse or is not there."""
        logging.getLogger("cantools").setLevel(logging.CRITICAL)  # what is wrong is said here, in one line
        try:
            text = Path(path).read_text(encoding="cp1252", errors="replace")
            bounds.check(text)
            database = cantools.database.load_string(text, database_format="dbc")
            return cls([Message(message) for message in database.messages])
        except Refused as error:
            raise Refused(2, f"{path}: {error.text}") from error
        except OSError as error:
            raise Refused(2, f"{path}: cannot be read: {error.strerror}") from error
        except Exception as error:  # cantools has no one class for what it does not like
            words = " ".join(str(error).split())
            raise Refused(2, f"{path}: does not parse as a DBC: {words[:200]}") from error

    def by_name(self, name):
        return next((message for message in self.messages.values() if message.name == name), None)
