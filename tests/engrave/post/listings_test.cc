// The programs printed in Siwiec 2016, annexes A to E, from the supplied templates.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

std::filesystem::path ListingFile(const std::string& name) {
  return std::filesystem::path(INTAGLIO_SOURCE_DIR) / "tests/data/contours" / name;
}

/// Lines with runs of blanks as one, without comments and empty lines.
std::vector<std::string> LinesOf(const std::string& text) {
  static const std::regex kBlanks("[ \t]+");
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    line = std::regex_replace(line, kBlanks, " ");
    if (!line.empty() && line[0] == ' ') line.erase(0, 1);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.pop_back();
    if (line.empty() ||
        (line[0] == ';' && !line.starts_with(";FOLD") && !line.starts_with(";ENDFOLD")))
      continue;
    lines.push_back(line);
  }
  return lines;
}

std::vector<std::string> Listing(const std::string& name) {
  return LinesOf(intaglio::test::ContentOf(ListingFile(name)));
}

std::optional<double> FieldOf(const io::CsvTable& table, const io::CsvRow& row,
                              std::string_view name) {
  const auto* text = table.Find(row, name);
  if (text == nullptr || text->empty()) return {};
  return io::ParseNumber(*text);
}

/// The short form as a controller takes it: a FOLD is a comment, behind which the move
/// that it names stands, and a name has 24 characters; the source's listing has one
/// of 25.
std::vector<std::string> CorrectedListing(const std::string& name) {
  std::vector<std::string> lines;
  for (std::string line : Listing(name)) {
    if (const auto at = line.find("Drill("); line.starts_with("DEF ") && at != line.npos)
      line.replace(at, 5, "Dril");
    if (!line.starts_with("FOLD ")) {
      lines.push_back(line);
      continue;
    }
    lines.insert(lines.end(), {";" + line, "PTP XHOME", ";ENDFOLD"});
  }
  return lines;
}

/// The annex's contours with the numbers that are printed.
std::vector<ToolPath> PathsOfAnnexB() {
  const auto table = io::ReadCsv(ListingFile("krl_mill.csv"));
  EXPECT_TRUE(table);
  std::vector<ToolPath> paths;
  for (const io::CsvRow& row : table->rows) {
    const Vec2 end(*FieldOf(*table, row, "x"), *FieldOf(*table, row, "y"));
    const std::string kind = *table->Find(row, "primitive");
    if (kind == "start") {
      paths.push_back({*table->Find(row, "contour"), end, {}});
    } else if (kind == "line") {
      paths.back().moves.push_back(LineTo(end));
    } else {
      const Vec2 middle(*FieldOf(*table, row, "ax"), *FieldOf(*table, row, "ay"));
      paths.back().moves.push_back({WorkKind::kClockwise, end, middle, {}, 1, 1});
    }
  }
  return paths;
}

TEST(Listings, AnnexBIsTheKrlProgramOfThreeContours) {
  Cutting cutting;
  cutting.name = "serwokontroler4_pcb_Mill";
  cutting.safe_mm = 5;
  const auto texts = MillPrograms(fixture::SuppliedMill("krl"), PathsOfAnnexB(), cutting);
  ASSERT_TRUE(texts) << texts.error().message;
  ASSERT_EQ(texts->size(), 1U);
  EXPECT_THAT(LinesOf(texts->front()),
              testing::ElementsAreArray(CorrectedListing("krl_mill.src")));
}

TEST(Listings, AnnexCIsTheKrlProgramOfTwentyHoles) {
  const auto table = io::ReadCsv(ListingFile("krl_drill.csv"));
  ASSERT_TRUE(table);
  DrillRound round{1.0, {}};
  for (const io::CsvRow& row : table->rows) {
    round.places_mm.emplace_back(*FieldOf(*table, row, "x"), *FieldOf(*table, row, "y"));
  }
  Cutting cutting;
  cutting.name = "serwokontroler4_pcb_Dril";
  const auto texts =
      DrillPrograms(fixture::SuppliedDrill("krl"), std::vector{round}, cutting);
  ASSERT_TRUE(texts) << texts.error().message;
  EXPECT_THAT(LinesOf(texts->front()),
              testing::ElementsAreArray(CorrectedListing("krl_drill.src")));
}

/// With the blocks that the source does not print, so that those it prints have their
/// numbers: comments in their place.
Template WithUnprinted(const std::string& kind, const std::string& at, int count) {
  std::string text = intaglio::test::ContentOf(fixture::SuppliedFile(kind, "sinumerik"));
  std::string blocks;
  for (int i = 0; i < count; ++i) blocks += "N@N@ ;unprinted\n";
  const auto add = [&](const std::string& behind, const std::string& what) {
    const auto place = text.find(behind);
    EXPECT_NE(place, std::string::npos);
    text.insert(place + behind.size(), what);
  };
  add("N@N@ SOFT\n", "N@N@ ;\nN@N@ ;\nN@N@ ;\nN@N@ ;\nN@N@ ;\n");
  if (count > 0) add(at, blocks);
  auto parsed = kind == "mill" ? ParseMillTemplate(text, "sinumerik.post")
                               : ParseDrillTemplate(text, "sinumerik.post");
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed.value_or(Template{});
}

/// Those of our lines that have the block number of a line of the listing.
std::vector<std::string> PrintedOf(const std::string& text,
                                   const std::vector<std::string>& listing) {
  const auto number_of = [](const std::string& line) {
    return line.substr(0, line.find(' '));
  };
  std::vector<std::string> printed;
  for (const std::string& line : LinesOf(text)) {
    for (const std::string& theirs : listing) {
      if (number_of(line) == number_of(theirs)) printed.push_back(line);
    }
  }
  return printed;
}

/// The contours of the annex. `unprinted` moves stand for blocks N25 - N30 and for the
/// contours in blocks N37 - N552.
std::vector<ToolPath> PathsOfAnnexD() {
  const auto table = io::ReadCsv(ListingFile("sinumerik_mill.csv"));
  EXPECT_TRUE(table);
  const WorkMove unprinted = LineTo(Vec2(9, 9));
  std::vector<ToolPath> paths;
  for (const io::CsvRow& row : table->rows) {
    const std::string block = *table->Find(row, "block");
    if (block == "N553") {
      // An approach and a retract are three blocks.
      paths.push_back({"unprinted", Vec2(9, 9), {}});
      paths.back().moves.assign(552 - 37 + 1 - 3, unprinted);
    }
    const auto x = FieldOf(*table, row, "x"), y = FieldOf(*table, row, "y");
    if (!x) continue;
    const Vec2 end(*x, *y);
    if (FieldOf(*table, row, "z")) {
      paths.push_back({block, end, {}});
      continue;
    }
    auto& moves = paths.back().moves;
    if (block == "N31") moves.insert(moves.end(), 6, unprinted);
    if (*table->Find(row, "code") == "G1") {
      moves.push_back(LineTo(end));
    } else {
      const Vec2 center(*FieldOf(*table, row, "i"), *FieldOf(*table, row, "j"));
      moves.push_back({WorkKind::kClockwise, end, {}, center, center.norm(), 1});
    }
  }
  return paths;
}

TEST(Listings, AnnexDIsTheSinumerikProgramOfItsContours) {
  Cutting cutting;
  cutting.speed_mm_s = 500.0 / 60;
  MillOptions options;
  options.axis_speed_deg_s = 1e5;
  const auto texts =
      MillPrograms(WithUnprinted("mill", "", 0), PathsOfAnnexD(), cutting, options);
  ASSERT_TRUE(texts) << texts.error().message;
  const auto listing = Listing("sinumerik_mill.mpf");
  EXPECT_EQ(listing.size(), 40U);
  EXPECT_THAT(PrintedOf(texts->front(), listing), testing::ElementsAreArray(listing));
}

TEST(Listings, AnnexEIsTheSinumerikProgramOfItsHole) {
  // The hole is blocks N14 - N16, 311 blocks behind it are not printed: 103 holes, and
  // two that no hole explains.
  DrillRound round{0.8, {{7.495, 4.6625}}};
  round.places_mm.insert(round.places_mm.end(), 103, Vec2(1, 1));
  Cutting cutting;
  cutting.plunge_mm_s = 500.0 / 60;
  cutting.depths_mm = {-3};
  const auto texts = DrillPrograms(WithUnprinted("drill", "#fragment end\n", 2),
                                   std::vector{round}, cutting);
  ASSERT_TRUE(texts) << texts.error().message;
  const auto listing = Listing("sinumerik_drill.mpf");
  EXPECT_EQ(listing.size(), 18U);
  EXPECT_THAT(PrintedOf(texts->front(), listing), testing::ElementsAreArray(listing));
}

TEST(Listings, AnnexAIsASubprogramOfTheFullForm) {
  Cutting cutting;
  const auto texts =
      MillPrograms(fixture::SuppliedMill("krl-full"), PathsOfAnnexB(), cutting);
  ASSERT_TRUE(texts) << texts.error().message;
  auto listing = Listing("krl_flin_full.src");
  // Attributes of the file; the last is a folder of that robot.
  const std::vector<std::string> head(listing.begin(), listing.begin() + 4);
  listing.erase(listing.begin(), listing.begin() + 5);
  ASSERT_EQ(listing.front(), "DEF FLin( DestPoint:in )");
  const auto lines = LinesOf(texts->front());
  EXPECT_TRUE(std::equal(head.begin(), head.end(), lines.begin()));
  EXPECT_NE(std::search(lines.begin(), lines.end(), listing.begin(), listing.end()),
            lines.end());
  EXPECT_THAT(texts->front(), testing::HasSubstr("Vel=0.005 m/s"));
}

}  // namespace
}  // namespace intaglio::post
