#include "services/platform/text_format/field_suggestion.h"

#include <fmt/format.h>

#include <regex>
#include <vector>

#include "engrave/io/nearest_name.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// The type of the message at "models[0].placement", names as in JSON or in the schema;
/// nullptr when there is none.
const pb::Descriptor* TypeAt(const pb::Descriptor& root, const std::string& path) {
  static const std::regex kStep("([A-Za-z0-9_]+)(?:\\[[0-9]+\\])?");
  const pb::Descriptor* type = &root;
  for (auto it = std::sregex_iterator(path.begin(), path.end(), kStep);
       it != std::sregex_iterator() && type != nullptr; ++it) {
    const std::string name = (*it)[1];
    const pb::FieldDescriptor* field = type->FindFieldByName(name);
    if (field == nullptr) field = type->FindFieldByCamelcaseName(name);
    type = field == nullptr ? nullptr : field->message_type();
  }
  return type;
}

std::string Sentence(const pb::Descriptor* type, const std::string& name) {
  const auto meant = type == nullptr ? std::nullopt : NearestField(*type, name);
  return meant ? fmt::format(" Did you mean {}?", *meant) : "";
}

}  // namespace

std::optional<std::string> NearestField(const pb::Descriptor& type,
                                        std::string_view name) {
  std::vector<std::string> known;
  for (int i = 0; i < type.field_count(); ++i) known.push_back(type.field(i)->name());
  return io::NearestName(std::string(name), known);
}

std::string SuggestionFor(const pb::Descriptor& root, const std::string& parser_message) {
  static const std::regex kText(
      "Message type \"([A-Za-z0-9_.]+)\" has no field named \"([A-Za-z0-9_]+)\"");
  static const std::regex kJson(
      "^(?:\\(([^)]*)\\))?:? ?([A-Za-z0-9_]+): Cannot find field");
  std::smatch found;
  if (std::regex_search(parser_message, found, kText)) {
    return Sentence(root.file()->pool()->FindMessageTypeByName(found[1]), found[2]);
  }
  if (std::regex_search(parser_message, found, kJson)) {
    return Sentence(TypeAt(root, found[1]), found[2]);
  }
  return "";
}

}  // namespace intaglio
