#include "services/job/quality/cloud_warnings.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "engrave/proof/cloud_quality.h"
#include "services/job/quality/quality_options.h"

namespace intaglio {
namespace {

void Add(const proof::CloudQuality& quality, CloudFindings& found) {
  const double spacing_mm = quality.nearest.smallest.distance_mm;
  if (std::isfinite(spacing_mm) && quality.point_count > 1 &&
      (found.measured_spacing_mm == 0 || spacing_mm < found.measured_spacing_mm)) {
    found.measured_spacing_mm = spacing_mm;
  }
  if (!quality.crack_risk) return;
  if (!found.crack_risk ||
      quality.crack_risk->densest.crack_share > found.crack_risk->densest.crack_share) {
    found.crack_risk = quality.crack_risk;
  }
}

}  // namespace

CloudFindings FindInCloud(const JobSpec& job, const MachineSpec& machine,
                          const PointCloud& cloud, const std::vector<ChannelMask>& masks,
                          const Executor& executor) {
  proof::QualityOptions options = QualityOptionsOf(job, machine);
  options.executor = executor;
  const std::vector<ChannelMask> channels = DistinctChannels(masks);
  const bool one = channels.size() == 1;
  CloudFindings found;
  for (const ChannelMask channel : channels) {
    const PointCloud part = one ? PointCloud() : PointsIn(channel, cloud, masks);
    auto quality = proof::MeasureCloud(one ? cloud : part, {}, options);
    if (!quality) continue;  // no points: reported before
    Add(*quality, found);
    for (Warning& warning : quality->warnings) {
      if (!one) {
        warning.text =
            fmt::format("channel {}: {}", std::countr_zero(channel) + 1, warning.text);
      }
      found.warnings.push_back(std::move(warning));
    }
  }
  return found;
}

}  // namespace intaglio
