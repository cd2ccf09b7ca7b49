"""Monte Carlo accuracy: our odometry, usual methods and oracles, on simulated scenarios."""
