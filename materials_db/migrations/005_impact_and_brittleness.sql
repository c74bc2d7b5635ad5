-- The energy of a blow that breaks a rod, and hardness by fracture toughness.
ALTER TABLE material ADD COLUMN impact_strength_kj_m2 REAL;
ALTER TABLE material ADD COLUMN brittleness_per_sqrt_um REAL;
