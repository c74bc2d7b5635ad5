#pragma once

// The names of the files of a proof, in its folder.

namespace intaglio::client {

inline constexpr const char* kReportFile = "report.json";
inline constexpr const char* kViewsFile = "views.png";
inline constexpr const char* kCustomerFile = "customer.png";
/// What is known of a shop's job besides: JobStages of report.proto.
inline constexpr const char* kStagesFile = "stages.json";

}  // namespace intaglio::client
