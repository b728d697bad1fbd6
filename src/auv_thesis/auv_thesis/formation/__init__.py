"""Chapter on formations, thesis Sections 1.7.2, 1.10 and 1.11: simulations, tables, claims."""
