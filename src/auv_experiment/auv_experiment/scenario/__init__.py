"""Scenarios: the schema, the file, what is checked at load; and those that come with Shoal."""
