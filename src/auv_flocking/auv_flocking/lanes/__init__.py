"""
Lanes: what vehicles that cannot stop need to fly in formation along one path.

A *lane* is a parallel curve of the path, a *layer* a depth. Room is assigned, not negotiated: a vehicle that
is not in its slot flies in its own layer, a vehicle in its slot in its own lane. Distances need no packet;
packets only decide when to merge. Everything here is a pure function of what one vehicle knows.
"""
