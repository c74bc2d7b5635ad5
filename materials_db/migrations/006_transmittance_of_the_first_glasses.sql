-- The internal transmittance of the glasses that are there from the start, unless a person
-- has changed them: wavelength in um, ratio, thickness in mm. The catalogs' three digits
-- follow from the extinction coefficients that refractiveindex.info (CC0) has of them.
-- Of fused silica the source has none.
UPDATE material SET
  transmittance = '0.3 0.050 25 0.31 0.250 25 0.32 0.520 25 0.334 0.780 25 0.35 0.920 25 0.365 0.971 25
0.37 0.977 25 0.38 0.983 25 0.39 0.989 25 0.4 0.992 25 0.405 0.993 25 0.42 0.993 25
0.436 0.992 25 0.46 0.993 25 0.5 0.994 25 0.546 0.996 25 0.58 0.995 25 0.62 0.994 25
0.66 0.994 25 0.7 0.996 25 1.06 0.997 25 1.53 0.980 25 1.97 0.840 25 2.325 0.560 25
2.5 0.360 25',
  source = source || char(10) || 'Internal transmittance of 25 mm: SCHOTT Zemax catalog 2017-01-20b.'
WHERE name = 'N-BK7' AND transmittance = '' AND source LIKE 'Dispersion%from refractiveindex.info.%';

UPDATE material SET
  transmittance = '0.29 0.275 10 0.3 0.557 10 0.31 0.776 10 0.32 0.894 10 0.33 0.951 10 0.34 0.974 10
0.35 0.982 10 0.36 0.992 10 0.37 0.995 10 0.38 0.995 10 0.39 0.996 10 0.4 0.997 10
0.42 0.997 10 0.44 0.997 10 0.46 0.997 10 0.48 0.997 10 0.5 0.997 10 0.55 0.997 10
0.6 0.997 10 0.65 0.997 10 0.7 0.997 10 0.8 0.998 10 0.85 0.998 10 0.9 0.998 10
0.95 0.998 10 1 0.998 10 1.06 0.998 10 1.2 0.998 10 1.4 0.975 10 1.6 0.987 10
1.8 0.957 10 2 0.904 10 2.2 0.778 10 2.4 0.709 10',
  source = source || char(10) || 'Internal transmittance of 10 mm: CDGM Zemax catalog 2022-06.'
WHERE name = 'H-K9L' AND transmittance = '' AND source LIKE 'Dispersion%from refractiveindex.info.%';

UPDATE material SET
  transmittance = '0.32 0.00452 10 0.33 0.09146 10 0.34 0.36688 10 0.35 0.66938 10 0.36 0.82766 10
0.37 0.87116 10 0.38 0.82177 10 0.39 0.91291 10 0.4 0.93772 10 0.41 0.93531 10
0.42 0.93409 10 0.43 0.93235 10 0.44 0.93530 10 0.45 0.94766 10 0.46 0.95543 10
0.47 0.95556 10 0.48 0.95690 10 0.49 0.96093 10 0.5 0.96320 10 0.51 0.96374 10
0.52 0.96249 10 0.53 0.95892 10 0.54 0.95479 10 0.55 0.95098 10 0.56 0.94483 10
0.57 0.93495 10 0.58 0.92571 10 0.59 0.91827 10 0.6 0.90914 10 0.61 0.89810 10
0.62 0.88600 10 0.63 0.87119 10 0.64 0.85877 10 0.65 0.85058 10 0.66 0.84079 10
0.67 0.82758 10 0.68 0.81650 10 0.69 0.80971 10 0.7 0.80129 10 0.71 0.78760 10
0.72 0.77425 10 0.73 0.76121 10 0.74 0.74848 10 0.75 0.73593 10 0.76 0.72367 10
0.77 0.71158 10 0.78 0.69999 10 0.79 0.68866 10 0.8 0.67768 10 0.81 0.66631 10
0.82 0.65560 10 0.83 0.64561 10 0.84 0.63630 10 0.85 0.62770 10 0.86 0.61977 10
0.87 0.61248 10 0.88 0.60579 10 0.89 0.59973 10 0.9 0.59429 10 0.91 0.59032 10
0.92 0.58653 10 0.93 0.58286 10 0.94 0.57936 10 0.95 0.57603 10 0.96 0.57249 10
0.97 0.56926 10 0.98 0.56641 10 0.99 0.56385 10 1 0.56162 10 1.1 0.55773 10
1.2 0.56963 10',
  source = source || char(10) || 'Internal transmittance of 10 mm: from the extinction coefficients of M. Rubin 1985, clear window glass.'
WHERE name = 'soda-lime' AND transmittance = '' AND source LIKE 'Dispersion%from refractiveindex.info.%';
