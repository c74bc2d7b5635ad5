#include "services/job/models/discretize_outcome.h"

#include "engrave/discretize/warnings.h"
#include "services/job/methods/method_table.h"
#include "services/job/methods/point_maker.h"
#include "services/job/verdict/warnings.h"

namespace intaglio {
namespace {

MethodCounts CountsOf(const discretize::MethodStatistics& statistics) {
  MethodCounts counts;
  counts.set_point_count(statistics.point_count);
  counts.set_plane_count(statistics.plane_count);
  counts.set_closed_contour_count(statistics.closed_contour_count);
  counts.set_open_contour_count(statistics.open_contour_count);
  counts.set_parallel_face_count(statistics.parallel_face_count);
  counts.set_parallel_area_mm2(statistics.parallel_area_mm2);
  counts.set_small_triangle_count(statistics.small_triangle_count);
  counts.set_rejected_triangle_count(statistics.rejected_triangle_count);
  counts.set_ray_count(statistics.ray_count);
  counts.set_odd_ray_count(statistics.odd_ray_count);
  counts.set_shallow_count(statistics.shallow_count);
  return counts;
}

discretize::MethodStatistics StatisticsOf(const MethodCounts& counts) {
  discretize::MethodStatistics statistics;
  statistics.point_count = counts.point_count();
  statistics.plane_count = counts.plane_count();
  statistics.closed_contour_count = counts.closed_contour_count();
  statistics.open_contour_count = counts.open_contour_count();
  statistics.parallel_face_count = counts.parallel_face_count();
  statistics.parallel_area_mm2 = counts.parallel_area_mm2();
  statistics.small_triangle_count = counts.small_triangle_count();
  statistics.rejected_triangle_count = counts.rejected_triangle_count();
  statistics.ray_count = counts.ray_count();
  statistics.odd_ray_count = counts.odd_ray_count();
  statistics.shallow_count = counts.shallow_count();
  return statistics;
}

}  // namespace

DiscretizeOutcome OutcomeOf(const JobSources& sources,
                            const discretize::Discretized& made,
                            const discretize::Part& part) {
  DiscretizeOutcome outcome;
  if (part.index == 0) {
    outcome.mutable_models()->Assign(sources.meshes.begin(), sources.meshes.end());
    AddTo(*outcome.mutable_warnings(), sources.warnings);
  }
  outcome.set_candidate_count(made.candidate_count);
  outcome.set_thinned_count(made.thinned_count);
  outcome.set_clipped_count(made.clipped_count);
  outcome.set_point_count(made.cloud.size());
  for (const discretize::MethodStatistics& model : made.models) {
    *outcome.add_methods() = CountsOf(model);
  }
  return outcome;
}

void AddPart(const DiscretizeOutcome& part, DiscretizeOutcome& all) {
  all.mutable_models()->MergeFrom(part.models());
  all.mutable_warnings()->MergeFrom(part.warnings());
  all.set_candidate_count(all.candidate_count() + part.candidate_count());
  all.set_thinned_count(all.thinned_count() + part.thinned_count());
  all.set_clipped_count(all.clipped_count() + part.clipped_count());
  all.set_point_count(all.point_count() + part.point_count());
  for (int i = 0; i < part.methods_size(); ++i) {
    if (i == all.methods_size()) all.add_methods();
    discretize::MethodStatistics sum = StatisticsOf(all.methods(i));
    sum.Add(StatisticsOf(part.methods(i)));
    *all.mutable_methods(i) = CountsOf(sum);
  }
}

Warnings WarningsOf(const DiscretizeOutcome& all, const JobSpec& job) {
  Warnings warnings = WarningsOf(all.warnings());
  discretize::MethodStatistics sum;
  for (int i = 0; i < all.methods_size(); ++i) {
    discretize::MethodStatistics one = StatisticsOf(all.methods(i));
    const Method* method = i < job.models_size() ? MethodOf(job.models(i)) : nullptr;
    if (method != nullptr) {
      const auto counts_to_warn_of = MakerOf(*method).counts_to_warn_of;
      if (counts_to_warn_of != nullptr) one = counts_to_warn_of(job.models(i), one);
    }
    sum.Add(one);
  }
  for (Warning& warning :
       discretize::WarningsOf(sum, job.discretization().min_spacing_mm())) {
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

}  // namespace intaglio
