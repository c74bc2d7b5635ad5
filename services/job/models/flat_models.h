#pragma once

// Drawings, texts and pictures of a job, placed, as sources of points. `job` with its
// defaults filled in; errors do not name the model's file but where its reader does.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/mesh/density.h"
#include "engrave/discretize/spacing/point_source.h"
#include "proto/job.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// What a file holds that is not engraved is told in `warnings`.
Result<std::unique_ptr<discretize::PointSource>> MakeDrawing(
    const JobSpec& job, const Model& model, std::string_view file,
    const ReadLimits& limits, std::vector<std::string>& warnings);

/// The model's text in the font, with `text` in place of it.
Result<std::unique_ptr<discretize::PointSource>> MakeText(const JobSpec& job,
                                                          const Model& model,
                                                          const std::string& text,
                                                          std::string_view font);

Result<std::unique_ptr<discretize::PointSource>> MakePicture(
    const JobSpec& job, const Model& model, std::string_view file,
    std::optional<std::string_view> photo, const ReadLimits& limits);

/// A picture laid over x and z of a box, seen from -y: bright is dense.
Result<discretize::Density> DensityOfPicture(std::string_view file, const Box3& box_mm,
                                             const image::ImageLimits& limits);

}  // namespace intaglio
