"""Common parts of commands: one-line errors for arguments, exit statuses, progress, robust output."""
