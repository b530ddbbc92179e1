"""Normal equations of base columns, candidate columns and reading, fold by fold: each fit and each error on held-out
blocks is then small algebra.

Columns are kept thinned to what the low-pass leaves, in single precision; products that a fit asks for are made when
it does. The order of the unknowns is: base parameters, one constant for each kind of angle, the candidates' columns.
"""

import copy
import gc

import numpy as np

from . import processors
from .calibration.thresholds import PART
from .catalogue.law import Column, batches, shows
from .dataset import PRIOR_WIDTH_OF_ONE_JOINT

RIDGE = 1e-10  # of unit columns: keeps what cannot be told apart solvable, far below any noise
TINY = 1e-12
LARGEST = 1e9  # Nm or rad for a unit of a strength: a link that is stepped too coarsely has run away
REWEIGHINGS = 3
FITTED_AT_ONCE = 128
FEWEST_DRAWN = 2  # values of inertia and gravity that tell a drawing
CHUNK = 64  # columns multiplied together


class Layout:
    """Where the rows of one kind of channel stand: fold after fold, block after block."""

    def __init__(self, dataset, kind):
        self.kind = kind
        self.channels = [c for c in dataset.channels if c.kind == kind]
        block = np.concatenate([dataset.block_of[c.record][c.thinned] for c in self.channels])
        order = np.lexsort((np.arange(len(block)), block, dataset.folds[block]))
        self.block = block[order]
        place = np.empty(len(order), int)
        place[order] = np.arange(len(order))
        begins = np.cumsum([0] + [len(c.thinned) for c in self.channels])
        self.place = {c.record: place[a:b] for c, a, b in zip(self.channels, begins, begins[1:])}
        self.channel = {c.record: c for c in self.channels}
        self.rows = len(order)
        self.weight = np.sqrt(dataset.thin) / dataset.sigma[kind]
        fold = dataset.folds[self.block]
        self.slices = [slice(*np.searchsorted(fold, [f, f + 1])) for f in range(dataset.fold_count)]

    def on_rows(self, values):
        """What each recording has at every grid instant, at the rows."""
        out = np.empty(self.rows, np.asarray(values[0]).dtype)
        for record, place in self.place.items():
            out[place] = values[record][self.channel[record].thinned]
        return out

    def put(self, row, record, values):
        """One column's values of one recording, thinned and weighted, to their places in `row`."""
        row[self.place[record]] = values * self.weight

    def put_all(self, rows, places, record, values, seen):
        """The same for some columns' values on the whole grid, `seen` of them, into rows of these numbers."""
        thinned, to = self.channel[record].thinned, self.place[record]
        for place, k in zip(places, seen):
            one = values[k, thinned]
            if np.abs(one).max(initial=0.0) < LARGEST:
                rows[place, to] = one * self.weight


class Gram:
    """Products of base columns, candidate columns and reading."""

    def __init__(self, dataset, all_terms, candidates):
        self.dataset, self.all_terms, self.folds = dataset, all_terms, dataset.fold_count
        self.first = dataset.bases + len(dataset.angle_kinds)
        self.prior_width = self.prior_spread = dataset.prior_width  # in chi-square's unit; for the variance of what it pulls
        self.drawn = False  # is the model file taken for a drawing?
        self.columns = list(dict.fromkeys(c for candidate in candidates for c in candidate.columns))
        self.place = {column: k for k, column in enumerate(self.columns)}
        shown = {c.kind for c in dataset.channels}  # a planned recording may lack a sensor that another one had
        self.layouts = [Layout(dataset, kind) for kind in dataset.kinds if kind in shown]
        self.plain = [self._plain_rows(layout) for layout in self.layouts]
        self.rows = [np.zeros((0, 0), np.float32)] * len(self.layouts)
        self.owner = [np.zeros(0, int)] * len(self.layouts)  # the column of each row kept
        self._made = {}  # rows of columns beyond these, by column
        if self.columns:
            self._fill()
        self._prepare(candidates)

    # ---- rows ----------------------------------------------------------------------

    def _plain_rows(self, layout):
        """Base columns and, last, the reading: (first + 1, rows)."""
        out = np.zeros((self.first + 1, layout.rows))
        for record, channel in layout.channel.items():
            base = self.dataset.base_columns(channel, channel.thinned)
            for k in range(self.first):
                layout.put(out[k], record, base[:, k])
            layout.put(out[-1], record, channel.values[channel.thinned])
        return out

    def _fill(self):
        rows = [np.zeros((len(self.columns), layout.rows), np.float32) for layout in self.layouts]
        seen = [np.zeros(len(self.columns), bool) for _ in self.layouts]
        processors.each(lambda part: self._put(*part, rows, seen), self._parts())
        self.owner = [np.flatnonzero(one) for one in seen]
        self.rows = [packed(every, owner) for every, owner in zip(rows, self.owner)]

    def _parts(self):
        """(record, columns) that can be made at the same time, what takes longest first: those of a recording's instants stay together,
        whose time some of them count otherwise."""
        long, short = {}, []
        for column in self.columns:
            if isinstance(column, Column) and not column.is_of_the_instant:
                long.setdefault((column.effect, column.joints), []).append(column)
            else:
                short.append(column)
        return [(record, columns) for columns in (*long.values(), short) for record in range(len(self.all_terms))]

    def _put(self, record, columns, rows, seen):
        """Makes some columns of one recording and puts them into their rows."""
        for some, shown in every_batch(self.all_terms[record], columns):
            for layout, into, own in zip(self.layouts, rows, seen):
                if layout.kind not in shown or record not in layout.channel:
                    continue
                values = shown[layout.kind]
                there = [k for k in range(len(some)) if shows(values[k])]
                places = [self.place[some[k]] for k in there]
                own[places] = True
                layout.put_all(into, places, record, values, there)

    def _prepare(self, candidates):
        self.plain_grams = [self.among([one], [layout]) for one, layout in zip(self.plain, self.layouts)]
        scale = np.sqrt(np.einsum("fii->i", sum(self.plain_grams)))
        self.base = [k for k in range(self.first) if scale[k] > 0]
        self.beside_plain = self.beside(self.plain)
        self.column_squares = {layout.kind: np.zeros(len(self.columns)) for layout in self.layouts}
        self.fold_squares = np.zeros((self.folds, len(self.columns)))
        for layout, owner, rows in zip(self.layouts, self.owner, self.rows):
            each = np.array([np.einsum("ij,ij->i", rows[:, part], rows[:, part], dtype=float) for part in layout.slices])
            self.column_squares[layout.kind][owner] = each.sum(0)
            self.fold_squares[:, owner] += each
        norms = sum(self.column_squares.values())
        usable = np.isfinite(norms) & (norms > TINY**2)
        self.candidates = [c for c in candidates if usable[self.of(c)].all()]
        self._own = {}

    def own(self, group):
        """Products (candidates, folds, k, k) of the columns of each of some candidates that have equally many, among themselves."""
        if len(group[0].columns) == 1:
            return np.moveaxis(self.fold_squares[:, [self.of(c) for c in group]], 0, 1)[..., None]
        new, together = [c for c in group if c not in self._own], max(1, CHUNK // len(group[0].columns))
        for begin in range(0, len(new), together):
            some = new[begin:begin + together]
            self._own.update(zip(some, self._own_products(np.array([self.of(c) for c in some]))))
        return np.array([self._own[c] for c in group])

    def _own_products(self, numbers):
        """The same of columns with these numbers, (candidates, k)."""
        out = np.zeros((len(numbers), self.folds, *2 * numbers.shape[1:]))
        for layout, owner, rows in zip(self.layouts, self.owner, self.rows):
            row_of = np.full(len(self.columns), -1)
            row_of[owner] = np.arange(len(owner))
            seen = np.flatnonzero(row_of[numbers].max(1) >= 0)
            many = rows[row_of[numbers[seen]]].astype(float)
            many[row_of[numbers[seen]] < 0] = 0.0  # a column that does not show there
            for f, part in enumerate(layout.slices):
                out[seen, f] += many[..., part] @ np.swapaxes(many[..., part], -1, -2)
        return out

    def of(self, candidate):
        """Numbers of the columns of a candidate that the search began with."""
        return [self.place[column] for column in candidate.columns]

    def gathered(self, columns):
        """Rows of some columns, whichever, one matrix (columns, rows) a layout; zeros where a column does not show."""
        out = [np.zeros((len(columns), layout.rows)) for layout in self.layouts]
        for k, column in enumerate(columns):
            for part, rows in zip(out, self._rows_of(column)):
                part[k] = rows
        return out

    def _rows_of(self, column):
        """Rows of one column, a vector (or 0) a layout."""
        number = self.place.get(column)
        if number is None:
            if column not in self._made:
                self._made[column] = self._make(column)
            return self._made[column]
        where = [np.flatnonzero(owner == number) for owner in self.owner]
        return [rows[w[0]] if len(w) else 0.0 for rows, w in zip(self.rows, where)]

    def _make(self, column):
        """Rows of a column; of one that runs away, as a body of absurd size does, zeros: it explains nothing."""
        shown = column.along(self.all_terms) if isinstance(column, Column) else [column(terms) for terms in self.all_terms]
        out = [np.zeros(layout.rows, np.float32) for layout in self.layouts]
        for layout, rows in zip(self.layouts, out):
            for record, channel in layout.channel.items():
                if layout.kind in shown[record]:
                    layout.put(rows, record, shown[record][layout.kind][channel.thinned])
        return out if all(np.isfinite(rows).all() for rows in out) else [np.zeros_like(rows) for rows in out]

    def make(self, columns):
        """Makes rows of columns that will be asked for, at the same time; those of the instant one by one when they are."""
        new = [c for c in dict.fromkeys(columns) if c not in self.place and c not in self._made and isinstance(c, Column) and not c.is_of_the_instant]
        self._made.update(zip(new, processors.each(self._make, new)))

    def forget(self, kept):
        """Leaves of the columns made since the begin only those of the candidates `kept`."""
        wanted = {column for candidate in kept for column in candidate.columns}
        self._made = {column: rows for column, rows in self._made.items() if column in wanted}

    def keep(self, chosen):
        """Gives up the rows of all columns but those of the candidates `chosen`, where no more is searched."""
        self._made = {c: [np.array(rows) for rows in self._rows_of(c)] for one in chosen for c in one.columns}
        self.columns, self.place, self.candidates = [], {}, []
        self.rows, self.owner = ([np.zeros(shape, kind)] * len(self.layouts) for shape, kind in (((0, 0), np.float32), (0, int)))

    def release(self):
        """Gives up rows and torque terms, in a process that was forked from the search's and makes its own."""
        self.keep([])
        self.plain = []
        self.all_terms.clear()
        gc.freeze()  # what stays is never garbage: to look through it would copy the pages shared with the other process

    def among(self, matrices, layouts=None):
        """Gram matrices (folds, k, k) of rows, one matrix a layout."""
        return self._between(matrices, matrices, layouts)

    def _between(self, matrices, others, layouts=None):
        """Products (folds, k, m) of rows with others."""
        out = np.zeros((self.folds, len(matrices[0]), len(others[0])))
        for layout, rows, beside in zip(layouts or self.layouts, matrices, others, strict=True):
            for f, part in enumerate(layout.slices):
                out[f] += rows[:, part] @ beside[:, part].T
        return out

    def beside(self, matrices):
        """Products (folds, k, columns) of rows with every candidate's columns."""
        out = np.zeros((self.folds, len(matrices[0]), len(self.columns)))
        for layout, own, owner, rows in zip(self.layouts, matrices, self.owner, self.rows):
            for begin in range(0, len(owner), CHUNK):
                chunk = slice(begin, begin + CHUNK)
                many = rows[chunk].astype(float)
                for f, part in enumerate(layout.slices):
                    out[f][:, owner[chunk]] += own[:, part] @ many[:, part].T
        return out

    # ---- fits ----------------------------------------------------------------------

    def scan(self, chosen, candidates):
        """Fits of each candidate beside the columns `chosen`: (chi-square on held-out folds, strengths of the fit to everything) for
        each, those of `chosen` and then the candidate's."""
        rows = self.gathered(chosen)
        fixed = self.bordered(rows)
        beside = np.concatenate([self.beside_plain, self.beside(rows)], axis=1)
        order = [*self.base, *range(self.first + 1, self.first + 1 + len(chosen))]
        out = {}
        for count, group in groups(candidates):
            gram = np.zeros((len(group), self.folds, len(order) + count + 1, len(order) + count + 1))
            places = np.array([self.of(c) for c in group])
            old, new = np.arange(len(order)), np.arange(len(order), len(order) + count)
            gram[..., old[:, None], old] = fixed[:, order][:, :, order]
            gram[..., old, -1] = gram[..., -1, old] = fixed[:, order, self.first]
            gram[..., -1, -1] = fixed[:, self.first, self.first]
            gram[..., old[:, None], new] = np.moveaxis(beside[:, order][:, :, places], 2, 0)
            gram[..., new[:, None], old] = np.swapaxes(gram[..., old[:, None], new], -1, -2)
            gram[..., new, -1] = gram[..., -1, new] = np.moveaxis(beside[:, self.first][:, places], 1, 0)
            gram[..., new[:, None], new] = self.own(group)
            chi2, strengths = self._held_out(gram)
            out.update({c: (x, s[len(self.base):]) for c, x, s in zip(group, chi2, strengths)})
        return [out[c] for c in candidates]

    def bordered(self, rows, weights=None):
        """Gram matrices of plain columns, reading, and `rows` after them."""
        weights = np.ones(len(self.plain)) if weights is None else weights
        own = [w * w * one for w, one in zip(weights, rows, strict=True)]
        plain, beside = sum(w * w * one for w, one in zip(weights, self.plain_grams, strict=True)), self._between(self.plain, own)
        return np.block([[plain, beside], [np.swapaxes(beside, 1, 2), self._between(rows, own)]])

    def _gram(self, columns, weights=None):
        """Gram matrices of base, columns and, last, the reading."""
        return self._ordered(self.gathered(columns), weights)

    def _ordered(self, rows, weights=None):
        order = [*self.base, *range(self.first + 1, self.first + 1 + len(rows[0])), self.first]
        return self.bordered(rows, weights)[:, order][:, :, order]

    def products(self, rows):
        """Products of base columns, `rows` (one matrix a layout) and, last, the reading, with what is known before."""
        total = self._ordered(rows).sum(0)
        return total + self._prior(len(total) - 1)

    def cost_of_drawing(self, columns, temperature):
        """Chi-square that it costs a fit with these columns to have inertia and gravity as the model file has them, to a drawing's
        accuracy. That of the data counts by its `temperature`: where forms are approximate, parameters move more."""
        data = self._gram(columns).sum(0) / temperature
        drawn = data + self._known_to(self.dataset.drawn_width, len(data) - 1)
        return max(float(squares(drawn, solve(drawn)) - squares(data, solve(data))), 0.0)

    def off_drawing(self, columns, temperature):
        """The same where the file is a drawing or a first guess, as likely as not: one that no fit comes near costs all of them the
        same. A guess has its values anywhere within the width that one joint's have, so a drawing foretells them so much better. A
        single value may be near by chance."""
        drawing, guess = self._drawing_and_guess(columns, temperature)
        return float(2.0 * np.log((1.0 + guess) / (drawing + guess)))

    def is_drawn(self, columns, temperature):
        """Is the file likelier a drawing than a guess, beside these columns?"""
        drawing, guess = self._drawing_and_guess(columns, temperature)
        return bool(drawing > guess)

    def _drawing_and_guess(self, columns, temperature):
        """How likely the fit's machine is if the file is a drawing, and if it is a guess; the same where nothing can tell."""
        drawn = np.isfinite(self.dataset.drawn_width).sum()
        if drawn < FEWEST_DRAWN:
            return 1.0, 1.0
        return np.exp(-0.5 * self.cost_of_drawing(columns, temperature)), (PART / PRIOR_WIDTH_OF_ONE_JOINT) ** drawn

    def as_drawn(self, temperature):
        """The same products where the file is a drawing. The data's chi-square counts by its `temperature`, so in its unit a drawing is
        so much nearer."""
        near, drawn = copy.copy(self), self.dataset.drawn_width
        near.drawn = True
        near.prior_width, near.prior_spread = (np.where(np.isfinite(drawn), drawn / one, self.prior_width)
                                               for one in (np.sqrt(temperature), temperature))  # fmt: skip
        return near

    def prior_share(self, weights):
        """By how much less a drawing counts where each kind of channel counts by a weight: by as much less as the torques' chi-square, whose
        temperature it has."""
        if not self.drawn:
            return 1.0
        rows, times = zip(*((layout.rows, w**-2) for layout, w in zip(self.layouts, weights, strict=True) if layout.kind[0] == "T"))
        return sum(rows) / float(np.dot(rows, times))

    def variance(self, products, left):
        """Variance of the right side of products(), where the noise is `left` times the one known: that of the data, and of what is
        known before by its own deviation."""
        size = len(products) - 1
        return left * (products - self._prior(size)) + self._known_to(self.prior_spread, size)

    def prior_rows(self, width=None):
        """What is known of the base parameters before: (unknowns, rows) and readings, in chi-square's unit. Far less than
        recordings tell, but for effects that could stand for a parameter: a spring for gravity, say."""
        given, width = self.dataset.prior, self.prior_width if width is None else width
        known = np.flatnonzero(given)
        rows, weight = np.zeros((self.first, len(known))), 1 / width[known]
        rows[known, np.arange(len(known))] = weight
        return rows, weight * given[known]

    def prior_products(self):
        """Products of prior_rows() among the base columns that the data see."""
        return self._prior(len(self.base))[:-1, :-1]

    def reading(self, kind):
        """Weighted rows of what a kind of channel showed."""
        return next(plain[-1] for layout, plain in zip(self.layouts, self.plain) if layout.kind == kind)

    def _prior(self, size):
        """Products of prior_rows() in the order of a fit with `size` unknowns and the reading."""
        return self._known_to(self.prior_width, size)

    def _known_to(self, width, size):
        """The same where base parameters are known to other widths."""
        rows, reading = self.prior_rows(width)
        every = np.zeros((size + 1, rows.shape[1]))
        every[:len(self.base)], every[-1] = rows[self.base], reading
        return every @ every.T

    def held_out(self, columns):
        """(chi-square on held-out folds, strengths of `columns` in the fit to everything)."""
        chi2, strengths = self._held_out(self._gram(columns)[None])
        return float(chi2[0]), strengths[0][len(self.base):]

    def _held_out(self, gram):
        """Gram matrices (m, folds, p + 1, p + 1) whose last column is the reading: chi-square on the held-out folds (m),
        and the fit to everything (m, p)."""
        total, prior = gram.sum(1), self._prior(gram.shape[-1] - 1)
        return squares(gram, solve(total[:, None] - gram + prior)).sum(1), solve(total + prior)

    def held_out_blocks(self, columns):
        """Chi-square of each block by the fit that has not seen its fold, for each kind of channel: {kind: (blocks)}."""
        strengths, out = self.fold_strengths(columns), {}
        for layout, plain, own in zip(self.layouts, self.plain, self.gathered(columns)):
            residual = plain[-1].copy()
            for f, part in enumerate(layout.slices):
                residual[part] -= strengths[f] @ np.concatenate([plain[:-1, part], own[:, part]])
            out[layout.kind] = np.bincount(layout.block, residual**2, minlength=self.dataset.blocks)
        return out

    def by_other_recordings(self, columns):
        """Chi-square of each recording by the fit to all others, for each kind of channel: {kind: (recordings)}."""
        own, weights = self.gathered(columns), self.settled_weights(columns)
        grams = np.array([self._of_recordings(*one) for one in zip(self.layouts, self.plain, own, strict=True)])
        each = np.einsum("l,lrij->rij", weights**2, grams)
        known = self.prior_share(weights) * self._prior(len(each[0]) - 1)
        strengths = solve(each.sum(0) - each + known)
        return {layout.kind: squares(one, strengths) for layout, one in zip(self.layouts, grams)}

    def _of_recordings(self, layout, plain, own):
        """Products of base columns, some rows of a layout and, last, the reading, by recording."""
        every, record = np.concatenate([plain[self.base], own, plain[-1:]]), self.dataset.block_record[layout.block]
        parts = (every[:, record == r] for r in range(len(self.all_terms)))
        return np.array([part @ part.T for part in parts])

    def by_stretch(self, columns):
        """Each unknown's product with what the fit to everything leaves, in the order of products(), summed over each stretch of the motion:
        (stretches, unknowns)."""
        strengths = self.fold_strengths(columns)[-1]
        strengths = np.concatenate([strengths[self.base], strengths[self.first:]])
        sums = np.zeros((self.dataset.stretches, len(strengths)))
        for layout, plain, own in zip(self.layouts, self.plain, self.gathered(columns), strict=True):
            every = np.concatenate([plain[self.base], own])
            left, stretch = plain[-1] - strengths @ every, layout.on_rows(self.dataset.stretch_of)
            for k, column in enumerate(every):
                sums[:, k] += np.bincount(stretch, column * left, self.dataset.stretches)
        return sums

    def settled_weights(self, columns):
        """A weight for each kind of channel by what a fit with these columns leaves of it, not by its noise alone: the joint
        whose effect is not in the model would bend the other's parameters otherwise."""
        weights = np.ones(len(self.layouts))
        own = self.gathered(columns)
        for _ in range(REWEIGHINGS):
            strengths = self.fold_strengths(columns, weights)[-1]
            weights = 1 / np.sqrt(np.maximum([np.mean(x**2) for x in self.left(strengths, own)], 1.0))
        return weights

    def left(self, strengths, own):
        """What base columns, and after them rows of others, leave of the readings with these strengths: one vector a layout."""
        return [plain[-1] - strengths @ np.concatenate([plain[:-1], rows]) for plain, rows in zip(self.plain, own, strict=True)]

    def fold_strengths(self, columns, weights=None):
        """Strengths of the fit that left out each fold, and of the fit to everything: (folds + 1, base + columns).
        Base columns that the data cannot see are 0. `weights`: of each layout; None: 1."""
        gram = self._gram(columns, weights)
        total, share = gram.sum(0), 1.0 if weights is None else self.prior_share(weights)
        found = solve(np.concatenate([total - gram, total[None]]) + share * self._prior(len(total) - 1))
        out = np.zeros((len(found), self.first + len(columns)))
        out[:, self.base] = found[:, :len(self.base)]
        out[:, self.first:] = found[:, len(self.base):]
        return out


def packed(rows, kept):
    """The rows with these numbers alone, moved to the front of what holds all; the rest is given back."""
    for place, number in enumerate(kept):
        if place != number:
            rows[place] = rows[number]
    rows.resize((len(kept), rows.shape[1]), refcheck=False)
    return rows


def every_batch(terms, columns):
    """As batches(): the library's columns many at once, a recording's own one by one."""
    yield from batches(terms, [column for column in columns if isinstance(column, Column)])
    for column in columns:
        if not isinstance(column, Column):
            yield [column], {name: values[None] for name, values in column(terms).items()}


def groups(candidates):
    """(columns, candidates) of candidates with equally many columns, so many at once that their products stay small."""
    for count in sorted({len(c.columns) for c in candidates}):
        alike = [c for c in candidates if len(c.columns) == count]
        for begin in range(0, len(alike), FITTED_AT_ONCE):
            yield count, alike[begin:begin + FITTED_AT_ONCE]


def solve(gram):
    """Least squares of Gram matrices (..., p + 1, p + 1) whose last column is the reading: (..., p)."""
    p = gram.shape[-1] - 1
    scale = np.sqrt(np.einsum("...ii->...i", gram[..., :p, :p]))
    scale[scale == 0] = 1
    unit = gram[..., :p, :p] / (scale[..., :, None] * scale[..., None, :]) + RIDGE * np.eye(p)
    return np.linalg.solve(unit, (gram[..., :p, -1] / scale)[..., None])[..., 0] / scale


def squares(gram, strengths):
    """Sum of squares that strengths leave of Gram matrices (..., p + 1, p + 1)."""
    weights = np.concatenate([-strengths, np.ones((*strengths.shape[:-1], 1))], axis=-1)
    return np.matmul(np.matmul(weights[..., None, :], gram), weights[..., :, None])[..., 0, 0]
