"""Two tables of poses, as `ninedot replay` writes them on two kinds of machine, must agree.

Not to the byte: a fused multiply-add rounds once where a multiplication and an addition round twice, OpenCV's versions differ, and
the solver stops at a step far below the noise, not at zero. What must hold: the same frames, dots and landmarks; position within
1e-6 of the distance; the quaternion within 1e-6; angles within 1e-5 rad; what rests on the residuals (sigmas, odds, rms) within 1e-3 of
itself; the rival pose as the pose, but for its position, which has a thousandth of the pose's sigma if that is more. A column of none of
these kinds fails.

usage: compare_poses.py EXPECTED.csv ACTUAL.csv
"""

import csv
import math
import sys

TIMES_IT_TOOK = {"process_us"}
SAME_TEXT = {"frame", "timestamp_ns", "landmark_id", "dots", "occlusion_level", "solver", "valid", "reason"}
POSITION = {"x_mm", "y_mm", "z_mm", "distance_mm"}
RIVAL_POSITION = {"rival_x_mm", "rival_y_mm", "rival_z_mm"}
QUATERNION = {"qw", "qx", "qy", "qz", "rival_qw", "rival_qx", "rival_qy", "rival_qz"}
ANGLES = {"psi_deg", "phi_deg", "theta_deg"}
SIGMA = ("sigma_x_mm", "sigma_y_mm", "sigma_z_mm")
FROM_RESIDUALS = {*SIGMA, "sigma_rot_deg", "ambiguity", "rms_px", "rival_odds", "sigma_calibration_mm"}
KNOWN = TIMES_IT_TOOK | SAME_TEXT | POSITION | RIVAL_POSITION | QUATERNION | ANGLES | FROM_RESIDUALS


def rows(path):
    with open(path, newline="", encoding="ascii") as file:
        return list(csv.DictReader(file))


def allowed(name, row):
    """The largest difference that passes"""
    if name in POSITION:
        return 1e-6 * float(row["distance_mm"])
    if name in RIVAL_POSITION:
        return max(1e-6 * float(row["distance_mm"]), *(1e-3 * float(row[sigma]) for sigma in SIGMA))
    if name in QUATERNION:
        return 1e-6
    if name in ANGLES:
        return math.degrees(1e-5)
    if name in FROM_RESIDUALS:
        return max(1e-3 * float(row[name]), 2e-6)  # written with six decimals
    raise KeyError(name)


def share(name, expected, actual):
    """The difference as a share of what is allowed."""
    if expected[name] == actual[name]:
        return 0.0
    if not expected[name] or not actual[name] or name in SAME_TEXT:
        return math.inf
    limit = allowed(name, expected)
    difference = abs(float(expected[name]) - float(actual[name]))
    return math.inf if math.isnan(difference) else difference / limit


def main(expected_path, actual_path):
    expected, actual = rows(expected_path), rows(actual_path)
    if not expected or len(expected) != len(actual) or expected[0].keys() != actual[0].keys():
        sys.exit(f"FAILED: {len(expected)} frames expected, {len(actual)} found, or other columns")
    if unknown := expected[0].keys() - KNOWN:
        sys.exit(f"FAILED: how close must {', '.join(sorted(unknown))} be? compare_poses.py does not say")
    worst, differing, values = (0.0, ""), 0, 0
    for one, other in zip(expected, actual):
        for name in (column for column in one if column not in TIMES_IT_TOOK):
            part = share(name, one, other)
            values += 1
            differing += part > 0.0
            worst = max(worst, (part, f"frame {one['frame']}, {name}: {one[name]} and {other[name]}"))
    if worst[0] > 1.0:
        sys.exit(f"FAILED: {worst[1]}")
    print(f"ok: {len(expected)} frames; {differing} of {values} values differ, by at most {worst[0]:.2f} of what is allowed"
          + (f" ({worst[1]})" if differing else ""))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
