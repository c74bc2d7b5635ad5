#pragma once

// The positions of a machine's axes for a place of the focus in the block, and the
// inverse.
//
//   glass point --optics/machine_frame.h--> place of the focus in air --this--> axes
//
// Frame `machine`: fixed to what carries the block, mm, z up, the beam comes from +z.
// With all axes at zero it is the frame of the stage, so the block's corner is at
// MachineSpec.block_origin_mm in it. `axes` are three coordinates in the order of the
// machine's axes, each in mm or in rad as axes() names it; the planner, the limits and
// the motion controller work in them.
//
// What every implementation guarantees, and tests/engrave/machine/conformance_test.cc
// checks for all of them:
//   K1 Round trip: ToPlace(ToAxes(p)) is p within 1e-9 mm.
//   K2 Branch: a rotary coordinate is the one of its turns that is nearest to `near`,
//      within half a turn of it; the configuration never changes. So along a path, each
//      point near the one before, coordinates are continuous. Linear ones ignore `near`.
//   K3 Scale: ScaleAt is the derivative of ToPlace, is not singular where ToAxes
//   succeeds,
//      and stays within BoundsOver of a box that has the place. At the face of a block
//      under a scan head it is that of the side of the place.
//   K4 Reach: a place that is no number, out of reach or in a singular region is
//      kOutsideBlock, with the place, why, and what to do. The limits of travel are not
//      regarded: they are motion::Limits.
//   K5 The same arguments give the same bits. Nothing is stored between calls: any
//      threads may share one.
//
// Trochimczuk 2008 ch. 7.1, fig. 45: a positioner is a pair (object, tool), each
// Cartesian, polar or fixed, of which 8 pairs work. Here are four of them:
// CartesianOptions has (fixed, Cartesian), (Cartesian, fixed) and (Cartesian, Cartesian),
// PolarOptions has (polar, polar). Mirrors are none of them: the beam tilts.

#include <array>
#include <memory>
#include <string_view>
#include <variant>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/galvo/correction_table.h"
#include "engrave/optics/oblique_focus.h"

namespace intaglio::machine {

enum class AxisUnit { kMm, kRad };

struct Axis {
  std::string_view name;  ///< short, e.g. "x", "table"
  AxisUnit unit = AxisUnit::kMm;

  std::string_view unit_name() const { return unit == AxisUnit::kMm ? "mm" : "rad"; }
};

/// How far the focus moves in air when the axes move by one unit (mm or rad), at most,
/// over a box of places; > 0, mm.
struct ScaleBounds {
  Vec3 axis_mm = Vec3::Ones();  ///< one axis alone
  double any_mm = 1;            ///< all axes together, by a vector of length one
};

class Kinematics {
 public:
  virtual ~Kinematics() = default;
  virtual std::array<Axis, 3> axes() const = 0;
  virtual Result<Vec3> ToAxes(const Vec3& place_mm, const Vec3& near) const = 0;
  virtual Vec3 ToPlace(const Vec3& axes) const = 0;
  /// Column i: the move of the focus for one unit of axis i, mm.
  virtual Mat3 ScaleAt(const Vec3& axes) const = 0;
  /// Not for an empty box.
  virtual ScaleBounds BoundsOver(const Box3& places_mm) const = 0;
};

/// What an axis moves, and which way it counts.
struct LinearAxis {
  bool moves_table = false;  ///< the block; false: the head, and with it the focus
  bool reversed = false;     ///< it counts down when the part that it moves goes to + of
                             ///< the frame
  /// What it moves for 1 mm of its coordinate, mm: 0.9..1.1; 1: it counts mm.
  double scale_ratio = 1;

  /// Move of the focus in the block for a unit of the coordinate, mm.
  double per_unit_mm() const {
    return moves_table != reversed ? -scale_ratio : scale_ratio;
  }
};

/// Three linear axes along those of the frame, y inclined to x by a small angle. Default:
/// the head moves, all count up, so axes and places are the same numbers.
struct CartesianOptions {
  LinearAxis x, y, z;
  /// How much less than a right angle + of x and + of y of the focus enclose,
  /// -0.1..0.1; y is inclined, x goes along the frame.
  double squareness_xy_rad = 0;
};

enum class ArmSide { kLeft, kRight };

/// A rotary table that carries the block and an arm that carries the focus
/// (Trochimczuk 2008 ch. 8.4, fig. 66). The machine frame turns with the table: its
/// origin is on the table's axis, and at table angle 0 its +y points to the arm's axis.
/// Both angles grow counterclockwise, seen from +z; at arm angle 0 the arm points to the
/// table's axis. Axes: arm (rad), table (rad), z (mm).
struct PolarOptions {
  double axis_distance_mm = 200;  ///< d, between both axes, > 0
  double arm_length_mm = 150;     ///< r1, from the arm's axis to the beam, > 0
  /// On which side of the line from the arm's axis to the table's the arm works: left is
  /// the source's (arm angle pi..2 pi); right is its mirror image (0..pi).
  ArmSide side = ArmSide::kLeft;
  LinearAxis z = {};
  /// Places at which the arm is nearer to that line, folded or stretched, are refused,
  /// 0.01..1 rad: there a small move across the arm's circle takes a large turn. At the
  /// default 0.1 the arm's axis is 10 times as sensitive as at best.
  double singular_margin_rad = 0.1;
  /// How far the frame of the places is turned on the table, counterclockwise: of a block
  /// at another station, -1000..1000.
  double frame_turn_rad = 0;
};

/// Two mirrors and a lens over a block, whose origin of the frame is on the axis of the
/// lens, and a slow axis z (scan_head.h). Default: a telecentric lens over air.
struct ScanHeadOptions {
  optics::ScanLens lens = {};
  LinearAxis z = {};
  /// What the mirrors' commands need besides the place in the field: a table of
  /// corrections (files of galvo/files, or galvo::CommandGrid). nullptr: the controller
  /// of the mirrors corrects.
  std::shared_ptr<const galvo::CorrectionTable> corrections = nullptr;
  /// What the corrections leave: the moves of the focus in the focal plane, mm, for 1 mm
  /// of x and of y of the field (its columns; FieldMatrix of scan_head.h). Not singular.
  Eigen::Matrix2d place_per_field = Eigen::Matrix2d::Identity();
  /// > 0: the axis z rests at multiples of this, and a place is met in x and y alone, in
  /// z within half of it (of the focus: times the refractive index). So K1 and K3 hold in
  /// x and y alone. 0: z meets it, too.
  double z_step_mm = 0;
  // Of the block. Above top_z_mm the beam is in air.
  double refractive_index = 1;  ///< at the laser's wavelength, >= 1
  double top_z_mm = 0;          ///< of its face, in the frame
};

using KinematicsOptions = std::variant<CartesianOptions, PolarOptions, ScanHeadOptions>;

/// One row a kind, in the order of KinematicsOptions: its name is that of the member of
/// MachineSpec.kinematics that chooses it.
struct KinematicsKind {
  std::string_view name;
  std::shared_ptr<const Kinematics> (*make)(const KinematicsOptions& options);
};
std::array<KinematicsKind, std::variant_size_v<KinematicsOptions>> KinematicsKinds();

/// Throws PreconditionError for options outside their ranges.
std::shared_ptr<const Kinematics> MakeKinematics(const KinematicsOptions& options);

/// The reference of ToAxes for the first point of a path: the middle of each axis'
/// travel, 0 for an axis without end.
Vec3 BranchStart(const Box3& travel);

}  // namespace intaglio::machine
