#pragma once

// Correction files for tests, byte by byte by their published layouts, of a field whose
// lens puts the beam farther out than commanded by a share that grows with the square of
// the distance. The command for a place is found by bisection along its radius, so the
// files share nothing with the tables of the product.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "engrave/core/geometry.h"

namespace intaglio::galvo {

/// Its error is this share of the distance at 100 mm, as `distortion_ratio` of the
/// virtual glass head.
struct WrongField {
  double distortion_ratio = 0;

  Vec2 Arrive(const Vec2& command_mm) const {
    return (1 + 1e-4 * distortion_ratio * command_mm.squaredNorm()) * command_mm;
  }
  /// What is added to a place so that the beam arrives there.
  Vec2 CorrectionAt(const Vec2& place_mm) const {
    const double radius_mm = place_mm.norm();
    if (radius_mm == 0) return Vec2::Zero();
    double low = 0, high = 2;
    for (int i = 0; i < 60; ++i) {
      const double share = 0.5 * (low + high);
      (Arrive(share * place_mm).norm() < radius_mm ? low : high) = share;
    }
    return (low - 1) * place_mm;
  }
};

template <typename Number>
void PutNumber(std::string& bytes, std::size_t at, Number value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

inline std::string CorBytes(const WrongField& field, double field_mm) {
  std::string bytes(33'840, '\0');
  std::memcpy(bytes.data(), "JCZ_COR_2_1", 11);
  const double scale = 65536 / field_mm;
  PutNumber(bytes, 28, scale);
  for (int y = 0; y < 65; ++y) {
    for (int x = 0; x < 65; ++x) {
      const Vec2 at_mm = Vec2(x - 32, y - 32) * 1024 / scale;
      const Vec2 units = scale * field.CorrectionAt(at_mm);
      const auto at = static_cast<std::size_t>(36 + 8 * (y * 65 + x));
      PutNumber(bytes, at, static_cast<std::int32_t>(std::lround(units.x())));
      PutNumber(bytes, at + 4, static_cast<std::int32_t>(std::lround(units.y())));
    }
  }
  return bytes;
}

/// The outputs have 16 bits: at the border those of a field that needs more are cut off.
inline std::string CtbBytes(const WrongField& field, double field_mm) {
  std::string bytes(2 * 65 * 65 * 2, '\0');
  const double scale = 65536 / field_mm;
  for (int y = 0; y < 65; ++y) {
    for (int x = 0; x < 65; ++x) {
      const Vec2 at_mm = Vec2(x - 32, y - 32) * 1024 / scale;
      const Vec2 bits = scale * (at_mm + field.CorrectionAt(at_mm));
      const auto at = static_cast<std::size_t>(2 * (y * 65 + x));
      const auto of = [](double bit) {
        return static_cast<std::uint16_t>(
            std::clamp(std::lround(bit + 32768), 0L, 65535L));
      };
      PutNumber(bytes, at, of(bits.x()));
      PutNumber(bytes, at + 8450, of(bits.y()));
    }
  }
  return bytes;
}

/// Tables 0 and 1 and the calibration; its inverse and its check are left out.
inline std::string Ct5Bytes(const WrongField& field, double field_mm) {
  constexpr int kNodes = 257;
  std::string bytes(64 + 4UL * kNodes * kNodes * 4 + 4, '\0');
  const auto scale = static_cast<std::int32_t>((1 << 20) / field_mm);
  PutNumber(bytes, 4, scale);
  for (int y = 0; y < kNodes; ++y) {
    for (int x = 0; x < kNodes; ++x) {
      const Vec2 at_mm = Vec2(x - 128, y - 128) * 4096 / scale;
      const Vec2 bits = scale * (at_mm + field.CorrectionAt(at_mm));
      const auto at = static_cast<std::size_t>(64 + 4 * (y * kNodes + x));
      const auto of = [](double bit) {
        return static_cast<std::int32_t>(
            std::clamp(std::lround(bit) + (1L << 19), 0L, (1L << 20) - 1));
      };
      PutNumber(bytes, at, of(bits.x()));
      PutNumber(bytes, at + 4UL * kNodes * kNodes, of(bits.y()));
      for (const int inverse : {2, 3})
        PutNumber(bytes, at + 4UL * kNodes * kNodes * inverse, std::int32_t{1 << 19});
    }
  }
  return bytes;
}

}  // namespace intaglio::galvo
