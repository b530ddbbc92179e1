"""DBCs drawn by a seed: signals anywhere in frames of every length, of either byte order, of every width, sign, scale and kind of number,
multiplexed and not.

    text, drawn = random_dbc(seed)       # drawn: [Drawn(message, name, width, motorola, kind)], kind is '+', '-' or 'f'
"""

import random
from dataclasses import dataclass

LENGTHS = (1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)  # of frames, classic and FD
SCALES = ("1", "1", "2", "-3", "1000000007", "2.0", "3.0", "1E3", "0.5", "1e-3", "0.1", "-0.0078125", "1.0000000000000002")
OFFSETS = ("0", "0", "-40", "7", "7.0", "0.25", "-0.1", "-100000000000", "12345678901234567", "1e-9", "1e20")
GROUPS = 4  # values of a multiplexer that select something
TRIES = 40  # places that are tried for signals of one message, or of one group in it
WHOLE = [(width, motorola, sign) for width in range(1, 65) for motorola in (False, True) for sign in "+-"]
TURN = 20  # seeds that follow each other have each kind of whole number


@dataclass(frozen=True)
class Drawn:
    message: str
    name: str
    width: int
    motorola: bool
    kind: str


def bits_of(start, width, motorola):
    """The numbers of a signal's bits as DBCs count them, eight to a byte from its lowest on: Intel's rise from its lowest bit, Motorola's
    fall within a byte from its highest and go on at the top of the next."""
    out = [start]
    while len(out) < width:
        last = out[-1]
        out.append(last + 1 if not motorola else last - 1 if last % 8 else last + 15)
    return out


class Maker:
    """The text of one message as it grows."""

    def __init__(self, generator, number, length):
        self.generator, self.number, self.length = generator, number, length
        self.name = f"Message{number}"
        self.lines, self.behind, self.drawn = [f"BO_ {number} {self.name}: {length} Node"], [], []

    def add(self, taken, what, mark="", is_plain=False):
        """A signal (width, is it Motorola's, kind) somewhere; is there room for it?"""
        (width, motorola, kind), pick = what, self.generator.choice
        start = self.generator.randrange(8 * self.length)
        bits = set(bits_of(start, width, motorola))
        if max(bits) >= 8 * self.length or bits & taken:
            return False
        taken |= bits
        name, scale, offset = f"S{len(self.drawn)}", *(("1", "0") if is_plain else (pick(SCALES), pick(OFFSETS)))
        order = f"{0 if motorola else 1}{'-' if kind == 'f' else kind}"
        self.lines.append(f' SG_ {name} {mark}: {start}|{width}@{order} ({scale},{offset}) [0|0] "" Node')
        if kind == "f":
            self.behind.append(f"SIG_VALTYPE_ {self.number} {name} : {1 if width == 32 else 2};")
        elif not is_plain and self.generator.random() < 0.1:
            self.behind.append(f'VAL_ {self.number} {name} 0 "off" 1 "on" ;')
        self.drawn.append(Drawn(self.name, name, width, motorola, kind))
        return True

    def any_signal(self):
        pick = self.generator.choice
        kind = pick("+-+-+-f")
        return pick((32, 64)) if kind == "f" else pick(range(1, 65)), pick((False, True)), kind

    def fill(self, taken, mark=""):
        for _ in range(TRIES):
            self.add(taken, self.any_signal(), mark)

    def hold(self, signals):
        """Each of these, the widest first, while there is room."""
        taken = set()
        for what in sorted(signals, reverse=True):
            while not self.add(taken, what):
                pass

    def multiplex(self, taken):
        """A multiplexer and what it selects, each value's signals on the same bits."""
        while not self.add(taken, (self.generator.choice((2, 3)), self.generator.random() < 0.5, "+"), "M ", is_plain=True):
            pass
        for _ in range(2):
            self.add(taken, self.any_signal())  # is always there
        for value in range(GROUPS):
            self.fill(set(taken), f"m{value} ")


def random_dbc(seed):
    generator = random.Random(seed)
    makers = [Maker(generator, 100 + k, generator.choice(LENGTHS)) for k in range(4)]
    for maker in makers:
        maker.fill(set())
    for number, first in ((110, seed % TURN), (111, seed % TURN + TURN)):
        makers.append(Maker(generator, number, 64))
        makers[-1].hold(WHOLE[first::2 * TURN])
    for number, length in ((120, 8), (121, generator.choice(LENGTHS[-7:]))):
        makers.append(Maker(generator, number, length))
        makers[-1].multiplex(set())
    lines = [line for maker in makers for line in maker.lines] + nested(generator)
    text = "\n".join(['VERSION ""', "BU_: Node", *lines, *(line for maker in makers for line in maker.behind)]) + "\n"
    return text, [one for maker in makers for one in maker.drawn]


def nested(generator):
    """A multiplexer within another, and signals that several of its values select; the ranges stand behind all messages."""
    scale, offset = generator.choice(SCALES), generator.choice(OFFSETS)
    return ["BO_ 300 Nested: 8 Node", ' SG_ Outer M : 0|2@1+ (1,0) [0|0] "" Node', ' SG_ Inner m1M : 2|2@1+ (1,0) [0|0] "" Node',
            f' SG_ Deep m2 : 8|16@0- ({scale},{offset}) [0|0] "" Node', f' SG_ Flat m0 : 30|20@1- ({scale},{offset}) [0|0] "" Node',
            "SG_MUL_VAL_ 300 Inner Outer 1-1;", f"SG_MUL_VAL_ 300 Deep Inner {generator.choice(('2-3', '0-1', '0-0,3-3'))};",
            f"SG_MUL_VAL_ 300 Flat Outer {generator.choice(('0-0,2-3', '2-2', '3-3'))};"]  # fmt: skip
