#include "engrave/contour/files/excellon_pattern.h"

#include <fmt/format.h>

#include "engrave/contour/files/excellon_read.h"
#include "engrave/contour/files/excellon_terms.h"
#include "engrave/contour/files/gerber_aperture.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

Status RequireWithin(const Vec2& place_mm) {
  if (place_mm.cwiseAbs().maxCoeff() <= kMaxExcellon_mm) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("a place is beyond {} mm; correct it", kMaxExcellon_mm));
}

}  // namespace

Status ExcellonPattern::Begin(const DrillFile& file) {
  if (IsOpen())
    return Fail(
        ErrorCode::kUnsupported,
        "a pattern (M25) begins in another one; export the file without patterns");
  begin_ = Counts{file.holes.size(), file.slots.size()};
  end_.reset();
  offset_mm_ = Vec2::Zero();
  return {};
}

Status ExcellonPattern::End(const DrillFile& file) {
  if (!IsOpen())
    return Fail(ErrorCode::kInvalidValue,
                "a pattern ends (M01) that has not begun (M25); correct it");
  end_ = Counts{file.holes.size(), file.slots.size()};
  return {};
}

Status ExcellonPattern::Repeat(int count, const Vec2& step_mm, std::uint64_t max_holes,
                               DrillFile& file) {
  if (!begin_ || !end_)
    return Fail(ErrorCode::kInvalidValue,
                "a pattern is repeated (M02) that was not declared between M25 and M01; "
                "correct it");
  for (int k = 0; k < count; ++k) {
    offset_mm_ += step_mm;
    const std::uint64_t more = end_->holes - begin_->holes + end_->slots - begin_->slots;
    if (file.holes.size() + file.slots.size() + more > max_holes)
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("more than {} holes; divide the file", max_holes));
    INTAGLIO_TRY(RequireWithin(offset_mm_));
    for (std::size_t h = begin_->holes; h < end_->holes; ++h) {
      Hole hole = file.holes[h];
      hole.center_mm += offset_mm_;
      INTAGLIO_TRY(RequireWithin(hole.center_mm));
      file.holes.push_back(hole);
    }
    for (std::size_t s = begin_->slots; s < end_->slots; ++s) {
      const Shape moved = Moved(file.slots[s].shape, offset_mm_);
      file.slots.push_back({moved});
    }
  }
  return {};
}

void ExcellonPattern::Finish() {
  begin_.reset();
  end_.reset();
}

}  // namespace intaglio::contour
