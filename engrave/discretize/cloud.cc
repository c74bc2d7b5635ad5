#include "engrave/discretize/cloud.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/shared_progress.h"
#include "engrave/core/try.h"
#include "engrave/discretize/spacing/bounds.h"
#include "engrave/discretize/spacing/even_out.h"
#include "engrave/discretize/spacing/remembered.h"

namespace intaglio::discretize {
namespace {

// Candidates in memory: a seam with its lead, what is between it and the next, the
// filling of that one; and the seam above all of them.
constexpr std::uint64_t kRangesPerSlab = 4, kRangesPerSeam = 2;

struct SlabResult {
  SpacedCloud kept;
  std::uint64_t candidate_count = 0;
  std::uint64_t thinned_count = 0;
  BoundsReport outside;
  std::vector<MethodStatistics> models;
};

/// A seam's front is as irregular as elsewhere so many reaches from its start.
constexpr double kLeadReaches = 4;

/// The sources of a job and the direction in which its thinning rises: that of its
/// sources, and if they differ, any that is not upward; the others get another range.
class Rising {
 public:
  explicit Rising(const Sources& sources) {
    for (const auto& source : sources) {
      if (source->Rise() != kUpward) rise_ = source->Rise();
    }
    for (const auto& source : sources) {
      sources_.push_back(source.get());
      if (source->Rise() == rise_) continue;
      remembered_.push_back(MakeRemembered(*source, rise_));
      sources_.back() = remembered_.back().get();
    }
  }

  const Vec3& rise() const { return rise_; }
  const std::vector<const PointSource*>& sources() const { return sources_; }

  HeightRange Heights() const {
    HeightRange all = HeightsOf({}, rise_);
    for (const PointSource* source : sources_) {
      const HeightRange heights = source->Heights();
      all = {std::min(all.low_mm, heights.low_mm),
             std::max(all.high_mm, heights.high_mm)};
    }
    return all;
  }

  /// How far points reach in height.
  double Reach(const ThinningOptions& thinning) const {
    double reach_mm = thinning.min_spacing_mm * thinning.height_ratio;
    for (const PointSource* source : sources_) {
      reach_mm = std::max(reach_mm, source->MaxSpacing());
    }
    return reach_mm;
  }

 private:
  Vec3 rise_ = kUpward;
  std::vector<const PointSource*> sources_;
  std::vector<std::unique_ptr<PointSource>> remembered_;
};

void Append(const SpacedCloud& from, SpacedCloud& to) {
  to.points_mm.insert(to.points_mm.end(), from.points_mm.begin(), from.points_mm.end());
  to.source.insert(to.source.end(), from.source.begin(), from.source.end());
  to.spacing_mm.insert(to.spacing_mm.end(), from.spacing_mm.begin(),
                       from.spacing_mm.end());
}

/// Makes the slabs from `begin` to `end`, each seam between them once: slabs that are
/// made at the same time wait for the seam that they share.
class SlabMaker {
 public:
  SlabMaker(const Rising& rising, const CloudOptions& options, const Slabs& slabs,
            double reach_mm, SharedProgress& progress, std::size_t begin, std::size_t end)
      : rising_(rising),
        options_(options),
        thinning_(options.thinning),
        slabs_(slabs),
        reach_mm_(reach_mm),
        progress_(progress),
        begin_(begin),
        seams_(end - begin + 1) {
    thinning_.rise = rising.rise();
  }

  Result<SlabResult> Make(std::size_t slab) const {
    const Result<SlabResult>& lower = SeamOf(slab);
    if (!lower) return lower;
    SlabResult result = *lower;
    SpacedCloud taken = lower->kept;
    const bool has_next = slab + 1 < slabs_.count();
    if (has_next) {
      const Result<SlabResult>& upper = SeamOf(slab + 1);
      if (!upper) return upper;
      Append(upper->kept, taken);
    }
    SpacedCloud candidates;
    SlabResult of_next = Empty();  // discarded: counted with the next seam
    INTAGLIO_TRY(AddCandidates(slabs_.Between(slab), candidates, result));
    INTAGLIO_TRY(AddCandidates(slabs_.Filling(slab), candidates, of_next));
    SpacedCloud between = Thin(candidates, thinning_, taken);
    if (has_next && rising_.rise() != kUpward) {
      const double end_mm = slabs_.Whole(slab).high_mm;
      EvenOut(candidates, taken, end_mm - kEvenOutReaches * reach_mm_, reach_mm_,
              thinning_, between);
    }
    Append(between, result.kept);
    // A slab may keep a point of the filling without a candidate in its own range: the
    // sum over all slabs is right, modulo 2^64.
    result.thinned_count = result.candidate_count - result.outside.outside_count;
    result.thinned_count -= result.kept.size();
    return result;
  }

 private:
  SlabResult Empty() const {
    SlabResult result;
    result.models.resize(rising_.sources().size());
    return result;
  }

  struct Seam {
    std::once_flag once;
    Result<SlabResult> made;
  };

  const Result<SlabResult>& SeamOf(std::size_t slab) const {
    Seam& seam = seams_[slab - begin_];
    std::call_once(seam.once, [&] { seam.made = MakeSeam(slab); });
    return seam.made;
  }

  Result<SlabResult> MakeSeam(std::size_t slab) const {
    SlabResult seam = Empty(), of_lead = Empty();  // the lead counts with the slab below
    SpacedCloud candidates;
    INTAGLIO_TRY(AddCandidates(slabs_.Lead(slab), candidates, of_lead));
    INTAGLIO_TRY(AddCandidates(slabs_.Seam(slab), candidates, seam));
    SpacedCloud kept = Thin(candidates, thinning_);
    if (of_lead.candidate_count == 0) {
      seam.kept = std::move(kept);
      return seam;
    }
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (rising_.rise().dot(kept.points_mm[i]) < slabs_.Seam(slab).low_mm) continue;
      seam.kept.Add(kept.points_mm[i], kept.source[i], kept.spacing_mm[i]);
    }
    return seam;
  }

  /// Those of the range that are not outside the block.
  Status AddCandidates(const HeightRange& range, SpacedCloud& all,
                       SlabResult& result) const {
    const bool empty = !(range.low_mm < range.high_mm);
    SpacedCloud candidates;
    for (std::uint32_t i = 0; !empty && i < rising_.sources().size(); ++i) {
      const auto goes_on = [this](std::uint64_t, std::uint64_t) {
        return progress_.GoesOn(0);
      };
      const auto added =
          INTAGLIO_TRY(rising_.sources()[i]->AddPoints(range, i, goes_on, candidates));
      result.models[i].Add(added);
    }
    result.candidate_count += candidates.size();
    const auto& of_source = options_.permitted_of_source_mm;
    result.outside.Add(of_source.empty() ? TakeOutside(options_.permitted_mm, candidates)
                                         : TakeOutside(of_source, candidates));
    if (!progress_.GoesOn(1)) return Cancelled();
    if (all.size() == 0) {
      all = std::move(candidates);
    } else {
      Append(candidates, all);
    }
    return {};
  }

  static tl::unexpected<Error> Cancelled() {
    return Fail(ErrorCode::kCancelled, "making the points was cancelled");
  }

  const Rising& rising_;
  const CloudOptions& options_;
  ThinningOptions thinning_;
  const Slabs& slabs_;
  double reach_mm_;
  SharedProgress& progress_;
  std::size_t begin_;
  mutable std::vector<Seam> seams_;
};

void AppendTo(Discretized& all, SlabResult&& slab) {
  all.candidate_count += slab.candidate_count;
  all.clipped_count += slab.outside.outside_count;
  all.thinned_count += slab.thinned_count;
  for (std::size_t i = 0; i < slab.models.size(); ++i) all.models[i].Add(slab.models[i]);
  PointCloud& cloud = all.cloud;
  cloud.points_mm.insert(cloud.points_mm.end(), slab.kept.points_mm.begin(),
                         slab.kept.points_mm.end());
  cloud.source.insert(cloud.source.end(), slab.kept.source.begin(),
                      slab.kept.source.end());
  slab = {};
}

}  // namespace

Result<Discretized> MakeCloud(const Sources& sources, const CloudOptions& options,
                              const Part& part, const Executor& executor,
                              const ProgressSink& progress) {
  Require(part.index < part.count, "there is no part {} of {}", part.index, part.count);
  const Rising rising(sources);
  const double reach_mm = rising.Reach(options.thinning);
  const Slabs slabs(rising.Heights(), reach_mm,
                    rising.rise() == kUpward ? 0 : kLeadReaches * reach_mm);
  const std::size_t begin = part.Begin(slabs.count()), end = part.End(slabs.count());
  SharedProgress shared(progress, kRangesPerSlab * (end - begin) + kRangesPerSeam);
  const SlabMaker maker(rising, options, slabs, reach_mm, shared, begin, end);
  std::vector<Result<SlabResult>> made(end - begin);
  RunEach(executor, made.size(), [&](std::size_t i) { made[i] = maker.Make(begin + i); });
  Discretized all;
  all.models.resize(sources.size());
  BoundsReport outside;
  std::size_t count = 0;
  for (const Result<SlabResult>& slab : made) {
    if (!slab) return tl::unexpected(slab.error());
    outside.Add(slab->outside);
    count += slab->kept.size();
  }
  all.cloud.points_mm.reserve(count);
  all.cloud.source.reserve(count);
  for (Result<SlabResult>& slab : made) AppendTo(all, std::move(*slab));
  if (outside.outside_count > 0 && !options.clip) {
    return tl::unexpected(OutsideBlock(outside, all.candidate_count));
  }
  return all;
}

Error NoPoints() {
  return {ErrorCode::kMissing,
          "the model gave no points: it is empty, lies outside the block, or is smaller "
          "than the requested distances",
          ""};
}

}  // namespace intaglio::discretize
