"""What the group does: graph, consensus, neighbour filters, flocking laws, and the agent that joins them."""
