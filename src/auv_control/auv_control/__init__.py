"""Control of a single vehicle: references, control laws, obstacle avoidance."""
