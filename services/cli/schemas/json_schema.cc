#include "services/cli/schemas/json_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "services/platform/fields/field_rules.h"
#include "services/platform/fields/field_text.h"

namespace intaglio::schemas {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

constexpr std::size_t kShortList = 60;  // characters

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

Json Texts(const std::vector<std::string>& texts) {
  std::vector<Json> list;
  for (const std::string& text : texts) list.push_back({text});
  return {list};
}

/// The comment of a field or a message as one paragraph.
template <typename Descriptor>
std::string CommentOf(const Descriptor& descriptor) {
  pb::SourceLocation location;
  if (!descriptor.GetSourceLocation(&location)) return "";
  const std::string& raw = location.leading_comments.empty() ? location.trailing_comments
                                                             : location.leading_comments;
  std::string text;
  for (const char c : raw) {
    const char plain = c == '\n' ? ' ' : c;
    if (plain != ' ' || (!text.empty() && text.back() != ' ')) text += plain;
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

/// "0.01..100", "default 1": what the rule of a field adds to its meaning.
std::string RuleText(const Field& field) {
  const FieldRule& rule = RuleOf(field);
  std::vector<std::string> parts;
  if (rule.has_min()) parts.push_back(RangeText(field));
  if (rule.has_default_value()) {
    parts.push_back("default " + DefaultText(field));
  } else if (rule.default_field() == "min_spacing_mm") {
    parts.push_back("default: the minimum spacing");
  } else if (!rule.default_field().empty()) {
    parts.push_back(
        fmt::format("default: {} times {}", rule.default_ratio(), rule.default_field()));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// The meaning of a field, by its comment or its rule, with its range and default.
std::string DescriptionOf(const Field& field) {
  const std::string& meaning = RuleOf(field).meaning();
  const std::string comment = meaning.empty() ? CommentOf(field) : meaning;
  const std::string rule = RuleText(field);
  if (comment.empty() || rule.empty()) return comment + rule;
  return comment + (comment.back() == '.' ? " " : ", ") + rule;
}

/// Where the definition of a message is.
Json::Members Reference(const pb::Descriptor& message) {
  return {{"$ref", {"#/$defs/" + message.name()}}};
}

Json::Members Number(const Field& field) {
  switch (field.cpp_type()) {
    case Field::CPPTYPE_INT32:
      return {{"type", {"integer"}},
              {"minimum", {-2147483648.0}},
              {"maximum", {2147483647.0}}};
    case Field::CPPTYPE_UINT32:
      return {{"type", {"integer"}}, {"minimum", {0.0}}, {"maximum", {4294967295.0}}};
    case Field::CPPTYPE_INT64:
      return {{"type", {"string"}}, {"pattern", {"^-?[0-9]+$"}}};
    case Field::CPPTYPE_UINT64:
      return {{"type", {"string"}}, {"pattern", {"^[0-9]+$"}}};
    default:
      // Numbers that JSON does not have are texts.
      return {{"oneOf",
               {std::vector<Json>{
                   {Json::Members{{"type", {"number"}}}},
                   {Json::Members{{"enum", Texts({"NaN", "Infinity", "-Infinity"})}}}}}}};
  }
}

/// One value of the field.
Json::Members ValueOf(const Field& field) {
  switch (field.cpp_type()) {
    case Field::CPPTYPE_BOOL:
      return {{"type", {"boolean"}}};
    case Field::CPPTYPE_STRING: {
      Json::Members text = {{"type", {"string"}}};
      if (field.type() == Field::TYPE_BYTES)
        text.push_back({"contentEncoding", {"base64"}});
      return text;
    }
    case Field::CPPTYPE_ENUM: {
      std::vector<std::string> names;
      for (int i = 0; i < field.enum_type()->value_count(); ++i) {
        names.push_back(field.enum_type()->value(i)->name());
      }
      return {{"enum", Texts(names)}};
    }
    case Field::CPPTYPE_MESSAGE:
      if (field.message_type()->full_name() == "google.protobuf.Value") return {};
      return Reference(*field.message_type());
    default:
      return Number(field);
  }
}

Json::Members FieldSchema(const Field& field) {
  Json::Members schema;
  if (field.is_map()) {
    schema = {{"type", {"object"}},
              {"additionalProperties", {ValueOf(*field.message_type()->field(1))}}};
  } else if (field.is_repeated()) {
    schema = {{"type", {"array"}}, {"items", {ValueOf(field)}}};
  } else {
    schema = ValueOf(field);
  }
  if (const std::string text = DescriptionOf(field); !text.empty()) {
    schema.insert(schema.begin(), {"description", {text}});
  }
  return schema;
}

/// Whether JsonTextOf writes the field also when it has no value.
bool IsAlwaysWritten(const Field& field) {
  return field.is_repeated() || !field.has_presence();
}

Json::Members MessageSchema(const pb::Descriptor& message, Fields fields) {
  Json::Members properties;
  std::vector<std::string> required;
  for (int i = 0; i < message.field_count(); ++i) {
    const Field& field = *message.field(i);
    properties.push_back({field.name(), {FieldSchema(field)}});
    if (fields == Fields::kWritten && IsAlwaysWritten(field)) {
      required.push_back(field.name());
    }
  }
  Json::Members schema = {{"type", {"object"}}, {"properties", {properties}}};
  if (const std::string comment = CommentOf(message); !comment.empty()) {
    schema.insert(schema.begin(), {"description", {comment}});
  }
  if (!required.empty()) schema.push_back({"required", Texts(required)});
  return schema;
}

/// The messages below it, by name; not the message itself unless it nests.
void CollectBelow(const pb::Descriptor& message,
                  std::map<std::string, const pb::Descriptor*>& found) {
  for (int i = 0; i < message.field_count(); ++i) {
    const Field* field = message.field(i);
    if (field->is_map()) field = field->message_type()->field(1);
    const pb::Descriptor* below = field->message_type();
    if (below == nullptr || below->full_name() == "google.protobuf.Value") continue;
    if (found.emplace(below->name(), below).second) CollectBelow(*below, found);
  }
}

Json::Members Head(const std::string& name, const std::string& title) {
  return {{"$schema", {"https://json-schema.org/draft/2020-12/schema"}},
          {"$id", {name + ".schema.json"}},
          {"title", {title}}};
}

void AddDefinitions(const std::map<std::string, const pb::Descriptor*>& messages,
                    Fields fields, Json::Members& schema) {
  if (messages.empty()) return;
  Json::Members definitions;
  for (const auto& [name, message] : messages) {
    definitions.push_back({name, {MessageSchema(*message, fields)}});
  }
  schema.push_back({"$defs", {definitions}});
}

}  // namespace

std::string Json::Text(int level) const {
  const std::string indent(static_cast<std::size_t>(level) * 2 + 2, ' ');
  const std::string close = "\n" + indent.substr(2);
  if (const auto* yes = std::get_if<bool>(&held)) return *yes ? "true" : "false";
  if (const auto* number = std::get_if<double>(&held))
    return fmt::format("{:.0f}", *number);
  if (const auto* text = std::get_if<std::string>(&held)) return Quoted(*text);
  std::string lines, line;
  if (const auto* list = std::get_if<std::vector<Json>>(&held)) {
    for (const Json& element : *list) {
      lines += (lines.empty() ? "\n" : ",\n") + indent + element.Text(level + 1);
      line += (line.empty() ? "" : ", ") + element.Text(level + 1);
    }
    const bool is_short =
        line.size() <= kShortList && line.find('\n') == std::string::npos;
    return is_short ? "[" + line + "]" : "[" + lines + close + "]";
  }
  for (const auto& [name, member] : std::get<Members>(held)) {
    lines += (lines.empty() ? "\n" : ",\n") + indent + Quoted(name) + ": " +
             member.Text(level + 1);
  }
  return lines.empty() ? "{}" : "{" + lines + close + "}";
}

Json SchemaOf(const Schema& schema) {
  Json::Members whole = Head(schema.name, schema.title);
  for (auto& member : MessageSchema(*schema.message, schema.fields)) {
    whole.push_back(std::move(member));
  }
  std::map<std::string, const pb::Descriptor*> below;
  CollectBelow(*schema.message, below);
  AddDefinitions(below, schema.fields, whole);
  return {whole};
}

Json GlassSchema(const std::string& name, const std::string& title,
                 const pb::Descriptor& material, const pb::Descriptor& optics,
                 const pb::Descriptor* focus, bool list) {
  Json::Members members = {{"material", {Reference(material)}},
                           {"optics", {Reference(optics)}}};
  if (focus != nullptr) members.push_back({"focus", {Reference(*focus)}});
  Json::Members glass = {
      {"type", {"object"}}, {"properties", {members}}, {"required", Texts({"material"})}};
  Json::Members whole = Head(name, title);
  if (list) {
    whole.push_back({"type", {"array"}});
    whole.push_back({"items", {glass}});
  } else {
    for (auto& member : glass) whole.push_back(std::move(member));
  }
  std::map<std::string, const pb::Descriptor*> below;
  for (const pb::Descriptor* message : {&material, &optics, focus}) {
    if (message == nullptr) continue;
    below.emplace(message->name(), message);
    CollectBelow(*message, below);
  }
  AddDefinitions(below, Fields::kWritten, whole);
  return {whole};
}

}  // namespace intaglio::schemas
