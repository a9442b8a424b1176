// `ninedot cameras`: what is there, with the names that the configuration takes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "drivers/camera/libcamera_device.h"
#include "drivers/camera/v4l2_list.h"
#include "programs/commands/commands.h"

namespace ninedot {
namespace {

void print_camera(const char* source, const CameraListing& camera) {
  fmt::print("{}{}{}\n", camera.device, camera.name.empty() ? "" : "  ", camera.name);
  fmt::print("  configure  source = \"{}\", device = \"{}\"\n", source,
             camera.steady_device.empty() ? camera.device : camera.steady_device);
  if (!camera.identity.empty()) fmt::print("  camera_id  {}\n", camera.identity);
  if (!camera.path.empty()) fmt::print("  path       {}\n", camera.path);
  if (!camera.now.empty()) fmt::print("  now        {}\n", camera.now);
  if (!camera.problem.empty()) fmt::print("  problem    {}\n", camera.problem);
  for (const std::string& line : camera.formats) fmt::print("  format     {}\n", line);
  for (const std::string& line : camera.controls) fmt::print("  control    {}\n", line);
}

void run_cameras() {
  const std::vector<CameraListing> v4l2 = list_v4l2_cameras();
  for (const CameraListing& camera : v4l2) print_camera("v4l2", camera);
  const std::vector<CameraListing> others = list_libcamera_cameras();
  for (const CameraListing& camera : others) print_camera("libcamera", camera);
  if (v4l2.empty() && others.empty())
    fmt::print("no camera: connect one; a camera on a ribbon cable also needs its device-tree overlay\n");
}

}  // namespace

void add_cameras_command(CLI::App& app) {
  app.add_subcommand("cameras", "List the cameras of this machine with their formats, rates and controls")
      ->callback(run_cameras);
}

}  // namespace ninedot
