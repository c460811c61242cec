"""The linear part of a control loop: operating points, margins, poles against the gain, and the largest gain."""

from stribeck.loop.linear.assemble import Assembly, assemble
from stribeck.loop.linear.gains import KpMax, kp_max, root_locus
from stribeck.loop.linear.margins import Margins, margins
from stribeck.loop.linear.operating import OperatingPoint, free, sliding, stuck
from stribeck.loop.linear.plant import linearise

__all__ = [
    "Assembly", "KpMax", "Margins", "OperatingPoint", "assemble", "free", "kp_max", "linearise", "margins",
    "root_locus", "sliding", "stuck",
]  # fmt: skip
