#include "engrave/render/accents.h"

#include <array>
#include <string_view>

namespace intaglio::render {
namespace {

struct MarkedLetters {
  Mark mark;
  std::u32string_view letters;
  std::string_view bases;  ///< in the same order
};

constexpr std::array<MarkedLetters, 15> kMarkedLetters = {
    {{Mark::kAcute, U"ÁÉÍÓÚÝáéíóúýĆćĹĺŃńŔŕŚśŹź", "AEIOUYaeiouyCcLlNnRrSsZz"},
     {Mark::kGrave, U"ÀÈÌÒÙàèìòù", "AEIOUaeiou"},
     {Mark::kCircumflex, U"ÂÊÎÔÛâêîôûĈĉĜĝĤĥĴĵŜŝŴŵŶŷ", "AEIOUaeiouCcGgHhJjSsWwYy"},
     {Mark::kCaron, U"ČčĎďĚěŇňŘřŠšŤťŽžĽľ", "CcDdEeNnRrSsTtZzLl"},
     {Mark::kDiaeresis, U"ÄËÏÖÜŸäëïöüÿ", "AEIOUYaeiouy"},
     {Mark::kTilde, U"ÃÑÕãñõĨĩŨũ", "ANOanoIiUu"},
     {Mark::kRing, U"ÅåŮů", "AaUu"},
     {Mark::kBreve, U"ĂăĔĕĞğĬĭŎŏŬŭ", "AaEeGgIiOoUu"},
     {Mark::kMacron, U"ĀāĒēĪīŌōŪū", "AaEeIiOoUu"},
     {Mark::kDot, U"ĊċĖėĠġİŻż", "CcEeGgIZz"},
     {Mark::kDoubleAcute, U"ŐőŰű", "OoUu"},
     {Mark::kCedilla, U"ÇçŞşŢţĢĶķĻļŅņ", "CcSsTtGKkLlNn"},
     {Mark::kOgonek, U"ĄąĘęĮįŲų", "AaEeIiUu"},
     {Mark::kSlash, U"ØøŁł", "OoLl"},
     {Mark::kBar, U"ĐđĦħ", "DdHh"}}};

}  // namespace

std::optional<AccentedLetter> SplitAccent(char32_t sign) {
  for (const MarkedLetters& row : kMarkedLetters) {
    const auto at = row.letters.find(sign);
    if (at != std::u32string_view::npos) return AccentedLetter{row.bases[at], row.mark};
  }
  return std::nullopt;
}

std::vector<std::vector<Vec2>> StrokesOfMark(Mark mark, double width, double height) {
  const double x = 0.5 * width;
  const double y = height + 1.4;
  const auto dot = [&](double dx) {
    return std::vector<Vec2>{{x + dx, y + 0.6}, {x + dx, y + 0.6}};
  };
  switch (mark) {
    case Mark::kAcute:
      return {{{x - 0.5, y}, {x + 0.9, y + 1.8}}};
    case Mark::kGrave:
      return {{{x + 0.5, y}, {x - 0.9, y + 1.8}}};
    case Mark::kCircumflex:
      return {{{x - 1.5, y}, {x, y + 1.8}, {x + 1.5, y}}};
    case Mark::kCaron:
      return {{{x - 1.5, y + 1.8}, {x, y}, {x + 1.5, y + 1.8}}};
    case Mark::kDiaeresis:
      return {dot(-1.3), dot(1.3)};
    case Mark::kTilde:
      return {{{x - 1.7, y + 0.3},
               {x - 1.0, y + 1.2},
               {x - 0.3, y + 1.1},
               {x + 0.4, y + 0.5},
               {x + 1.1, y + 0.4},
               {x + 1.7, y + 1.3}}};
    case Mark::kRing:
      return {{{x - 0.5, y - 0.5},
               {x + 0.5, y - 0.5},
               {x + 1.0, y + 0.4},
               {x + 0.5, y + 1.3},
               {x - 0.5, y + 1.3},
               {x - 1.0, y + 0.4},
               {x - 0.5, y - 0.5}}};
    case Mark::kBreve:
      return {{{x - 1.5, y + 1.5},
               {x - 0.8, y + 0.4},
               {x, y + 0.2},
               {x + 0.8, y + 0.4},
               {x + 1.5, y + 1.5}}};
    case Mark::kMacron:
      return {{{x - 1.6, y + 0.7}, {x + 1.6, y + 0.7}}};
    case Mark::kDot:
      return {dot(0.0)};
    case Mark::kDoubleAcute:
      return {{{x - 1.4, y}, {x - 0.5, y + 1.8}}, {{x + 0.4, y}, {x + 1.3, y + 1.8}}};
    case Mark::kCedilla:
      return {{{x, 0.0}, {x + 0.7, -1.0}, {x + 0.5, -2.0}, {x - 0.8, -2.1}}};
    case Mark::kOgonek:
      return {
          {{width, 0.0}, {width - 0.9, -1.0}, {width - 0.6, -2.0}, {width + 0.3, -2.0}}};
    case Mark::kSlash:
      return {{{x - 2.0, 0.5 * height - 2.2}, {x + 2.0, 0.5 * height + 2.2}}};
    case Mark::kBar:
      return {{{-0.8, 0.5 * height + 2.0}, {2.4, 0.5 * height + 2.0}}};
  }
  return {};
}

}  // namespace intaglio::render
