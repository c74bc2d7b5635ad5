#include "engrave/contour/equal_elements.h"

#include <string>
#include <unordered_map>
#include <utility>

namespace intaglio::contour {
namespace {

/// The kind of a shape and the bytes of all its numbers.
class Key {
 public:
  std::string operator()(const Circle& s) { return Pad('c', s.center_mm, s.diameter_mm); }
  std::string operator()(const Square& s) { return Pad('s', s.center_mm, s.side_mm); }
  std::string operator()(const Octagon& s) { return Pad('o', s.center_mm, s.size_mm); }
  std::string operator()(const Track& s) {
    const Vec2 &a = s.begin_mm, &b = s.end_mm;
    const bool turn = a.x() != b.x() ? b.x() < a.x() : b.y() < a.y();
    key_ = "t";
    Add(turn ? b : a);
    Add(turn ? a : b);
    Add(s.width_mm);
    return std::move(key_);
  }
  std::string operator()(const ArcTrack& s) {
    key_ = "a";
    Add(s.arc);
    Add(s.width_mm);
    return std::move(key_);
  }
  std::string operator()(const Outline& s) {
    key_ = "l";
    for (const Edges& loop : s.loops) {
      Add(static_cast<double>(loop.size()));
      for (const Edge& edge : loop) Add(edge);
    }
    return std::move(key_);
  }

 private:
  std::string Pad(char kind, const Vec2& center, double size) {
    key_ = kind;
    Add(center);
    Add(size);
    return std::move(key_);
  }
  void Add(double value) {
    value += 0.0;  // -0 is 0
    key_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Add(const Vec2& place) {
    Add(place.x());
    Add(place.y());
  }
  void Add(const Edge& edge) {
    Add(edge.begin_mm);
    Add(edge.end_mm);
    Add(edge.center_mm);
    Add(edge.radius_mm);
    Add(edge.sweep_rad);
  }

  std::string key_;
};

}  // namespace

std::vector<std::uint32_t> FirstsOfEqual(std::span<const Element> elements) {
  std::unordered_map<std::string, std::uint32_t> firsts;
  std::vector<std::uint32_t> first_of;
  for (std::uint32_t k = 0; k < elements.size(); ++k)
    first_of.push_back(
        firsts.try_emplace(std::visit(Key{}, elements[k].shape), k).first->second);
  return first_of;
}

}  // namespace intaglio::contour
