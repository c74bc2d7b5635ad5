#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::drawing {

/// The user units of a plot (HP-GL/2 reference, SC and IP): a user point lies at
/// offset + factor * user, axis by axis, in plotter units. Scale and scaling points hold
/// until they are changed, in any order.
class HpglScale {
 public:
  struct Wrong {
    ErrorCode code;
    std::string_view sentence;
  };

  /// IN: plotter units, and the scaling points of the page.
  void Initialize() { *this = {}; }
  /// DF, SC without numbers: plotter units.
  void SwitchOff();
  /// SC: x and y from .. to; then 0, stretched to the scaling points (default); 1, with
  /// both units the same, and the free room left and below in percent; or 2: x and y of
  /// P1, each with the plotter units that a user unit is long.
  std::optional<Wrong> TakeScale(const std::vector<double>& numbers);
  /// IP: P1 and P2 in plotter units; P1 alone takes P2 along; none, the page's.
  std::optional<Wrong> TakePoints(const std::vector<double>& numbers);
  /// IR: they lie at shares of the page, whose size is not in the file.
  void TakePointsOfPage();

  /// Why factor and offset are not known. Report it only when they are needed: files
  /// change scale and points one after the other.
  const std::optional<Wrong>& wrong() const { return wrong_; }
  const Vec2& factor() const { return factor_; }
  const Vec2& offset() const { return offset_; }

 private:
  void Update();
  std::optional<Wrong> FindUnits();
  std::optional<Wrong> UpdateByPoints(const Vec2& span);

  std::vector<double> scale_;  ///< numbers of SC; empty: off
  std::optional<Vec2> p1_ = Vec2(Vec2::Zero());
  std::optional<Vec2> p2_;
  std::optional<Wrong> wrong_;
  Vec2 factor_ = Vec2::Ones();
  Vec2 offset_ = Vec2::Zero();
};

}  // namespace intaglio::drawing
