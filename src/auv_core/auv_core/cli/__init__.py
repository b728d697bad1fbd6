"""The manners of a command: one line for bad arguments, exit statuses, progress, output that lasts."""
