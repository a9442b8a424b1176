#include "tests/bench/mrcal_lens.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "calibrate_camera/lens_parameters.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A vnlog of what a corner finder would have said: row by row, x to the right and y downwards, as a grid's dots are.
void write_corners(const fs::path& path, std::size_t dots, std::span<const SheetView> views) {
  std::ofstream file(path);
  file << "# filename x y level\n";
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t disc = 0; disc < dots; ++disc) {
      const auto seen = std::ranges::find(views[i].seen, disc, &SeenDisc::disc);
      file << (seen == views[i].seen.end()
                   ? fmt::format("view{:03}.png - - -\n", i)
                   : fmt::format("view{:03}.png {:.6f} {:.6f} 0\n", i, seen->centre_px.x(), seen->centre_px.y()));
    }
}

std::string last_line_of(const fs::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last;
}

/// Of a .cameramodel, which is a Python dictionary.
std::vector<double> read_intrinsics(const fs::path& path) {
  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::size_t key = text.find("'intrinsics'"), begin = text.find('[', key), end = text.find(']', begin);
  std::vector<double> values;
  if (key == std::string::npos || end == std::string::npos) return values;
  std::string numbers = text.substr(begin + 1, end - begin - 1);
  std::ranges::replace(numbers, ',', ' ');
  std::istringstream words(numbers);
  for (double value = 0; words >> value;) values.push_back(value);
  return values;
}

}  // namespace

bool has_mrcal() { return std::system("command -v mrcal-calibrate-cameras > /dev/null") == 0; }

std::optional<CameraModel> lens_by_mrcal(const CameraModel& like, const DotGrid& grid,
                                         std::span<const SheetView> views) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("ninedot_mrcal_{}", ::getpid());
  fs::create_directories(folder);
  write_corners(folder / "corners.vnl", discs_of(grid).size(), views);
  CameraModel camera = like;
  if (camera.model == DistortionModel::kEquidistant) camera.model = DistortionModel::kRationalPolynomial;
  const std::string command = fmt::format(
      "cd {0} && mrcal-calibrate-cameras --corners-cache corners.vnl --lensmodel LENSMODEL_OPENCV{1} --focal {2} "
      "--object-spacing {3} --object-width-n {4} --object-height-n {5} --imagersize {6} {7} --outdir . 'view*.png' > "
      "log 2>&1",
      folder.string(), coefficient_count(camera.model), std::round(like.fx_px), grid.pitch_m, grid.columns, grid.rows,
      like.width_px, like.height_px);
  std::vector<double> values;
  if (std::system(command.c_str()) == 0) values = read_intrinsics(folder / "camera-0.cameramodel");
  if (values.empty()) fmt::print(stderr, "mrcal: {}\n", last_line_of(folder / "log"));
  fs::remove_all(folder);
  if (static_cast<int>(values.size()) != parameter_count(camera.model)) return std::nullopt;
  return with_parameters(camera, Eigen::Map<const Eigen::VectorXd>(values.data(), parameter_count(camera.model)));
}

}  // namespace ninedot
