#include "services/platform/bus/type_recipe.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <deque>
#include <span>
#include <vector>

namespace intaglio::bus {
namespace {

constexpr char kLibrary[] = "cyclonedds 0.10";

std::string Hex(const void* bytes, std::size_t size) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * size);
  for (const std::uint8_t byte :
       std::span(static_cast<const std::uint8_t*>(bytes), size)) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

template <typename T>
bool ReadNumber(std::string_view text, T& value) {
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool ReadHex(std::string_view text, std::vector<std::uint8_t>& bytes) {
  if (text.size() % 2 != 0) return false;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    std::uint8_t byte = 0;
    const auto [end, error] =
        std::from_chars(text.data() + i, text.data() + i + 2, byte, 16);
    if (error != std::errc() || end != text.data() + i + 2) return false;
    bytes.push_back(byte);
  }
  return true;
}

}  // namespace

namespace internal {

TypeRecipe RecipeOf(const dds_topic_descriptor& d) {
  std::string keys;
  for (std::uint32_t i = 0; i < d.m_nkeys; ++i) {
    keys += fmt::format("{} {} {};", d.m_keys[i].m_name, d.m_keys[i].m_offset,
                        d.m_keys[i].m_idx);
  }
  const std::uint32_t words = dds_stream_countops(d.m_ops, d.m_nkeys, d.m_keys);
  return {{"library", kLibrary},
          {"name", d.m_typename},
          {"size", std::to_string(d.m_size)},
          {"align", std::to_string(d.m_align)},
          {"flags", std::to_string(d.m_flagset)},
          {"representations", std::to_string(d.restrict_data_representation)},
          {"op_count", std::to_string(d.m_nops)},
          {"ops", Hex(d.m_ops, words * sizeof(std::uint32_t))},
          {"keys", keys},
          {"type_information", Hex(d.type_information.data, d.type_information.sz)},
          {"type_mapping", Hex(d.type_mapping.data, d.type_mapping.sz)}};
}

}  // namespace internal

struct RecipeDescriptor::Parts {
  std::unique_ptr<const dds_topic_descriptor_t> descriptor;
  std::string name;
  std::deque<std::string> key_names;
  std::vector<dds_key_descriptor_t> keys;
  std::vector<std::uint32_t> ops;
  std::vector<std::uint8_t> type_information, type_mapping;

  bool ReadKeys(std::string_view text) {
    while (!text.empty()) {
      const auto end = text.find(';');
      if (end == std::string_view::npos) return false;
      const std::string_view key = text.substr(0, end);
      const auto first = key.find(' '), second = key.rfind(' ');
      std::uint32_t offset = 0, index = 0;
      if (first == std::string_view::npos || first == second ||
          !ReadNumber(key.substr(first + 1, second - first - 1), offset) ||
          !ReadNumber(key.substr(second + 1), index)) {
        return false;
      }
      key_names.emplace_back(key.substr(0, first));
      keys.push_back({key_names.back().c_str(), offset, index});
      text.remove_prefix(end + 1);
    }
    return true;
  }

  bool ReadOps(std::string_view text) {
    std::vector<std::uint8_t> bytes;
    if (!ReadHex(text, bytes) || bytes.empty() || bytes.size() % 4 != 0) return false;
    ops.resize(bytes.size() / 4);
    std::memcpy(ops.data(), bytes.data(), bytes.size());
    return true;
  }
};

RecipeDescriptor::RecipeDescriptor(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}
RecipeDescriptor::RecipeDescriptor(RecipeDescriptor&&) noexcept = default;
RecipeDescriptor& RecipeDescriptor::operator=(RecipeDescriptor&&) noexcept = default;
RecipeDescriptor::~RecipeDescriptor() = default;

const dds_topic_descriptor& RecipeDescriptor::descriptor() const {
  return *parts_->descriptor;
}

Result<RecipeDescriptor> RecipeDescriptor::Parse(const TypeRecipe& recipe) {
  const auto entry = [&](const char* name) {
    const auto found = recipe.find(name);
    return found == recipe.end() ? std::string_view() : std::string_view(found->second);
  };
  if (entry("library") != kLibrary) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the recipe of type {} was written for {}, this is {}: "
                            "record it again, or compile its IDL",
                            entry("name"), entry("library"), kLibrary),
                std::string(entry("library")));
  }
  auto parts = std::make_unique<Parts>();
  Parts& p = *parts;
  p.name = entry("name");
  std::uint32_t size = 0, align = 0, flags = 0, representations = 0, op_count = 0;
  const char* wrong = nullptr;
  const auto check = [&](const char* name, bool good) {
    if (!good && wrong == nullptr) wrong = name;
  };
  check("name", !p.name.empty());
  check("size", ReadNumber(entry("size"), size));
  check("align", ReadNumber(entry("align"), align));
  check("flags", ReadNumber(entry("flags"), flags));
  check("representations", ReadNumber(entry("representations"), representations));
  check("op_count", ReadNumber(entry("op_count"), op_count));
  check("ops", p.ReadOps(entry("ops")));
  check("keys", p.ReadKeys(entry("keys")));
  check("type_information", ReadHex(entry("type_information"), p.type_information));
  check("type_mapping", ReadHex(entry("type_mapping"), p.type_mapping));
  if (wrong != nullptr) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("the recipe of type {}: {} is missing or damaged", p.name, wrong),
        wrong);
  }
  p.descriptor.reset(new dds_topic_descriptor_t{
      size,
      align,
      flags,
      static_cast<std::uint32_t>(p.keys.size()),
      p.name.c_str(),
      p.keys.empty() ? nullptr : p.keys.data(),
      op_count,
      p.ops.data(),
      "",
      {p.type_information.data(), static_cast<std::uint32_t>(p.type_information.size())},
      {p.type_mapping.data(), static_cast<std::uint32_t>(p.type_mapping.size())},
      representations});
  return RecipeDescriptor(std::move(parts));
}

}  // namespace intaglio::bus
