"""
Neighbour estimates: one filter per neighbour, updated by packets, sonar contacts and own position fixes.
"""
