#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/drawing/dxf_read.h"
#include "engrave/drawing/flatten.h"

// The bytes are read and flattened: finite points, or an error with a sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  drawing::ReadOptions options;
  options.limits.max_entities = 1000;
  options.limits.max_points = 10'000;
  options.limits.max_unfolded_bytes = 1 << 20;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto read = drawing::ReadDxf(text, options);
  if (!read) {
    Require(!read.error().message.empty(), "an error without a sentence");
    return 0;
  }
  const drawing::FlattenOptions coarse{0.1, 0.5, 200'000};
  auto flat = drawing::Flatten(*read, coarse);
  if (!flat) return 0;
  drawing::JoinOpenCurves(0.001, *flat);
  for (const drawing::FlatCurve& curve : flat->curves) {
    Require(!curve.points_mm.empty(), "a curve without points");
    for (const Vec3& p : curve.points_mm) {
      Require(p.allFinite(), "a point that is not finite");
    }
  }
  return 0;
}
