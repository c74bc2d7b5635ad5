#pragma once

// How a job is cut by height into slabs, along the rise of its thinning. Any process can
// make any slab, in any order, and the slabs together are the same cloud, bit for bit.
//
// The lowest sheet of a slab, its seam, is thinned separately; then the points between
// two seams are thinned with the points of both seams fixed. A seam is as thick as the
// points' reach, so two neighbouring slabs share only the seam between them, and each
// computes that seam itself: no slab waits for another.
//
//   ------------ seam k + 1    slab k gives seam k and what is between;
//      between                 seam k + 1, made by slab k as well, is given by slab k + 1
//   ------------ seam k
//
// A front that starts at a seam starts with a straight row of points, which shows. With a
// lead it starts below the seam, and only what it has kept in the seam counts: its
// points there are as irregular as elsewhere. Those at the seam's lower end were thinned
// by points of the lead, which do not count; so the slab below fills the lower half of
// the seam, and the seam is twice as thick, so that this filling reaches no point above
// it.

#include <cstddef>
#include <vector>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

class Slabs {
 public:
  /// Of a job whose points lie between `heights` and keep no more than reach_mm (> 0)
  /// apart in height. lead_mm (>= 0, less than a slab, which is 32 reaches or more): how
  /// far below a seam its front starts. The slabs depend on these alone, not on which
  /// process makes them.
  Slabs(const HeightRange& heights, double reach_mm, double lead_mm = 0);

  std::size_t count() const { return heights_mm_.size() + 1; }

  /// All of a slab, its seam included. The lowest has no lower end, the highest no upper.
  HeightRange Whole(std::size_t slab) const;
  /// Below a seam: empty without a lead, and for the lowest slab.
  HeightRange Lead(std::size_t slab) const;
  /// Empty for the lowest slab, which has none.
  HeightRange Seam(std::size_t slab) const;
  HeightRange Between(std::size_t slab) const;
  /// The lower half of the next slab's seam. Empty without a lead, and for the highest.
  HeightRange Filling(std::size_t slab) const;

 private:
  double reach_mm_, lead_mm_;
  double seam_mm_;                  // thickness
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
