"""The reproduction of the thesis: its figures, tables and claims, made from our own runs."""
