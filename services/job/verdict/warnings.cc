#include "services/job/verdict/warnings.h"

#include <fmt/format.h>

namespace intaglio {
namespace {

// The enumerations have the same order.
static_assert(static_cast<int>(WarningWeight::kNote) == intaglio_WEIGHT_NOTE);
static_assert(static_cast<int>(WarningWeight::kWarning) == intaglio_WEIGHT_WARNING);
static_assert(static_cast<int>(WarningWeight::kConsent) == intaglio_WEIGHT_CONSENT);

char* Borrowed(const char* text) { return const_cast<char*>(text); }

std::string_view TextOf(const char* text) {
  return text == nullptr ? std::string_view() : std::string_view(text);
}

}  // namespace

WarningRecord RecordOf(const Warning& warning) {
  WarningRecord record;
  record.set_code(WarningCodeName(warning.code));
  record.set_weight(WarningWeightName(warning.weight));
  record.set_text(warning.text);
  return record;
}

Warning WarningOf(const WarningRecord& record) {
  return {WarningCodeOf(record.code()), WarningWeightOf(record.weight()), record.text()};
}

WarningRecords RecordsOf(const Warnings& warnings) {
  WarningRecords records;
  AddTo(records, warnings);
  return records;
}

Warnings WarningsOf(const WarningRecords& records) {
  Warnings warnings;
  for (const WarningRecord& record : records) warnings.push_back(WarningOf(record));
  return warnings;
}

void AddTo(WarningRecords& records, const Warnings& warnings) {
  for (const Warning& warning : warnings) *records.Add() = RecordOf(warning);
}

std::vector<intaglio_JobWarning> SamplesOf(const Warnings& warnings) {
  std::vector<intaglio_JobWarning> samples;
  for (const Warning& warning : warnings) {
    samples.push_back({Borrowed(WarningCodeName(warning.code)),
                       static_cast<intaglio_WarningWeight>(warning.weight),
                       Borrowed(warning.text.c_str())});
  }
  return samples;
}

Warning WarningOf(const intaglio_JobWarning& sample) {
  return {WarningCodeOf(TextOf(sample.code)), static_cast<WarningWeight>(sample.weight),
          std::string(TextOf(sample.text))};
}

std::string BytesOf(const Warnings& warnings) {
  WarningList list;
  AddTo(*list.mutable_warnings(), warnings);
  return list.SerializeAsString();
}

Warnings WarningsOfBytes(std::string_view bytes) {
  WarningList list;
  if (!list.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
  return WarningsOf(list.warnings());
}

std::string AcceptOption(const Warning& warning) {
  return fmt::format("--accept {}", WarningCodeName(warning.code));
}

}  // namespace intaglio
