#include "services/job/fields/field_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/job.pb.h"
#include "services/platform/text_format/field_suggestion.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

struct Step {
  std::string_view name;
  std::optional<int> index;
};

/// The first step of a path, and what is left of it; nullopt when it is none.
std::optional<Step> TakeStep(std::string_view& path) {
  Step step;
  const auto end = std::min(path.find_first_of(".["), path.size());
  step.name = path.substr(0, end);
  path.remove_prefix(end);
  if (path.starts_with('[')) {
    int index = -1;
    const char* last = path.data() + path.size();
    const auto [read, error] = std::from_chars(path.data() + 1, last, index);
    if (error != std::errc() || read == last || *read != ']' || index < 0) return {};
    step.index = index;
    path.remove_prefix(static_cast<std::size_t>(read - path.data()) + 1);
  }
  if (!path.empty()) {
    if (!path.starts_with('.') || path.size() == 1) return {};
    path.remove_prefix(1);
  }
  return step;
}

std::string FieldNames(const pb::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::string_view> Tokens(std::string_view text) {
  constexpr std::string_view kBetween = " \t\r\n,;";
  std::vector<std::string_view> words;
  for (;;) {
    const auto begin = text.find_first_not_of(kBetween);
    if (begin == text.npos) return words;
    const auto end = std::min(text.find_first_of(kBetween, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

template <typename Number>
std::optional<Number> NumberIn(std::string_view text) {
  const auto words = Tokens(text);
  if (words.size() != 1) return {};
  Number number{};
  const char* end = words[0].data() + words[0].size();
  const auto [read, error] = std::from_chars(words[0].data(), end, number);
  if (error != std::errc() || read != end) return {};
  return number;
}

std::string Upper(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) {
    c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return upper;
}

/// AXIS_ of AXIS_X and its like: up to the last _ that all have in common.
std::string CommonBeginning(const pb::EnumDescriptor& type) {
  std::string common = type.value(0)->name();
  for (int i = 1; i < type.value_count(); ++i) {
    const std::string& name = type.value(i)->name();
    const auto differ =
        std::mismatch(common.begin(), common.end(), name.begin(), name.end());
    common.erase(differ.first, common.end());
  }
  return common.substr(0, common.rfind('_') + 1);
}

const pb::EnumValueDescriptor* EnumValue(const pb::EnumDescriptor& type,
                                         std::string_view text) {
  const std::string wanted = Upper(text);
  const std::string common = CommonBeginning(type);
  for (int i = 0; i < type.value_count(); ++i) {
    const std::string& name = type.value(i)->name();
    if (name == wanted || name == common + wanted) return type.value(i);
  }
  return nullptr;
}

/// Sets or adds one value; false when the text is none.
bool Put(pb::Message& message, const Field& field, std::string_view text) {
  const pb::Reflection& reflection = *message.GetReflection();
  const bool add = field.is_repeated();
  switch (field.cpp_type()) {
    case Field::CPPTYPE_DOUBLE: {
      const auto number = NumberIn<double>(text);
      if (number && add) reflection.AddDouble(&message, &field, *number);
      if (number && !add) reflection.SetDouble(&message, &field, *number);
      return number.has_value();
    }
    case Field::CPPTYPE_UINT32: {
      const auto number = NumberIn<std::uint32_t>(text);
      if (number && add) reflection.AddUInt32(&message, &field, *number);
      if (number && !add) reflection.SetUInt32(&message, &field, *number);
      return number.has_value();
    }
    case Field::CPPTYPE_INT32: {
      const auto number = NumberIn<std::int32_t>(text);
      if (number && !add) reflection.SetInt32(&message, &field, *number);
      return number && !add;
    }
    case Field::CPPTYPE_UINT64: {
      const auto number = NumberIn<std::uint64_t>(text);
      if (number && !add) reflection.SetUInt64(&message, &field, *number);
      return number && !add;
    }
    case Field::CPPTYPE_BOOL:
      if (add || (text != "true" && text != "false")) return false;
      reflection.SetBool(&message, &field, text == "true");
      return true;
    case Field::CPPTYPE_STRING:
      if (add) return false;
      reflection.SetString(&message, &field, std::string(text));
      return true;
    case Field::CPPTYPE_ENUM: {
      const auto* value = EnumValue(*field.enum_type(), text);
      if (value != nullptr && !add) reflection.SetEnum(&message, &field, value);
      return value != nullptr && !add;
    }
    default:
      return false;
  }
}

bool HoldsNumbersOnly(const pb::Descriptor& type) {
  for (int i = 0; i < type.field_count(); ++i) {
    if (type.field(i)->type() != Field::TYPE_DOUBLE || type.field(i)->is_repeated()) {
      return false;
    }
  }
  return true;
}

std::string Expected(const Field& field) {
  switch (field.cpp_type()) {
    case Field::CPPTYPE_DOUBLE:
      return field.is_repeated() ? "numbers" : "a number";
    case Field::CPPTYPE_UINT32:
    case Field::CPPTYPE_UINT64:
      return field.is_repeated() ? "whole numbers, 0 or more"
                                 : "a whole number, 0 or more";
    case Field::CPPTYPE_INT32:
      return "a whole number";
    case Field::CPPTYPE_BOOL:
      return "true or false";
    case Field::CPPTYPE_ENUM: {
      std::vector<std::string> names;
      for (int i = 0; i < field.enum_type()->value_count(); ++i) {
        names.push_back(field.enum_type()->value(i)->name());
      }
      return fmt::format("one of {}", fmt::join(names, ", "));
    }
    case Field::CPPTYPE_MESSAGE:
      if (field.message_type() == Vector3::descriptor()) return "three numbers";
      if (field.is_repeated() && HoldsNumbersOnly(*field.message_type())) {
        return fmt::format("numbers, {} for each place",
                           FieldNames(*field.message_type()));
      }
      if (field.is_repeated()) return "an index, as " + field.name() + "[0]";
      return fmt::format("true, or one of its fields by its path: {}",
                         FieldNames(*field.message_type()));
    default:
      return field.is_repeated() ? "texts with commas between them" : "a text";
  }
}

bool PutVector(pb::Message& message, std::string_view text) {
  const auto words = Tokens(text);
  if (words.size() != 3) return false;
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < 3; ++i) {
    if (!Put(message, *type.field(i), words[static_cast<std::size_t>(i)])) return false;
  }
  return true;
}

bool PutList(pb::Message& message, const Field& field, std::string_view text) {
  message.GetReflection()->ClearField(&message, &field);
  const auto words = Tokens(text);
  return std::all_of(words.begin(), words.end(),
                     [&](std::string_view word) { return Put(message, field, word); });
}

/// A list of groups of numbers, such as the places of a curve: one group after another.
bool PutGroups(pb::Message& message, const Field& field, std::string_view text) {
  const pb::Descriptor& type = *field.message_type();
  if (!HoldsNumbersOnly(type)) return false;
  const auto words = Tokens(text);
  const auto fields_count = static_cast<std::size_t>(type.field_count());
  if (words.size() % fields_count != 0) return false;
  message.GetReflection()->ClearField(&message, &field);
  pb::Message* group = nullptr;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto at = static_cast<int>(i % fields_count);
    if (at == 0) group = message.GetReflection()->AddMessage(&message, &field);
    if (!Put(*group, *type.field(at), words[i])) return false;
  }
  return true;
}

/// Texts have blanks in them: "Noto Sans, DejaVu Sans".
bool PutTexts(pb::Message& message, const Field& field, std::string_view text) {
  message.GetReflection()->ClearField(&message, &field);
  for (std::size_t at = 0; at <= text.size();) {
    const auto end = std::min(text.find(',', at), text.size());
    std::string_view one = text.substr(at, end - at);
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    if (one.empty()) return false;
    message.GetReflection()->AddString(&message, &field, std::string(one));
    at = end + 1;
  }
  return true;
}

bool PutAny(pb::Message& message, const Field& field, std::string_view text) {
  if (field.is_repeated() && field.cpp_type() == Field::CPPTYPE_STRING) {
    return PutTexts(message, field, text);
  }
  if (field.cpp_type() != Field::CPPTYPE_MESSAGE) {
    return field.is_repeated() ? PutList(message, field, text)
                               : Put(message, field, text);
  }
  if (field.is_repeated()) return PutGroups(message, field, text);
  pb::Message& child = *message.GetReflection()->MutableMessage(&message, &field);
  if (field.message_type() == Vector3::descriptor()) return PutVector(child, text);
  return text == "true";
}

tl::unexpected<Error> NoSuchField(std::string_view path, const pb::Descriptor& type,
                                  std::string_view name) {
  const auto meant = NearestField(type, name);
  return Fail(ErrorCode::kNotFound,
              fmt::format("{}: {} has no field '{}'{}; it has: {}", path, type.name(),
                          name, meant ? fmt::format(", did you mean {}?", *meant) : "",
                          FieldNames(type)),
              std::string(name));
}

/// The message below, by the step; null when it is not there.
pb::Message* Below(pb::Message& message, const Field& field, const Step& step) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated()) return reflection.MutableMessage(&message, &field);
  if (!step.index || *step.index >= reflection.FieldSize(message, &field)) return nullptr;
  return reflection.MutableRepeatedMessage(&message, &field, *step.index);
}

}  // namespace

bool BeginsWithField(const pb::Descriptor& type, std::string_view path) {
  const auto end = std::min(path.find_first_of(".["), path.size());
  return type.FindFieldByName(std::string(path.substr(0, end))) != nullptr;
}

Status SetField(pb::Message& message, std::string_view path, std::string_view text) {
  pb::Message* at = &message;
  for (std::string_view rest = path;;) {
    const auto step = TakeStep(rest);
    if (!step) {
      return Fail(
          ErrorCode::kNotFound,
          fmt::format(
              "{}: is not the path of a field; write it as models[0].placement.move_mm.x",
              path),
          std::string(path));
    }
    const pb::Descriptor& type = *at->GetDescriptor();
    const Field* field = type.FindFieldByName(std::string(step->name));
    if (field == nullptr) return NoSuchField(path, type, step->name);
    const bool is_message = field->cpp_type() == Field::CPPTYPE_MESSAGE;
    if (step->index && !(is_message && field->is_repeated())) {
      return Fail(ErrorCode::kNotFound,
                  fmt::format("{}: '{}' takes no index", path, step->name),
                  std::string(step->name));
    }
    if (rest.empty() && !step->index) {
      if (PutAny(*at, *field, text)) return {};
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: '{}' is not {}", path, text, Expected(*field)),
                  std::string(text));
    }
    if (!is_message) {
      return Fail(ErrorCode::kNotFound,
                  fmt::format("{}: '{}' has no fields", path, step->name),
                  std::string(step->name));
    }
    if (rest.empty()) return NoSuchField(path, *field->message_type(), "");
    pb::Message* below = Below(*at, *field, *step);
    if (below == nullptr) {
      return Fail(ErrorCode::kNotFound,
                  fmt::format("{}: the job has {} of '{}', counted from [0]", path,
                              at->GetReflection()->FieldSize(*at, field), step->name),
                  std::string(path));
    }
    at = below;
  }
}

bool IsSet(const pb::Message& message, std::string_view path) {
  const pb::Message* at = &message;
  for (std::string_view rest = path;;) {
    const auto step = TakeStep(rest);
    const Field& field = *at->GetDescriptor()->FindFieldByName(std::string(step->name));
    const pb::Reflection& reflection = *at->GetReflection();
    if (field.is_repeated()) {
      if (!step->index) return true;
      at = &reflection.GetRepeatedMessage(*at, &field, *step->index);
    } else {
      if (!field.has_presence()) return true;
      if (!reflection.HasField(*at, &field)) return false;
      if (rest.empty()) return true;
      at = &reflection.GetMessage(*at, &field);
    }
  }
}

}  // namespace intaglio
