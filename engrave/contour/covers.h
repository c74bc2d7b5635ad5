#pragma once

// Which parts of the edges of areas other areas cover.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/area.h"
#include "engrave/contour/crossings.h"
#include "engrave/contour/near_pairs.h"

namespace intaglio::contour {

enum class CoverKind : std::uint8_t {
  kInside,    ///< the part lies inside the other area
  kSame,      ///< on its outline, with both areas on one side
  kOpposite,  ///< on its outline, with an area on each side
};

/// Edges of all areas are numbered through: area by area in their order.
struct Cover {
  std::uint32_t edge = 0;
  std::uint32_t other = 0;  ///< the area that covers
  CoverKind kind = CoverKind::kInside;
  double begin_mm = 0;  ///< way along the edge
  double end_mm = 0;
  Vec2 begin_place_mm;
  Vec2 end_place_mm;
  double depth_mm = 0;  ///< of the part's middle in the other area; kInside
};

/// Compares areas two by two. Where two edges cross, both are divided at one and the same
/// point, and whether one runs along the other is decided once for both: so what remains
/// of one ends where the other goes on.
class CoverFinder {
 public:
  /// `areas` outlive it. Edges nearer than tolerance_mm run along each other.
  CoverFinder(std::span<const Area> areas, double tolerance_mm);

  /// Appends the covers of both areas' edges by the other area. True: they touch.
  bool Find(const Pair& pair, std::vector<Cover>& covers);

  /// The number of an area's first edge.
  std::uint32_t FirstEdge(std::uint32_t area) const { return first_edge_[area]; }
  std::uint32_t EdgeCount() const { return first_edge_.back(); }

 private:
  struct Cut {
    double way_mm;
    Vec2 place_mm;
  };
  /// An edge that may lie partly inside the other area.
  struct Divided {
    std::uint32_t edge = 0;  ///< of its area
    std::vector<Cut> cuts;
    std::vector<SharedPart> shared;
  };
  struct Side {
    std::uint32_t area = 0;
    std::vector<Divided> divided;
    std::size_t count = 0;  ///< of `divided` in use
  };

  void Sort(Side& side, std::uint32_t other, std::vector<Cover>& covers);
  void Meet(Divided& a, Divided& b);
  void AddCover(const Side& side, const Divided& divided, const Cut& begin,
                const Cut& end, std::uint32_t other, std::vector<Cover>& covers);
  void Classify(Side& side, std::uint32_t other, std::vector<Cover>& covers);

  std::span<const Area> areas_;
  double tolerance_mm_;
  std::vector<std::uint32_t> first_edge_;
  Side first_;
  Side second_;
  std::vector<Vec2> points_;
  bool touch_ = false;
};

}  // namespace intaglio::contour
