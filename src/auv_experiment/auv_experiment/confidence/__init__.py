"""
Confidence intervals at 95 %, of numbers over runs.

`binomial.py` has those of a count out of n independent runs, `clusters.py` those of means, shares and
percentiles over runs that share a draw or a seed, `differences.py` those of differences between runs that
share them. docs/how_to/sweeps.md shows how often each interval covers the true value.
"""

CONFIDENCE = 0.95
