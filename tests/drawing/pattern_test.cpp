// The printed landmark, read back from its files and from a rasterised page (pdftoppm of poppler-utils).
#include "drawing/pattern.h"

#include "programs/commands/pattern_output.h"
#include "world/landmark_codes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "base/startup_error.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

struct Disc {
  double x_mm, y_mm, diameter_mm;
  std::string colour;
};

/// Nine discs on A4 by METHOD's definition: P1 lowest, clockwise for the viewer; the sheet starts 18 mm below the top.
std::array<Disc, 9> expected_a4_discs() {
  std::array<Disc, 9> discs;
  const double middle_x_mm = 105, middle_y_mm = 18 + 105;
  for (std::size_t i = 0; i < 8; ++i) {
    const double a_rad = static_cast<double>(i) * std::numbers::pi / 4;
    discs[i] = {middle_x_mm - 80 * std::sin(a_rad), middle_y_mm + 80 * std::cos(a_rad), 25.4, "#000000"};
  }
  discs[8] = {middle_x_mm, middle_y_mm, 50.8, "#000000"};
  return discs;
}

std::vector<Disc> discs_of_svg(const std::string& svg) {
  const std::regex circle("<circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\" r=\"([0-9.]+)\" fill=\"(#[0-9a-f]+)\"/>");
  std::vector<Disc> discs;
  for (std::sregex_iterator it(svg.begin(), svg.end(), circle), end; it != end; ++it)
    discs.push_back({std::stod((*it)[1]), std::stod((*it)[2]), 2 * std::stod((*it)[3]), (*it)[4]});
  return discs;
}

/// The discs of a PDF: every path of curves, by its bounding points on the axes; in mm from the upper left corner.
std::vector<Disc> discs_of_pdf(const std::string& pdf, double page_height_mm) {
  std::vector<Disc> discs;
  std::istringstream lines(pdf.substr(pdf.find("stream\n")));
  double left = 0, right = 0, low = 0, high = 0;
  bool in_path = false;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double x = 0, y = 0, skipped = 0;
    if (line.ends_with(" m") && words >> x >> y) {
      left = right = x, low = high = y;
      in_path = false;
    } else if (line.ends_with(" c") && words >> skipped >> skipped >> skipped >> skipped >> x >> y) {
      left = std::min(left, x), right = std::max(right, x), low = std::min(low, y), high = std::max(high, y);
      in_path = true;
    } else if (line == "f" && in_path) {
      EXPECT_NEAR(right - left, high - low, 2e-6);
      discs.push_back({(left + right) / 2, page_height_mm - (low + high) / 2, right - left, ""});
    }
  }
  return discs;
}

void expect_same_discs(const std::vector<Disc>& found) {
  const auto expected = expected_a4_discs();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found[i].x_mm, expected[i].x_mm, 2e-6) << "dot " << i + 1;
    EXPECT_NEAR(found[i].y_mm, expected[i].y_mm, 2e-6) << "dot " << i + 1;
    EXPECT_NEAR(found[i].diameter_mm, expected[i].diameter_mm, 2e-6) << "dot " << i + 1;
  }
}

/// A folder of its own that is gone afterwards.
class PatternFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("ninedot_pattern_{}", ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string contents(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  fs::path folder_;
};

template <typename Call>
std::string refusal(Call call, ExitStatus status) {
  try {
    call();
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, status) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  ADD_FAILURE() << "not refused";
  return "";
}
std::string pdf_of(const PatternPage& page) { return encode_pdf({&page, 1}); }

std::string refusal_of(const PatternOptions& options) {
  return refusal([&] { make_pattern_page(options); }, ExitStatus::kWrongUsage);
}

TEST(PatternSvg, HasNineDotsOfExactSizeAndPlace) { expect_same_discs(discs_of_svg(encode_svg(make_pattern_page({})))); }

TEST(PatternSvg, IsAsLargeAsThePaperInMillimetres) {
  const std::string svg = encode_svg(make_pattern_page({}));
  EXPECT_NE(svg.find("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""), std::string::npos);
}

TEST(PatternSvg, HasAScaleBarOfExactly100Millimetres) {
  const std::string svg = encode_svg(make_pattern_page({}));
  const std::regex line(
      "<line x1=\"([0-9.]+)\" y1=\"([0-9.]+)\" x2=\"([0-9.]+)\" y2=\"([0-9.]+)\"[^>]*stroke=\"#000000\"/>");
  int bars = 0;
  for (std::sregex_iterator it(svg.begin(), svg.end(), line), end; it != end; ++it)
    if ((*it)[2] == (*it)[4]) {
      ++bars;
      EXPECT_DOUBLE_EQ(std::stod((*it)[3]) - std::stod((*it)[1]), 100.0);
      EXPECT_GT(std::stod((*it)[2]), 18 + 210) << "outside of the white sheet";
    }
  EXPECT_EQ(bars, 1);
  EXPECT_NE(svg.find("check: this bar is 100 mm long"), std::string::npos);
}

TEST(PatternSvg, ColoursTheDotsInTheOrderOfTheCode) {
  PatternOptions options;
  options.landmark_id = 2;
  options.code = known_code(2).value();
  ASSERT_EQ(options.code, "RRGKBGKB");
  const std::string svg = encode_svg(make_pattern_page(options));
  const std::string red = "#cc0000", green = "#008000", blue = "#0000cc", black = "#000000";
  const std::array<std::string, 9> expected{red, red, green, black, blue, green, black, blue, black};
  const auto discs = discs_of_svg(svg);
  ASSERT_EQ(discs.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(discs[i].colour, expected[i]) << "dot " << i + 1;
  EXPECT_NE(svg.find("ninedot landmark 2, code RRGKBGKB"), std::string::npos);
}

TEST(PatternPdf, HasNineDotsOfExactSizeAndPlace) {
  expect_same_discs(discs_of_pdf(pdf_of(make_pattern_page({})), 297));
}

TEST(PatternPdf, HasTheMediaBoxOfThePaperInPoints) {
  const std::string pdf = pdf_of(make_pattern_page({}));
  std::smatch box;
  ASSERT_TRUE(std::regex_search(pdf, box, std::regex("/MediaBox \\[0 0 ([0-9.]+) ([0-9.]+)\\]")));
  EXPECT_NEAR(std::stod(box[1]), 210 * 72 / 25.4, 1e-6);
  EXPECT_NEAR(std::stod(box[2]), 297 * 72 / 25.4, 1e-6);
  EXPECT_NE(pdf.find("2.834645669291 0 0 2.834645669291 0 0 cm"), std::string::npos) << "points per mm";
  EXPECT_NE(pdf.find("/PrintScaling /None"), std::string::npos);
}

TEST(PatternPdf, TableOfObjectsPointsAtTheObjects) {
  const std::vector<PatternPage> pages(2, make_pattern_page({}));
  const std::string pdf = encode_pdf(pages);
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10));
  ASSERT_EQ(pdf.substr(table, 9), "xref\n0 9\n");
  for (std::size_t object = 1; object <= 8; ++object) {
    const std::size_t at = std::stoul(pdf.substr(table + 9 + 20 * object, 10));
    EXPECT_EQ(pdf.substr(at, 8), fmt::format("{} 0 obj\n", object));
  }
}

TEST_F(PatternFiles, APdfHasItsPagesInOrderEachOfItsOwnSize) {
  std::vector<PatternPage> pages;
  for (const auto& [id, sheet] : {std::pair(3, "a4"), std::pair(1, "letter"), std::pair(27, "a3")}) {
    PatternOptions options;
    options.landmark_id = id;
    options.code = known_code(id).value();
    options.sheet = sheet;
    pages.push_back(make_pattern_page(options));
  }
  write_pattern(pages, folder_ / "sheets.pdf");
  const auto told_by = [&](const std::string& command) {
    EXPECT_EQ(std::system(fmt::format("{} > '{}/told'", command, folder_.string()).c_str()), 0);
    return contents(folder_ / "told");
  };
  const std::string file = (folder_ / "sheets.pdf").string();
  const std::string sizes = told_by(fmt::format("pdfinfo -l 9 '{}'", file));
  EXPECT_TRUE(std::regex_search(sizes, std::regex("Pages: +3\n"))) << sizes;
  EXPECT_TRUE(std::regex_search(sizes, std::regex("Page +2 size: +612 x 792 pts"))) << sizes;
  EXPECT_TRUE(std::regex_search(sizes, std::regex("Page +3 size: +841.89 x 1190.55 pts"))) << sizes;
  const std::array<std::string, 3> words{"landmark 3, code KKGRRBGB", "landmark 1, code KRGBKKRB",
                                         "landmark 27, code RBGGBBGB"};
  for (std::size_t i = 0; i < words.size(); ++i)
    EXPECT_NE(told_by(fmt::format("pdftotext -f {0} -l {0} '{1}' -", i + 1, file)).find(words[i]), std::string::npos);
}

TEST_F(PatternFiles, RefusesSeveralPagesInAnSvg) {
  const std::vector<PatternPage> pages(2, make_pattern_page({}));
  const std::string line = refusal([&] { write_pattern(pages, folder_ / "sheets.svg"); }, ExitStatus::kWrongUsage);
  EXPECT_NE(line.find("write a .pdf"), std::string::npos) << line;
  EXPECT_FALSE(fs::exists(folder_ / "sheets.svg"));
}

TEST(PatternPdf, ArcsStayWithin5e6OfTheRadius) {
  PatternPage page{100, 100, "one disc", {PageDisc{{50, 50}, 80, {}}}};
  const std::string pdf = pdf_of(page);
  std::istringstream lines(pdf.substr(pdf.find(" m\n") - 20));
  std::array<double, 8> p{90, 50};  // start, two control points, end
  int arcs = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.ends_with(" c")) continue;
    std::istringstream words(line);
    for (std::size_t i = 2; i < 8; ++i) words >> p[i];
    for (double t = 0; t <= 1; t += 0.05) {
      const double s = 1 - t, b0 = s * s * s, b1 = 3 * s * s * t, b2 = 3 * s * t * t, b3 = t * t * t;
      const double x = b0 * p[0] + b1 * p[2] + b2 * p[4] + b3 * p[6], y = b0 * p[1] + b1 * p[3] + b2 * p[5] + b3 * p[7];
      EXPECT_NEAR(std::hypot(x - 50, y - 50), 40, 40 * 5e-6);
    }
    p[0] = p[6], p[1] = p[7];
    ++arcs;
  }
  EXPECT_EQ(arcs, 8);
}

/// An 8-bit PGM picture and what is measured in it.
class GreyPage {
 public:
  explicit GreyPage(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string magic;
    int most = 0;
    file >> magic >> width >> height >> most;
    file.get();
    if (magic != "P5" || most != 255) return;
    pixels_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    file.read(pixels_.data(), static_cast<std::streamsize>(pixels_.size()));
    whole = file.gcount() == static_cast<std::streamsize>(pixels_.size());
  }
  /// 0 = paper, 1 = ink
  double ink(int x, int y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return 0;
    const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return 1 - static_cast<unsigned char>(pixels_[at]) / 255.0;
  }
  int width = 0, height = 0;
  bool whole = false;

 private:
  std::vector<char> pixels_;
};

TEST_F(PatternFiles, RasterisedPdfHasDotsAndScaleBarWithin0p05Millimetres) {
  write_pattern(std::vector{make_pattern_page({})}, folder_ / "sheet.pdf");
  const std::string command =
      fmt::format("pdftoppm -r 300 -gray -singlefile '{0}/sheet.pdf' '{0}/sheet'", folder_.string());
  ASSERT_EQ(std::system(command.c_str()), 0) << "pdftoppm is of the package poppler-utils";
  const GreyPage page(folder_ / "sheet.pgm");
  ASSERT_TRUE(page.whole);
  constexpr double kPxPerMm = 300 / 25.4;

  for (const Disc& disc : expected_a4_discs()) {
    const double half_mm = disc.diameter_mm / 2 + 2;
    double area = 0, x_sum = 0, y_sum = 0;
    for (int y = static_cast<int>((disc.y_mm - half_mm) * kPxPerMm); y < (disc.y_mm + half_mm) * kPxPerMm; ++y)
      for (int x = static_cast<int>((disc.x_mm - half_mm) * kPxPerMm); x < (disc.x_mm + half_mm) * kPxPerMm; ++x) {
        const double ink = page.ink(x, y);
        area += ink, x_sum += ink * (x + 0.5), y_sum += ink * (y + 0.5);
      }
    ASSERT_GT(area, 0);
    EXPECT_NEAR(x_sum / area / kPxPerMm, disc.x_mm, 0.05);
    EXPECT_NEAR(y_sum / area / kPxPerMm, disc.y_mm, 0.05);
    EXPECT_NEAR(2 * std::sqrt(area / std::numbers::pi) / kPxPerMm, disc.diameter_mm, 0.05);
  }

  // Only the bar's two end ticks reach 5 mm above it.
  const int row = static_cast<int>((18 + 210 + 12 - 5) * kPxPerMm);
  double sums[2] = {0, 0}, inks[2] = {0, 0};
  for (int x = 0; x < page.width; ++x) {
    const auto side = static_cast<std::size_t>(x > page.width / 2);
    sums[side] += page.ink(x, row) * (x + 0.5), inks[side] += page.ink(x, row);
  }
  ASSERT_GT(inks[0], 0);
  ASSERT_GT(inks[1], 0);
  EXPECT_NEAR((sums[1] / inks[1] - sums[0] / inks[0]) / kPxPerMm, 100, 0.05);
}

TEST(PatternPage, PutsNothingButDotsOnTheWhiteSheet) {
  PatternOptions options;
  options.sheet = "a3";
  for (const PageItem& item : make_pattern_page(options).items) {
    if (const auto* text = std::get_if<PageText>(&item)) {
      EXPECT_TRUE(text->base_line_start.y_mm < 18 || text->base_line_start.y_mm > 18 + 210 + text->size_mm)
          << text->words;
    }
    if (const auto* line = std::get_if<PageLine>(&item)) {
      const bool above = line->from.y_mm <= 18 && line->to.y_mm <= 18,
                 below = line->from.y_mm >= 228 && line->to.y_mm >= 228;
      const bool beside = line->from.x_mm == line->to.x_mm && std::abs(line->from.x_mm - 148.5) >= 105;
      EXPECT_TRUE(above || below || beside);
    }
  }
}

TEST(PatternPage, ScalesWithItsLengthsAndThePaper) {
  PatternOptions options{0, "", 40, 12.7, 25.4, "250x150"};  // turned upright
  const PatternPage page = make_pattern_page(options);
  EXPECT_EQ(page.width_mm, 150);
  EXPECT_EQ(page.height_mm, 250);
  const auto& p1 = std::get<PageDisc>(*std::find_if(page.items.begin(), page.items.end(), [](const PageItem& item) {
    return std::holds_alternative<PageDisc>(item);
  }));
  EXPECT_DOUBLE_EQ(p1.centre.x_mm, 75);
  EXPECT_NEAR(p1.centre.y_mm, 18 + 105.0 / 2 + 40, 1e-9);
  EXPECT_DOUBLE_EQ(p1.diameter_mm, 12.7);
}

TEST(PatternPage, NamesTheLargestRingThatFitsThePaperAndItFits) {
  PatternOptions options;
  options.ring_radius_mm = 100;
  const std::string line = refusal_of(options);
  std::smatch m;
  ASSERT_TRUE(std::regex_search(
      line, m, std::regex("--ring-radius-mm ([0-9.]+) --dot-diameter-mm ([0-9.]+) --centre-diameter-mm ([0-9.]+)")))
      << line;
  options.ring_radius_mm = std::stod(m[1]), options.dot_diameter_mm = std::stod(m[2]),
  options.centre_diameter_mm = std::stod(m[3]);
  EXPECT_NO_THROW(make_pattern_page(options));
  EXPECT_GT(options.ring_radius_mm, 80);
  options.ring_radius_mm += 1, options.dot_diameter_mm += 0.5;
  refusal_of(options);
}

TEST(PatternPage, RefusesPaperTooShortForTheScaleBar) {
  PatternOptions options;
  options.sheet = "215x220";
  EXPECT_NE(refusal_of(options).find("does not fit"), std::string::npos);
}

TEST(PatternPage, RefusesWrongCodesWithWhatToGive) {
  for (const char* code : {"KRGBKKR", "KRGBKKRBK", "KRGBKKRX", "krgbkkrb", "-"}) {
    PatternOptions options;
    options.code = code;
    EXPECT_NE(refusal_of(options).find("eight letters of K R G B"), std::string::npos) << code;
  }
}

TEST(PatternPage, RefusesACodeThatLooksTheSameAfterATurn) {
  PatternOptions options;
  options.code = "KRGBKRGB";
  EXPECT_NE(refusal_of(options).find("after a turn by 4 dots"), std::string::npos);
  options.code = "KKKKKKKK";  // black and white: P1 is the lowest, by the camera's known roll
  EXPECT_NO_THROW(make_pattern_page(options));
}

TEST(PatternPage, RefusesLengthsThatAreNoneAndDotsThatTouch) {
  for (const double length_mm : {0.0, -1.0, std::nan(""), 1e9}) {
    PatternOptions options;
    options.ring_radius_mm = length_mm;
    EXPECT_NE(refusal_of(options).find("--ring-radius-mm"), std::string::npos);
  }
  PatternOptions touching;
  touching.ring_radius_mm = 30;
  EXPECT_NE(refusal_of(touching).find("dots touch"), std::string::npos);
  touching = {};
  touching.centre_diameter_mm = 140;
  EXPECT_NE(refusal_of(touching).find("dots touch"), std::string::npos);
}

TEST(PatternPage, RefusesUnknownPaper) {
  for (const char* sheet :
       {"", "a9", "legal", "210", "210x", "x297", "210x297mm", "0x10", "1e3x1e9", "-210x297", "100x300", "nanxnan"}) {
    PatternOptions options;
    options.sheet = sheet;
    EXPECT_NE(refusal_of(options).find("--sheet"), std::string::npos) << sheet;
  }
}

TEST_F(PatternFiles, WritesTheWholeFileAndLeavesNoTemporaryOne) {
  const PatternPage page = make_pattern_page({});
  write_pattern({&page, 1}, folder_ / "sheet.svg");
  write_pattern({&page, 1}, folder_ / "sheet.pdf");
  EXPECT_EQ(contents(folder_ / "sheet.svg"), encode_svg(page));
  EXPECT_EQ(contents(folder_ / "sheet.pdf"), pdf_of(page));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(PatternFiles, RefusesOtherEndingsAndWritesNothing) {
  for (const char* name : {"sheet.png", "sheet", "sheet.svg.txt", ".pdf"}) {
    const std::string line =
        refusal([&] { write_pattern(std::vector{make_pattern_page({})}, name); }, ExitStatus::kWrongUsage);
    EXPECT_NE(line.find(".svg or .pdf"), std::string::npos);
    EXPECT_FALSE(fs::exists(name));
  }
}

TEST_F(PatternFiles, KeepsTheOldFileWhenTheNewOneCannotBeWritten) {
  fs::create_directories(folder_ / "sheet.svg");  // a folder in the way
  const std::string line = refusal([&] { write_pattern(std::vector{make_pattern_page({})}, folder_ / "sheet.svg"); },
                                   ExitStatus::kWorkFailed);
  EXPECT_NE(line.find("sheet.svg: cannot be created: Is a directory"), std::string::npos) << line;
  EXPECT_TRUE(fs::is_directory(folder_ / "sheet.svg"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 1);
  refusal([&] { write_pattern(std::vector{make_pattern_page({})}, folder_ / "missing" / "sheet.svg"); },
          ExitStatus::kWorkFailed);
}

TEST_F(PatternFiles, AFullDiskIsReported) {
  fs::create_symlink("/dev/full", folder_ / "sheet.pdf");
  const std::string line = refusal([&] { write_pattern(std::vector{make_pattern_page({})}, folder_ / "sheet.pdf"); },
                                   ExitStatus::kWorkFailed);
  EXPECT_NE(line.find("No space left"), std::string::npos) << line;
  EXPECT_TRUE(fs::is_symlink(folder_ / "sheet.pdf"));
}

}  // namespace
}  // namespace ninedot
