#pragma once

// Messages as a table for spreadsheets: RFC 4180, a column for each field, a row for each
// message. Of fields that are no messages; of lists only those of warnings, as sentences.
//
// A text that a spreadsheet would take for a formula, because it begins with = + - @, a
// tab or a carriage return, gets an apostrophe before it: whoever names a job must not
// command the computer of whoever reads the table (OWASP, CSV Injection).

#include <google/protobuf/message.h>

#include <string>

namespace intaglio::history {

/// The names of the columns, one line.
std::string CsvHeader(const google::protobuf::Descriptor& type);
std::string CsvLine(const google::protobuf::Message& message);

}  // namespace intaglio::history
