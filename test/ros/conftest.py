"""Lets the tests of this folder share its modules and the synthetic bags."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "src" / "auv_bringup" / "test")]
