"""
Confidence intervals at 95 %, of numbers over runs.

`binomial.py` has those of a count out of n independent runs.
"""

CONFIDENCE = 0.95
