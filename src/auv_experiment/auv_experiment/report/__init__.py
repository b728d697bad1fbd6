"""The page that shows a run: verdicts, figures, metrics."""
