#include "engrave/discretize/cloud.h"

#include <algorithm>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/shared_progress.h"
#include "engrave/core/try.h"
#include "engrave/discretize/spacing/bounds.h"

namespace intaglio::discretize {
namespace {

// A seam, the points between it and the next seam, and that next seam.
constexpr std::uint64_t kThinningsPerSlab = 3;

struct SlabResult {
  SpacedCloud kept;
  std::uint64_t candidate_count = 0;
  std::uint64_t thinned_count = 0;
  BoundsReport outside;
  std::vector<MethodStatistics> models;
};

/// How far points of the job reach in height.
double ReachOf(const Sources& sources, const ThinningOptions& thinning) {
  double reach_mm = thinning.min_spacing_mm * thinning.height_ratio;
  for (const auto& source : sources) reach_mm = std::max(reach_mm, source->MaxSpacing());
  return reach_mm;
}

Box3 BoundsOf(const Sources& sources) {
  Box3 bounds;
  for (const auto& source : sources) bounds.Extend(source->Bounds());
  return bounds;
}

void Append(const SpacedCloud& from, SpacedCloud& to) {
  to.points_mm.insert(to.points_mm.end(), from.points_mm.begin(), from.points_mm.end());
  to.source.insert(to.source.end(), from.source.begin(), from.source.end());
  to.spacing_mm.insert(to.spacing_mm.end(), from.spacing_mm.begin(),
                       from.spacing_mm.end());
}

class SlabMaker {
 public:
  SlabMaker(const Sources& sources, const CloudOptions& options, const Slabs& slabs,
            SharedProgress& progress)
      : sources_(sources), options_(options), slabs_(slabs), progress_(progress) {}

  Result<SlabResult> Make(std::size_t slab) const {
    SlabResult result;
    result.models.resize(sources_.size());
    auto lower = INTAGLIO_TRY(Thinned(slabs_.Seam(slab), {}, result));
    SpacedCloud taken = lower;
    if (slab + 1 < slabs_.count()) {
      SlabResult of_next;  // discarded: counted when slab + 1 is made
      of_next.models.resize(sources_.size());
      const auto upper = INTAGLIO_TRY(Thinned(slabs_.Seam(slab + 1), {}, of_next));
      Append(upper, taken);
    }
    const auto between = INTAGLIO_TRY(Thinned(slabs_.Between(slab), taken, result));
    result.kept = std::move(lower);
    Append(between, result.kept);
    return result;
  }

 private:
  Result<SpacedCloud> Thinned(const HeightRange& range, const SpacedCloud& taken,
                              SlabResult& result) const {
    SpacedCloud candidates;
    for (std::uint32_t i = 0; i < sources_.size(); ++i) {
      const auto goes_on = [this](std::uint64_t, std::uint64_t) {
        return progress_.GoesOn(0);
      };
      const auto added =
          INTAGLIO_TRY(sources_[i]->AddPoints(range, i, goes_on, candidates));
      result.models[i].Add(added);
    }
    const std::size_t offered = candidates.size();
    const auto& of_source = options_.permitted_of_source_mm;
    result.outside.Add(of_source.empty() ? TakeOutside(options_.permitted_mm, candidates)
                                         : TakeOutside(of_source, candidates));
    if (!progress_.GoesOn(1)) return Cancelled();
    result.candidate_count += offered;
    SpacedCloud kept = Thin(candidates, options_.thinning, taken);
    result.thinned_count += candidates.size() - kept.size();
    return kept;
  }

  static tl::unexpected<Error> Cancelled() {
    return Fail(ErrorCode::kCancelled, "making the points was cancelled");
  }

  const Sources& sources_;
  const CloudOptions& options_;
  const Slabs& slabs_;
  SharedProgress& progress_;
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
  const Slabs slabs(BoundsOf(sources), ReachOf(sources, options.thinning));
  const std::size_t begin = part.Begin(slabs.count()), end = part.End(slabs.count());
  SharedProgress shared(progress, kThinningsPerSlab * (end - begin));
  const SlabMaker maker(sources, options, slabs, shared);
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
