#pragma once
/// A calibration as one picture: where the sheet was seen, what its outlines are off, and how well directions are
/// known.
#include <Eigen/Core>
#include <string>
#include <vector>

namespace ninedot {

/// One outline stretch: where, and how far it is from where the lens shows it, outwards along `normal`.
struct DrawnResidual {
  Eigen::Vector2d at_px{0, 0};
  double off_px = 0;
};

struct CalibrationDrawing {
  int width_px = 0, height_px = 0;                         ///< of the camera's pictures
  std::vector<std::vector<Eigen::Vector2d>> disc_centres;  ///< of each view [px]
  std::vector<DrawnResidual> residuals;
  int columns = 0, rows = 0;  ///< of direction_sigma_px, whose first and last pixels are the picture's corners
  std::vector<double> direction_sigma_px;  ///< row by row
  std::string title;                       ///< one line, plain text
};

/// SVG, three panels beside each other. Memory: allocates. Threads: pure.
std::string draw_calibration(const CalibrationDrawing& drawing);

}  // namespace ninedot
