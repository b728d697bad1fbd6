"""Use of the machine: processes, signals, memory, atomic writing of files."""
