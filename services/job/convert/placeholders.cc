#include "services/job/convert/placeholders.h"

#include <fmt/format.h>

namespace intaglio {
namespace {

/// The copies of a text have it without a table.
constexpr std::string_view kNumber = "n";

struct Piece {
  bool is_name = false;
  std::string_view text;  ///< with its braces
  std::string_view name() const { return text.substr(1, text.size() - 2); }
};

/// The first piece of the text, which is not empty.
Piece NextPiece(std::string_view text) {
  const auto brace = text.find_first_of("{}");
  if (brace != 0) return {false, text.substr(0, brace)};
  if (text.starts_with("{{") || text.starts_with("}}")) return {false, text.substr(0, 2)};
  const auto close = text.find('}', 1);
  const bool is_name = text.front() == '{' && close != text.npos && close > 1;
  return {is_name, text.substr(0, is_name ? close + 1 : 1)};
}

std::vector<Piece> PiecesOf(std::string_view text) {
  std::vector<Piece> pieces;
  while (!text.empty()) {
    pieces.push_back(NextPiece(text));
    text.remove_prefix(pieces.back().text.size());
  }
  return pieces;
}

void CheckField(const std::string& path, const std::string& text, bool may_be_numbered,
                Findings& findings) {
  for (const std::string& name : PlaceholdersOf(text)) {
    if (may_be_numbered && name == kNumber) continue;
    return findings.Wrong(path, fmt::format("{{{}}}", name), "{}", UnfilledText(name));
  }
}

}  // namespace

std::string FillPlaceholders(
    std::string_view text,
    const std::function<std::optional<std::string>(const std::string&)>& value) {
  std::string filled;
  for (const Piece& piece : PiecesOf(text)) {
    const auto found = piece.is_name ? value(std::string(piece.name())) : std::nullopt;
    filled += found ? *found : std::string(piece.text);
  }
  return filled;
}

std::vector<std::string> PlaceholdersOf(std::string_view text) {
  std::vector<std::string> names;
  for (const Piece& piece : PiecesOf(text)) {
    if (piece.is_name) names.emplace_back(piece.name());
  }
  return names;
}

std::string WithDoubledBraces(std::string_view value) {
  std::string doubled;
  for (const char c : value) {
    doubled += c;
    if (c == '{' || c == '}') doubled += c;
  }
  return doubled;
}

std::string WithoutBraces(std::string value) {
  std::erase_if(value, [](char c) { return c == '{' || c == '}'; });
  return value;
}

std::string NumberedText(std::string_view text, std::size_t number) {
  std::string plain;
  for (const Piece& piece : PiecesOf(text)) {
    if (piece.is_name && piece.name() == kNumber) {
      plain += std::to_string(number);
    } else {
      const bool doubled = piece.text == "{{" || piece.text == "}}";
      plain += doubled ? piece.text.substr(1) : piece.text;
    }
  }
  return plain;
}

void CheckPlaceholders(const JobSpec& job, Findings& findings) {
  CheckField("name", job.name(), false, findings);
  CheckField("glass", job.glass(), false, findings);
  for (int i = 0; i < job.models_size(); ++i) {
    CheckField(fmt::format("models[{}].text.text", i), job.models(i).text().text(), true,
               findings);
    CheckField(fmt::format("models[{}].code.text", i), job.models(i).code().text(), false,
               findings);
  }
}

std::string UnfilledText(const std::string& name) {
  return fmt::format(
      "is not filled in: submit the job with a table that has the column '{}' (--series, "
      "or a batch); in a text, {{{{ and }}}} are braces",
      name);
}

}  // namespace intaglio
