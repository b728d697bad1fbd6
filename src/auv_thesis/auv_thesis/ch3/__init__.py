"""Chapter 3: adaptive formation."""
