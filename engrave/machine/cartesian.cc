#include "engrave/machine/cartesian.h"

#include "engrave/machine/unreachable.h"

// A head at h has the focus at h; a table at t has the block moved by t, so the focus at
// -t of it. Both only change signs, so every bit of a coordinate is kept.

namespace intaglio::machine {
namespace {

class Cartesian final : public Kinematics {
 public:
  explicit Cartesian(const CartesianOptions& options)
      : sign_(options.x.sign(), options.y.sign(), options.z.sign()) {}

  std::array<Axis, 3> axes() const override { return {{{"x"}, {"y"}, {"z"}}}; }

  Result<Vec3> ToAxes(const Vec3& place_mm, const Vec3& /*near*/) const override {
    if (!place_mm.allFinite()) return NoNumber(place_mm);
    return Vec3(sign_.cwiseProduct(place_mm));
  }
  Vec3 ToPlace(const Vec3& axes) const override { return sign_.cwiseProduct(axes); }
  Mat3 ScaleAt(const Vec3& /*axes*/) const override { return sign_.asDiagonal(); }
  ScaleBounds BoundsOver(const Box3& /*places_mm*/) const override { return {}; }

 private:
  Vec3 sign_;
};

}  // namespace

std::shared_ptr<const Kinematics> MakeCartesian(const CartesianOptions& options) {
  return std::make_shared<Cartesian>(options);
}

}  // namespace intaglio::machine
