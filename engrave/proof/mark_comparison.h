#pragma once

// The comparison of what a scan head burnt with the marks of its job. Frame: material,
// mm; x along the web, whose piece web_mm lies at x - web_mm.
//
// Burnt ticks belong to marks by the number in their record, and those of a row to its
// dots by their place: a row is made when each of its dots is. A mark's place is the mean
// of its way, weighted by length; its shape is compared after both means are laid upon
// each other. Where the web was at the beginning of a run is not known to the material:
// with `on_web` the median of a run's deviations along x is no error of its marks. Where
// repeats begin at print marks, each is compared with the print mark of the material that
// is nearest to its first mark, and nothing is removed. The comparison does not use the
// journal or any other record of a service.
// Time: burnt ticks of a mark times its chords.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/formats/mark_record.h"
#include "engrave/mark/mark.h"

namespace intaglio::proof {

enum class BurntFate : std::uint8_t {
  kMissed,      ///< nothing of it was burnt
  kIncomplete,  ///< a tenth less than its way in all passes, or half a pass
  kMade,        ///< in all passes of its pen
  kDoubled,     ///< as much more
};

struct BurntMark {
  BurntFate fate = BurntFate::kMissed;
  double pass_count = 0;  ///< length burnt, of the length planned
  Vec2 offset_mm = Vec2::Zero();
  /// Of its run along the web, or of its print mark; not in offset_mm.
  double web_shift_mm = 0;
  double shape_um = 0;                ///< largest distance from the planned way
  std::optional<double> gap_um;       ///< largest between strokes of a closed mark
  std::optional<double> diameter_um;  ///< of a circle: burnt less planned
  double energy_mj_mm = 0;            ///< per length, over all passes
  /// Of a row of dots those that were missed, burnt in part, or twice.
  std::uint32_t wrong_dot_count = 0;
};

/// Largest absolute value over the made marks.
struct MarkErrors {
  double place_um = 0, shape_um = 0, gap_um = 0, diameter_um = 0;
  /// Of the energy per length from the median of the same pen's.
  double energy_ratio = 0;
};

struct MarkComparison {
  std::uint64_t made_count = 0, missed_count = 0, incomplete_count = 0, doubled_count = 0;
  /// Dots of rows, and those that were missed, burnt in part, or twice.
  std::uint64_t dot_count = 0, wrong_dot_count = 0;
  std::uint64_t stray_tick_count = 0;  ///< of marks that the job does not have
  /// With print marks: repeats at one at which another repeat lies.
  std::uint64_t shared_print_count = 0;
  MarkErrors worst;
  std::vector<BurntMark> marks;  ///< by their place in the job

  /// All marks are made, and place, shape, gap and diameter are within `tolerance_um`.
  bool IsGood(double tolerance_um) const;
};

/// Repeats that begin at print marks.
struct PrintedRepeats {
  std::vector<double> prints_mm;  ///< edges of print marks along x of the material
  double pitch_mm = 1;            ///< a mark's web_mm is a multiple, > 0
  double offset_mm = 0;           ///< x of a repeat's origin less that of its print mark
};

/// Of so much burnt of a way that is planned in these passes; not missed.
BurntFate FateOf(double burnt_mm, double way_mm, std::uint32_t pass_count);

/// As below, of marks on a web.
MarkComparison CompareMarks(const mark::MarkSet& set,
                            std::span<const formats::BurntTick> ticks,
                            const PrintedRepeats& repeats);

/// `set` passes CheckMarks; `ticks` in the order of the record. Of a mark without length
/// (a hole) only the place and whether it was burnt are compared.
MarkComparison CompareMarks(const mark::MarkSet& set,
                            std::span<const formats::BurntTick> ticks, bool on_web);

}  // namespace intaglio::proof
