#pragma once

// Warnings (engrave/core/warning.h) as messages, and back. The one place of this.

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/warning.h"
#include "idl/job.h"
#include "proto/warning.pb.h"

namespace intaglio {

using WarningRecords = google::protobuf::RepeatedPtrField<WarningRecord>;

WarningRecord RecordOf(const Warning& warning);
Warning WarningOf(const WarningRecord& record);

WarningRecords RecordsOf(const Warnings& warnings);
Warnings WarningsOf(const WarningRecords& records);
/// Behind what `records` has.
void AddTo(WarningRecords& records, const Warnings& warnings);

/// A sample only borrows the texts: `warnings` has to live until it is written.
std::vector<intaglio_JobWarning> SamplesOf(const Warnings& warnings);
Warning WarningOf(const intaglio_JobWarning& sample);

/// As a blob of a database; of one that is not readable: none.
std::string BytesOf(const Warnings& warnings);
Warnings WarningsOfBytes(std::string_view bytes);

/// What has to be typed to accept a warning of the weight kConsent: "--accept breakage".
std::string AcceptOption(const Warning& warning);

}  // namespace intaglio
