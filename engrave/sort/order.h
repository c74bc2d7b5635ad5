#pragma once

// In which order the points of a cloud are engraved.
//
// A point must be made before any point above it in the converging beam, because a crack
// above scatters the pulse (Trochimczuk 2008 ch. 1 and 6.7); shadow.h counts where an
// order breaks that. Deterministic: the same points and options give the same order.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

/// Indices into a cloud, in the order of engraving.
using Order = std::vector<std::uint32_t>;

enum class Method {
  kKdz,            ///< greedy in 3D: kdz.h
  kLayers,         ///< a layer at a time: layers.h
  kSmooth,         ///< greedy for the stage: smooth.h
  kBoustrophedon,  ///< rows to and fro, a layer at a time: boustrophedon.h
  kPublishedKdz,   ///< as published, through earlier cracks: published_kdz.h
  kAnneal,         ///< kSmooth or rows, improved as long as the options allow: anneal.h
  kSweep,          ///< once upward, for a slow axis z: sweep.h
  kJumpLayers,     ///< for a head that jumps and dwells, a height at a time:
                   ///< jump_layers.h
};

struct KdzOptions {
  /// K, the weight of a step in z against one in x or y, 0..100. Not less than the
  /// tangent of the beam's cone in the glass, or points are fired through earlier cracks.
  /// 0.6-1.2 has the shortest moves, hence the default; DefaultUpRatio (kdz.h) takes the
  /// lens into account as well.
  double up_ratio = 0.6;
};

struct LayersOptions {
  /// 0.01..100 mm, not less than the distance of the cloud's layers. Default: the usual
  /// distance of sections.
  double layer_thickness_mm = 0.1;
};

struct BoustrophedonOptions {
  double layer_thickness_mm = 0.1;  ///< 0.01..100 mm
  double row_width_mm = 0.1;        ///< 0.01..100 mm
  /// Direction of the rows, from x counterclockwise seen from above, -pi..pi.
  double row_turn_rad = 0;
};

struct PublishedKdzOptions {
  double up_ratio = 1;    ///< K of steps up, 0..100
  double down_ratio = 1;  ///< K of steps down, 0..100
};

/// The order that annealing begins with.
enum class AnnealStart {
  kSmooth,  ///< smooth.h
  kRows,    ///< boustrophedon.h, of a lattice: whole rows of it are kept where they pay
};

struct AnnealOptions {
  AnnealStart start = AnnealStart::kSmooth;
  /// Changes tried, for each point, 0..1e6. Ten thousand points and more: 30 bring half
  /// of what there is to gain, 1000 nearly all. Absent: as many as are worth it, that is,
  /// for as long as a second of annealing promises to save more than a second of
  /// engraving all `pieces`. The order does not depend on the time that it takes then,
  /// either.
  std::optional<double> tries_per_point;
  double pieces = 1;  ///< to be engraved in this order, 1..1e6
  std::uint64_t seed = 1;
  /// When given, it decides in the place of tries_per_point: the share of a time budget
  /// that is used, 0..1, and at 1 the annealing ends. The order then depends on the time.
  std::function<double()> used_share;
};

struct SweepOptions {
  double slab_mm = 0.05;  ///< 0.01..100 mm
  /// How far above or below a point z may pass it, 0..100 mm. 0: it begins in slabs.
  double tolerance_mm = 0;
  /// Changes tried, for each point, 0..1e6. By trial: 40 have most of what there is to
  /// gain.
  double tries_per_point = 40;
};

struct JumpLayersOptions {
  /// Places of the mirrors x, y, mm, and the layer: the height z at which the axis rests,
  /// growing upward; equal for the points of a layer. Empty: no such machine.
  std::function<Vec3(const Vec3& glass_mm)> head_from_glass;
  /// Number of the energy with which a point is made: a controller changes it only
  /// between its lists. Empty: all have the same.
  std::function<std::uint32_t(const Vec3& glass_mm)> energy_from_glass;
  double jump_mm_s = 2000;  ///< > 0
  /// What one list more takes, s, 0..1: points of an energy are gathered where their
  /// longer ways take less. By virtual boards "some milliseconds"; to be measured.
  double change_s = 0.005;
};

struct OrderOptions {
  Method method = Method::kKdz;
  KdzOptions kdz;
  LayersOptions layers;
  BoustrophedonOptions boustrophedon;
  PublishedKdzOptions published_kdz;
  AnnealOptions anneal;
  SweepOptions sweep;
  JumpLayersOptions jump_layers;
  /// The cone that must be free of cracks for a pulse. All methods keep to it but
  /// kPublishedKdz, and kKdz where its ratio is set too low.
  BeamCone cone;
  /// Of the stage, in the frame of the points; kSmooth, kAnneal and kSweep regard them.
  motion::Limits limits;
  /// The motion keeps more than speed and acceleration of each axis.
  bool keeps_more = false;
  double rate_hz = 100;  ///< lamp sync, 1..50000
  Executor executor;     ///< for methods that can use several workers
};

/// points_mm: glass frame, mm, each coordinate within a kilometre. Every index occurs
/// once. Fails on wrong options, on points that are elsewhere or too many for the index,
/// and with kCancelled.
Result<Order> MakeOrder(const PointList& points_mm, const OrderOptions& options,
                        const ProgressSink& progress = {});

/// The same for points that are made in the channels of their masks. One mask per point,
/// not 0. The points of one mask form groups (channel_groups.h), each ordered by the
/// method, and no point is made through an earlier crack of one of its own channels. Of
/// equal masks, the order is that of MakeOrder.
Result<Order> MakeChannelOrder(const PointList& points_mm,
                               std::span<const ChannelMask> masks,
                               const OrderOptions& options,
                               const ProgressSink& progress = {});

}  // namespace intaglio::sort
