"""Normal equations of everything at once, block by block: each fit and each error on held-out blocks is then small
algebra, and no row is read twice.

The order of the unknowns is: base parameters, one constant for each kind of angle, the candidates' columns; the
reading itself comes last.
"""

import numpy as np

RIDGE = 1e-10  # of unit columns: keeps what cannot be told apart solvable, far below any noise
TINY = 1e-12


class Gram:
    """Block Gram matrices of base columns, candidate columns and reading."""

    def __init__(self, evidence, scenes, candidates):
        self.evidence = evidence
        self.first = evidence.bases + len(evidence.angle_kinds)
        self.columns = list(dict.fromkeys(c for candidate in candidates for c in candidate.columns))
        self.place = {column: self.first + k for k, column in enumerate(self.columns)}
        size = self.first + len(self.columns) + 1
        self.block = np.zeros((evidence.blocks, size, size))
        for record, scene in enumerate(scenes):
            self._add(record, scene)
        self.total = self.block.sum(0)
        self.scale = np.sqrt(np.diag(self.total))
        self.fold = np.array([self.block[evidence.folds == f].sum(0) for f in np.unique(evidence.folds)])
        self.base = [k for k in range(self.first) if self.scale[k] > 0]
        self.candidates = [c for c in candidates if self._usable(c)]

    def _usable(self, candidate):
        norms = self.scale[self.of(candidate)]
        return bool(np.all(np.isfinite(norms)) and np.all(norms > TINY))

    def of(self, candidate):
        """Places of a candidate's columns."""
        return [self.place[column] for column in candidate.columns]

    def _add(self, record, scene):
        shown = {column: column(scene) for column in self.columns}
        for channel in self.evidence.channels:
            if channel.record != record:
                continue
            active = [c for c in self.columns if channel.kind in shown[c]]
            weight = 1.0 / self.evidence.sigma[channel.kind]
            rows = np.column_stack([self.evidence.base_columns(channel)]
                                   + [shown[c][channel.kind][channel.rows] for c in active]
                                   + [channel.values[channel.rows]]) * weight  # fmt: skip
            place = np.array([*range(self.first), *(self.place[c] for c in active), self.block.shape[1] - 1])
            block = self.evidence.block_of[record][channel.rows]
            for b in np.unique(block):
                part = rows[block == b]
                self.block[b][np.ix_(place, place)] += part.T @ part

    # ---- fits ----------------------------------------------------------------------

    def held_out(self, columns):
        """Chi-square on held-out folds of a fit with these columns beside the base, and the strengths of a fit
        to everything (base first)."""
        every = [*self.base, *columns, -1]
        index = np.ix_(every, every)
        fold = np.array([f[index] for f in self.fold])
        total = self.total[index]
        strengths = solve(np.concatenate([total - fold, total[None]]))
        return float(squares(fold, strengths[:-1]).sum()), strengths[-1]

    def held_out_blocks(self, columns):
        """Chi-square of each block, by the fit that has not seen its fold."""
        every = [*self.base, *columns, -1]
        index = np.ix_(every, every)
        total, out = self.total[index], np.empty(len(self.block))
        for f, fold in enumerate(self.fold):
            strengths = solve((total - fold[index])[None])[0]
            for b in np.flatnonzero(self.evidence.folds == f):
                out[b] = squares(self.block[b][index], strengths)
        return out

    def fold_strengths(self, columns):
        """Strengths of the fit that left out each fold, and of the fit to everything: (folds + 1, base + columns).
        Base columns that the data cannot see are 0."""
        every = [*self.base, *columns, -1]
        index = np.ix_(every, every)
        total = self.total[index]
        found = solve(np.array([total - fold[index] for fold in self.fold] + [total]))
        out = np.zeros((len(found), self.first + len(columns)))
        out[:, self.base] = found[:, :len(self.base)]
        out[:, self.first:] = found[:, len(self.base):]
        return out


def solve(gram):
    """Least squares of Gram matrices (m, p + 1, p + 1) whose last column is the reading: (m, p)."""
    p = gram.shape[1] - 1
    scale = np.sqrt(np.einsum("mii->mi", gram[:, :p, :p]))
    scale[scale == 0] = 1
    unit = gram[:, :p, :p] / (scale[:, :, None] * scale[:, None, :]) + RIDGE * np.eye(p)
    return np.linalg.solve(unit, (gram[:, :p, -1] / scale)[..., None])[..., 0] / scale


def squares(gram, strengths):
    """Sum of squares that strengths leave of Gram matrices (..., p + 1, p + 1)."""
    weights = np.concatenate([-strengths, np.ones((*strengths.shape[:-1], 1))], axis=-1)
    return np.einsum("...i,...ij,...j->...", weights, gram, weights)
