#include "services/platform/recording/cdr_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace intaglio::recording {
namespace {

/// What is not understood; caught in DecodeCdr.
struct Stop {
  ErrorCode code;
  std::string why;
};

constexpr std::size_t kHeaderSize = 4;
constexpr int kMaxDepth = 32;  // of types in each other

class Decoder {
 public:
  Decoder(const IdlTypes& types, ByteView payload) : types_(types) {
    if (payload.size() < kHeaderSize) throw Stop{ErrorCode::kUnreadable, "no header"};
    const auto encoding = static_cast<unsigned>(payload[1]);
    swap_ = (encoding & 1) == 0;
    // 0, 1: CDR; 6, 7: plain CDR2; 8, 9: delimited CDR2.
    second_ = encoding >= 6 && encoding <= 9;
    if (payload[0] != std::byte{} || !(encoding <= 1 || second_)) {
      throw Stop{ErrorCode::kUnsupported, fmt::format("encoding {}", encoding)};
    }
    bytes_ = payload.subspan(kHeaderSize);
  }

  Value Struct(const std::string& name) {
    const auto found = types_.structs.find(name);
    if (found == types_.structs.end()) {
      throw Stop{ErrorCode::kUnsupported, "type " + name + " is not in the schema"};
    }
    if (++depth_ > kMaxDepth) throw Stop{ErrorCode::kUnsupported, "nested too deep"};
    // Structs without bytes would let a short schema make millions of an empty message.
    if (++struct_count_ > kMaxDepth * (bytes_.size() + 1))
      throw Stop{ErrorCode::kUnreadable, "more parts than the message has bytes for"};
    if (found->second.appendable && second_) (void)Number<std::uint32_t>();
    ValueObject object;
    object.reserve(found->second.members.size());
    for (const IdlMember& member : found->second.members) {
      object.push_back({member.name, Member(member)});
    }
    --depth_;
    return {std::move(object)};
  }

 private:
  template <typename T>
  T Number() {
    const std::size_t alignment = std::min<std::size_t>(sizeof(T), second_ ? 4 : 8);
    at_ += (alignment - at_ % alignment) % alignment;
    if (at_ > bytes_.size() || bytes_.size() - at_ < sizeof(T)) {
      throw Stop{ErrorCode::kUnreadable, "the message ends too early"};
    }
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + at_, raw.size());
    at_ += raw.size();
    if (swap_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), raw.size());
    return value;
  }

  std::string Text() {
    const auto length = Number<std::uint32_t>();
    if (length > bytes_.size() - at_) {
      throw Stop{ErrorCode::kUnreadable, "a text is longer than the message"};
    }
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_), length);
    at_ += length;
    if (!text.empty() && text.back() == '\0') text.pop_back();
    return text;
  }

  Value Member(const IdlMember& member) {
    if (member.optional) {
      if (!second_) throw Stop{ErrorCode::kUnsupported, "an optional member in CDR"};
      if (Number<std::uint8_t>() == 0) return {};
    }
    const bool delimited = second_ && (member.sequence || !member.dimensions.empty()) &&
                           member.kind >= IdlKind::kString;
    if (delimited) (void)Number<std::uint32_t>();
    if (!member.dimensions.empty()) {
      std::uint64_t count = 1;
      for (const std::uint32_t size : member.dimensions) {
        count *= size;
        if (count > bytes_.size()) {
          throw Stop{ErrorCode::kUnreadable, "an array is longer than the message"};
        }
      }
      if (member.sequence) throw Stop{ErrorCode::kUnsupported, "an array of sequences"};
      return List(member, static_cast<std::uint32_t>(count));
    }
    return member.sequence ? List(member, Number<std::uint32_t>()) : One(member);
  }

  template <typename Stored, typename Kept>
  Value Numbers(std::uint32_t count) {
    if (count > (bytes_.size() - at_) / sizeof(Stored)) {
      throw Stop{ErrorCode::kUnreadable, "a sequence is longer than the message"};
    }
    std::vector<Kept> numbers(count);
    for (Kept& number : numbers) number = static_cast<Kept>(Number<Stored>());
    return {std::move(numbers)};
  }

  Value List(const IdlMember& member, std::uint32_t count) {
    switch (member.kind) {
      case IdlKind::kBoolean:
      case IdlKind::kOctet:
      case IdlKind::kUint8:
        return Numbers<std::uint8_t, std::uint64_t>(count);
      case IdlKind::kInt8:
        return Numbers<std::int8_t, std::int64_t>(count);
      case IdlKind::kInt16:
        return Numbers<std::int16_t, std::int64_t>(count);
      case IdlKind::kUint16:
        return Numbers<std::uint16_t, std::uint64_t>(count);
      case IdlKind::kInt32:
        return Numbers<std::int32_t, std::int64_t>(count);
      case IdlKind::kUint32:
        return Numbers<std::uint32_t, std::uint64_t>(count);
      case IdlKind::kInt64:
        return Numbers<std::int64_t, std::int64_t>(count);
      case IdlKind::kUint64:
        return Numbers<std::uint64_t, std::uint64_t>(count);
      case IdlKind::kFloat:
        return Numbers<float, double>(count);
      case IdlKind::kDouble:
        return Numbers<double, double>(count);
      default:
        break;
    }
    if (count > bytes_.size() - at_) {
      throw Stop{ErrorCode::kUnreadable, "a sequence is longer than the message"};
    }
    ValueList list;
    for (std::uint32_t i = 0; i < count; ++i) list.push_back(One(member));
    return {std::move(list)};
  }

  Value One(const IdlMember& member) {
    switch (member.kind) {
      case IdlKind::kBoolean:
        return {Number<std::uint8_t>() != 0};
      case IdlKind::kOctet:
      case IdlKind::kUint8:
        return {std::uint64_t{Number<std::uint8_t>()}};
      case IdlKind::kInt8:
        return {std::int64_t{Number<std::int8_t>()}};
      case IdlKind::kInt16:
        return {std::int64_t{Number<std::int16_t>()}};
      case IdlKind::kUint16:
        return {std::uint64_t{Number<std::uint16_t>()}};
      case IdlKind::kInt32:
        return {std::int64_t{Number<std::int32_t>()}};
      case IdlKind::kUint32:
        return {std::uint64_t{Number<std::uint32_t>()}};
      case IdlKind::kInt64:
        return {Number<std::int64_t>()};
      case IdlKind::kUint64:
        return {Number<std::uint64_t>()};
      case IdlKind::kFloat:
        return {double{Number<float>()}};
      case IdlKind::kDouble:
        return {Number<double>()};
      case IdlKind::kChar:
        return {std::string(1, Number<char>())};
      case IdlKind::kString:
        return {Text()};
      case IdlKind::kEnum:
        return Enum(types_.enums.at(member.type));
      case IdlKind::kStruct:
        return Struct(member.type);
    }
    return {};
  }

  Value Enum(const IdlEnum& type) {
    const std::int64_t number = type.bit_bound <= 8    ? Number<std::int8_t>()
                                : type.bit_bound <= 16 ? Number<std::int16_t>()
                                                       : Number<std::int32_t>();
    const auto name = type.names.find(number);
    if (name == type.names.end()) return {number};
    return {name->second};
  }

  const IdlTypes& types_;
  ByteView bytes_;
  std::size_t at_ = 0;
  bool swap_ = false, second_ = false;
  int depth_ = 0;
  std::size_t struct_count_ = 0;
};

void PutJsonText(std::string& out, const std::string& text) {
  out += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  out += '"';
}

void PutJson(std::string& out, const Value& value);

/// JSON cannot express numbers that are not finite.
void PutJson(std::string& out, double number) {
  if (std::isfinite(number)) {
    out += fmt::format("{}", number);
  } else {
    out += "null";
  }
}
void PutJson(std::string& out, std::int64_t number) { out += std::to_string(number); }
void PutJson(std::string& out, std::uint64_t number) { out += std::to_string(number); }

template <typename List>
void PutJsonList(std::string& out, const List& list) {
  out += '[';
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) out += ',';
    PutJson(out, list[i]);
  }
  out += ']';
}

void PutJson(std::string& out, const Value& value) {
  std::visit(
      [&out](const auto& held) {
        using T = std::remove_cvref_t<decltype(held)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          out += "null";
        } else if constexpr (std::is_same_v<T, bool>) {
          out += held ? "true" : "false";
        } else if constexpr (std::is_same_v<T, std::string>) {
          PutJsonText(out, held);
        } else if constexpr (std::is_arithmetic_v<T>) {
          PutJson(out, held);
        } else if constexpr (std::is_same_v<T, ValueObject>) {
          out += '{';
          for (std::size_t i = 0; i < held.size(); ++i) {
            if (i > 0) out += ',';
            PutJsonText(out, held[i].name);
            out += ':';
            PutJson(out, held[i].value);
          }
          out += '}';
        } else {
          PutJsonList(out, held);
        }
      },
      value.held);
}

}  // namespace

const Value* Value::Find(const std::string& name) const {
  const auto* object = As<ValueObject>();
  if (object == nullptr) return nullptr;
  for (const auto& [member, value] : *object) {
    if (member == name) return &value;
  }
  return nullptr;
}

Result<Value> DecodeCdr(const IdlTypes& types, const std::string& type,
                        ByteView payload) {
  try {
    return Decoder(types, payload).Struct(type);
  } catch (const Stop& stop) {
    return Fail(stop.code, fmt::format("a message of {}: {}", type, stop.why), stop.why);
  }
}

std::string JsonOf(const Value& value) {
  std::string text;
  PutJson(text, value);
  return text;
}

}  // namespace intaglio::recording
