#pragma once

// Messages as a table for spreadsheets: RFC 4180, a column for each field, a row for each
// message. Of fields that are no messages; of lists only those of warnings, as sentences.

#include <google/protobuf/message.h>

#include <string>

namespace intaglio::cli {

/// The names of the columns, one line.
std::string CsvHeader(const google::protobuf::Descriptor& type);
std::string CsvLine(const google::protobuf::Message& message);

}  // namespace intaglio::cli
