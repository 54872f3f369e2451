"""How far the heights of a file can be trusted: holes, steps of rounding, noise between posts.

Symbols: D(h) = mean (z(x-h) - 2 z(x) + z(x+h))^2 at a lag of h posts [m^2], c spacing of posts [m],
q step that heights are rounded to [m], s rms of noise [m].

Noise. On self-affine ground D grows as h^(2H); noise that posts do not share adds 6 s^2 at every
lag beyond its own reach. Natural ground has H of 0.5 and more from post to post (M. K. Shepard et
al., J. Geophys. Res. 106, 2001, find 0.3 to 0.9, most above 0.5; R. Orosei et al., J. Geophys. Res.
108, 2003, find 0.7 to 0.95 on Mars). What the roughness at short lags exceeds such ground by is
called noise:

- next to a post, D(2h) of ground is at least twice D(h); noise alone leaves them equal, so its
  share of D(h) is at least 2 - D(2h) / D(h), at h of 1 and 2 posts;
- D at 16 and 32 posts carried down with H = 0.55 is what ground would have at h of 1, 2 and 4
  posts, and its share is at least 1 minus their ratio. This also finds noise that neighbours
  share, as stereo matching over a patch makes it.

The larger share counts, in the direction of the four where it is smallest; dunes and furrows are
rough at one scale too, but not in every direction, so that four more directions may overrule. What
looks like noise may be trees, walls, or hills as narrow as a few posts; either way the heights from
post to post do not show where a rover could drive.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core import F64, Float, value
from ._elevation import Terrain
from ._raster import Raster
from ._roughness import second_structure

LAGS = (1, 2, 4, 8, 16, 32)
GROUND = 0.55
"""Hurst exponent with which long lags are carried down to short ones."""

MOSTLY = 0.5
"""Noise is flagged where it makes more than this share of the relief between near posts ..."""
MATTERS = math.radians(1.0)
"""... and, like rounding, where it turns the slope between two posts by more than this [rad]."""

STEPPED = 0.99
"""Heights are rounded where this share of the gaps between them are multiples of one."""

MAIN = ((0, 1), (1, 0), (1, 1), (1, -1))
BETWEEN = ((1, 2), (2, 1), (1, -2), (2, -1))
"""Directions that are looked at, as rows and columns of a step."""
ALONG = 0.5
"""Less than this share of the noise of the main directions in one between is a crest, not noise."""

PIECE, PIECES = 512, 3
"""A large raster is judged by PIECES x PIECES squares of PIECE x PIECE posts."""

Part = tuple[int, int, int, int]


@value
class Quality:
    """What is wrong with the heights of a file or terrain, and by how much.

    Attributes:
        posts: How many posts were looked at.
        sampled: Whether they are a sample of a larger file.
        holes: Share of them without data, 0 to 1.
        step: What heights are rounded to [m]; 0 where they are not.
        ties: Share of neighbours with the same height to the bit, 0 to 1.
        step_slope: Rms error of the slope between two posts by rounding [rad].
        noise: Rms of the noise [m]; 0 where none is seen.
        noise_share: Its share of the relief between near posts, 0 to 1.
        noise_slope: Rms error of the slope between two posts by noise [rad].
        flags: One sentence for each thing to beware of; empty where nothing is.
    """

    posts: int
    sampled: bool
    holes: float
    step: float
    ties: float
    step_slope: float
    noise: float
    noise_share: float
    noise_slope: float
    flags: tuple[str, ...]

    @property
    def noisy(self) -> bool:
        """Whether the relief between near posts is mostly noise."""
        return self.noise_share > MOSTLY and self.noise_slope > MATTERS

    @property
    def stepped(self) -> bool:
        """Whether heights are rounded so coarsely that slopes between posts suffer."""
        return self.step_slope > MATTERS

    def report(self) -> dict[str, Any]:
        """The numbers as a JSON object has them, angles in degrees."""
        return {
            "posts": self.posts,
            "sampled": self.sampled,
            "holes": self.holes,
            "step_m": self.step,
            "ties": self.ties,
            "step_slope_deg": math.degrees(self.step_slope),
            "noise_m": self.noise,
            "noise_share": self.noise_share,
            "noise_slope_deg": math.degrees(self.noise_slope),
            "noisy": self.noisy,
            "stepped": self.stepped,
            "flags": list(self.flags),
        }


def quality(ground: Terrain | Raster) -> Quality:
    """Holes, rounding and noise of a terrain, or of the posts of a file as they are stored.

    Of a large file nine squares of 512 x 512 posts are read. Where too few posts are known the
    noise is 0: nothing can be said.
    """
    cell, parts = ground.frame.cell, sample(ground)
    sampled = isinstance(ground, Raster) and len(parts) > 1
    posts = sum(part.size for part in parts)
    holes = sum(int(np.isnan(part).sum()) for part in parts) / posts
    step, ties = _step(parts)
    rounding = math.atan(step / math.sqrt(6.0) / cell)
    noise, share, lag = _noise(parts)
    tilt = math.atan(noise * math.sqrt(2.0) / (lag * cell))
    found = Quality(
        posts=posts, sampled=sampled, holes=holes, step=step, ties=ties, step_slope=rounding,
        noise=noise, noise_share=share, noise_slope=tilt, flags=(),
    )  # fmt: skip
    return _flagged(found)


def sample(ground: Terrain | Raster) -> list[Float]:
    """Heights [m] that stand for a terrain or a file: all, or of a large file nine squares."""
    if isinstance(ground, Terrain):
        return [ground.height]
    with ground.posts.open() as read:
        return [read(*square) for square in _squares(ground.placing.shape)]


def _flagged(q: Quality) -> Quality:
    flags: list[str] = []
    if q.holes > 0:
        share = f"{q.holes:.1%}" if q.holes >= 0.0005 else "less than 0.1%"
        flags.append(f"holes: {share} of the posts have no data")
    if q.stepped:
        flags.append(
            f"rounded: heights come in steps of {q.step:.3g} m, which turns the slope between two "
            f"posts by {math.degrees(q.step_slope):.1f} deg; judge slopes over several posts"
        )
    if q.noisy:
        flags.append(
            f"noisy: {q.noise_share:.0%} of the relief between near posts is noise, or narrower "
            f"than posts can show: about {q.noise:.2g} m rms, which turns slopes by "
            f"{math.degrees(q.noise_slope):.1f} deg; average posts (--factor) before you trust them"
        )
    return dataclasses.replace(q, flags=tuple(flags))


def _squares(shape: tuple[int, int]) -> list[Part]:
    """All posts, or squares spread evenly over them."""
    h, w = shape
    if h * w <= (PIECE * PIECES) ** 2 or min(h, w) <= PIECES:
        return [(0, 0, h, w)]
    rows, columns = min(PIECE, h), min(PIECE, w)
    tops, lefts = _spread(h - rows), _spread(w - columns)
    return [(top, left, rows, columns) for top in tops for left in lefts]


def _spread(last: int) -> list[int]:
    return sorted({round(last * (n + 0.5) / PIECES) for n in range(PIECES)})


def _step(parts: Sequence[Float]) -> tuple[float, float]:
    """What heights are rounded to [m], and the share of equal neighbours."""
    known = np.concatenate([part[np.isfinite(part)] for part in parts])
    pairs = [part[:, 1:] - part[:, :-1] for part in parts]
    counted = sum(int(np.isfinite(pair).sum()) for pair in pairs)
    ties = sum(int((pair == 0.0).sum()) for pair in pairs) / counted if counted else 0.0
    if not known.size:
        return 0.0, ties
    levels = np.unique(known)
    blur = 2.0 * float(np.spacing(known.dtype.type(np.abs(levels).max())))
    gaps = np.diff(levels).astype(np.float64)
    gaps = gaps[gaps > blur]
    if len(gaps) < 2 or float(gaps.min()) < 8.0 * blur:
        return 0.0, ties  # as fine as the numbers themselves
    step = float(gaps.min())
    near = gaps[gaps < 20.0 * step]
    step = float(near.sum() / np.rint(near / step).sum())
    off = np.abs(gaps / step - np.rint(gaps / step)) * step
    return (step if float((off <= 0.05 * step + blur).mean()) >= STEPPED else 0.0), ties


def _noise(parts: Sequence[Float]) -> tuple[float, float, int]:
    """Rms of the noise [m], its share of the relief, and the lag [posts] where it is largest."""
    found = _least(parts, MAIN)
    if found[1] > MOSTLY:
        along = _least(parts, BETWEEN)
        if along[1] < ALONG * found[1]:
            return along
    return found


def _least(parts: Sequence[Float], steps: Sequence[tuple[int, int]]) -> tuple[float, float, int]:
    """As `_noise`, in the direction of the steps where the share is smallest."""
    d = second_structure(parts, LAGS, steps)
    best: list[tuple[float, float, int]] = []
    for k in range(d.shape[1]):
        shares = _shares(d[:, k])
        if shares:
            clear = 0.9 * max(share for share, _ in shares)
            at, share = min((at, share) for share, at in shares if share >= clear)
            best.append((share, math.sqrt(share * float(d[at, k]) / 6.0), LAGS[at]))
    if not best:
        return 0.0, 0.0, 1
    share, noise, lag = min(best)
    return noise, share, lag


def _shares(d: F64) -> list[tuple[float, int]]:
    """What share of D cannot be ground, with the place of its lag, by each of the two tests."""
    found = [(2.0 - d[i + 1] / d[i], i) for i in (0, 1) if d[i] > 0]
    far = [math.log(d[i]) - 2.0 * GROUND * math.log(LAGS[i]) for i in (4, 5) if d[i] > 0]
    if far:
        level = math.exp(sum(far) / len(far))
        found += [(1.0 - level * LAGS[i] ** (2 * GROUND) / d[i], i) for i in range(3) if d[i] > 0]
    return [(min(max(float(s), 0.0), 1.0), i) for s, i in found if math.isfinite(s)]
