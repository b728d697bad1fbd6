"""Node processes: their layout, start, supervision and end."""
