"""What each layer of `hazards` means: unit, formula, source."""

from __future__ import annotations

from typing import NamedTuple


class LayerWords(NamedTuple):
    """How a layer explains itself; braces take the rover's own numbers."""

    unit: str
    words: str
    formula: str
    source: str


_FIT = "least squares over a square window; normal equations in docs/derivations.md"
_ACE = (
    "own bound in the manner of K. Otsu and others, Fast approximate clearance evaluation for "
    "rovers with articulated suspension systems, J. Field Robotics (2020)"
)
_SLIP = "curves of slip in the soil's file, which names its sources and assumptions"

WORDS = {
    "slope": LayerWords(
        "rad",
        "Angle of the plane fitted to the ground over {footing}.",
        "arctan(sqrt(p^2 + q^2))",
        _FIT,
    ),
    "east": LayerWords(
        "1",
        "Rise per metre to the east of the plane fitted over {footing}.",
        "p = sum(u z) / (n s c)",
        _FIT,
    ),
    "north": LayerWords(
        "1",
        "Rise per metre to the north of the plane fitted over {footing}.",
        "q = sum(v z) / (n s c)",
        _FIT,
    ),
    "roughness": LayerWords(
        "m",
        "Root mean square of what the plane fitted over {footing} leaves of the ground.",
        "sqrt(mean((z - plane)^2))",
        _FIT,
    ),
    "step": LayerWords(
        "m",
        "Highest ledge within a wheel's diameter of {wheel}.",
        "max |dz| along eight rays where steeper than the rover's slope limit",
        "docs/decisions/0005-steps-are-steep.md",
    ),
    "distance": LayerWords(
        "m",
        "Distance to the nearest ground that blocks by itself.",
        "exact Euclidean distance between cell centres",
        "A. Meijster, J. Roerdink and W. Hesselink, A general algorithm for computing distance "
        "transforms in linear time (2000)",
    ),
    "slip": LayerWords(
        "1",
        "Share of the wheels' way that is lost, {course}.",
        "s(rise along the heading), straight between the soil's points",
        _SLIP,
    ),
    "energy": LayerWords(
        "J/m",
        "Energy for a metre of map, {course}; infinite where the wheels get nowhere.",
        "(max(0, W (A + c) / sqrt(1 + A^2)) / e + P0 / v) sqrt(1 + A^2) / sqrt((1 - s)^2 - y^2)",
        "D. Helmick and others, Terrain adaptive navigation for planetary rovers, J. Field "
        "Robotics (2009), in the form of docs/derivations.md",
    ),
    "pitch": LayerWords(
        "rad",
        "Nose up on the fitted plane, {course}.",
        "arctan(A), A = p cos(heading) + q sin(heading)",
        _FIT,
    ),
    "roll": LayerWords(
        "rad",
        "Left side up on the fitted plane, {course}.",
        "arctan(B / sqrt(1 + A^2)), B = q cos(heading) - p sin(heading)",
        _FIT,
    ),
    "tilt_bound": LayerWords(
        "rad",
        "Most that the body can tilt with its middle anywhere in the cell, at any heading; NaN "
        "where a heading could not be proven safe.",
        "interval bounds of wheel heights, joints and attitude",
        _ACE,
    ),
    "clearance_bound": LayerWords(
        "m",
        "Least clearance of the belly with the middle anywhere in the cell, at any heading; NaN "
        "where a heading could not be proven safe.",
        "lowest the belly can be less highest ground under it, in 3 x 2 tiles",
        _ACE,
    ),
    "proven": LayerWords(
        "1",
        "Share of the headings at which every pose with its middle in the cell is proven safe.",
        "proven headings / headings",
        _ACE,
    ),
}
