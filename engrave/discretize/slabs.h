#pragma once

// How a job is cut by height into slabs. Any process can make any slab, in any order, and
// the slabs together are the same cloud, bit for bit.
//
// The lowest sheet of a slab, its seam, is thinned by itself; then the points between two
// seams are thinned with the points of both seams fixed. A seam is as thick as the
// points' reach, so two neighbouring slabs share only the seam between them, and each
// computes that seam itself: no slab waits for another.
//
//   ------------ seam k + 1    slab k gives seam k and what is between;
//      between                 seam k + 1, made by slab k as well, is given by slab k + 1
//   ------------ seam k

#include <cstddef>
#include <vector>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

class Slabs {
 public:
  /// Of a job whose points lie in `bounds` (glass frame, mm) and keep no more than
  /// reach_mm (> 0) apart in height. The slabs depend on these two alone, not on which
  /// process makes them.
  Slabs(const Box3& bounds, double reach_mm);

  std::size_t count() const { return heights_mm_.size() + 1; }

  /// All of a slab, its seam included. The lowest has no lower end, the highest no upper.
  HeightRange Whole(std::size_t slab) const;
  /// Empty for the lowest slab, which has none.
  HeightRange Seam(std::size_t slab) const;
  HeightRange Between(std::size_t slab) const;

 private:
  double reach_mm_;
  std::vector<double> heights_mm_;  // where a slab ends and the next begins, rising
};

/// Consecutive shares of a job's slabs, as equal as can be.
struct Part {
  std::size_t index = 0;
  std::size_t count = 1;

  /// The slabs of this part: from begin to end, of slab_count.
  std::size_t Begin(std::size_t slab_count) const { return index * slab_count / count; }
  std::size_t End(std::size_t slab_count) const {
    return (index + 1) * slab_count / count;
  }
};

}  // namespace intaglio::discretize
