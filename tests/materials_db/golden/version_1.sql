-- A database of version 1 as it was written, with two glasses of a user's own; one has
-- the name of a glass that version 2 brings.
PRAGMA application_id = 1229870157;
CREATE TABLE material (
  name TEXT NOT NULL PRIMARY KEY COLLATE NOCASE CHECK (length(name) > 0),
  manufacturer TEXT NOT NULL,
  source TEXT NOT NULL,
  dispersion_formula TEXT NOT NULL,
  dispersion_coefficients TEXT NOT NULL,
  min_wavelength_um REAL NOT NULL CHECK (min_wavelength_um > 0),
  max_wavelength_um REAL NOT NULL CHECK (max_wavelength_um >= min_wavelength_um),
  density_kg_m3 REAL,
  youngs_modulus_gpa REAL,
  poisson_ratio REAL,
  tensile_strength_mpa REAL,
  expansion_per_k REAL,
  specific_heat_j_kg_k REAL,
  conductivity_w_m_k REAL,
  melting_point_c REAL
) STRICT;
INSERT INTO material VALUES('our-crown','Works','measured in 2019','schott','2.2718929 -0.010108077 0.010592509 0.00020816965 -7.6472538e-06 4.9240991e-07',0.334,2.325,2511.5,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO material VALUES('n-bk7','Works','melt 4711','sellmeier_1','1.0396 0.006 0.2318 0.02 1.01 103.6',0.3,2.5,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL);
PRAGMA user_version = 1;
