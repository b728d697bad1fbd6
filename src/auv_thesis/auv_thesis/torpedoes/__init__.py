"""Chapter on fleets of torpedoes in lanes over acoustic links: many seeds, and limits that must hold."""
