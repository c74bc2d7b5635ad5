// Every instruction of HP-GL (7475A, DXY) and HP-GL/2 (HP-GL/2 and HP RTL Reference
// Guide, 1997) draws, or is found by name with its effect, and what follows it is drawn
// in any case, with a semicolon between or without.

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "engrave/drawing/hpgl_read.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

struct Instruction {
  const char* name;
  const char* parameters;
};

enum class Outcome { kObeyed, kStyle, kChangesLines, kMissing };

/// Each with parameters that do not move the pen, so that one line of 10 mm follows.
const std::map<Outcome, std::vector<Instruction>> kInstructions = {
    {Outcome::kObeyed,
     {{"IN", ""},
      {"DF", ""},
      {"PU", ""},
      {"SP", "1"},
      {"PA", ""},
      {"RO", "0"},

      {"IP", ""},
      {"SC", ""}}},
    {Outcome::kStyle,
     {{"VS", "10"},
      {"FS", "3"},
      {"AS", "1"},
      {"PW", "0.10"},
      {"WU", "1"},
      {"FT", "3,10,45"},
      {"AC", "1,1"},
      {"SI", "0.2,0.3"},
      {"SR", "1,2"},
      {"DI", "1,0"},
      {"DR", "1,0"},
      {"CS", "1"},
      {"CA", "1"},
      {"SS", ""},
      {"SA", ""},
      {"SD", "1,21"},
      {"AD", "1,21"},
      {"ES", "1"},
      {"SL", "0.1"},
      {"LO", "1"},
      {"LA", "1,4,2,4"},
      {"DV", "0"},
      {"OA", ""},
      {"OE", ""},
      {"OI", ""},
      {"OS", ""},
      {"OW", ""},
      {"PG", ""},
      {"PS", "23760,33640"},
      {"NP", "256"},
      {"NR", ""},
      {"CR", "0,255,0,255,0,255"},
      {"TR", "0"},
      {"BP", "1,\"PU;PD900,900\""},
      {"CO", "\"PD9,9;\""},
      {"MC", "1,252"},
      {"EC", ""},
      {"MT", "0"},
      {"PC", "1,255,0,0"},
      {"SV", "1,50"},
      {"SB", "0"},
      {"RF", "1,2,1,1,0"},
      {"QL", "50"},
      {"CT", "1"},
      {"MG", "\"hello\""}}},
    {Outcome::kChangesLines,
     {{"IW", "0,0,9,9"},
      {"LT", "2,4"},
      {"UL", "1,2,2"},
      {"PM", "0"},
      {"SM", "P"},
      {"CP", "1,1"},
      {"PT", "0.3"},
      {"CF", "1"},
      {"RP", "2"}}},
    {Outcome::kMissing, {{"EP", ""}, {"FP", ""}, {"ZZ", "1,2"}}}};

constexpr Effect EffectOf(Outcome outcome) {
  return outcome == Outcome::kStyle          ? Effect::kNothingSeen
         : outcome == Outcome::kChangesLines ? Effect::kChanged
                                             : Effect::kLost;
}

TEST(HpglGrammar, EveryInstructionIsObeyedOrFoundAndNoneHidesTheNext) {
  for (const auto& [outcome, instructions] : kInstructions) {
    for (const auto& [name, parameters] : instructions) {
      for (const char* between : {";", "", "\n", " "}) {
        const std::string text =
            std::string("IN;SP1;") + name + parameters + between + "PU0,0PD400,0PU;";
        const auto drawing = ReadHpgl(text);
        ASSERT_TRUE(drawing) << text << ": " << drawing.error().message;
        EXPECT_EQ(drawing->curves.size(), 1U) << text;
        std::size_t found = 0;
        for (const FileFinding& finding : drawing->findings) {
          found += finding.what == name && finding.effect == EffectOf(outcome) ? 1 : 0;
        }
        EXPECT_EQ(found, outcome == Outcome::kObeyed ? 0U : 1U) << text;
        EXPECT_EQ(drawing->findings.size(), found) << text;
      }
    }
  }
}

// Drawn over the sheet before it, as if it were the same one.
TEST(HpglGrammar, ASecondSheetChangesThePieceAndAnEmptyOneDoesNot) {
  for (const char* sheet : {"PG;", "AF;", "FR;"}) {
    const std::string line = "PU0,0;PD400,0;PU;";
    const auto second = ReadHpgl("IN;SP1;" + line + sheet + line);
    ASSERT_TRUE(second && second->findings.size() == 1) << sheet;
    EXPECT_EQ(second->findings.begin()->effect, Effect::kChanged) << sheet;
    for (const std::string& text :
         {"IN;SP1;" + line + sheet, std::string("IN;SP1;") + sheet + line}) {
      const auto first = ReadHpgl(text);
      ASSERT_TRUE(first && first->findings.size() == 1) << text;
      EXPECT_EQ(first->findings.begin()->effect, Effect::kNothingSeen) << text;
    }
  }
}

// Each new sheet was looked for in the whole file: a megabyte took minutes.
TEST(HpglGrammar, AFileOfSheetsAloneIsReadInOnePass) {
  constexpr std::size_t kSheets = 300'000;
  std::string text = "IN;";
  for (std::size_t i = 0; i < kSheets; ++i) text += "PG;";
  const auto drawing = ReadHpgl(text);
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing->findings.CountOf("PG"), kSheets);
  EXPECT_TRUE(drawing->curves.empty());
}

// As plotter drivers write HP-GL/2: nothing between the instructions but polylines (PE),
// whose end alone is marked.
TEST(HpglGrammar, PolylinesBehindOtherInstructionsAreDrawn) {
  const auto drawing = ReadHpgl(
      "BPINPS23760,33640ECNP256LA1,4,2,4TR0PW0.10PC1,2,3PU400,0PE\xCF\xBF;"
      "PE<=\xBF\xBF;PW0.20PM0PEO\xC0\xBF;PM2FTFPPU");
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_GE(drawing->curves.size(), 2U);
  EXPECT_EQ(drawing->findings.CountOf("PW"), 2U);
  EXPECT_EQ(drawing->findings.CountOf("FP"), 1U);
}

}  // namespace
}  // namespace intaglio::drawing
