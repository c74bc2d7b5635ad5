#include "services/history/message_csv.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <string_view>

#include "engrave/io/csv.h"
#include "proto/warning.pb.h"

namespace intaglio::history {
namespace {

namespace pb = google::protobuf;

std::string TextField(const std::string& text) {
  constexpr std::string_view kBeginsFormulas = "=+-@\t\r";
  const bool is_formula =
      !text.empty() && kBeginsFormulas.find(text.front()) != std::string_view::npos;
  return io::CsvField(is_formula ? "'" + text : text);
}

/// The sentences of a list of warnings, in one field.
std::string WarningTexts(const pb::Message& message, const pb::FieldDescriptor& field) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::string texts;
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
    const pb::Message& element = reflection.GetRepeatedMessage(message, &field, i);
    texts += (i == 0 ? "" : "; ") + static_cast<const WarningRecord&>(element).text();
  }
  return TextField(texts);
}

std::string FieldText(const pb::Message& message, const pb::FieldDescriptor& field) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (field.is_repeated()) {
    const bool warnings = field.message_type() == WarningRecord::descriptor();
    return warnings ? WarningTexts(message, field) : std::string();
  }
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return TextField(reflection.GetString(message, &field));
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return fmt::format("{}", reflection.GetUInt32(message, &field));
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return fmt::format("{}", reflection.GetInt32(message, &field));
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return fmt::format("{:.6g}", reflection.GetDouble(message, &field));
    default:
      return {};
  }
}

}  // namespace

std::string CsvHeader(const pb::Descriptor& type) {
  std::string line;
  for (int i = 0; i < type.field_count(); ++i) {
    line += (i == 0 ? "" : ",") + type.field(i)->name();
  }
  return line + "\n";
}

std::string CsvLine(const pb::Message& message) {
  const pb::Descriptor& type = *message.GetDescriptor();
  std::string line;
  for (int i = 0; i < type.field_count(); ++i) {
    line += (i == 0 ? "" : ",") + FieldText(message, *type.field(i));
  }
  return line + "\n";
}

}  // namespace intaglio::history
