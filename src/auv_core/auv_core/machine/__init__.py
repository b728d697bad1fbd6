"""What a program does with the machine that it runs on: processes, signals, memory, whole files."""
