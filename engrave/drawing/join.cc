#include <optional>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/curve/open_ends.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::drawing {
namespace {

using curve::End;
using curve::kNoEnd;
using curve::OtherEnd;

std::vector<std::optional<curve::CurveEnds>> EndsOf(
    const std::vector<FlatCurve>& curves) {
  std::vector<std::optional<curve::CurveEnds>> ends(curves.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const PointList& points = curves[i].points_mm;
    if (!curves[i].closed && points.size() > 1)
      ends[i] = curve::CurveEnds{curves[i].layer, points.front(), points.back()};
  }
  return ends;
}

class Joiner {
 public:
  Joiner(double tolerance_mm, std::vector<FlatCurve> curves)
      : ends_(EndsOf(curves), tolerance_mm), curves_(std::move(curves)) {}

  std::vector<FlatCurve> Join() {
    used_.assign(curves_.size(), false);
    std::vector<FlatCurve> joined;
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      if (!used_[i]) joined.push_back(Chain(ends_.FirstOfChain(2 * i)));
    }
    return joined;
  }

 private:
  FlatCurve Chain(End first) {
    const FlatCurve& head = curves_[first / 2];
    if (ends_.PartnerOf(first) == kNoEnd && ends_.PartnerOf(OtherEnd(first)) == kNoEnd) {
      used_[first / 2] = true;
      return std::move(curves_[first / 2]);
    }
    FlatCurve chain{{}, false, head.layer, head.color};
    PointList& points = chain.points_mm;
    End end = first;
    while (true) {
      used_[end / 2] = true;
      PointList part = std::move(curves_[end / 2].points_mm);
      const auto skip = points.empty() ? 0 : 1;  // the point of the joint is already in
                                                 // the list
      if (end % 2 == 0) {
        points.insert(points.end(), part.begin() + skip, part.end());
      } else {
        points.insert(points.end(), part.rbegin() + skip, part.rend());
      }
      const End next = ends_.PartnerOf(OtherEnd(end));
      if (next == kNoEnd) return chain;
      if (next == first) break;
      end = next;
    }
    if (points.size() > 3) {
      points.pop_back();
      chain.closed = true;
    }
    return chain;
  }

  curve::OpenEnds ends_;
  std::vector<FlatCurve> curves_;
  std::vector<bool> used_;
};

}  // namespace

void JoinOpenCurves(double tolerance_mm, FlatDrawing& flat) {
  Require(tolerance_mm >= 1e-6 && tolerance_mm <= 10,
          "tolerance_mm of joining must be 1e-6 .. 10, is {}", tolerance_mm);
  flat.curves = Joiner(tolerance_mm, std::move(flat.curves)).Join();
}

}  // namespace intaglio::drawing
