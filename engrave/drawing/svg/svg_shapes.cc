#include "engrave/drawing/svg/svg_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/drawing/svg/svg_path.h"

namespace intaglio::drawing {
namespace {

class ShapeReader {
 public:
  ShapeReader(const pugi::xml_node& node, const SvgStyle& style, const SvgScale& scale,
              std::string_view place, DrawingBuilder& builder)
      : node_(node),
        style_(style),
        page_(scale.page),
        em_(scale.em),
        place_(place),
        builder_(builder) {}

  bool Read(std::vector<Curve>& curves) {
    const std::string_view shape = SvgName(node_.name());
    if (shape == "path") return Path(curves);
    if (shape == "polyline" || shape == "polygon") {
      return Points(shape == "polygon", curves);
    }
    if (shape == "rect") return Rectangle(curves);
    if (shape == "line") return Line(curves);
    return Ellipse(shape == "circle", curves);
  }

 private:
  bool Refuse(std::string_view attribute, std::string_view sentence,
              std::string_view value) {
    return builder_.Refuse(ErrorCode::kInvalidValue, place_,
                           fmt::format("attribute {}: {}", attribute, sentence), value);
  }

  bool Length(const char* attribute, double whole, double& length, bool* has = nullptr) {
    const std::string_view found = style_.Attribute(node_, attribute);
    const bool given = !found.empty() && found != "auto";
    if (has != nullptr) *has = given;
    if (!given) return true;
    const std::optional<double> value = ParseSvgLength(found, whole, em_);
    if (!value) return Refuse(attribute, "not a length that is known", found);
    length = *value;
    return true;
  }
  double Diagonal() const { return page_.norm() / std::numbers::sqrt2; }

  bool Path(std::vector<Curve>& curves) {
    std::string_view text = style_.Attribute(node_, "d");
    if (text.starts_with("path(")) {
      text = text.substr(5, text.rfind(')') - 5);
      if (text.size() > 1) text = text.substr(1, text.size() - 2);
    }
    if (text == "none") return true;
    const auto wrong = ParseSvgPath(text, builder_.limits().max_points, curves);
    return !wrong ||
           Refuse("d", wrong->sentence + "; export the drawing again", wrong->near);
  }

  bool Points(bool closed, std::vector<Curve>& curves) {
    SvgNumbers numbers(node_.attribute("points").value());
    Polyline line;
    while (numbers.Peek() != '\0') {
      const std::optional<double> x = numbers.Next();
      numbers.SkipComma();
      const std::optional<double> y = x ? numbers.Next() : std::nullopt;
      if (!y) {
        if (line.points_mm.size() > 1) curves.push_back({{std::move(line)}, closed});
        return Refuse("points", "needs pairs of finite numbers", numbers.rest());
      }
      numbers.SkipComma();
      line.points_mm.emplace_back(*x, *y, 0);
      if (line.points_mm.size() > builder_.limits().max_points) {
        return builder_.CountPoints(line.points_mm.size(), place_);
      }
    }
    if (line.points_mm.size() > 1) curves.push_back({{std::move(line)}, closed});
    return true;
  }

  bool Line(std::vector<Curve>& curves) {
    Vec3 p = Vec3::Zero(), q = Vec3::Zero();
    if (!Length("x1", page_.x(), p.x()) || !Length("y1", page_.y(), p.y()) ||
        !Length("x2", page_.x(), q.x()) || !Length("y2", page_.y(), q.y())) {
      return false;
    }
    curves.push_back({{Polyline{{p, q}}}, false});
    return true;
  }

  bool Ellipse(bool circle, std::vector<Curve>& curves) {
    Vec3 center = Vec3::Zero();
    double rx = 0, ry = 0;
    if (!Length("cx", page_.x(), center.x()) || !Length("cy", page_.y(), center.y())) {
      return false;
    }
    if (circle) {
      if (!Length("r", Diagonal(), rx)) return false;
      ry = rx;
    } else {
      bool has_x = false, has_y = false;
      if (!Length("rx", page_.x(), rx, &has_x) || !Length("ry", page_.y(), ry, &has_y)) {
        return false;
      }
      if (!has_x) rx = ry;
      if (!has_y) ry = rx;
    }
    if (rx < 0 || ry < 0)
      return Refuse("r", "a radius must not be negative",
                    fmt::format("{}", std::min(rx, ry)));
    if (rx == 0 || ry == 0) return true;  // not drawn, as the standard defines
    curves.push_back(
        {{EllipticArc{center, {rx, 0, 0}, {0, ry, 0}, 0, 2 * std::numbers::pi}}, true});
    return true;
  }

  bool Rectangle(std::vector<Curve>& curves) {
    double x = 0, y = 0, width = 0, height = 0, rx = 0, ry = 0;
    bool has_x = false, has_y = false;
    if (!Length("x", page_.x(), x) || !Length("y", page_.y(), y) ||
        !Length("width", page_.x(), width) || !Length("height", page_.y(), height) ||
        !Length("rx", page_.x(), rx, &has_x) || !Length("ry", page_.y(), ry, &has_y)) {
      return false;
    }
    if (width < 0 || height < 0 || rx < 0 || ry < 0) {
      return Refuse("width", "sizes and radii must not be negative",
                    fmt::format("{}", std::min(width, height)));
    }
    if (width == 0 || height == 0) return true;
    if (!has_x) rx = ry;
    if (!has_y) ry = rx;
    curves.push_back(Rounded({x, y}, {width, height},
                             {std::min(rx, width / 2), std::min(ry, height / 2)}));
    return true;
  }

  /// Round the rectangle from its upper left, corner by corner.
  static Curve Rounded(const Vec2& low, const Vec2& size, const Vec2& r) {
    const Vec2 high = low + size;
    const auto at = [](double x, double y) { return Vec3(x, y, 0); };
    Curve curve;
    curve.closed = true;
    if (!(r.minCoeff() > 0)) {
      curve.pieces.push_back(Polyline{{at(low.x(), low.y()), at(high.x(), low.y()),
                                       at(high.x(), high.y()), at(low.x(), high.y())}});
      return curve;
    }
    const Vec2 centers[] = {{high.x() - r.x(), low.y() + r.y()},
                            high - r,
                            {low.x() + r.x(), high.y() - r.y()},
                            low + r};
    for (int i = 0; i < 4; ++i) {
      // Straight lines join one corner's end with the next one's beginning.
      curve.pieces.push_back(EllipticArc{{centers[i].x(), centers[i].y(), 0},
                                         {r.x(), 0, 0},
                                         {0, r.y(), 0},
                                         (i - 1) * std::numbers::pi / 2,
                                         std::numbers::pi / 2});
    }
    return curve;
  }

  const pugi::xml_node& node_;
  const SvgStyle& style_;
  Vec2 page_;
  double em_;
  std::string_view place_;
  DrawingBuilder& builder_;
};

}  // namespace

std::string_view SvgName(const char* name) {
  const std::string_view whole(name);
  const auto colon = whole.rfind(':');
  return colon == whole.npos ? whole : whole.substr(colon + 1);
}

bool IsSvgShape(std::string_view element) {
  constexpr std::string_view kShapes[] = {"path", "rect",     "circle", "ellipse",
                                          "line", "polyline", "polygon"};
  return std::ranges::find(kShapes, element) != std::end(kShapes);
}

bool SvgShapeCurves(const pugi::xml_node& node, const SvgStyle& style,
                    const SvgScale& scale, std::string_view place,
                    DrawingBuilder& builder, std::vector<Curve>& curves) {
  return ShapeReader(node, style, scale, place, builder).Read(curves);
}

}  // namespace intaglio::drawing
