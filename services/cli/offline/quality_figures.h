#pragma once

// The figures of a cloud, for people, for programs and for spreadsheets.

#include <string>

#include "engrave/proof/cloud_quality.h"
#include "proto/quality.pb.h"

namespace intaglio::cli {

/// What was measured by which options.
CloudQuality RecordOf(const proof::CloudQuality& quality,
                      const proof::QualityOptions& options);

/// An aligned block, a line a subject, and a line a warning.
std::string FiguresOf(const CloudQuality& quality);
std::string JsonOf(const CloudQuality& quality);
/// "figure,value", a row a figure, without the histogram and the warnings.
std::string CsvOf(const CloudQuality& quality);

/// "(1.23, 4.56, 7.89) mm".
std::string PlaceText(const Vector3& place_mm);

}  // namespace intaglio::cli
