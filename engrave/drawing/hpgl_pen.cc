#include "engrave/drawing/hpgl_pen.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {

void HpglPen::SetPlace(std::size_t byte, std::string_view instruction) {
  byte_ = byte;
  instruction_ = instruction;
}

std::string HpglPen::Place() const {
  return fmt::format("byte {}, {}", byte_, instruction_);
}

bool HpglPen::Select(double number) {
  if (!EndLine()) return false;
  has_pen_ = number != 0;
  layer_ = number == 0 ? 0 : builder_.NameIndex(fmt::format("SP{}", number));
  return true;
}

bool HpglPen::SetDown(bool down) {
  if (!down && !EndLine()) return false;
  down_ = down;
  if (down && line_.empty()) line_.push_back(at_);
  return true;
}

void HpglPen::Turn(int quarters) {
  Eigen::Matrix2d quarter;
  quarter << 0, -1, 1, 0;
  turn_ = Eigen::Matrix2d::Identity();
  for (int i = 0; i < quarters; ++i) turn_ = quarter * turn_;
}

bool HpglPen::LineTo(const Vec3& to) {
  if (down_ && line_.empty()) line_.push_back(at_);
  at_ = to;
  if (!down_) return true;
  line_.push_back(at_);
  return line_.size() <= limits_.max_points ||
         builder_.CountPoints(line_.size(), Place());
}

bool HpglPen::Draw(const Piece& piece, const Vec3& end) {
  at_ = end;
  if (!down_) return true;
  FlushLine();
  pieces_.push_back(piece);
  line_.push_back(at_);
  return pieces_.size() <= limits_.max_points / 3 ||
         builder_.CountPoints(3 * pieces_.size(), Place());
}

bool HpglPen::Shape(std::vector<Piece> pieces) {
  return AddCurve({std::move(pieces), true, layer_, 0});
}

bool HpglPen::EndLine() {
  // A pen that goes down and up again leaves a point.
  if (line_.size() == 1 && pieces_.empty()) {
    pieces_.push_back(Polyline{std::exchange(line_, {})});
  }
  FlushLine();
  if (pieces_.empty()) return true;
  return AddCurve({std::exchange(pieces_, {}), false, layer_, 0});
}

void HpglPen::FlushLine() {
  if (line_.size() > 1) pieces_.push_back(Polyline{std::move(line_)});
  line_.clear();
}

bool HpglPen::AddCurve(Curve curve) {
  if (!builder_.CountEntity(Place())) return false;
  if (!has_pen_) {
    builder_.LeaveOut("line without a pen (SP0)", Effect::kLost, Place());
    return true;
  }
  for (Piece& piece : curve.pieces) {
    Transform(unit_mm_ * Mat3::Identity(), Vec3::Zero(), piece);
  }
  return builder_.Add(std::move(curve), Place());
}

Vec3 HpglPen::AxisOfUser(double x, double y) const {
  const Vec2 turned = turn_ * scale_.factor().cwiseProduct(Vec2(x, y));
  return {turned.x(), turned.y(), 0};
}

Vec3 HpglPen::PointAtUser(double x, double y, bool from_pen) const {
  const Vec2 origin = turn_ * scale_.offset();
  return (from_pen ? at_ : Vec3(origin.x(), origin.y(), 0)) + AxisOfUser(x, y);
}

Vec2 HpglPen::UserVector(const Vec3& v) const {
  return (turn_.transpose() * v.head<2>()).cwiseQuotient(scale_.factor());
}

}  // namespace intaglio::drawing
