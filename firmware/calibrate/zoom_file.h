#pragma once
/// The part `zoom` of a calibration file: the lens at each position of the zoom at which it was calibrated. What stands
/// above it in the file is the lens of the widest position, for programs that know no zoom.
///
///     zoom:                           # other programs pass over it
///       positions:                    # two or more, rising [steps that the camera counts in]
///         - position: 0
///           parameters: [fx, fy, cx, cy, k1, k2, p1, p2, k3]   # px; the model's coefficients in the file's order
///           covariance: {rows: 9, cols: 9, data: [...]}        # of these, by rows
#include <string>

#include "calibrate/yaml_reader.h"
#include "calibrate/zoom_table.h"

namespace ninedot {

/// \param node  the mapping \param camera  of the same file: its size and model are those of all positions
/// Throws StartupError(kWrongUsage), "NAME:LINE: what is wrong".
ZoomTable read_zoom(const YAML::Node& node, const CameraModel& camera, const YamlReader& yaml);

/// Text for the end of a calibration file; read_zoom reads the same parameters back, to the last bit.
std::string format_zoom(const ZoomTable& zoom);

}  // namespace ninedot
