// The contents page, and that words on any page stand clear of each other and of the paper's edge.
#include "drawing/pattern_contents.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "drawing/paper.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

struct Box {
  double left_mm, top_mm, right_mm, bottom_mm;
  std::string words;
};

/// Capitals and the digits are 0.718 of the font's size high, "p" reaches 0.207 below the line (Helvetica.afm).
std::vector<Box> boxes_of(const PatternPage& page) {
  std::vector<Box> boxes;
  for (const PageItem& item : page.items) {
    const auto* text = std::get_if<PageText>(&item);
    if (text == nullptr) continue;
    const PagePoint& at = text->base_line_start;
    boxes.push_back({at.x_mm, at.y_mm - 0.718 * text->size_mm, at.x_mm + text_width_mm(text->words, text->size_mm),
                     at.y_mm + 0.207 * text->size_mm, text->words});
  }
  return boxes;
}

void expect_readable(const PatternPage& page) {
  const std::vector<Box> boxes = boxes_of(page);
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    EXPECT_GE(boxes[a].left_mm, kPrinterMargin_mm) << boxes[a].words;
    EXPECT_LE(boxes[a].right_mm, page.width_mm - kPrinterMargin_mm) << boxes[a].words;
    EXPECT_LE(boxes[a].bottom_mm, page.height_mm - kPrinterMargin_mm) << boxes[a].words;
    for (std::size_t b = 0; b < a; ++b) {
      const bool beside = boxes[a].left_mm > boxes[b].right_mm + 0.5 || boxes[b].left_mm > boxes[a].right_mm + 0.5;
      const bool below = boxes[a].top_mm > boxes[b].bottom_mm || boxes[b].top_mm > boxes[a].bottom_mm;
      EXPECT_TRUE(beside || below) << boxes[a].words << " on " << boxes[b].words;
    }
  }
}

std::vector<std::string> words_of(const PatternPage& page) {
  std::vector<std::string> words;
  for (const Box& box : boxes_of(page)) words.push_back(box.words);
  return words;
}

TEST(PatternContents, HaveALineForEachLandmarkWithThePageThatItIsOn) {
  const std::vector<ListedLandmark> list{{3, "KKGRRBGB", {{-1000.25, 20, 1200}}, -90.0},
                                         {7, "", {{1, 2, 3}}, std::nullopt},
                                         {65535, "KRGBKKRB", std::nullopt, std::nullopt}};
  const std::vector<PatternPage> pages = make_contents_pages(list, {});
  ASSERT_EQ(pages.size(), 1U);
  EXPECT_EQ(pages[0].title, "ninedot landmarks, contents, 1 of 1");
  const std::vector<std::string> words = words_of(pages[0]);
  const auto first = std::ranges::find(words, "heading");
  ASSERT_NE(first, words.end());
  EXPECT_EQ(std::vector<std::string>(first + 1, words.end()),
            (std::vector<std::string>{"2", "3", "KKGRRBGB", "-1000.2", "20.0", "1200.0", "-90.0",  //
                                      "3", "7", "black and white", "1.0", "2.0", "3.0", "tilted",  //
                                      "4", "65535", "KRGBKKRB"}));
  EXPECT_NE(std::ranges::find(words, "3 sheets: ring radius 80 mm, dots 25.4 mm, centre dot 50.8 mm in diameter"),
            words.end());
}

TEST(PatternContents, GoOnOnFurtherPagesAndCountThemselves) {
  std::vector<ListedLandmark> list(1000);
  for (std::size_t i = 0; i < list.size(); ++i) list[i].landmark_id = static_cast<int>(i) + 5000;
  const std::vector<PatternPage> pages = make_contents_pages(list, {});
  ASSERT_GT(pages.size(), 10U);
  std::size_t line = 0;
  for (const PatternPage& page : pages) {
    const std::vector<std::string> words = words_of(page);
    for (std::size_t i = 0; i + 1 < words.size(); ++i)
      if (words[i + 1] == fmt::format("{}", 5000 + line)) {
        EXPECT_EQ(words[i], fmt::format("{}", pages.size() + line + 1)) << "page of landmark " << 5000 + line;
        ++line;
      }
  }
  EXPECT_EQ(line, 1000U);
}

TEST(PatternContents, KeepTheirColumnsApartOnTheNarrowestPaper) {
  std::vector<ListedLandmark> list(1000, {65535, "", {{-1e7, -1e7, -1e7}}, -360.0});
  list[1].code = "GGGGGGGG";
  list[2].heading_deg.reset();
  for (const char* sheet : {"130x130", "letter", "a4", "a0"}) {
    PatternOptions lengths;
    lengths.sheet = sheet;
    for (const PatternPage& page : make_contents_pages(list, lengths)) expect_readable(page);
  }
}

TEST(PatternPage, KeepsItsWordsApartAndOnThePaper) {
  for (const char* sheet : {"130x185", "a5", "letter", "a4", "a3"}) {
    PatternOptions options{65535, "GGGGGGGR", 45.123, 14.123, 28.123, sheet};
    expect_readable(make_pattern_page(options));
  }
}

TEST(Paper, IsKnownByNameAndTurnedUpright) {
  const auto expect = [](const char* sheet, double width_mm, double height_mm) {
    EXPECT_EQ(parse_sheet(sheet).width_mm, width_mm) << sheet;
    EXPECT_EQ(parse_sheet(sheet).height_mm, height_mm) << sheet;
  };
  expect("a3", 297, 420);
  expect("A4", 210, 297);
  expect("Letter", 215.9, 279.4);
  expect("300x200.5", 200.5, 300);
}

TEST(TextWidth, IsThatOfHelvetica) {
  EXPECT_DOUBLE_EQ(text_width_mm("", 10), 0);
  EXPECT_DOUBLE_EQ(text_width_mm("-12.5", 1), 0.333 + 3 * 0.556 + 0.278);
  EXPECT_DOUBLE_EQ(text_width_mm("Hamburg ~", 1000), 722 + 556 + 833 + 556 + 556 + 333 + 556 + 278 + 584);
}

}  // namespace
}  // namespace ninedot
