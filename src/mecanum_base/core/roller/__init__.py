"""Shape of the rollers of a mecanum wheel: curve, surface, torus, sizing, mesh (G eq. 1-9)."""
