#pragma once
/// Which landmark of a map a ring of dots is, by its colours, from frame to frame.
#include <optional>
#include <vector>

#include "colour/code_reader.h"
#include "image/frame.h"

namespace ninedot {

/// What one landmark in view has shown of its colours since it came into view.
struct ShownColours {
  DotColours sum;  ///< logarithms added up; numbered as its track numbers it
  int frames = 0;  ///< that added to it
};

/// Who a ring is.
struct Identity {
  std::optional<std::size_t> coded;  ///< index into the map's landmarks(); none: a black-and-white one
  std::size_t turn = 0;              ///< the dot at this index is P1; 0 where colours do not tell [1]
  double others_odds = 0;            ///< that it is another one, or none of the map, 0..1
};

/// Memory: the constructor's. Threads: one caller.
class CodeIdentity {
 public:
  explicit CodeIdentity(const LandmarkMap& map);

  /// No landmark of the map has a colour: there is nothing to read.
  bool is_colourless() const noexcept { return indices_.empty(); }

  /// Adds what a picture shows, by the reader of its lens, to what those before it did. A ring's colours are read with
  /// the same error from frame to frame (light, ink, where its dots fall on the sensor's pattern): frames count as
  /// kMostFrames at most.
  void look(const ColourReader& reader, const Frame& frame, const CameraFromLandmark& T_camera_landmark,
            const PictureMotion& motion, const PictureNoise& noise, ShownColours& shown) const noexcept;
  static constexpr int kMostFrames = 3;

  /// None: its colours do not tell it from another one of the map, or from none, to `max_odds`. \param max_odds  0..1
  std::optional<Identity> identify(const ShownColours& shown, double max_odds) const noexcept;

  /// Who it should be, where the map and the camera's track say so and its colours alone do not suffice: dots of two
  /// pixels have hardly any. None: the colours contradict. \param expected  index into the map's landmarks() [1]
  std::optional<Identity> confirm(std::size_t expected, const ShownColours& shown, double max_odds) const noexcept;

  /// Whether one picture's colours say that it is another one. \param coded  index into the map's landmarks() [1]
  /// \param shown  of that picture, numbered by its code
  bool contradicts(std::size_t coded, const ShownColours& shown) const noexcept;

  /// Whether the picture still shows it: two places of the ring are looked at in each frame, others in the next.
  /// \param coded  index into the map's landmarks() [1] \param T_camera_landmark  numbered by its code
  /// \param doubt  what the frames before said against it, as a logarithm, forgotten within some ten frames; goes on
  /// [1]
  bool is_still(std::size_t coded, const ColourReader& reader, const Frame& frame,
                const CameraFromLandmark& T_camera_landmark, const PictureMotion& motion, const PictureNoise& noise,
                double& doubt) const noexcept;

 private:
  std::size_t reader_index(std::size_t map_index) const noexcept;

  std::vector<std::size_t> indices_;  // into the map, of what `codes_` was made of
  bool has_black_ = false;            // the last of them stands for all black-and-white ones
  CodeReader codes_;
};

}  // namespace ninedot
