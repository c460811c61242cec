"""An unrelated laboratory: a plant with known hidden effects that records runs, to test the diagnoser blind.

It shares no equations, integrator or code with the diagnoser.
"""

from stribeck.withheld.injections import KNOWN, UNKNOWN, Injection, null
from stribeck.withheld.motions import Motion
from stribeck.withheld.recorder import Gains, default_gains, record

__all__ = ["KNOWN", "UNKNOWN", "Gains", "Injection", "Motion", "default_gains", "null", "record"]
