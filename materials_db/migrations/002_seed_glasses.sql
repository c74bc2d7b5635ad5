-- The glasses that are there from the start. Who has a glass of that name already keeps
-- it. Dispersion: refractiveindex.info (CC0). Where no value is given by the sources
-- named, it stays unknown.
INSERT OR IGNORE INTO material VALUES (
  'N-BK7', 'SCHOTT',
  'Dispersion, density, expansion (-30..70 C): SCHOTT Zemax catalog 2017-01-20b, from refractiveindex.info.
Young''s modulus, Poisson''s ratio, specific heat, conductivity, softening point (10^7.6 dPa s; transformation at 557 C): SCHOTT data sheet N-BK7 517642.251.',
  'rii_formula_2',
  '0 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653',
  0.3, 2.5,
  2510, 82, 0.206, NULL, 7.1e-6, 858, 1.114, 719);

INSERT OR IGNORE INTO material VALUES (
  'H-K9L', 'CDGM',
  'Dispersion, density, expansion (-30..70 C): CDGM Zemax catalog 2022-06, from refractiveindex.info.',
  'rii_formula_2',
  '0 0.614555251 0.0145987884 0.656775017 0.00287769588 1.02699346 107.653051',
  0.302, 2.325,
  2520, NULL, NULL, NULL, 7.6e-6, NULL, NULL, NULL);

INSERT OR IGNORE INTO material VALUES (
  'fused-silica', '',
  'Dispersion: I. H. Malitson, Interspecimen comparison of the refractive index of fused silica, J. Opt. Soc. Am. 55, 1205-1208 (1965); its validity up to 6.7 um: C. Z. Tan, J. Non-Cryst. Solids 223, 158-163 (1998); from refractiveindex.info.
Density, Young''s modulus, Poisson''s ratio, expansion, specific heat, conductivity, softening point: Crystran data sheet Silica Glass (SiO2).
Tensile strength: the usual design value, 50 MPa (makeitfrom.com, Fused Silica); it depends on the surface.',
  'rii_formula_1',
  '0 0.6961663 0.0684043 0.4079426 0.1162414 0.8974794 9.896161',
  0.21, 6.7,
  2203, 73.1, 0.17, 50, 0.55e-6, 703, 1.38, 1600);

INSERT OR IGNORE INTO material VALUES (
  'soda-lime', '',
  'Dispersion: M. Rubin, Optical properties of soda lime silica glasses, Sol. Energy Mater. 12, 275-288 (1985), clear window glass; from refractiveindex.info.
All others: Pilkington ATS-129 (2013), Properties of soda-lime silica float glass; tensile strength: mean modulus of rupture of annealed weathered glass under a load of 60 s; expansion: 24..302 C; softening point ASTM C 338.',
  'rii_formula_5',
  '1.5130 -0.003169 2 0.003962 -2',
  0.31, 4.6,
  2500, 72, 0.23, 41, 8.3e-6, 880, 0.937, 715);
