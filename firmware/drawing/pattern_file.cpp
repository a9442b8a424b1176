// The two file formats, written by hand: discs, lines and words are a dozen operators of either, the bytes are the same
// at every run (no date, no version of a library), and nothing but the operators below decides a length on paper.
//   SVG 1.1: a viewBox in mm on a page sized in mm makes one user unit one millimetre (section 7).
//   PDF 1.4 (ISO 32000-1 section 8): `cm` scales the page's points to mm; y goes up. Helvetica is one of the 14 fonts
//   that every reader has (9.6.2.2), so none is embedded; only words depend on it.
#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "base/contract.h"
#include "drawing/pattern.h"

namespace ninedot {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;  // PDF's unit is 1/72 inch (ISO 32000-1, 8.3.2.3)

template <typename... Kinds>
struct Overloaded : Kinds... {
  using Kinds::operator()...;
};
template <typename... Kinds>
Overloaded(Kinds...) -> Overloaded<Kinds...>;

/// Shortest form with 1e-6 mm; fmt knows no locale, so the decimal point is a point.
std::string number(double value) {
  std::string text = fmt::format("{:.6f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string svg_colour(const PageColour& c) {
  const auto byte = [](double part) { return static_cast<int>(std::lround(255 * part)); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(c.red), byte(c.green), byte(c.blue));
}

std::string svg_item(const PageItem& item) {
  return std::visit(
      Overloaded{
          [](const PageDisc& d) {
            return fmt::format("  <circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>\n", number(d.centre.x_mm),
                               number(d.centre.y_mm), number(d.diameter_mm / 2), svg_colour(d.colour));
          },
          [](const PageLine& l) {
            return fmt::format("  <line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke-width=\"{}\" stroke=\"{}\"/>\n",
                               number(l.from.x_mm), number(l.from.y_mm), number(l.to.x_mm), number(l.to.y_mm),
                               number(l.width_mm), svg_colour(l.colour));
          },
          [](const PageTriangle& t) {
            std::string points;
            for (const PagePoint& p : t.corners) points += fmt::format("{},{} ", number(p.x_mm), number(p.y_mm));
            points.pop_back();
            return fmt::format("  <polygon points=\"{}\" fill=\"#000000\"/>\n", points);
          },
          [](const PageText& t) {
            return fmt::format(
                "  <text x=\"{}\" y=\"{}\" font-size=\"{}\" font-family=\"Helvetica, Arial, sans-serif\">{}</text>\n",
                number(t.base_line_start.x_mm), number(t.base_line_start.y_mm), number(t.size_mm), t.words);
          }},
      item);
}

/// Fill (`g`, `rg`) or stroke (`G`, `RG`) colour. Black as grey: printers then use black ink alone.
std::string pdf_colour(const PageColour& c, const char* grey, const char* rgb) {
  if (c.red == c.green && c.green == c.blue) return fmt::format("{} {}\n", number(c.red), grey);
  return fmt::format("{} {} {} {}\n", number(c.red), number(c.green), number(c.blue), rgb);
}

/// Eight cubic arcs of 45 degrees, control points at 4/3 tan(45 deg / 4) of the radius along the tangents: the radius
/// is then true to 4.2e-6 of itself (four arcs: 2.7e-4).
std::string pdf_disc(const PageDisc& d, double page_height_mm) {
  constexpr int kArcs = 8;
  const double step_rad = 2 * std::numbers::pi / kArcs, k = 4.0 / 3.0 * std::tan(step_rad / 4), r = d.diameter_mm / 2;
  const double cx = d.centre.x_mm, cy = page_height_mm - d.centre.y_mm;
  std::string path = pdf_colour(d.colour, "g", "rg") + fmt::format("{} {} m\n", number(cx + r), number(cy));
  for (int arc = 0; arc < kArcs; ++arc) {
    const double c0 = std::cos(arc * step_rad), s0 = std::sin(arc * step_rad);
    const double c1 = std::cos((arc + 1) * step_rad), s1 = std::sin((arc + 1) * step_rad);
    path += fmt::format("{} {} {} {} {} {} c\n", number(cx + r * (c0 - k * s0)), number(cy + r * (s0 + k * c0)),
                        number(cx + r * (c1 + k * s1)), number(cy + r * (s1 - k * c1)), number(cx + r * c1),
                        number(cy + r * s1));
  }
  return path + "f\n";
}

std::string pdf_item(const PageItem& item, double page_height_mm) {
  const auto y = [page_height_mm](const PagePoint& p) { return number(page_height_mm - p.y_mm); };
  return std::visit(Overloaded{[&](const PageDisc& d) { return pdf_disc(d, page_height_mm); },
                               [&](const PageLine& l) {
                                 return pdf_colour(l.colour, "G", "RG") +
                                        fmt::format("{} w\n{} {} m {} {} l S\n", number(l.width_mm),
                                                    number(l.from.x_mm), y(l.from), number(l.to.x_mm), y(l.to));
                               },
                               [&](const PageTriangle& t) {
                                 const auto& p = t.corners;
                                 return fmt::format("0 g\n{} {} m {} {} l {} {} l f\n", number(p[0].x_mm), y(p[0]),
                                                    number(p[1].x_mm), y(p[1]), number(p[2].x_mm), y(p[2]));
                               },
                               [&](const PageText& t) {
                                 return fmt::format("0 g\nBT /F1 {} Tf {} {} Td ({}) Tj ET\n", number(t.size_mm),
                                                    number(t.base_line_start.x_mm), y(t.base_line_start), t.words);
                               }},
                    item);
}

}  // namespace

std::string encode_svg(const PatternPage& page) {
  std::string file = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} "
      "{1}\">\n"
      "  <title>{2}</title>\n"
      "  <rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
      number(page.width_mm), number(page.height_mm), page.title);
  for (const PageItem& item : page.items) file += svg_item(item);
  return file + "</svg>\n";
}

std::string encode_pdf(std::span<const PatternPage> pages) {
  EXPECTS(!pages.empty());
  constexpr std::size_t kFirstPage = 5;  // objects 1 to 4 are for all; each page is two
  std::string kids;
  for (std::size_t i = 0; i < pages.size(); ++i) kids += fmt::format("{}{} 0 R", i == 0 ? "" : " ", kFirstPage + 2 * i);
  // PrintScaling None makes readers offer "actual size" first (12.2).
  std::vector<std::string> objects{
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      fmt::format("<< /Type /Pages /Kids [{}] /Count {} >>", kids, pages.size()),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
      fmt::format("<< /Title ({}) /Creator (ninedot pattern) >>", pages.front().title),
  };
  for (const PatternPage& page : pages) {
    std::string content = fmt::format("{0:.12f} 0 0 {0:.12f} 0 0 cm\n", kPointsPerMm);
    for (const PageItem& item : page.items) content += pdf_item(item, page.height_mm);
    objects.push_back(fmt::format(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents {} 0 R /Resources << /Font << /F1 3 0 R >> >> >>",
        number(page.width_mm * kPointsPerMm), number(page.height_mm * kPointsPerMm), objects.size() + 2));
    objects.push_back(fmt::format("<< /Length {} >>\nstream\n{}\nendstream", content.size(), content));
  }

  std::string file = "%PDF-1.4\n";
  std::string table;
  std::size_t count = 1;
  for (const std::string& object : objects) {
    table += fmt::format("{:010} 00000 n \n", file.size());
    file += fmt::format("{} 0 obj\n{}\nendobj\n", count++, object);
  }
  const std::size_t table_at = file.size();
  return file + fmt::format(
                    "xref\n0 {0}\n0000000000 65535 f \n{1}trailer\n<< /Size {0} /Root 1 0 R /Info 4 0 R "
                    ">>\nstartxref\n{2}\n%%EOF\n",
                    count, table, table_at);
}

}  // namespace ninedot
