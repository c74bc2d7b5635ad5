#pragma once

// What the oblique beams of a scan head cost a job: how far from the axis of the lens
// they still make cracks, by depth, what the laser makes of it by its energy, and which
// points lie beyond (engrave/machine/beam_strength.h).

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// At one depth, mm from the axis of the lens, within the field.
struct UsableRadii {
  double depth_mm = 0;
  double radius_mm = 0;         ///< with the energy asked for
  double max_radius_mm = 0;     ///< with the largest of the laser
  double double_radius_mm = 0;  ///< beyond it a crack may begin at either of two depths
};

/// Points of one kind.
struct PointGroup {
  std::uint64_t count = 0;
  Vec3 first_mm = Vec3::Zero();  ///< glass frame

  void Add(const Vec3& point_mm) {
    if (count++ == 0) first_mm = point_mm;
  }
};

struct ObliqueFigures {
  std::vector<UsableRadii> radii;  ///< rising depths
  double field_mm = 0;             ///< from its middle to its corner
  PointGroup weak;               ///< points that get no crack with the energies they have
  PointGroup beyond;             ///< those that get none with the largest energy, either
  PointGroup two_foci;           ///< points with two strong foci
  double weakest_ratio = 1;      ///< peak intensity, of that of an upright beam
  double max_apart_mm = 0;       ///< of both line foci
  double needed_energy_mj = 0;   ///< with which every point cracks
  double largest_energy_mj = 0;  ///< of the laser
  bool crack_is_measured = false;  ///< the profile has head_over_block.crack_energy_mj
  std::string why_one_energy;  ///< the energy does not follow the place; empty: it does
  std::vector<double> energies_mj;  ///< that the points have, rising
  std::uint64_t limited_count = 0;  ///< they crack, and with more energy than the laser
                                    ///< has they would be as strong as the others
};

/// nullopt: the machine has no scan head over the block. Points in the glass frame, mm,
/// each with the number of its model.
std::optional<ObliqueFigures> ObliqueFiguresOf(const FrozenJob& job,
                                               const PointList& points_mm,
                                               std::span<const std::uint32_t> source);

/// kOutsideBlock: points that get no crack even with the largest energy, with the usable
/// radius by depth. Not of a profile whose crack energy nobody has measured: it may be
/// less than what is assumed, and a warning says so; nor of a job that has
/// laser.energy_by_place switched off, which tries its energies.
Status CheckOblique(const FrozenJob& job, const ObliqueFigures& figures);

/// "up to 24.1 mm from the axis of the lens at 5 mm depth, ...", with the largest energy.
std::string MaxRadiiText(const ObliqueFigures& figures);

/// Points that get no crack, and points at which it may begin at either of two depths.
Warnings ObliqueWarningsOf(const ObliqueFigures& figures);

/// How far each lens of the profile makes cracks in glass of the index 1.52 (N-BK7), with
/// the laser's largest energy: a sentence each. Empty: no scan head over the block. Of a
/// profile that CheckMachine passes, with its defaults.
std::vector<std::string> ObliqueNotesOf(const MachineSpec& machine);

}  // namespace intaglio
