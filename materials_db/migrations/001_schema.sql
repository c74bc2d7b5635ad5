-- One row a glass. Names are the same glass in upper and lower case. Values that are not
-- known are NULL. The coefficients are numbers with a space between, in the order of the
-- formula's catalog.
PRAGMA application_id = 1229870157;  -- "INTM": this file holds Intaglio's materials

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
