"""Laws side by side; each file is a chapter of the page."""
