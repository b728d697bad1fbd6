"""Chapter 2: path following of one vehicle."""
