#include "services/recorder/bulk_rule.h"

#include <algorithm>

#include "services/platform/bus/topics.h"

namespace intaglio::recorder {
namespace {

// With 200 points a second a batch holds less than a second of a job: every tenth still
// shows where the machine was, in a tenth of the size.
constexpr unsigned kThinOneOf = 10;

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

recording::BulkRequest RequestOf(recording::Bulk bulk) {
  const std::vector<std::string> batches = {
      bus::kPointBatch.name,         bus::kPathBatch.name,
      bus::kMarkBatch.name,          bus::kOrderedMarkBatch.name,
      bus::kMotionSegmentBatch.name, bus::kPositionReport.name};
  // A part of a model's file is of no use.
  const std::vector<std::string> files = {bus::kModelChunk.name};
  recording::BulkRequest request;
  request.bulk = bulk;
  if (bulk == recording::Bulk::kAll) return request;
  request.left_out = files;
  if (bulk == recording::Bulk::kThin) {
    request.thinned = batches;
    request.one_of = kThinOneOf;
  } else {
    request.left_out.insert(request.left_out.end(), batches.begin(), batches.end());
  }
  return request;
}

}  // namespace

BulkRule::BulkRule(recording::Bulk bulk) : request_(RequestOf(bulk)) {}

bool BulkRule::Takes(const std::string& topic) const {
  return !Contains(request_.left_out, topic);
}

bool BulkRule::Keeps(const std::string& topic, std::uint32_t channel) {
  if (!Contains(request_.thinned, topic)) return true;
  return received_[channel]++ % request_.one_of == 0;
}

}  // namespace intaglio::recorder
