"""What a vehicle knows of its neighbours: one filter for each, fed by packets, sonar and own fixes."""
