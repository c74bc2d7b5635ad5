#include "engrave/discretize/picture/halftone_tone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/image/luminance.h"

namespace intaglio::discretize {
namespace {

Status CheckRange(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} must be {:g}..{:g}, is {:g}", name, low, high, value),
              fmt::format("{:g}", value));
}

}  // namespace

Status CheckTone(const ToneCurve& tone) {
  for (const Status& status : {CheckRange("brightness", tone.brightness, -1, 1),
                               CheckRange("contrast_ratio", tone.contrast_ratio, 0, 10),
                               CheckRange("gamma", tone.gamma, 0.1, 10)}) {
    if (!status) return status;
  }
  for (std::size_t i = 0; i < tone.points.size(); ++i) {
    const Vec2& p = tone.points[i];
    for (const Status& status : {CheckRange("a tone point's brightness", p.x(), 0, 1),
                                 CheckRange("a tone point's result", p.y(), 0, 1)}) {
      if (!status) return status;
    }
    if (i > 0 && !(p.x() > tone.points[i - 1].x())) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("tone points must rise in brightness; {:g} follows {:g}",
                              p.x(), tone.points[i - 1].x()),
                  fmt::format("{:g}", p.x()));
    }
  }
  return {};
}

double ApplyTone(const ToneCurve& tone, double shown) {
  double v = tone.invert ? 1 - shown : shown;
  v = 0.5 + (v + tone.brightness - 0.5) * tone.contrast_ratio;
  v = std::pow(std::clamp(v, 0.0, 1.0), 1 / tone.gamma);
  if (tone.points.empty()) return v;
  const auto above = std::find_if(tone.points.begin(), tone.points.end(),
                                  [v](const Vec2& p) { return p.x() > v; });
  if (above == tone.points.begin()) return tone.points.front().y();
  if (above == tone.points.end()) return tone.points.back().y();
  const Vec2 &from = *(above - 1), &to = *above;
  return from.y() + (to.y() - from.y()) * (v - from.x()) / (to.x() - from.x());
}

void ApplyTone(const ToneCurve& tone, image::FloatImage& picture) {
  if (tone.IsIdentity()) return;
  constexpr int kSteps = 65535;  // those of a GreyImage
  std::vector<float> table(kSteps + 1);
  for (int i = 0; i <= kSteps; ++i) {
    const double linear = static_cast<double>(i) / kSteps;
    table[static_cast<std::size_t>(i)] = static_cast<float>(
        image::LinearOfSrgb(ApplyTone(tone, image::SrgbOfLinear(linear))));
  }
  for (float& value : picture.values) {
    const float at = std::clamp(value, 0.0F, 1.0F) * kSteps + 0.5F;
    value = table[static_cast<std::size_t>(at)];
  }
}

}  // namespace intaglio::discretize
