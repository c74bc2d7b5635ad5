-- Other names of a glass: names that data sheets and shops use for a glass of the same
-- index. A glass that is stored under such a name comes first. Glasses that are only
-- similar (S-BSL7, BSC7: 5e-4 in the index) are not listed.
CREATE TABLE alias (
  name TEXT NOT NULL PRIMARY KEY COLLATE NOCASE CHECK (length(name) > 0),
  material TEXT NOT NULL COLLATE NOCASE,
  source TEXT NOT NULL
) STRICT;

INSERT INTO alias VALUES
  ('BK7', 'N-BK7', 'The same glass with arsenic as the refining agent; both have the glass code 517642: SCHOTT data sheet N-BK7 517642.251. Exchanging them makes no difference to an optical design: E. Judd, Take Care With Exact Equivalent Glasses, Zemax knowledge base (2007).'),
  ('N-BK7HT', 'N-BK7', 'N-BK7 of higher transmittance in the blue: P. Hartmann, 110 years BK7, Proc. SPIE 8550, 85500U (2012).'),
  ('BK7HT', 'N-BK7', 'As N-BK7HT.'),
  ('K9', 'H-K9L', 'Chinese trade name of the borosilicate crown 517642; H-K9L is what CDGM makes of it without lead and arsenic: CDGM Zemax catalog 2022-06, glass code 517642.'),
  ('K9L', 'H-K9L', 'As K9.'),
  ('H-K9', 'H-K9L', 'As K9.'),
  ('D-K9L', 'H-K9L', 'H-K9L for pressed parts, glass code 517642: CDGM Zemax catalog 2022-06.'),
  ('UVFS', 'fused-silica', 'Synthetic fused silica for the ultraviolet. The specimens of three makers that Malitson measured agree within 1e-5 of the index (J. Opt. Soc. Am. 55, 1205, 1965).'),
  ('quartz-glass', 'fused-silica', 'Trade name of fused silica; crystal quartz is another material.'),
  ('float-glass', 'soda-lime', 'Float glass is a soda-lime silica glass: Pilkington ATS-129 (2013).'),
  ('window-glass', 'soda-lime', 'The specimens of M. Rubin, Sol. Energy Mater. 12, 275-288 (1985), are clear window glass.');
