-- Strengths and hardness, and the internal transmittance of catalogs: wavelength in um,
-- ratio and thickness in mm of each entry, with a space between, by ascending wavelength;
-- empty: unknown.
ALTER TABLE material ADD COLUMN bending_strength_mpa REAL;
ALTER TABLE material ADD COLUMN compressive_strength_mpa REAL;
ALTER TABLE material ADD COLUMN knoop_hardness_hk REAL;
ALTER TABLE material ADD COLUMN transmittance TEXT NOT NULL DEFAULT '';
