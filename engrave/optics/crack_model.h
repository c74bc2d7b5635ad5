#pragma once

// How large a crack a pulse makes, from its energy (Trochimczuk 2008 ch. 5.2: a crack
// grows where the glass is heated between its thermal strength and its melting point;
// its surface energy is 8 to 10 J/m^2).
//
// The source gives no formula from energy to size. Two bounds follow from conservation of
// energy, and one law between measured cracks:
// - melting: the pulse cannot melt more glass than it can heat to the melting point;
// - surface: new surface costs its surface energy, so a crack of a size needs at least
//   that energy;
// - scaling: a crack grows as the heated volume does, in proportion to the energy above
//   that of its surface, so its diameter and length go with the cube root.
// Doubts: what share of a pulse stays at the focus is not known (3 % by the melting bound
// for the published crack and 30 mJ), latent heat and the plasma are not regarded, the
// heat capacity is that at room temperature, and the threshold of breakdown, which
// depends on the lens and the pulse's duration, is not predicted. So sizes are derived
// from a measured crack, near its energy, and never from the bounds alone.

namespace intaglio::optics {

/// Surface energy of glass, J/m^2: middle and ends of the published range.
inline constexpr double kSurfaceEnergyJM2 = 9;
inline constexpr double kMinSurfaceEnergyJM2 = 8;
inline constexpr double kMaxSurfaceEnergyJM2 = 10;

/// Temperature of a block before it is engraved, C.
inline constexpr double kRoomTemperatureC = 20;

/// What heating a glass to its melting point takes; all > 0, melting above 20 C.
struct MeltingProperties {
  double density_kg_m3 = 0;
  double specific_heat_j_kg_k = 0;
  double melting_point_c = 0;
};

/// An ellipsoid of revolution about the beam; both > 0.
struct CrackSize {
  double diameter_mm = 0;  ///< across the beam
  double length_mm = 0;    ///< along it
};

/// Energy that heats one cubic millimetre from room temperature to the melting point,
/// mJ/mm^3: rho c (T_m - T_0).
double MeltingEnergyMjMm3(const MeltingProperties& glass);

/// The largest ellipsoid of this length by diameter (> 0) that a pulse can melt if all of
/// its energy stays at the focus. energy_mj > 0.
CrackSize MeltingBound(const MeltingProperties& glass, double energy_mj,
                       double length_ratio);

/// The energy of both surfaces of a flat crack in the plane of the beam, an ellipse of
/// that size, mJ: 2 gamma pi/4 d l. A pulse of less makes no such crack.
double SurfaceEnergyMj(const CrackSize& crack,
                       double surface_energy_j_m2 = kSurfaceEnergyJM2);

/// The share of a pulse's energy that the heat of its crack accounts for: the melting
/// energy of the measured crack's volume by the energy. Above 1 the measurement, the
/// energy or the glass is wrong.
double HeatedShare(const MeltingProperties& glass, const CrackSize& measured,
                   double energy_mj);

/// The crack of another energy (>= 0), from one measured at `measured_energy_mj`:
/// both sizes times ((E - E_s) / (E_0 - E_s))^(1/3) with E_s the surface energy of the
/// measured crack; nothing (zeros) where E <= E_s.
CrackSize CrackOfEnergy(const CrackSize& measured, double measured_energy_mj,
                        double energy_mj);

}  // namespace intaglio::optics
