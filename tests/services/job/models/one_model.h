#pragma once

// A job of one model whose files are held in memory.

#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "services/job/convert/job_defaults.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"

namespace intaglio {

inline FileBytes BytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A job of one model, and the cloud that is made of it in the block of the sample.
struct OneModel {
  JobSpec job = GoodJob();
  Model& model = (job.mutable_models(0)->Clear(), *job.mutable_models(0));

  Result<discretize::Discretized> Make(std::vector<std::string_view> files) {
    std::vector<FileBytes> bytes;
    for (const std::string_view file : files) bytes.push_back(BytesOf(file));
    const JobSpec whole = WithDefaults(job, GoodMachine());
    const auto sources = MakeSources(whole, std::move(bytes), {}, {});
    if (!sources) return tl::unexpected(sources.error());
    return discretize::MakeCloud(sources->sources, CloudOptionsOf(whole), {}, {}, {});
  }
};

inline constexpr std::string_view kThreePoints = "0 0 0\n1 0 0\n0 0 2\n";

}  // namespace intaglio
