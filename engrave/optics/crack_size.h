#pragma once

// How large a crack is, from the energy of its pulse.
//
// A pulse of energy E heats a volume V of glass. Glass softens when it melts and takes no
// stress any more, so what cracks has at most its melting point T_m (Trochimczuk 2008,
// ch. 5.2): of a pulse that is absorbed whole
//     V <= E / (rho c (T_m - T_0)).
// A crack opens surface; its surface A takes a part w A of the energy, w = 8 to 10 J/m^2
// at crack speeds of 0.1 to 1 m/s (ch. 5.2). Of 30 mJ this is less than a thousandth, so
// the heat decides the size, and the volume follows the energy in proportion:
//     V = V_m E / E_m,   each length by the cube root,
// from a crack that was measured at the energy E_m.
//
// Doubts. The source has no equation of the size; the share of a pulse that is absorbed
// is not known, and changes with energy and focus; below a threshold of the glass no
// crack is made, which this does not have; a crack may run on beyond the heated volume,
// as the source's largest, 200 x 200 x 600 um, does with 30 mJ. So it is good for a
// change of energy by a factor of a few, from a crack that was measured.

namespace intaglio::optics {

/// A spheroid, its axis along the beam; both above 0.
struct CrackSize {
  double diameter_mm = 0;
  double length_mm = 0;
};

struct HeatedGlass {
  double density_kg_m3 = 0;         ///< > 0
  double specific_heat_j_kg_k = 0;  ///< > 0
  double melting_point_k = 0;       ///< > start_k
  double start_k = 293.15;          ///< before the pulse, > 0
};

/// Trochimczuk 2008, ch. 5.2, J/m^2.
inline constexpr double kMinSurfaceEnergy_j_m2 = 8, kMaxSurfaceEnergy_j_m2 = 10;

/// Of `measured`, made with `measured_mj`, with a pulse of `energy_mj`; both above 0.
CrackSize CrackSizeAt(const CrackSize& measured, double measured_mj, double energy_mj);

double CrackVolume_mm3(const CrackSize& crack);
/// Of the spheroid: the least area that a crack of this size opens.
double CrackSurface_mm2(const CrackSize& crack);

/// The largest volume that a pulse brings to the melting point; `energy_mj` above 0.
double MeltingBound_mm3(const HeatedGlass& glass, double energy_mj);

}  // namespace intaglio::optics
