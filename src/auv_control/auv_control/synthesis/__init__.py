"""Design of a control law's gains, before any flight."""
