#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/hpgl_scale.h"

namespace intaglio::drawing {

/// The pen of a plotter: where it is, whether it is down, its units, and the curves that
/// it draws. A function that returns false has given its error to the builder.
class HpglPen {
 public:
  HpglPen(std::string_view name, const DrawingLimits& limits, double unit_mm)
      : limits_(limits), unit_mm_(unit_mm), builder_(name, limits) {
    builder_.SetUnit(unit_mm);
  }

  DrawingBuilder& builder() { return builder_; }
  HpglScale& scale() { return scale_; }
  const Vec3& at() const { return at_; }
  bool down() const { return down_; }

  /// Where the curves of errors begin, e.g. "byte 12, PD".
  void SetPlace(std::size_t byte, std::string_view instruction);
  std::string Place() const;

  /// The number is that of SP; 0 is no pen, which draws nothing.
  bool Select(double number);
  /// Down with a first point at once.
  bool SetDown(bool down);
  /// Up in the next move, without an end of the line; for PE.
  void Move(bool down) { down_ = down; }
  /// Turns all that follows about the origin by quarters (RO).
  void Turn(int quarters);

  bool LineTo(const Vec3& to);
  /// Along the piece, which begins at the pen.
  bool Draw(const Piece& piece, const Vec3& end);
  /// A closed curve of its own; the pen stays.
  bool Shape(std::vector<Piece> pieces);
  bool EndLine();

  /// Plotter units of a vector and of a point in user units, and back.
  Vec3 AxisOfUser(double x, double y) const;
  Vec3 PointAtUser(double x, double y, bool from_pen) const;
  Vec2 UserVector(const Vec3& v) const;

 private:
  void FlushLine();
  bool AddCurve(Curve curve);

  DrawingLimits limits_;
  double unit_mm_;
  DrawingBuilder builder_;
  HpglScale scale_;
  Eigen::Matrix2d turn_ = Eigen::Matrix2d::Identity();
  std::size_t byte_ = 0;
  std::string instruction_;
  bool down_ = false;
  bool has_pen_ = true;  ///< also before the first SP, which files leave out
  std::uint32_t layer_ = 0;
  Vec3 at_ = Vec3::Zero();  ///< plotter units, as all that is stored
  PointList line_;
  std::vector<Piece> pieces_;
};

}  // namespace intaglio::drawing
