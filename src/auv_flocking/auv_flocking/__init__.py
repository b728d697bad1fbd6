"""Control of the group: consensus, neighbour filters, flocking laws, and the agent that combines them."""
