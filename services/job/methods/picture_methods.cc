// The methods that make points of pictures: as mesh_methods.cc.

#include <fmt/format.h>

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

// The number of a picture's points is its brightness: none may be lost to thinning.
template <typename Message>
std::vector<MethodFault> ToneFaults(const JobSpec& job, const Message& asked) {
  std::vector<MethodFault> faults;
  const double spacing_mm = job.discretization().min_spacing_mm();
  if (asked.distance_mm() < spacing_mm) {
    faults.push_back({"distance_mm", fmt::format("{}", asked.distance_mm()),
                      fmt::format("is less than the minimum spacing, {}: thinning would "
                                  "remove points and change the tone",
                                  spacing_mm)});
  }
  for (int i = 1; i < asked.curve_size(); ++i) {
    const double before = asked.curve(i - 1).from(), from = asked.curve(i).from();
    if (from > before) continue;
    faults.push_back({fmt::format("curve[{}].from", i), fmt::format("{}", from),
                      fmt::format("is not above the previous one, {}", before)});
  }
  return faults;
}

// ---- halftone ------------------------------------------------------------------------

Method Halftone() {
  return {
      .number = Model::kHalftone,
      .kinds = {ModelKind::kImage},
      .default_of = {ModelKind::kImage},
      .meaning = "a photo as a flat panel, points follow the brightness",
      .layer_field = "layer_distance_mm",
      .layer_count_field = "layer_count",
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.halftone()); },
  };
}

// ---- relief --------------------------------------------------------------------------

Method Relief() {
  return {
      .number = Model::kRelief,
      .kinds = {ModelKind::kImage},
      .meaning = "an image as a depth map",
      .layer_field = "layer_distance_mm",
      .layer_count_field = "layer_count",
      .faults = [](const JobSpec& job,
                   const Model& model) { return ToneFaults(job, model.relief()); },
  };
}

}  // namespace

std::vector<Method> PictureMethods() { return {Halftone(), Relief()}; }

}  // namespace intaglio
